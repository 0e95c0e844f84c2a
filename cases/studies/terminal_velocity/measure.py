"""Velocity of one falling sphere against its terminal velocity in a fluid at rest.

velocity: error of the mean over the last 8 d of the way (a whole particle cell of the coarsest grid); jitter: standard
deviation about that mean, from the sphere's place in its cell.
"""
import os

import numpy as np

from harness import read_dump

V, D = 0.02, 1e-3


def measure(folder, choices):
    frames = read_dump(os.path.join(folder, "particles.txt"))
    z, vz = (np.array([f[1][k][0] for f in frames]) for k in ("z", "vz"))
    z0 = max(z[-1], 2 * D)
    last = (z < z0 + 8 * D) & (z > z0)
    way = vz[last] / -V
    return dict(velocity=float(abs(way.mean() - 1)), signed_velocity=float(way.mean() - 1), jitter=float(way.std()))
