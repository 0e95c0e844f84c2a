"""Slip of a homogeneous suspension that starts from rest, against its exact course.

With no net flux of volume, eps u = -eps_s v. Then (formulation B, drag (b/eps)(u - v) on a particle)
    dv/dt = -g' - v/T,      g' = g (1 - rho_f/rho_p),  T = eps^2 m/b
and in A, with -grad p taken from the fluid's equation,
    (1 + a) dv/dt = -g' - b v/(eps^2 m),   a = eps_s rho_f/(eps rho_p): T = (1 + a) eps^2 m/b.
Exact: v = v_end (1 - exp(-t/T)). Delta: coupling interval; tau = eps m/b: response time of a particle in B, T = eps tau.
"""
import math
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "tests", "system"))
from harness import data_file, read_thermo  # noqa: E402

D, G, EPS, N = 1e-3, 9.81e-3, 0.4, 6
V = math.pi / 6 * D**3
SPACING = (V / (1 - EPS))**(1 / 3)


def prepare(folder, c):
    q = (np.arange(N) + 0.5) * SPACING
    L = N * SPACING
    x = [(a, b, z) for z in q for b in q for a in q]
    with open(os.path.join(folder, "particles.data"), "w") as f:
        f.write(data_file(f"0 {L!r} 0 {L!r} 0 {L!r}", x, D, c["rho_p"]))


def measure(folder, c):
    t = read_thermo(os.path.join(folder, "log.liggghts"))
    vz = t.get("vz", t.get("c_vz"))
    b_m = 3 * math.pi * c["mu"] * D / (c["rho_p"] * V)
    ratio = c["rho"] / c["rho_p"]
    T = EPS**2 / b_m * (1 + (1 - EPS) / EPS * ratio if c["form"] == "A" else 1)
    v_end = -(1 - ratio) * G * EPS**2 / b_m
    time = t["Step"] * c["dt"]
    error = np.abs(vz / v_end - (1 - np.exp(-time / T)))
    half = error[len(error) // 5:]  # the first intervals know no past
    return dict(largest=float(error.max()), late=float(half.max()), last=float(error[-1]), interval_over_tau=c["k"] * EPS)
