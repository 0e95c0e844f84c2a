"""Force on each particle of a homogeneous random bed against the drag law (Ergun at this void fraction) at the exact eps.

pressure_drop: the mean force against the law's, for the forces on the particles are the whole pressure gradient; force:
root mean square of F/F_exact - 1 over the particles.
Standard error: from the eight octants of the box.
"""
import os

import numpy as np

from beds import force, random_bed
from harness import data_file, read_dump

WIDTH, EPS = 12, 0.5
D, MU, RHO, U = 1e-3, 1.8e-5, 1.2, 0.3


def bed(seed):
    return random_bed(WIDTH, WIDTH, EPS, seed, periodic_z=True)


def prepare(folder, choices):
    box = " ".join(["0", repr(WIDTH * D)] * 3)
    with open(os.path.join(folder, "particles.data"), "w") as f:
        f.write(data_file(box, bed(choices["seed"]) * D, D, 1e6))


def measure(folder, choices):
    p = read_dump(os.path.join(folder, "particles.txt"))[-1][1]
    eps = 1 - len(p["z"]) * np.pi / 6 / WIDTH**3
    ratio = (p["f_gas[3]"] + p["f_gas[6]"]) / force(eps, D, MU, RHO, U)
    octant = sum(2**i * (p[a] > 0.5 * WIDTH * D) for i, a in enumerate("xyz"))
    means = [ratio[octant == o].mean() for o in range(8)]
    bias = ratio.mean() - 1
    return dict(force=float(np.sqrt(np.mean((ratio - 1)**2))), pressure_drop=abs(bias),
                pressure_drop_err=float(np.std(means, ddof=1) / np.sqrt(8)), signed_bias=bias)
