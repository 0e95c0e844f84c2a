#!/usr/bin/python3
"""Gas set in motion through a held lattice by a pressure gradient that is switched on: its velocity in time against the exact
solution, formulations A and B, and the order of the error in the coupling interval.

Without this test formulation A's route as a user runs it (the fluid feels all of grad p, the particles' -V_p grad p comes back
with their impulses, rebuilt from the fluid's own momentum balance) would rest on tests of its steady state: a share of the
gradient lost or doubled in time, or a force that lags a whole interval for ever, leaves that state as it is.

Reference. All is uniform: rho eps du/dt = -eps G - beta u in A, rho eps du/dt = -G - (beta/eps) u in B, beta = n 3 pi mu d (Stokes), so
    u = -(eps G/beta) (1 - exp(-t/T)),   T = rho eps/beta in A, rho eps^2/beta in B.
"""
import math

import numpy as np

from harness import Checks, Run, arguments, column, data_file, head_with_particles

D, A, RHO, MU, G = 1e-3, 1.25e-3, 1.2, 1.8e-5, -20.0
N = 4
AXES = "xyz"


def script(formulation, axis, read, interval, end):
    L = N * A
    q = (np.arange(N) + 0.5) * A
    x = [(i, j, k) for k in q for j in q for i in q]
    gradient = [0.0] * 3
    gradient[axis] = G
    every = 10
    return data_file(f"0 {L} 0 {L} 0 {L}", x, D, 2500), head_with_particles(interval / every, skin=3e-4) + f"""
fix gas all twogrid fine {N} {N} {N} ratio 2 2 2 density {RHO} viscosity {MU} every {every}
fix_modify gas drag stokes formulation {formulation} deposit centroid read {read} dt {interval!r}
fix_modify gas pressure_gradient {gradient[0]} {gradient[1]} {gradient[2]}
compute u all reduce ave f_gas[{8 + axis}]
thermo {every}
thermo_style custom step f_gas[1] c_u f_gas[7]
thermo_modify format float %.14g
run {every * round(end / interval)}
"""


def main():
    executable, _ = arguments()
    c = Checks("gas through a held lattice, in time")
    eps = 1 - math.pi / 6 * (D / A)**3
    beta = 3 * math.pi * MU * D / A**3
    for formulation, axis, read in (("A", 2, "cell"), ("A", 0, "trilinear"), ("B", 1, "cell")):
        T = RHO * eps / beta * (1 if formulation == "A" else eps)
        errors = []
        for parts in (20, 40, 80, 160):
            data, text = script(formulation, axis, read, T / parts, 2 * T)
            r = Run(executable, text, 1, ["-fluid_pressure_rtol", "1e-11"], files={"particles.data": data})
            t = r.thermo()
            time, u = column(t, "f_gas[1]"), t["u"] if "u" in t else t["c_u"]
            exact = -eps * G / beta * (1 - np.exp(-time / T))
            errors.append(np.abs(u - exact).max() / (-eps * G / beta))
            c.below(f"{formulation} along {AXES[axis]}, T/{parts}: action and reaction", column(t, "f_gas[7]").max(), 1e-12)
        order = np.log2(np.array(errors[:-1]) / errors[1:])
        c.note(f"{formulation} along {AXES[axis]}, read {read}: largest errors {', '.join(f'{e:.2e}' for e in errors)} at T/20 to T/160, orders "
               + ", ".join(f"{o:.2f}" for o in order))
        wanted = 1 if formulation == "A" else 2  # in A the particles' share of the gradient is that of the interval before
        c.below(f"{formulation} along {AXES[axis]}: {wanted} less the order in the interval", wanted - order[-1], 0.1)
        c.below(f"{formulation} along {AXES[axis]}: error at T/160", errors[-1], 0.02)
    c.end()


if __name__ == "__main__":
    main()
