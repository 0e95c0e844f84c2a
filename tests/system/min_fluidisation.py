#!/usr/bin/python3
"""Minimum fluidisation from the falling ramp of cases/fluidisation_curve, in its short form, against Ergun.

Without it a drag that is wrong by a factor of the void fraction, a reaction that doesn't reach the pressure, or an inlet
whose variable isn't followed would pass: all other tests of drag keep the particles fixed or alone.
Usage: min_fluidisation.py EXECUTABLE
"""
import os
import subprocess
import sys

import h5py

from harness import Run

CASE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases", "fluidisation_curve")


def main():
    with open(os.path.join(CASE, "in.fluidisation_curve")) as f:
        script = f.read()
    failed = 0
    for form in "BA":
        print(f"formulation {form}", flush=True)
        run = Run(sys.argv[1], script, options=["-var", "out", ".", "-var", "tup", "0.2", "-var", "tdown", "0.6", "-var", "form", form], timeout=300)
        compare = ["/usr/bin/python3", os.path.join(CASE, "compare.py"), run.path, "--no-picture"]
        failed += subprocess.run(compare).returncode != 0
        # The law of a gas that is twice as dense and viscous gives exactly twice the drag: to it this is a run with half of it.
        with h5py.File(run.file("bed.h5"), "r+") as f:
            for key in ("density", "viscosity"):
                f["record"].attrs[key] = 2 * f["record"].attrs[key]
        code = subprocess.run(compare).returncode
        print(f"{'ok  ' if code == 1 else 'FAIL'} half the drag: the comparison ends with {code} (wanted: 1)", flush=True)
        failed += code != 1
    sys.exit(failed)


if __name__ == "__main__":
    main()
