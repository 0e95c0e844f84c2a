"""Pressure drop (mean, standard deviation), mean height of the particles, void fraction by height; each with a standard error
from eight batches."""
import os
import sys

import h5py
import numpy as np

LAYER = 3.6e-3  # m, of the profile
WEIGHT = 900 * np.pi / 6 * 1.2e-3**3 * (1000 - 1.2) * 9.81 / (14.4e-3 * 4.8e-3)  # buoyant, Pa


def error(batches):
    return np.std(batches, axis=0, ddof=1) / np.sqrt(len(batches))


def layers(nodes, eps):
    """Means over x, y and layers of LAYER; eps [..][nz][ny][nx]."""
    n = round((nodes[-1] - nodes[0]) / LAYER)
    flat = eps.mean((-1, -2))
    return flat.reshape(*flat.shape[:-1], n, -1).mean(-1)


def measure(folder, c):
    t, dp, z, moved, least = np.loadtxt(os.path.join(folder, "now.txt"))[:, 1:].T
    keep = t >= float(c.get("tavg", 0.2))
    out = dict(moved=float(np.abs(moved).max() / (900 * np.pi / 6 * 1.2e-3**3)), eps_min=float(least.min()))
    for name, q, f in (("dp", dp / WEIGHT, np.mean), ("dp_std", dp / WEIGHT, np.std), ("height", z, np.mean)):
        parts = np.array_split(q[keep], 8)
        out[name] = float(f(q[keep]))
        out[name + "_err"] = float(error([f(p) for p in parts]))
    with h5py.File(os.path.join(folder, "bed.h5")) as f:
        a, nodes = f["average/particle_grid"], f["particle_grid/z"][:]
        w = a["batch/weight"][:]
        out["profile"] = layers(nodes, a["eps"][:])
        out["profile_err"] = error(layers(nodes, a["batch/eps"][:][w > 0.5 * w.max()]))
    return out
