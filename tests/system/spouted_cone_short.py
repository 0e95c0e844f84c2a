#!/usr/bin/python3
"""The short mode of cases/spouted_cone: surfaces, script, comparison and pictures work, on fewer grains and coarse cells.

Without this test the case could rot: a nozzle that leads from an inlet into a vessel with the inlet's side closed behind it, a mesh that only
grains feel beside one that is the gas's wall, the balance of momentum of a cone. What needs a long mean (the spout, minimum spouting, symmetry) is
printed by the comparison without a verdict.
"""
import tempfile

from harness import Checks, arguments, half_the_drag, pictures_are_there, run_case


def main():
    executable, ranks = arguments()
    c = Checks("short run of the spouted cone")
    with tempfile.TemporaryDirectory() as out:
        done = run_case("spouted_cone", executable, ranks[-1], out)
        c.true("run and comparison pass", done.returncode == 0 and done.stdout.count("PASS") >= 8 and "FAIL" not in done.stdout)
        pictures_are_there(c, out, "mean_void_fraction", "cut", "curve", "snapshots", "profiles", "pressure", "grains")
        half_the_drag(c, "spouted_cone", out)
    c.end()


if __name__ == "__main__":
    main()
