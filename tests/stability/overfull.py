#!/usr/bin/python3
"""Spheres of sizes 1:5, pressed into each other until particle cells would have a void fraction below 0.30; gas blows through.

Bounded: void fraction at least 0.30 where the bound moves volume, gas speed, particle speed. Conserved: solid volume to 1e-13,
momentum exchange. The bound reports what it moved (f_gas[8]); nothing is left without a place.
Without this test volume above the bound could be thrown away in silence, or eps go to zero and the drag with it to infinity.
"""
import math

import numpy as np

from hard import Checks, Run, arguments, column, data_file, head_with_particles, walls

W, H, RHO, RHO_P, MU, U = 0.012, 0.036, 1.2, 2500.0, 1.8e-5, 0.6
SIZES = np.array([0.4e-3, 1.0e-3, 2.0e-3])
PRESS = 200.0  # m/s2: twenty times gravity on soft springs


def bed(rng):
    """Large spheres on a lattice, small ones in its gaps, still without overlap."""
    x, d = [], []
    for k in range(8):
        for a in range(5):
            for b in range(5):
                x.append((1.2e-3 + 2.4e-3 * a, 1.2e-3 + 2.4e-3 * b, 1.1e-3 + 3.2e-3 * k))
                d.append(SIZES[2])
        for a in range(4):
            for b in range(4):
                x.append((2.4e-3 + 2.4e-3 * a, 2.4e-3 + 2.4e-3 * b, 1.1e-3 + 3.2e-3 * k))
                d.append(SIZES[1])
        for a in range(14):
            for b in range(14):
                x.append((0.5e-3 + 0.84e-3 * a, 0.5e-3 + 0.84e-3 * b, 2.7e-3 + 3.2e-3 * k))
                d.append(SIZES[0])
    x = np.array(x)
    return x + rng.uniform(-2e-5, 2e-5, x.shape), np.array(d)


def script(bound):
    x, d = bed(np.random.default_rng(3))
    return x, d, data_file(f"0 {W} 0 {W} 0 {H}", x, d, RHO_P), head_with_particles(
        1e-5, boundary="f f f", kn=60, kt=15, gamman=2e-3, gammat=1e-3, mu=0.1, skin=4e-4) + walls(
            xplane=(0, W), yplane=(0, W), zplane=(0, H)) + f"""
fix press all gravity {PRESS} vector 0 0 -1
fix motion all nve/sphere
fix gas all twogrid fine 8 8 24 ratio 2 2 2 density {RHO} viscosity {MU} every 10
fix_modify gas deposit trilinear eps bound {bound}
fix_modify gas boundary zlo inlet 0 0 {U} boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
variable speed atom sqrt(vx*vx+vy*vy+vz*vz)
compute fastest all reduce max v_speed
thermo 10
thermo_style custom step atoms c_fastest f_gas[2] f_gas[3] f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[8] f_gas[9]
thermo_modify format float %.14g lost error norm no
run 3000
"""


def main():
    executable, _ = arguments()
    c = Checks("void fraction down to 0.30, sizes 1:5")
    for bound in ("move 0.3", "clip 0.3"):
        x, d, data, text = script(bound)
        r = Run(executable, text, 1, files={"particles.data": data})
        t = r.thermo()
        total = math.pi / 6 * np.sum(d**3)
        moved = column(t, "f_gas[8]")
        c.true(f"{bound}: all {len(x)} particles there", np.all(t["Atoms"] == len(x)))
        c.true(f"{bound}: it was needed: {moved.max() / total:.2%} of the solids above the bound at most", moved.max() > 1e-4 * total)
        c.below(f"{bound}: 0.30 less the smallest void fraction", 0.3 - column(t, "f_gas[9]").min(), 1e-12)
        error = column(t, "f_gas[6]")
        if bound.startswith("move"):
            c.below("move: solid volume error", error.max(), 1e-13)
        else:
            c.below("clip: what it threw away is the solid volume's error", np.abs(error * total - moved).max() / total, 1e-12)
        c.below(f"{bound}: momentum exchange error", column(t, "f_gas[7]").max(), 1e-12)
        c.below(f"{bound}: continuity error (U/h)", column(t, "f_gas[5]").max(), 1e-4)
        c.below(f"{bound}: Courant number", column(t, "f_gas[3]").max(), 0.4)
        fall = math.sqrt(2 * PRESS * H)
        fastest = column(t, "c_fastest")
        c.below(f"{bound}: fastest particle / its free fall through the box (they are thrown together and up again)", fastest.max() / fall, 2)
        c.below(f"{bound}: the same in the last third", fastest[2 * len(fastest) // 3:].max() / fall, 1)
        gas = column(t, "f_gas[3]")[1:] / column(t, "f_gas[2]")[1:] * (W / 8)  # of the fastest: Courant number times cell over step
        c.below(f"{bound}: fastest gas / (inflow / 0.30 + fastest particle)", gas.max() / (U / 0.3 + fastest.max()), 3)
    c.end()


if __name__ == "__main__":
    main()
