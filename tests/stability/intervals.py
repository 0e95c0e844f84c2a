#!/usr/bin/python3
"""A small bubbling bed coupled every 1 to 64 DEM steps, with ratios 1 to 16, with one particle cell across it: the same means.

Bounded: mean pressure drop within 3 % of the weight and three standard errors of it, mean height of the grains within 10 % and three standard
errors of the run with every 4 and ratio 2. Beyond the limit, 0.3 particle cells crossed in an interval, a warning names it and what to write.
Without this test an interval or ratio at the end of what is allowed could change the bed, or a warning could be missing where it does.
"""
import numpy as np

from hard import Checks, Run, arguments, column
from small_bed import DEPTH, DT, G, N, RHO, RHO_P, V_P, W, small_bed

WEIGHT = N * V_P * (RHO_P - RHO) * G / (W * DEPTH)
STEPS, SKIP, BATCHES = 20000, 4000, 8
BASE = dict(every=4, fine=(6, 1, 24), ratio=(2, 1, 2))
VARIANTS = {"every 4, ratio 2": {}, "every 1": dict(every=1), "every 64": dict(every=64), "ratio 1": dict(ratio=(1, 1, 1)),
            "ratio 16, cells of d/5": dict(fine=(48, 1, 192), ratio=(16, 1, 16), every=5, steps=6000),
            "one particle cell across": dict(ratio=(6, 1, 2))}


def means(executable, values):
    v = {**BASE, **values}
    steps = v.pop("steps", STEPS)
    data, text = small_bed(steps, thermo=max(20, v["every"]), extra="fix_modify gas deposit trilinear", floor="inlet 0 0 1.3", before="compute z0 all reduce ave z", **v)
    text = text.replace("variable z atom z\n", "").replace("c_z c_top", "c_z0 c_top").replace("compute z all reduce ave v_z\n", "").replace(
        "compute top all reduce max v_z\n", "compute top all reduce max z\n")
    r = Run(executable, text, 1, files={"particles.data": data})
    t = r.thermo()
    late = t["Step"] > 5000 + min(SKIP, steps // 4)
    out = []
    for name in ("f_gas[4]", "c_z0"):
        groups = [g.mean() for g in np.array_split(column(t, name)[late], BATCHES)]
        out += [np.mean(groups), np.std(groups, ddof=1) / BATCHES**0.5]
    return out, r.output, t


def main():
    executable, _ = arguments()
    c = Checks("intervals and ratios")
    found = {name: means(executable, values) for name, values in VARIANTS.items()}
    height, height_error = found["every 4, ratio 2"][0][2:]
    for name, ((dp, dp_error, z, z_error), output, t) in found.items():
        c.note(f"{name}: pressure drop {dp:.1f} +- {dp_error:.1f} Pa (weight {WEIGHT:.1f}), mean height {1e3 * z:.2f} +- {1e3 * z_error:.2f} mm")
        c.true(f"{name}: none lost, no warning of the interval", np.all(t["Atoms"] == N) and "coupling interval of" not in output)
        c.below(f"{name}: pressure drop against the weight, relative, less three standard errors", abs(dp / WEIGHT - 1) - 3 * dp_error / WEIGHT, 0.03)
        c.below(f"{name}: mean height, relative, less three standard errors", abs(z / height - 1) - 3 * np.hypot(z_error, height_error) / height, 0.1)
    data, text = small_bed(3000, every=1000, thermo=1000)
    r = Run(executable, text, 1, files={"particles.data": data}, expect_success=False)
    said = [line for line in r.output.split("\n") if "coupling interval of" in line]
    c.true(f"every 1000: warned: {(said or ['nothing'])[0][:220]}", len(said) > 0 and "lower every to" in said[0])
    c.end()


if __name__ == "__main__":
    main()
