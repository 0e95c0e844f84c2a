"""What probes see of a slot jet. seen: upward gas velocity at all probes; core: its mean over the probes within 0.4 mm of
the jet's axis; width: its standard deviation about the axis, weighted by the velocity above that of the stream (mm).
"""
import os

import numpy as np

from harness import data_file, read_dump

STREAM = 0.4


def prepare(folder, choices):
    x, z = np.arange(1.0, 13.5, 0.2) * 1e-3, np.array([2.9, 4.3, 5.7, 7.1, 8.5]) * 1e-3
    probes = [(a, 1.2e-3, b) for b in z for a in x]
    with open(os.path.join(folder, "particles.data"), "w") as f:
        f.write(data_file("0 0.0144 0 0.0024 0 0.0144", probes, 0.75e-3, 1000))


def measure(folder, choices):
    p = read_dump(os.path.join(folder, "particles.txt"))[-1][1]
    off = p["x"] * 1e3 - (choices["left"] + 0.8)
    above = np.clip(p["f_gas[10]"] - STREAM, 0, None)
    return dict(seen=p["f_gas[10]"], core=float(p["f_gas[10]"][abs(off) < 0.4].mean()),
                width=float(np.sqrt(np.sum(above * off**2) / np.sum(above))))
