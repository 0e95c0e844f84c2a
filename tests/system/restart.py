#!/usr/bin/python3
"""Restart files of coupled runs: what the coupling knows of the particles goes on with them, and a file that another version of the program has
written is refused with a sentence.

Without this test a run could go on with particles that count as new (their volume would then replace gas once more), or with columns
of the state that mean something else; or end without a word, as LIGGGHTS' own message of such a file is not shown.
Usage: restart.py EXECUTABLE RANKS...
"""
import numpy as np

from harness import Checks, Run, arguments, data_file, head, head_with_particles

BOX, D = "0 0.008 0 0.008 0 0.016", 1e-3
GAS = """
fix integrate all nve/sphere
fix {id} all twogrid fine 8 8 16 ratio 4 4 4 density 1.2 viscosity 1.8e-5 every 10
fix_modify {id} boundary zlo inlet 0 0 0.1 boundary zhi pressure 0
fix_modify {id} output off
thermo_style custom step atoms f_{id}[7] f_{id}[14]
thermo 10
"""


def first(executable, ranks, gas):
    random = np.random.default_rng(2)
    x = [(1e-3 * (i + 0.7), 1e-3 * (j + 0.7), 1e-3 * (k + 0.7)) for k in range(8) for j in range(6) for i in range(6)]
    return Run(executable, head_with_particles(1e-5, boundary="p p f", skin=0.4e-3) + gas + "run 100\nwrite_restart half\n", ranks,
               files={"particles.data": data_file(BOX, x, D, 2500, random.uniform(-0.05, 0.05, (len(x), 3)))})


def second(executable, ranks, before, fix, success=True):
    script = head(BOX, 1e-5, boundary="p p f", skin=0.4e-3)
    begin = script.index("region box")
    script = script[:begin] + f"read_restart {before.file('half')}\n" + script[script.index("neighbor"):]
    return Run(executable, script + GAS.format(id=fix) + "run 50\n", ranks, expect_success=success)


def main():
    executable, ranks = arguments()
    c = Checks("restart files of coupled runs")
    for n in ranks:
        a = first(executable, n, GAS.format(id="gas"))
        b = second(executable, n, a, "gas")
        t = b.thermo()
        c.true(f"{n} ranks: goes on and says that the fluid starts anew", "holds no fluid" in b.output)
        c.true("all particles are there", t["Atoms"][-1] == 288)
        c.true("none of them counts as inserted", t["gas[14]"][-1] == 0)
        c.below("action and reaction", max(t["gas[7]"]), 1e-12)
        # as an other version would have left it: another number of values a particle
        columns = "fix gas_state all property/atom gas_state vector yes no no 1. 2. 3.\n"
        a = first(executable, n, columns + "fix integrate all nve/sphere\n")
        b = second(executable, n, a, "gas", False)
        c.true("another version's file ends the run", b.code != 0)
        c.true("with a sentence: " + next((line for line in b.output.splitlines() if line.startswith("ERROR")), "none"),
               "holds 3 values a particle" in b.output and "another ID" in b.output)
        b = second(executable, n, a, "air")
        c.true("under another ID it begins anew", b.thermo()["Atoms"][-1] == 288)
    c.end()


if __name__ == "__main__":
    main()
