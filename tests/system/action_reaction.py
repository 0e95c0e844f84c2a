#!/usr/bin/python3
"""Momentum of fluid and particles together, measured from outside: from velocities in the output file alone.

    action_reaction.py EXECUTABLE RANKS

A periodic box without gravity, moving particles, fluid at rest; several runs, whose ends don't fall on couplings. At the
coupling of step n, with one fluid step of constant length D an interval,

    T_n = sum m v - dt/2 sum f  +  P_n + (P_n - P_(n-1))/2,     P = rho_f sum eps_f u_f V_f

must not change. f is the fluid's force on the particles (drag and pressure force) of step n: velocity Verlet has given half
of its kick by the end of the step, and none of it has reached the fluid yet. The last term is what the two-step formula
(BDF2) in time has still to hand on. Contacts keep the particles' momentum. Wanted: |T_n - T_1| at most 1e-12 of
sum m |v|, for both formulations.

What would pass falsely without it: forces that the coupling counts and LIGGGHTS doesn't apply (or twice, or half of them at
the ends of runs, where velocity Verlet gives half kicks); a ledger that balances its own two sides only.
"""

import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from harness import launch

LIMIT = 1e-12
DT, RHO_P, RHO_F, D = 1e-5, 2500.0, 1.2, 1e-3

SCENE = """\
atom_style      granular
boundary        p p p
newton          off
communicate     single vel yes
units           si
region          box block 0 0.008 0 0.008 0 0.016 units box
create_box      1 box
neighbor        0.0005 bin
neigh_modify    delay 0
fix             m1 all property/global kn peratomtypepair 1 1000
fix             m2 all property/global kt peratomtypepair 1 300
fix             m3 all property/global gamman_abs peratomtypepair 1 1e-3
fix             m4 all property/global gammat_abs peratomtypepair 1 1e-3
fix             m5 all property/global coefficientFriction peratomtypepair 1 0.3
pair_style      gran model hooke/stiffness tangential history absolute_damping on
pair_coeff      * *
timestep        1e-5
fix             integrate all nve/sphere
lattice         sc 0.0016
create_atoms    1 box
set             group all diameter 0.001 density 2500
region          half block INF INF INF INF INF 0.008 units box
group           low region half
velocity        all set 0.1 0.05 0.3
velocity        low set -0.2 0.1 0.7
fix             gas all twogrid fine 8 8 16 ratio 4 4 4 density 1.2 viscosity 1.8e-5 every 10
fix_modify      gas formulation {formulation} dt 1e-4 output every 10 file box.h5 fields u p eps faces
thermo_style    custom step atoms f_gas[2] f_gas[7]
thermo          100
run             205
run             195
run             0
run             3
run             100
"""


def total(frame, particles, before):
    """T_n and sum m |v| (3 components each), P_n (3)."""
    eps = frame["eps"][...]
    volume = 0.008 * 0.008 * 0.016 / eps.size
    fluid = np.empty(3)
    for d, name in enumerate("xyz"):
        axis = 2 - d  # arrays are [z][y][x]
        eps_f = 0.5 * (eps + np.roll(eps, 1, axis))  # face i lies between cells i-1 and i
        fluid[d] = RHO_F * np.sum(eps_f * frame["faces/u" + name][...]) * volume
    m = RHO_P * np.pi / 6 * D**3
    v = particles["velocity"][...]
    force = particles["drag"][...] + particles["pressure_force"][...]
    solid = m * v.sum(axis=0) - 0.5 * DT * force.sum(axis=0)
    return solid + fluid + (0 if before is None else 0.5 * (fluid - before)), m * np.abs(v).sum(), fluid


def main():
    executable, ranks = os.path.abspath(sys.argv[1]), int(sys.argv[2])
    bad = 0
    for formulation in "AB":
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "in.box"), "w") as f:
                f.write(SCENE.format(formulation=formulation))
            done = subprocess.run([*launch(ranks), executable, "-in", "in.box", "-log", "none",
                                   "-fluid_pressure_rtol", "1e-12"], cwd=folder, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, encoding="utf-8", errors="replace")
            if done.returncode != 0:
                print(done.stdout[-2000:])
                return 1
            with h5py.File(os.path.join(folder, "box.h5"), "r") as h5:
                frames = sorted(h5["fluid"])
                steps = [int(h5["fluid"][k]["step"][()]) for k in frames]
                before, history, scale = None, [], 0.0
                for k in frames:
                    T, size, before = total(h5["fluid"][k], h5["particles"][k], before)
                    history.append(T)
                    scale = max(scale, size)
                handed_over = np.abs(before).max() / scale
        drift = np.abs(np.array(history[2:]) - history[1]).max() / scale
        print("formulation %s, %d ranks, %d couplings (steps %d to %d): drift %.2e of sum m |v| (wanted: at most %.0e); "
              "the fluid has got %.2e of it" % (formulation, ranks, len(frames) - 1, steps[0], steps[-1], drift, LIMIT,
                                                handed_over))
        bad += not drift <= LIMIT or steps != list(range(0, 501, 10)) or handed_over < 1e-4
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
