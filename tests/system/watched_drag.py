#!/usr/bin/python3
"""The drag per particle, f_ID[1..3], is that of the step at which someone looks at it: a dump, thermo output, compute reduce, or a fix that
averages. Between, it is not kept. A run whose dump falls on steps that are no couplings must write the same numbers as one in
which a fix averages the drag at every step, so that it is kept throughout.

Without this test a dump could show the drag of an earlier step, by up to the interval between outputs, and nothing would notice.
Usage: watched_drag.py EXECUTABLE RANKS...
"""
import numpy as np

from harness import Checks, Run, arguments
from same_bits import script

SCENE = dict(U="0.8", steps=100000)  # the dump of same_bits.py at the end falls away
LOOK = """
compute pull all reduce sum f_gas[3]
dump drag all custom 7 drag.* id f_gas[1] f_gas[2] f_gas[3]
dump_modify drag format "%d %.17g %.17g %.17g" sort id
thermo 11
thermo_style custom step f_gas[1] c_pull
thermo_modify norm no format float %.17g
"""
WATCH = "fix watch all ave/atom 1 1 5 f_gas[3]\n"


def table(run, step):
    return np.loadtxt(run.file(f"drag.{step}"), skiprows=9)


def main():
    executable, ranks = arguments()
    c = Checks("drag per particle where someone looks at it")
    for n in ranks:
        text = script(SCENE, n) + LOOK
        seldom = Run(executable, text + "run 203\nrun 50\n", n)
        always = Run(executable, text + WATCH + "run 203\nrun 50\n", n)
        steps = list(range(7, 253, 7))
        pairs = [(table(seldom, s), table(always, s)) for s in steps]
        c.true(f"{n} ranks: {len(steps)} dumps are the same numbers", all(np.array_equal(a, b) for a, b in pairs))
        moved = np.abs(pairs[-1][0][:, 1:] - pairs[-2][0][:, 1:]).max()
        size = np.abs(pairs[-1][0][:, 3]).max()
        c.true(f"{n} ranks: drag {size:.2g} N, changes by up to {moved:.2g} N between two dumps", size > 0 and moved > 1e-3 * size)
        a, b = seldom.thermo(), always.thermo()
        c.true(f"{n} ranks: its sum in thermo output too", np.array_equal(a["pull"], b["pull"]) and len(a["pull"]) > 20)
    c.end()


if __name__ == "__main__":
    main()
