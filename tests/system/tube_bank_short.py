#!/usr/bin/python3
"""The short mode of cases/tube_bank: both scenes, comparison and pictures work, on fewer grains and coarse cells.

Without this test the case could rot: cylinders that grains and gas both see in a box that is periodic along them, the force on each of eight bodies, two
scenes in one script, a bank of tubes in gas alone against what is published. What needs a long mean (pressure against weight, minimum fluidisation,
symmetry) is printed by the comparison without a verdict.
"""
import tempfile

from harness import Checks, arguments, half_the_drag, pictures_are_there, run_case


def main():
    executable, ranks = arguments()
    c = Checks("short run of the tube bank")
    with tempfile.TemporaryDirectory() as out:
        done = run_case("tube_bank", executable, ranks[-1], out)
        c.true("run and comparison pass", done.returncode == 0 and done.stdout.count("PASS") >= 9 and "FAIL" not in done.stdout)
        pictures_are_there(c, out, "mean_void_fraction", "cut", "snapshots", "profiles", "pressure", "grains")
        half_the_drag(c, "tube_bank", out)
    c.end()


if __name__ == "__main__":
    main()
