#!/usr/bin/python3
"""One particle, one-way, Schiller-Naumann drag, at Re = 0.1, 10 and 500, along x, y and z.

Without this test a drag with the wrong direction, a factor of eps, radius for diameter, a first half kick lost after
`run`, or an explicit drag that overshoots at large steps would pass. The reference is the same ODE integrated by a
Runge-Kutta method of order 4 with steps of tau/1000, and the terminal velocity from the balance of forces.
"""
import math

import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles

RHO, MU = 1000.0, 1e-3      # the fluid: water
RHO_P = 2500.0


def drag(v, d):
    """Drag force of still fluid on a sphere moving with v (Schiller & Naumann 1933)."""
    re = RHO * abs(v) * d / MU
    return 3 * math.pi * MU * d * v * (1 + 0.15 * re**0.687 if re < 1000 else 0.44 * re / 24)


def terminal(d, g):
    weight = (RHO_P - RHO) * math.pi / 6 * d**3 * g
    lo, hi = 0.0, 100.0
    for _ in range(200):
        mid = 0.5 * (lo + hi)
        lo, hi = (mid, hi) if drag(mid, d) < weight else (lo, mid)
    return lo


def reference(d, g, t):
    m = RHO_P * math.pi / 6 * d**3
    weight = (RHO_P - RHO) * math.pi / 6 * d**3 * g
    f = lambda v: (weight - drag(v, d)) / m
    v = x = 0.0
    tau = m * terminal(d, g) / weight
    n = max(2000, int(1000 * t / tau))
    h = t / n
    for _ in range(n):
        k1 = f(v); k2 = f(v + h / 2 * k1); k3 = f(v + h / 2 * k2); k4 = f(v + h * k3)
        x += h * (v + h / 6 * (k1 + k2 + k3))
        v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return v, x


def run(executable, d, g, axis, dt, steps, two_way=False, cell=None, every=1):
    L = 60 * d if dt < d / 10 / terminal(d, g) or two_way else max(60 * d, 20 * terminal(d, g) * dt)
    cells = [6, 6, 6]
    if cell:
        cells = [int(round(L / (cell * d)))] * 3
    vector = ["0", "0", "0"]
    vector[axis] = "1"
    data = data_file(f"0 {L!r} 0 {L!r} 0 {L!r}", [[L / 2 + 0.1 * d, L / 2 + 0.2 * d, L / 2 + 0.15 * d]], d, RHO_P)
    script = head_with_particles(dt, skin=max(d, L / 100)) + f"""  # few bins also in a large box
fix grav all gravity {g} vector {' '.join(vector)}
fix integrate all nve/sphere
fix gas all twogrid fine {cells[0]} {cells[1]} {cells[2]} ratio 1 1 1 density {RHO} viscosity {MU} every {every}
fix_modify gas drag schiller/naumann formulation B one-way {'no' if two_way else 'yes'}
{'fix_modify gas flow_rate ' + 'xyz'[axis] + ' 0' if two_way else ''}
dump d all custom 1 dump.txt id xu yu zu vx vy vz
dump_modify d format "%d %.15g %.15g %.15g %.15g %.15g %.15g"
thermo {steps}
run {steps}
"""
    r = Run(executable, script, files={"particles.data": data})
    frames = r.dump("dump.txt")
    x = np.array([f["xyz"[axis] + "u"][0] for _, f in frames])
    v = np.array([f["v" + "xyz"[axis]][0] for _, f in frames])
    other = max(abs(f["v" + "xyz"[a]][0]) for _, f in frames for a in range(3) if a != axis)
    return x - x[0], v, other


def main():
    executable, _ = arguments()
    c = Checks("one particle, one-way, Schiller-Naumann")
    for re in (0.1, 10, 500):
        # Diameter by the terminal Reynolds number under 9.81 m/s2.
        lo, hi = 1e-6, 1e-1
        for _ in range(200):
            d = math.sqrt(lo * hi)
            lo, hi = (d, hi) if RHO * terminal(d, 9.81) * d / MU < re else (lo, d)
        vt = terminal(d, 9.81)
        tau = RHO_P / (RHO_P - RHO) * vt / 9.81
        exact_of = {fraction: [reference(d, 9.81, k * fraction * tau) for k in range(1, round(5 / fraction) + 1)] for fraction in (0.5, 0.1)}
        for axis in (0, 1, 2):
            for fraction, exact in exact_of.items():
                dt, steps = fraction * tau, len(exact)
                x, v, other = run(executable, d, 9.81, axis, dt, steps)
                ev = max(abs(v[k] - exact[k - 1][0]) for k in range(1, steps + 1)) / vt
                ex = abs(x[-1] - exact[-1][1]) / exact[-1][1]
                c.below(f"Re {re} axis {axis} dt {fraction} tau: velocity error / v_t", ev, 0.006)
                c.below(f"Re {re} axis {axis} dt {fraction} tau: position error", ex, 0.002)
                c.below(f"Re {re} axis {axis} dt {fraction} tau: velocity across", other / vt, 1e-12)
            x, v, _ = run(executable, d, 9.81, axis, 4 * tau, 40)
            c.true(f"Re {re} axis {axis} dt 4 tau: monotone", bool(np.all(np.diff(v) > -1e-9 * vt)))
            c.below(f"Re {re} axis {axis} dt 4 tau: limit", abs(v[-1] - vt) / vt, 0.001)
    for cell in (4, 8):
        d = 1e-3
        vt = terminal(d, 9.81)
        tau = RHO_P / (RHO_P - RHO) * vt / 9.81
        _, v, _ = run(executable, d, 9.81, 2, 0.05 * tau, 200, two_way=True, cell=cell)
        c.note(f"two-way, particle cell {cell} d, Re {RHO * vt * d / MU:.0f}: v/v_t - 1 = {v[-1] / vt - 1:+.3f} (self-disturbance)")
    c.end()


if __name__ == "__main__":
    main()
