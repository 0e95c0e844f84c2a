"""Pressure drop of a bed in gas or water: noise (rms of its jumps from coupling to coupling over the buoyant weight), error of its
mean, its spread; mean height of the centres; time means from 0.1 s on.

drop: |mean drop over the weight - 1|; water also carries its own momentum, which is nothing beside the weight.
"""
import os

import numpy as np

from harness import column, data_file, read_thermo

D, RHO_P, L, H, N = 1e-3, 2500.0, 12, 48, 1728
MEDIA = {"gas": dict(U=0.9, rho=1.2, mu=1.8e-5), "water": dict(U=0.03, rho=1000, mu=1e-3)}


def prepare(folder, choices):
    rng = np.random.default_rng(5)
    side = 11
    x = [(a, b, c) for c in np.arange(N // side**2 + 1) for b in range(side) for a in range(side)][:N]
    x = (np.array(x) * [1.09, 1.09, 1.02] + [0.55, 0.55, 0.52] + rng.uniform(-0.03, 0.03, (N, 3))) * D
    with open(os.path.join(folder, "particles.data"), "w") as f:
        f.write(data_file(f"0 {L * D} 0 {L * D} 0 {H * D}", x, D, RHO_P))
    with open(os.path.join(folder, "medium.inc"), "w") as f:
        f.writelines(f"variable {name} index {value}\n" for name, value in MEDIA[choices["medium"]].items())


def measure(folder, choices):
    rho = MEDIA[choices["medium"]]["rho"]
    weight = N * np.pi / 6 * D**3 * (RHO_P - rho) * 9.81 / (L * D)**2
    t = read_thermo(os.path.join(folder, "log.liggghts"))
    time, drop, z = column(t, "f_gas[1]"), column(t, "f_gas[4]") / weight, column(t, "c_z")
    late = time > 0.1
    return dict(noise=float(np.sqrt(np.mean(np.diff(drop[late])**2))), drop=float(abs(drop[late].mean() - 1)), spread=float(drop[late].std()),
                height=float(z[late].mean() / D))
