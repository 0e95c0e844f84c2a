#!/usr/bin/python3
"""Limits of a run are told, with their remedy: what the eps bound moves or cannot place.

    limits.py EXECUTABLE RANKS...

What would pass falsely without it: an obstacle of overlapping spheres whose volume the eps bound has moved all over the channel, or a
bed with more solids than the bound allows anywhere, simulated to the end without a word.
"""
import math

import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles

GAS = """
fix gas all twogrid fine 8 4 8 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 5
fix_modify gas boundary zlo inlet 0 0 0.5 boundary zhi pressure 0 {modify}
fix_modify gas output off
thermo_style custom step atoms f_gas[6] f_gas[7] f_gas[8] f_gas[9]
thermo 5
"""
BOX, SIZE = "0 0.008 0 0.004 0 0.008", (0.008, 0.004, 0.008)


def run(executable, x, d, modify, steps=20, ranks=1):
    text = head_with_particles(1e-6, boundary="f f f", kn=1e-6, kt=1e-6) + GAS.format(modify=modify) + f"run {steps}\n"
    return Run(executable, text, ranks, files={"particles.data": data_file(BOX, x, d, 2500)})


def warnings(run, part):
    return [line for line in run.output.splitlines() if line.startswith("WARNING: fix gas twogrid:") and part in line]


def bound_moves(c, executable, ranks):
    """A rod of spheres that overlap, held, across a channel; once more with the same spheres apart."""
    d = 1e-3
    for gap, wanted in ((0.25e-3, 1), (1.0e-3, 0)):
        a = np.arange(-8, 9) * gap
        i, k = np.meshgrid(a, a, indexing="ij")
        near = (np.hypot(i, k) <= 0.55e-3).ravel()
        y = np.arange(0.5e-3, 3.6e-3, gap)
        x = np.array([(0.004 + p, q, 0.004 + r) for p, r in zip(i.ravel()[near], k.ravel()[near]) for q in y])
        for n in ranks:
            r = run(executable, x, d, "deposit trilinear", ranks=n)
            solids = len(x) * math.pi / 6 * d**3
            moved = r.thermo()["f_gas[8]" if "f_gas[8]" in r.thermo() else "gas[8]"][-1] / solids
            said = warnings(r, "eps bound move 0.3' moves")
            c.true(f"spheres of {d} m each {gap} m, {n} rank(s): {moved:.2%} of the solids moved, told {len(said)} time(s)",
                   len(said) == wanted and (moved > 0.01) == bool(wanted) and all("ratio" in s for s in said))


def bound_cannot_be_kept(c, executable):
    """Solids for a void fraction of 0.55 everywhere, and a bound of 0.7."""
    pitch, d = 1e-3, 1e-3 * (6 * 0.45 / math.pi)**(1 / 3)
    x = np.array([((i + .5) * pitch, (j + .5) * pitch, (k + .5) * pitch) for i in range(8) for j in range(4) for k in range(8)])
    for bound, wanted in ((0.7, 1), (0.5, 0)):
        said = warnings(run(executable, x, d, f"deposit trilinear eps bound move {bound}"), "cannot be kept")
        c.true(f"bound {bound} where the mean is 0.55: told {len(said)} time(s)", len(said) == wanted)
        if said:
            # V (1 - 0.55) there are, V (1 - 0.7) may be: a third of the solids has no place
            c.true(f"the volume unplaced: {said[0].split('kept: ')[1].split(' of')[0]} (wanted 33.33 %)", "33.33 %" in said[0])


def main():
    executable, ranks = arguments()
    c = Checks("limits that are told")
    bound_moves(c, executable, ranks)
    bound_cannot_be_kept(c, executable)
    c.end()


if __name__ == "__main__":
    main()
