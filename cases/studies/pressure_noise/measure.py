"""Noise of the pressure while a cloud of spheres crosses cells: rms over cells and couplings of p minus its time mean,
and the largest jump from its mean of the pressure drop; over rho v^2 where inertia rules, over the pressure drop of the
cloud at a slip of v where drag does.
"""
import os

import h5py
import numpy as np

from harness import data_file, read_thermo

WIDTH, LOW, HIGH, HEIGHT, V, D, RHO = 16, 5, 13, 24, 1.0, 1e-3, 1.2
EPS = 0.95
FROM = 1e-3   # s


def prepare(folder, choices):
    n = round((1 - EPS) * WIDTH**2 * (HIGH - LOW) / (np.pi / 6))
    # Independent places, so that crossings are: they overlap, but never move against each other.
    x = np.random.default_rng(3).uniform([0, 0, LOW], [WIDTH, WIDTH, HIGH], (n, 3))
    box = f"0 {WIDTH * D} 0 {WIDTH * D} 0 {HEIGHT * D}"
    with open(os.path.join(folder, "particles.data"), "w") as f:
        f.write(data_file(box, x * D, D, 1e8, np.tile([0.3 * V, 0.2 * V, V], (len(x), 1))))


def measure(folder, choices):
    mu = float(choices["mu"])
    scale = RHO * V**2 if mu < 1e-2 else 18 * mu * (1 - EPS) / D**2 * V * (HIGH - LOW) * D
    with h5py.File(os.path.join(folder, "noise.h5")) as f:
        variance = f["average/fine/p_variance"][:]
    t = read_thermo(os.path.join(folder, "log.liggghts"))
    time, drop = (t.get(f"f_gas[{i}]", t.get(f"gas[{i}]")) for i in (1, 4))
    drop = drop[time > FROM]
    return dict(rms=float(np.sqrt(np.mean(variance)) / scale), drop_peak=float(np.max(abs(drop - drop.mean())) / scale),
                drop_rms=float(drop.std() / scale))


def conclude(rows):
    """Exponents n of noise ~ dt^n between the coupling intervals, by method and viscosity."""
    out = ["Exponents of the noise in the coupling interval, between neighbouring intervals (rms of p; peak of the drop)", ""]
    good = [r for r in rows if r["state"] == "ok" and r.get("dt") and r.get("mu")]
    for mu, rule in (("1.8e-05", "inertia rules"), ("2.4", "drag rules")):
        out.append(f"{rule} (mu = {mu} Pa s)")
        for m in dict.fromkeys(r["method"] for r in good):
            mine = sorted((r for r in good if r["method"] == m and r["mu"] == mu and ", mu=" in r["name"]), key=lambda r: -float(r["dt"]))
            if len(mine) < 2:
                continue
            n = lambda k: " ".join(f"{np.log(a[k] / b[k]) / np.log(float(a['dt']) / float(b['dt'])):+.2f}" for a, b in zip(mine, mine[1:]))
            out.append(f"  {m:32s} rms {n('rms')}   peak {n('drop_peak')}")
    return "\n".join(out)
