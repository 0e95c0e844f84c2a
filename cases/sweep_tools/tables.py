"""Tables of runs, and what they recommend."""
import csv
import math
import os
import re

from .errors import LEAST_CPU
from .keywords import Wrong

LEVELS = (0.01, 0.03, 0.10)


def write_table(path, rows, head):
    names = list(dict.fromkeys(k for r in rows for k in r))
    with open(path, "w", newline="") as f:
        f.write("".join(f"# {h}\n" for h in head))
        w = csv.DictWriter(f, names, lineterminator="\n")
        w.writeheader()
        for r in rows:
            w.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in r.items()})


def read_table(path):
    with open(path) as f:
        rows = list(csv.DictReader(line for line in f if not line.startswith("#")))
    return [{k: float(v) if k not in ("name", "method", "state") and re.fullmatch(r"[-+0-9.eE]+|nan|inf", v or "x") else v
             for k, v in r.items()} for r in rows]


def usable(rows, error):
    return [r for r in rows if r["state"] == "ok" and isinstance(r.get(error), float) and math.isfinite(r[error])]


def noise_of(row, error):
    """Standard error of a row's error, 0 if none was given."""
    value = row.get(error + "_err")
    return value if isinstance(value, float) and math.isfinite(value) else 0.0


def percent(row, error):
    noise = noise_of(row, error)
    return f"{100 * row[error]:.2g} %" + (f" +- {100 * noise:.2g} %" if noise else "")


def front_of(rows, error):
    """Runs that no other beats in both, cheapest first."""
    best, out = math.inf, []
    for r in sorted(usable(rows, error), key=lambda r: (r["cpu_s"], r[error])):
        if r[error] < best:
            best = r[error]
            out.append(r)
    return out


def beaten(r, rows, error):
    """Another run is clearly cheaper and clearly more accurate, or no dearer and half again as accurate; beyond the noise."""
    for q in rows:
        noise = math.hypot(noise_of(q, error), noise_of(r, error))
        cheaper, no_dearer = q["cpu_s"] < 0.9 * r["cpu_s"] - LEAST_CPU, q["cpu_s"] < 1.1 * r["cpu_s"] + 0.5 * LEAST_CPU
        if cheaper and q[error] < 0.9 * r[error] - noise or no_dearer and q[error] < r[error] / 1.5 - noise:
            return True
    return False


def recommendation(study_title, rows, errors, keys, reference=""):
    """reference: the choices that errors are taken against, in words."""
    out = [study_title, *([f"Compared with the run of {reference}"] if reference else []), ""]
    for error in errors:
        good = usable(rows, error)
        out.append(f"Error: {error}; a run counts when its error and its standard error together are below")
        for level in LEVELS:
            enough = [r for r in good if r[error] + noise_of(r, error) <= level]
            if enough:
                r = min(enough, key=lambda r: (r["cpu_s"], r[error]))
                out.append(f"  {100 * level:3.0f} %: {r['name']} ({percent(r, error)}; {r['cpu_s']:.2g} s of CPU)")
            elif good:
                r = min(good, key=lambda r: r[error] + noise_of(r, error))
                out.append(f"  {100 * level:3.0f} %: none; the nearest is {r['name']} ({percent(r, error)}; {r['cpu_s']:.2g} s of CPU)")
        never = []
        for key in keys:
            values = list(dict.fromkeys(r[key] for r in good if r.get(key) not in (None, "")))
            for v in values if len(values) > 1 else []:
                if all(beaten(r, good, error) for r in good if r.get(key) == v):
                    never.append(f"{'' if key == 'method' else key + ' '}{v}")
        out.append("  never pays (another run is no dearer and more accurate): " + ("; ".join(never) or "nothing"))
        out.append("")
    failed = [r for r in rows if r["state"] != "ok"]
    out += [f"Did not run: {r['name']}: {r['state']}" for r in failed]
    return "\n".join(out).rstrip() + "\n"


def compare_short(study, rows, table):
    """Rows of a short sweep against those of table.csv: list of sentences, and whether all agree."""
    agree = study.short.get("agree", {})
    if not agree:
        raise Wrong("study.toml: [short.agree] is missing, so that --short has nothing to compare")
    if not os.path.exists(table):
        raise Wrong(f"{table} is not there: run the whole study first")
    kept = {r["name"]: r for r in read_table(table)}
    out, good = [], True
    for r in rows:
        if r["name"] not in kept:
            out.append(f"FAIL {r['name']}: not in {table}")
            good = False
            continue
        for key, (absolute, relative) in agree.items():
            was, now = kept[r["name"]].get(key), r.get(key)
            if not isinstance(was, float) or not isinstance(now, float):
                out.append(f"FAIL {r['name']}: {key} is {now}, table.csv has {was}")
                good = False
                continue
            bound = absolute + relative * abs(was)
            fine = abs(now - was) <= bound
            good = good and fine
            out.append(f"{'ok  ' if fine else 'FAIL'} {r['name']}: {key} {now:.4g}, table.csv {was:.4g} (wanted within {bound:.2g})")
    return out, good
