#!/usr/bin/python3
"""Settling in boxes that are periodic in one, two and three directions, the mixture's weight balanced by a pressure gradient:
nothing outside acts along the periodic directions, so the mixture's momentum along them stays what it was, to 1e-10 of
sum m|v|, at every coupling; formulations A and B.

Momentum from outside the coupling: written face velocities and void fractions, LIGGGHTS' dump; pending halves counted as in
tests/system/momentum.py. Without this test gravity, buoyancy and the imposed gradient could each act on a little more or
less than the mixture's weight, as with an eps left out or a side taken twice, and the box would run away over a long run.
"""
import h5py
import numpy as np

from hard import Checks, Run, arguments, data_file, head_with_particles, step_of, walls
from momentum import momentum_of_fluid

L, D, RHO, RHO_P, MU, G, N, EVERY, DT = 0.016, 1e-3, 1.2, 2500.0, 1.8e-5, 9.81, 300, 10, 2e-5
V_P = np.pi / 6 * D**3


def script(formulation, periodic, couplings):
    rng = np.random.default_rng(8)
    lattice = (np.arange(12) + 0.5) * L / 12
    x = np.array([(a, b, z) for z in lattice for b in lattice for a in lattice])[rng.permutation(12**3)[:N]]
    v = rng.uniform(-0.05, 0.05, (N, 3))
    balance = -N * V_P * (RHO_P - RHO) * G / L**3   # Pa/m: pushes up
    closed = [d for d in range(3) if not periodic[d]]
    sides = "".join(f"fix_modify gas boundary {'xyz'[d]}lo slip boundary {'xyz'[d]}hi slip\n" for d in closed)
    return {"particles.data": data_file(f"0 {L} 0 {L} 0 {L}", x, D, RHO_P, v)}, head_with_particles(
        DT, boundary=" ".join("p" if q else "f" for q in periodic), mu=0.0, gamman=0.002, skin=4e-4) + walls(
            **{"xyz"[d] + "plane": (0, L) for d in closed}) + f"""
fix grav all gravity {G} vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 8 8 8 ratio 2 2 2 density {RHO} viscosity {MU} every {EVERY}
fix_modify gas formulation {formulation} deposit trilinear
{sides}fix_modify gas pressure_gradient 0 0 {balance!r} dt {EVERY * DT!r}
fix_modify gas output every {EVERY} file bed.h5 fields u p eps faces particles no
dump d all custom {EVERY} dump.txt id mass vx vy vz f_gas[1] f_gas[2] f_gas[3] f_gas[4] f_gas[5] f_gas[6]
dump_modify d format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
thermo {EVERY}
thermo_style custom step atoms f_gas[6] f_gas[7] f_gas[9]
run {couplings * EVERY}
"""


def main():
    executable, ranks = arguments()
    c = Checks("settling in periodic boxes, weight balanced")
    for periodic in ((0, 0, 1), (1, 0, 1), (1, 1, 1)):
        for formulation in "BA":
            files, text = script(formulation, periodic, 60)
            r = Run(executable, text, max(ranks), ["-fluid_pressure_rtol", "1e-13"], files=files)
            dump = dict(r.dump("dump.txt"))
            total, scale, slip, before = [], [], [], None
            with h5py.File(r.file("bed.h5")) as f:
                widths = [f["grid/" + a][1] - f["grid/" + a][0] for a in "xyz"]
                for name in sorted(f["fluid"]):
                    p = dump[step_of(f["fluid/" + name])]
                    M = momentum_of_fluid(f["fluid/" + name], widths, RHO)
                    pending = 0.5 * (M - before) if before is not None else 0 * M
                    before = M
                    v = np.array([p["v" + a] for a in "xyz"])
                    force = np.array([np.sum(p[f"f_gas[{i + 1}]"] + p[f"f_gas[{i + 4}]"]) for i in range(3)])
                    total.append(M + pending + (p["mass"] * v).sum(axis=1) - 0.5 * DT * force)
                    scale.append(np.sum(p["mass"] * np.linalg.norm(v, axis=0)))
                    slip.append(M[2] / (RHO * (L**3 - N * V_P)) - v[2].mean())
            # The first step is backward Euler and has no pending part.
            total, scale = np.array(total)[2:], np.array(scale)[2:]
            drift = np.abs(total - total[0])[:, np.array(periodic, bool)] / scale[:, None]
            what = f"{formulation}, periodic in {''.join(a for a, q in zip('xyz', periodic) if q)}"
            c.note(f"{what}: slip at the end {slip[-1]:.3f} m/s")
            c.below(f"{what}: drift of momentum / sum m|v|, over 60 couplings", drift.max(), 1e-10)
            c.true(f"{what}: they do settle", slip[-1] > 0.05)
    c.end()


if __name__ == "__main__":
    main()
