"""Centre of mass of the block: velocity and distance fallen at ten times, and what the eps bound did."""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "tests", "system"))
from harness import data_file, read_thermo  # noqa: E402

D, RHO_P = 1e-3, 2500.0
NX, NY, NZ = 11, 3, 14


def prepare(folder, c):
    rng = np.random.default_rng(int(c.get("seed", 1)))
    x = np.array([(6e-3 + (a + 0.5) * 12e-3 / NX, (b + 0.5) * 4e-3 / NY, 22e-3 + (k + 0.5) * 1.09e-3)
                  for k in range(NZ) for b in range(NY) for a in range(NX)])
    x += rng.uniform(-4e-5, 4e-5, x.shape)
    with open(os.path.join(folder, "particles.data"), "w") as f:
        f.write(data_file("0 0.024 0 0.004 0 0.04", x, D, RHO_P))


def measure(folder, c):
    t = read_thermo(os.path.join(folder, "log.liggghts"))
    col = lambda n: t[n] if n in t else t[n.split("_", 1)[-1]]
    volume = t["Atoms"][0] * np.pi / 6 * D**3
    return dict(last=float(col("c_vz")[-1]), velocity=col("c_vz")[1:], fallen=col("c_z")[0] - col("c_z")[1:], eps_min=float(col("f_gas[9]").min()),
                moved=float(np.abs(col("f_gas[8]")).max() / volume), courant=float(col("f_gas[3]").max()))
