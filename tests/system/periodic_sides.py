#!/usr/bin/python3
"""Beads fly through the periodic sides of a box of gas whose mean flux, gas and beads together, is given: at every coupling the gas's own flux
is the given one less that of the beads, sum V_p v / V from LIGGGHTS' dump, whether one of them has just come back on the other side or not.

Without this test the coupling could take such a bead's way for one through the whole box: the fix has to tell the box's periods. The gas would be
thrown back and forth by a hundred times the beads' flux, and momentum and volume would still balance.
Usage: periodic_sides.py EXECUTABLE RANKS...
"""
import h5py
import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles, step_of

L, D, RHO_P, N, EVERY, DT, STEPS, RATE = (0.016, 0.012, 0.02), 1e-3, 2500.0, 40, 10, 2e-5, 600, 0.02
SPEED = (1.5, -1.2, 2.0)
V_P = np.pi / 6 * D**3


def script(axis):
    rng = np.random.default_rng(11)
    x = rng.uniform(0.02, 0.98, (N, 3)) * L
    box = " ".join(f"0 {a}" for a in L)
    files = {"particles.data": data_file(box, x, D, RHO_P, np.broadcast_to(SPEED, (N, 3)))}
    # The beads fly side by side, so that their contacts don't count; the gas is thin.
    return files, head_with_particles(DT, boundary="p p p", kn="1e-9", kt="1e-9", mu=0.0, skin=1e-3) + f"""
fix integrate all nve/sphere
fix gas all twogrid fine 8 6 10 ratio 2 2 2 density 1.2 viscosity 1e-6 every {EVERY}
fix_modify gas flow_rate {"xyz"[axis]} {RATE}
fix_modify gas output every {EVERY} file gas.h5 fields u eps faces particles no
dump d all custom {EVERY} dump.txt id x y z vx vy vz
dump_modify d format "%d %.17g %.17g %.17g %.17g %.17g %.17g"
thermo {STEPS}
run {STEPS}
"""


def main():
    executable, ranks = arguments()
    c = Checks("beads that fly through periodic sides")
    for axis in range(3):
        for n in ranks if axis == 0 else ranks[:1]:
            files, text = script(axis)
            r = Run(executable, text, n, files=files)
            dump, a, worst, crossed, before = dict(r.dump("dump.txt")), "xyz"[axis], 0.0, 0, None
            beads = N * V_P * abs(SPEED[axis]) / np.prod(L)
            with h5py.File(r.file("gas.h5")) as f:
                for name in sorted(f["fluid"])[2:]:  # behind the first step, in which paths are not known yet
                    frame = f["fluid/" + name]
                    p = dump[step_of(frame)]
                    gas = frame["faces/flux_" + a][()].mean()
                    worst = max(worst, abs(gas + V_P * p["v" + a].sum() / np.prod(L) - RATE))
                    if before is not None:
                        crossed += int(np.sum(np.abs(p[a] - before) > 0.5 * L[axis]))
                    before = p[a]
            c.below(f"along {a}, {n} ranks: flux of gas and beads off the given one, over the beads' flux", worst / beads, 1e-5)
            c.true(f"along {a}: beads went through the side {crossed} times", crossed > 20)
    c.end()


if __name__ == "__main__":
    main()
