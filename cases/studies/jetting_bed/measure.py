"""Pressure drop, mean height of the grains; along the jet's axis (the width of the jet, layers of 3 mm): time means of the void
fraction and of the upward gas flux eps u (m/s); jet: height up to which the mean void fraction on the axis is above 0.8 (mm)."""
import os

import h5py
import numpy as np

WEIGHT = 2600 * np.pi / 6 * 0.75e-3**3 * (2500 - 1.2) * 9.81 / (16.8e-3 * 3e-3)  # buoyant, Pa
LEFT, RIGHT, LAYER = 7.6e-3, 9.2e-3, 3e-3


def along_axis(x, z, field):
    """Means over the jet's width and layers; field [nz][1][nx] at cells."""
    column = np.clip(np.minimum(x[1:], RIGHT) - np.maximum(x[:-1], LEFT), 0, None)
    rows = (field[:, 0, :] * column).sum(1) / column.sum()
    n = round(z[-1] / LAYER)
    return rows.reshape(n, -1).mean(1)


def measure(folder, c):
    t, dp, height, moved, least = np.loadtxt(os.path.join(folder, "now.txt"))[:, 1:].T
    keep = t >= float(c.get("tavg", 0.1))
    out = dict(moved=float(np.abs(moved).max() / (2600 * np.pi / 6 * 0.75e-3**3)), eps_min=float(least.min()))
    for name, q in (("dp", dp[keep] / WEIGHT), ("height", height[keep])):
        parts = [p.mean() for p in np.array_split(q, 8)]
        out[name] = float(q.mean())
        out[name + "_err"] = float(np.std(parts, ddof=1) / 8**0.5)
    with h5py.File(os.path.join(folder, "bed.h5")) as f:
        x, z, a = f["grid/x"][:], f["grid/z"][:], f["average/fine"]
        eps = along_axis(x, z, a["eps"][:])
        out["eps_axis"] = eps
        out["gas_axis"] = along_axis(x, z, a["flux"][..., 2])
    below = np.nonzero(eps < 0.8)[0]
    k = below[0] if len(below) else len(eps) - 1
    out["jet"] = 1e3 * LAYER * (k + 0.5 if k == 0 else k - 0.5 + (eps[k - 1] - 0.8) / max(eps[k - 1] - eps[k], 1e-9))
    return out
