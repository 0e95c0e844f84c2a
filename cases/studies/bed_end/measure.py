"""Pressure drop of a lattice that ends against Ergun's law at its void fraction, times its height.

pressure_drop: |error|; signed: with its sign; lacking: height of bed that lacks in the drop, in particle cells; last: root mean
square of the error of the force on the particles of the cell in which the bed ends; settled: change of the drop over the last
half of the run.
"""
import math
import os

import numpy as np

from harness import column, data_file, read_dump, read_thermo

LAYERS, SIDE = 32, 4          # layers in n particle cells; spheres a side
A, D, MU, RHO, U = 1e-3, 0.98e-3, 1.8e-5, 1.2, 0.3


def layers(choices):
    return round((choices["n"] - 1 + choices["f"]) * LAYERS / choices["n"])


def prepare(folder, choices):
    q = (np.arange(SIDE) + 0.5) * A
    x = [(i, j, (k + 0.5) * A) for k in range(layers(choices)) for j in q for i in q]
    with open(os.path.join(folder, "particles.data"), "w") as f:
        f.write(data_file(f"0 {SIDE * A!r} 0 {SIDE * A!r} 0 {2 * LAYERS * A!r}", x, D, 1e6))


def measure(folder, choices):
    height = layers(choices)                 # in A
    cell = LAYERS // choices["n"]
    s = math.pi / 6 * (D / A)**3
    e = 1 - s
    gradient = 150 * MU * s**2 * U / (e**3 * D**2) + 1.75 * RHO * s * U**2 / (e**3 * D)
    t = read_thermo(os.path.join(folder, "log.liggghts"))
    drop = column(t, "f_gas[4]")
    p = read_dump(os.path.join(folder, "particles.txt"))[-1][1]
    force = (p["f_gas[3]"] + p["f_gas[6]"]) / (gradient * A**3)   # of formulation A: drag and pressure gradient
    signed = drop[-1] / (gradient * height * A) - 1
    last = p["z"] > (choices["n"] - 1) * cell * A
    return dict(pressure_drop=float(abs(signed)), signed=float(signed), lacking=float(-signed * height / cell),
                last=float(np.sqrt(np.mean((force[last] - 1)**2))), settled=float(abs(drop[-1] / drop[1] - 1)))


def conclude(rows):
    out = ["Height of bed that lacks in the pressure drop, in particle cells, mean over where in its cell the bed ends:"]
    for method in dict.fromkeys(r["method"] for r in rows if r["method"]):
        for n in ("2", "4", "8"):
            found = [r["lacking"] for r in rows if r["method"] == method and r.get("form", "") in ("", None) and str(r["n"]) == n and r["state"] == "ok"]
            if found:
                out.append(f"  {method}, n={n}: {np.mean(found):.3f}")
    return "\n".join(out)
