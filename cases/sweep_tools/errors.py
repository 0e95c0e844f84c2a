"""How wrong a run is: against the reference run, or by a study's own measure.py."""
import hashlib
import json
import math
import os

from .keywords import Wrong
from .runs import reason_of

# s: what is left of a run's CPU when its start-up is taken off is no surer than this
LEAST_CPU = 0.05


def onto(nodes, common, field):
    """Means of a cell-wise constant field [nz][ny][nx] over the cells of a common grid, exact overlaps."""
    import numpy as np
    for axis, (a, b) in enumerate(zip(nodes, common)):
        low = np.maximum(a[None, :-1], b[:-1, None])
        high = np.minimum(a[None, 1:], b[1:, None])
        weight = np.clip(high - low, 0, None) / np.diff(b)[:, None]
        at = 2 - axis
        field = np.moveaxis(np.tensordot(weight, np.moveaxis(field, at, 0), 1), 0, at)
    return field


def read_means(folder):
    """What the generic measure takes from the one output file with means: nodes, fields, batches of fields."""
    import glob
    import h5py
    import numpy as np
    for path in sorted(glob.glob(os.path.join(folder, "**", "*.h5"), recursive=True)):
        with h5py.File(path) as f:
            if "average/particle_grid" not in f:
                continue
            a = f["average/particle_grid"]
            nodes = [f["particle_grid"][c][:] for c in "xyz"]
            w = a["batch/weight"][:]
            full = w > 0.5 * w.max()
            batch = {k: a["batch/" + k][:][full] for k in ("eps", "p", "gas_velocity", "solids_flux")}
            batch["gas_flux"] = batch["eps"][..., None] * batch["gas_velocity"]
            return nodes, {k: a[k][:] for k in ("eps", "p", "solids_flux", "gas_flux")}, batch
    raise Wrong(f"the run in {folder} wrote no means: the generic measure needs 'fix_modify ID output ... average from T' "
                "in the script, or write a measure.py")


def generic_measure(folder, reference, common):
    """Errors of the time means against the reference run, on a common grid of the coarsest particle cells of the two or more
    runs: void fraction (rms difference over the rms of the solids fraction), flux of solids and of gas (over the rms of
    theirs), pressure drop from the lowest to the highest layer. name_err: standard error of the difference, from batches.
    """
    import numpy as np
    out = {}
    (n1, f1, b1), (n0, f0, b0) = read_means(folder), read_means(reference)
    rms = lambda q: float(np.sqrt(np.mean(np.square(q))))
    squared = lambda b: np.var(b, axis=0, ddof=1) / len(b) if len(b) > 1 else np.full(b.shape[1:], np.nan)

    def components(nodes, field, batch):
        each = [(..., c) for c in range(3)] if field.ndim == 4 else [...]
        return ([onto(nodes, common, field[c]) for c in each],
                [np.array([onto(nodes, common, b[c]) for b in batch]) for c in each])

    for name in ("eps", "solids_flux", "gas_flux"):
        v1, s1 = components(n1, f1[name], b1[name])
        v0, s0 = components(n0, f0[name], b0[name])
        scale = rms(1 - v0[0]) if name == "eps" else math.sqrt(sum(rms(v)**2 for v in v0))
        difference = math.sqrt(sum(rms(p - q)**2 for p, q in zip(v1, v0)))
        noise = math.sqrt(sum(float(np.mean(squared(p) + squared(q))) for p, q in zip(s1, s0)))
        out[name] = difference / scale if scale > 0 else float("nan")
        out[name + "_err"] = noise / scale if scale > 0 else float("nan")
    drop = lambda p: p[..., 0, :, :].mean((-1, -2)) - p[..., -1, :, :].mean((-1, -2))
    p1, p0 = drop(f1["p"]), drop(f0["p"])
    out["pressure_drop"] = abs(p1 / p0 - 1)
    error = lambda b: float(np.sqrt(squared(drop(b["p"]))))
    out["pressure_drop_err"] = math.hypot(error(b1), error(b0)) / abs(p0)
    return out


def measured(study, job, code):
    """measure.py's numbers, kept beside the run."""
    path = os.path.join(job.folder, "measured.json")
    mark = hashlib.sha256((code + json.dumps(job.all, sort_keys=True, default=str)).encode()).hexdigest()
    if os.path.exists(path):
        kept = json.load(open(path))
        if kept["mark"] == mark:
            return kept["numbers"]
    found = study.module.measure(job.folder, job.all)
    numbers = {k: v.tolist() if hasattr(v, "tolist") else v for k, v in found.items()}
    with open(path, "w") as f:
        json.dump(dict(mark=mark, numbers=numbers), f)
    return numbers


def against(value, reference, absolute):
    """Error of a number or an array against the reference's."""
    import numpy as np
    value, reference = np.asarray(value, float), np.asarray(reference, float)
    if value.shape != reference.shape:
        return float("nan")
    scale = 1.0 if absolute else float(np.sqrt(np.mean(reference**2)))
    return float(np.sqrt(np.mean((value - reference)**2))) / scale if scale > 0 else float("nan")


def rows_of(study):
    """One dict a run: name, choices, cost, numbers and errors."""
    import numpy as np
    runs = study.runs + ([study.reference] if study.reference else [])
    if study.reference and study.reference.record["code"] != 0:
        raise Wrong(f"the reference run failed: {reason_of(study.reference.folder)}")
    rows, numbers = [], {}
    good = [j for j in runs if j.record["code"] == 0]
    if study.module:
        code = "".join(open(os.path.join(study.folder, f)).read() for f in sorted(os.listdir(study.folder)) if f.endswith(".py"))
        for job in good:
            numbers[job.name] = measured(study, job, code)
        if study.reference:
            right = numbers[study.reference.name]
            for job in good:
                n = numbers[job.name]
                numbers[job.name] = {}
                for k, v in n.items():
                    if k.endswith("_err") and k[:-4] in n:
                        continue
                    if np.ndim(v) == 0:
                        numbers[job.name]["value_" + k] = v
                    numbers[job.name][k] = against(v, right[k], k in study.absolute)
                    if k + "_err" in n:
                        total = np.hypot(np.asarray(n[k + "_err"], float), np.asarray(right[k + "_err"], float))
                        numbers[job.name][k + "_err"] = against(total + np.asarray(right[k]), right[k], k in study.absolute)
    else:
        steps = [max(np.diff(read_means(j.folder)[0][a]).max() for j in good) for a in range(3)]
        nodes = read_means(study.reference.folder)[0]
        common = [np.linspace(n[0], n[-1], max(1, int((n[-1] - n[0]) / h + 1e-6)) + 1) for n, h in zip(nodes, steps)]
        for job in good:
            numbers[job.name] = generic_measure(job.folder, study.reference.folder, common)
    for job in study.runs:
        if study.reference and job.folder == study.reference.folder:
            continue
        r = job.record
        state = "ok" if r["code"] == 0 else "timeout" if r["late"] else "failed: " + reason_of(job.folder)
        rows.append({"name": job.name, **{k: job.table.get(k, "") for k in study.keys}, "state": state,
                     "cpu_s": max(LEAST_CPU, r["cpu"]), "wall_s": r["wall"], **numbers.get(job.name, {})})
    if not rows:
        raise Wrong("every run is the reference run itself: there is nothing to compare")
    if study.error is None:
        study.error = [k for k in (numbers[good[0].name] if good else {}) if not k.endswith("_err") and not k.startswith("value_")]
    for e in study.error:
        if good and e not in numbers[good[0].name]:
            raise Wrong(f"error '{e}' is not among what was measured: {', '.join(numbers[good[0].name])}")
    return rows
