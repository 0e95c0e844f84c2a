#!/usr/bin/python3
"""10,000 particles inserted in one step of a gas flow, and a region of them deleted; also in a closed box.

Bounded: gas speed and pressure right after, at every coupling; gas out = in + displaced by motion. In the ledger: the volume that
came (f_gas[14]) and went (f_gas[15]) is that of the particles.
Without this test an insertion would be taken for motion: at eps from 1 to 0.94 within 0.1 ms d(eps)/dt would blow the gas out at
20 m/s, or, in a closed box, leave the pressure solve without an answer.
"""
import math

import numpy as np

from hard import Checks, Run, arguments, column, head, walls
from outlets import frames

L, H, D, RHO_P, G, N = 0.024, 0.048, 0.6e-3, 2500.0, 9.81, 10000
V_P, DT, EVERY, U = math.pi / 6 * D**3, 1e-5, 10, 0.3


def script(closed):
    floor, top = ("slip", "slip") if closed else (f"inlet 0 0 {U}", "pressure 0")
    return head(f"0 {L} 0 {L} 0 {H}", DT, boundary="f f f", kn=50, kt=15, gamman=2e-4, gammat=1e-4, mu=0.2, skin=3e-4).replace(
        "newton off", "newton off\natom_modify sort 0 0") + walls(xplane=(0, L), yplane=(0, L), zplane=(0, H)) + f"""
fix weight all gravity {G} vector 0 0 -1
fix motion all nve/sphere
fix gas all twogrid fine 8 8 16 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every {EVERY}
fix_modify gas deposit trilinear
fix_modify gas boundary zlo {floor} boundary zhi {top} initial u 0 0 {0 if closed else U}
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
fix_modify gas output every {EVERY} file bed.h5 fields u p eps faces particles no
thermo {EVERY}
thermo_style custom step atoms f_gas[3] f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[9] f_gas[14] f_gas[15]
thermo_modify format float %.14g lost error norm no
run 200
region fill block 0 {L} 0 {L} 0.002 0.046 units box
fix ball all particletemplate/sphere 15485863 atom_type 1 density constant {RHO_P} radius constant {D / 2}
fix mix all particledistribution/discrete 32452843 1 ball 1.0
fix pour all insert/pack seed 49979687 distributiontemplate mix vel constant 0 0 0 insert_every once overlapcheck yes all_in yes &
    maxattempt 300 particles_in_region {N} region fill
run 200
unfix pour
region low block 0 {L} 0 {L} 0 0.02 units box
delete_atoms region low compress no
run 200
"""


def case(c, executable, ranks, closed):
    name = f"{'closed box' if closed else 'flow'}, {ranks} ranks"
    r = Run(executable, script(closed), ranks)
    t = r.thermo()
    steps, atoms = t["Step"], t["Atoms"]
    came, went = column(t, "f_gas[14]"), column(t, "f_gas[15]")
    left = atoms[-1]
    c.true(f"{name}: {N} came, {N - left:.0f} were deleted", atoms[steps == 400][0] == N and 0.2 * N < left < 0.8 * N)
    c.below(f"{name}: volume that came, in the ledger, relative error", abs(came[-1] / (N * V_P) - 1), 1e-12)
    c.below(f"{name}: volume that went, relative error", abs(went[-1] / ((N - left) * V_P) - 1), 1e-9)
    c.below(f"{name}: solid volume error", column(t, "f_gas[6]").max(), 1e-13)
    c.below(f"{name}: momentum exchange error", column(t, "f_gas[7]").max(), 1e-12)
    c.below(f"{name}: continuity error (U/h)", column(t, "f_gas[5]").max(), 1e-4)
    into, out, displaced, _, speed, _, spread = frames(r.file("bed.h5"))
    if closed:  # all starts at rest: what moves the gas is the fall of the particles
        fall = G * 400 * DT
        c.below(f"{name}: largest gas speed / fall of the particles (g t)", speed.max() / fall, 2)
    else:
        c.below(f"{name}: (out - in - displaced)/in", np.abs(out - into - displaced).max() / into.max(), 1e-5)
        c.below(f"{name}: largest gas speed / (inflow / eps_min)", speed.max() / (U / column(t, "f_gas[9]").min()), 1.5)
    weight = N * V_P * RHO_P * G / L**2
    c.below(f"{name}: range of p / weight over area", spread.max() / weight, 1)


def main():
    executable, ranks = arguments()
    c = Checks("insertion of 10,000 particles in one step, deletion of a region")
    case(c, executable, 1, False)
    case(c, executable, max(ranks), True)
    c.end()


if __name__ == "__main__":
    main()
