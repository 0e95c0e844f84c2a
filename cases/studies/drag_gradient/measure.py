"""Force on each particle of the gradient against the drag law at the true void fraction of its height.

bias: mean of F/F_exact - 1; scatter: its standard deviation; force: both together. pressure_drop: the sum of all forces
against that of the exact ones, which is the pressure drop over the gradient. Standard errors: from the four quarters of
the cross-section.
"""
import os

import numpy as np

from beds import force, random_bed
from harness import data_file, read_dump

WIDTH, HEIGHT, LOW, HIGH = 12, 24, 6, 18   # d; the gradient lies between LOW and HIGH
D, MU, RHO, U, DENSE, DILUTE = 1e-3, 1.8e-5, 1.2, 0.3, 0.42, 0.90


def true_eps(z):
    """z in d: from DENSE to DILUTE without a kink."""
    s = np.clip((np.asarray(z) - LOW) / (HIGH - LOW), 0, 1)
    return DENSE + (DILUTE - DENSE) * s**2 * (3 - 2 * s)


def bed(seed):
    z = np.linspace(0, HEIGHT, 97)
    return random_bed(WIDTH, HEIGHT, tuple(zip(z, true_eps(z))), seed, closest=0.95)


def prepare(folder, choices):
    with open(os.path.join(folder, "particles.data"), "w") as f:
        f.write(data_file(f"0 {WIDTH * D} 0 {WIDTH * D} 0 {HEIGHT * D}", bed(choices["seed"]) * D, D, 1e6))


def measure(folder, choices):
    p = read_dump(os.path.join(folder, "particles.txt"))[-1][1]
    z = p["z"] / D
    inside = (z > LOW) & (z < HIGH)
    exact = force(true_eps(z), D, MU, RHO, U)
    ratio = p["f_gas[3]"] / exact
    x, y = p["x"] > 0.5 * WIDTH * D, p["y"] > 0.5 * WIDTH * D
    quarters = [inside & (2 * x + y == q) for q in range(4)]
    error = lambda values: float(np.std(values, ddof=1) / 2)
    drop = lambda some: p["f_gas[3]"][some].sum() / exact[some].sum() - 1
    bias = ratio[inside].mean() - 1
    return dict(force=float(np.sqrt(np.mean((ratio[inside] - 1)**2))), bias=abs(bias),
                bias_err=error([ratio[q].mean() for q in quarters]), signed_bias=bias, scatter=float(ratio[inside].std()),
                pressure_drop=abs(drop(inside)), pressure_drop_err=error([drop(q) for q in quarters]),
                signed_pressure_drop=drop(inside))
