"""Paths of inertial particles against the equation m dv/dt = 3 pi mu d (u - v) in the analytic field

    u = U exp(-2 nu k^2 t) sin(k x) cos(k y),  v = -U exp(-2 nu k^2 t) cos(k x) sin(k y),

integrated here by Runge and Kutta's fourth-order rule. Errors after 40 ms, some 2.5 turns' worth of way: velocity (rms,
over U) and position (rms, over the length of the box).
"""
import functools
import os

import numpy as np

from harness import data_file, read_dump

L, U, NU, D, RHO_P, MU, T, N = 16e-3, 0.5, 1.5e-5, 1e-4, 100.0, 1.8e-5, 0.04, 400
K, TAU = 2 * np.pi / L, RHO_P * D**2 / (18 * MU)


def gas(x, t):
    a = U * np.exp(-2 * NU * K**2 * t)
    return a * np.stack([np.sin(K * x[:, 0]) * np.cos(K * x[:, 1]), -np.cos(K * x[:, 0]) * np.sin(K * x[:, 1])], 1)


def start():
    x = np.random.default_rng(4).uniform(0, L, (N, 2))
    return x, gas(x, 0)


@functools.lru_cache(maxsize=None)
def exact(dt=2e-5):
    x, v = start()
    y = np.concatenate([x, v], 1)
    rate = lambda y, t: np.concatenate([y[:, 2:], (gas(y[:, :2], t) - y[:, 2:]) / TAU], 1)
    for i in range(round(T / dt)):
        t = i * dt
        k1 = rate(y, t)
        k2 = rate(y + 0.5 * dt * k1, t + 0.5 * dt)
        k3 = rate(y + 0.5 * dt * k2, t + 0.5 * dt)
        k4 = rate(y + dt * k3, t + dt)
        y = y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return y[:, :2], y[:, 2:]


def prepare(folder, choices):
    x, v = start()
    flat = np.full((N, 1), 1e-3)
    with open(os.path.join(folder, "particles.data"), "w") as f:
        f.write(data_file(f"0 {L} 0 {L} 0 2e-3", np.hstack([x, flat]), D, RHO_P, np.hstack([v, 0 * flat])))


def measure(folder, choices):
    p = read_dump(os.path.join(folder, "particles.txt"))[-1][1]
    x, v = exact()
    off = np.stack([p["x"], p["y"]], 1) - x
    off -= L * np.round(off / L)
    slip = np.stack([p["vx"], p["vy"]], 1) - v
    rms = lambda q: float(np.sqrt(np.mean(np.sum(q**2, 1))))
    return dict(velocity=rms(slip) / U, position=rms(off) / L)
