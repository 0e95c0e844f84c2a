#!/usr/bin/python3
"""Drag far stiffer than the step.
(a) 60 um particles in air at eps = 0.4, fluid step 100 rho eps/beta. Fixed bed of two columns, eps 0.4 and 0.6, side by side,
    flow started at once: each column's velocity against Ergun's law solved for one pressure gradient in both. The same
    particles settling from rest in a closed box: slip against the law.
(b) 60 um particles in water, column closed at both ends, eps_s = 0.05: coupling interval 10 response times, DEM step a
    fifth of one, or 10, too. Settling velocity in the middle of the column against the law at no net flux.
Formulations A and B. Bounded: error of the velocity to 0.5 %; no oscillation: an error beyond that never changes sign after
the first two steps, in which BDF2 starts (backward Euler leaves 1/(1 + z) of the state before an impulsive start, the second
step -1/2 of that /(3/2 + z), z = beta dt/(rho eps): both are printed).

Without this test a drag that rings (Crank-Nicolson at stiff steps), one that is limited so as not to overshoot (right
sign, wrong velocity), or particles and fluid that see different drags in a long interval would pass.

Reference: published formulas, evaluated in system/fixed_bed.py; (rho_p - rho) V_p g eps = b w, b = 3 pi mu d eps F.
"""
import math

import numpy as np

from hard import Checks, Run, arguments, column, data_file, head_with_particles
from fixed_bed import reference

D, G, RHO_P = 60e-6, 9.81, 2500.0
V = math.pi / 6 * D**3


def bisect(f, lo, hi):
    """Root of a function that is negative at lo and positive at hi."""
    for _ in range(200):
        mid = 0.5 * (lo + hi)
        lo, hi = (mid, hi) if f(mid) < 0 else (lo, mid)
    return 0.5 * (lo + hi)


def coefficient(law, eps, w, rho, mu, d=D):
    """b_p (formulation A), kg/s, at the slip w."""
    return 3 * math.pi * mu * d * eps * reference(law, eps, max(rho * eps * w * d / mu, 1e-12))


def slip(law, eps, rho, mu, rho_p=RHO_P, d=D):
    """Steady slip of a homogeneous suspension under gravity, m/s, positive."""
    weight = abs(rho_p - rho) * math.pi / 6 * d**3 * G * eps
    return bisect(lambda w: coefficient(law, eps, w, rho, mu, d) * w - weight, 0.0, 10.0)


def lattice(n, spacing, origin=(0, 0, 0)):
    a, b, c = ((np.arange(n[i]) + 0.5) * spacing[i] + origin[i] for i in range(3))
    return [(p, q, r) for r in c for q in b for p in a]


def sign_changes(error):
    """Of an error beyond 0.5 %, after the first two steps."""
    large = error[2:][np.abs(error[2:]) > 5e-3]
    return int(np.sum(large[1:] * large[:-1] < 0))


def head(dt, x, box, boundary, rho_p=RHO_P, d=D, skin=0.2):
    text = head_with_particles(dt, boundary=boundary, kn=1e-12, kt=1e-12, mu=0.0, skin=skin * d)
    return data_file(box, x, d, rho_p), text.replace("neigh_modify delay 0", "neigh_modify delay 0 one 10000 page 100000")


def through_flow(executable, c, formulation):
    rho, mu, law, U = 1.2, 1.8e-5, "ergun", 0.02
    cell, width = 4 * D, 16 * D     # columns four particle cells wide; in a cell 4 x 3 x 6 and 4 x 4 x 3 particles
    x, found_eps = [], []
    for i, (a, b, z) in enumerate(((4, 3, 6), (4, 4, 3))):
        x += lattice((4 * a, 2 * b, 2 * z), (cell / a, cell / b, cell / z), (i * width, 0, 0))
        found_eps.append(1 - a * b * z * V / cell**3)
    box = f"0 {2 * width!r} 0 {2 * cell!r} 0 {2 * cell!r}"
    # u_i and the gradient: beta_i u_i/eps_i = grad p in both, the mean of eps_i u_i is U.
    def velocity(e, gradient):
        return bisect(lambda w: 18 * mu * (1 - e) * reference(law, e, max(rho * e * w * D / mu, 1e-12)) / D**2 * w - gradient, 0.0, 100.0)
    gradient = bisect(lambda p: np.mean([e * velocity(e, p) for e in found_eps]) - U, 0.0, 1e9)
    exact = [velocity(e, gradient) for e in found_eps]
    beta = 18 * mu * found_eps[0] * (1 - found_eps[0]) * reference(law, found_eps[0], rho * found_eps[0] * exact[0] * D / mu) / D**2
    step = 100 * rho * found_eps[0] / beta
    # Heavy: a kick at a coupling (coupling.h) gives velocity to particles that nothing integrates, too.
    data, text = head(step / 10, x, box, "p p p", rho_p=1e6 * RHO_P)
    text += f"""
# The inner cells of a column: beside the other column the gas shears.
region left block {cell!r} {3 * cell!r} INF INF INF INF units box
region right block {width + cell!r} {width + 3 * cell!r} INF INF INF INF units box
group left region left
group right region right
fix gas all twogrid fine 16 4 4 ratio 2 2 2 density {rho} viscosity {mu} every 10
# Read cell: what is read between cells reaches into the border cell.
fix_modify gas method paper drag {law} formulation {formulation} dt {step!r}
fix_modify gas flow_rate z {U}
compute left left reduce ave f_gas[10]
compute right right reduce ave f_gas[10]
compute el left reduce ave f_gas[7]
compute er right reduce ave f_gas[7]
thermo 10
thermo_style custom step atoms c_left c_right c_el c_er f_gas[2] f_gas[7]
thermo_modify format float %.14g
run 400
"""
    r = Run(executable, text, 1, ["-fluid_pressure_rtol", "1e-9"], files={"particles.data": data})
    t = r.thermo()
    what = f"{formulation} fixed bed, step 100 rho eps/beta = {step:.1e} s"
    for i, name in enumerate(("left", "right")):
        error = column(t, f"c_{name}")[1:] / exact[i] - 1
        c.note(f"{what}, eps {column(t, 'c_e' + name[0])[-1]:.3f} ({found_eps[i]:.3f}): {exact[i]:.4e} m/s wanted; error by couplings: "
               + " ".join(f"{e:+.1e}" for e in error[[0, 1, 2, 3, 10, 39]]))
        c.below(f"{what}, eps {found_eps[i]:.2f}: error of the velocity", abs(error[-1]), 5e-3)
        c.below(f"{what}, eps {found_eps[i]:.2f}: changes of sign", sign_changes(error), 0)


def settling(executable, c, formulation):
    rho, mu, law, eps, n = 1.2, 1.8e-5, "ergun", 0.4, 6
    s = (V / (1 - eps))**(1 / 3)
    w = slip(law, eps, rho, mu)
    beta = (1 - eps) / V * coefficient(law, eps, w, rho, mu)
    step = 100 * rho * eps / beta
    L = n * s
    data, text = head(step / 4, lattice((n,) * 3, (s,) * 3), f"0 {L!r} 0 {L!r} 0 {L!r}", "p p p")
    text += f"""
fix grav all gravity {G} vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 4 4 4 ratio 2 2 2 density {rho} viscosity {mu} every 4
fix_modify gas drag {law} formulation {formulation} deposit trilinear
fix_modify gas flow_rate z 0 dt {step!r}
compute vz all reduce ave vz
compute uz all reduce ave f_gas[10]
thermo 4
thermo_style custom step atoms c_vz c_uz f_gas[2] f_gas[7]
thermo_modify format float %.14g
run 1600
"""
    t = Run(executable, text, 1, ["-fluid_pressure_rtol", "1e-9"], files={"particles.data": data}).thermo()
    error = -column(t, "c_vz")[1:] / (eps * w) - 1
    what = f"{formulation} settling in air, step 100 rho eps/beta = {step:.1e} s"
    c.note(f"{what}: {eps * w:.4e} m/s wanted; response time {RHO_P * (1 - eps) * eps / beta:.1e} s")
    c.below(f"{what}: error of the velocity", abs(error[-1]), 5e-3)
    c.below(f"{what}: changes of sign", sign_changes(error), 0)


def settling_column(executable, c, formulation, dem_steps):
    rho, mu, law, eps_s = 1000.0, 1e-3, "ergun/wenyu", 0.05
    s = (V / eps_s)**(1 / 3)                     # a particle cell is 2 spacings, 4.4 d
    w = slip(law, 1 - eps_s, rho, mu)
    b = coefficient(law, 1 - eps_s, w, rho, mu)
    tau = RHO_P * V * (1 - eps_s) / b            # response of the slip's mean motion
    interval = 10 * tau
    layers, above, below = 24, 4, 8
    L, H = 4 * s, (layers + above + below) * s
    data, text = head(interval / dem_steps, lattice((4, 4, layers), (s,) * 3, (0, 0, below * s)), f"0 {L!r} 0 {L!r} 0 {H!r}", "p p f", skin=2)
    text += f"""
region middle block INF INF INF INF {(below + 8) * s!r} {(below + layers - 8) * s!r} units box
group middle region middle
fix grav all gravity {G} vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 4 4 {layers + above + below} ratio 2 2 2 density {rho} viscosity {mu} every {dem_steps}
fix_modify gas drag {law} formulation {formulation} deposit trilinear
fix_modify gas boundary zlo slip boundary zhi slip
compute vz middle reduce ave vz
compute fastest middle reduce max vz
compute slowest middle reduce min vz
thermo {dem_steps}
thermo_style custom step atoms c_vz c_fastest c_slowest f_gas[3] f_gas[7]
thermo_modify format float %.14g lost error
run {60 * dem_steps}
"""
    t = Run(executable, text, 1, ["-fluid_pressure_rtol", "1e-9"], files={"particles.data": data}).thermo()
    error = -column(t, "c_vz")[1:] / ((1 - eps_s) * w) - 1
    what = f"{formulation} column in water, interval 10 tau in {dem_steps} DEM steps"
    c.note(f"{what}: {(1 - eps_s) * w:.4e} m/s wanted; falls {60 * interval * (1 - eps_s) * w / s:.1f} spacings; error by couplings: "
           + " ".join(f"{e:+.1e}" for e in error[[0, 1, 2, 3, 5, 10, 30, 59]]))
    c.below(f"{what}: error of the velocity, from the 5th coupling on", np.abs(error[5:]).max(), 5e-3)
    c.below(f"{what}: spread of the velocities", (column(t, "c_fastest") - column(t, "c_slowest"))[-1] / ((1 - eps_s) * w), 5e-3)
    c.below(f"{what}: changes of sign", sign_changes(error), 0)


def main():
    executable, _ = arguments()
    c = Checks("drag far stiffer than the step")
    for formulation in "BA":
        through_flow(executable, c, formulation)
        settling(executable, c, formulation)
        for dem_steps in (50, 1):
            settling_column(executable, c, formulation, dem_steps)
    c.end()


if __name__ == "__main__":
    main()
