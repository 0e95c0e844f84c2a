#!/usr/bin/python3
"""The short mode of cases/round_bed: the STL surface, script, comparison and pictures work, on a thin bed and coarse cells.

Without this test the case could rot: a renamed keyword, a comparison that reads the wrong column, a vessel that leaks. What needs a long
mean (pressure against weight, symmetry) is printed by the comparison without a verdict.
"""
import tempfile

from harness import Checks, arguments, half_the_drag, pictures_are_there, run_case


def main():
    executable, ranks = arguments()
    c = Checks("short run of the round bed")
    with tempfile.TemporaryDirectory() as out:
        done = run_case("round_bed", executable, ranks[-1], out)
        c.true("run and comparison pass", done.returncode == 0 and done.stdout.count("PASS") >= 7 and "FAIL" not in done.stdout)
        pictures_are_there(c, out, "mean_void_fraction", "section", "snapshots", "profiles", "pressure", "grains")
        half_the_drag(c, "round_bed", out)
    c.end()


if __name__ == "__main__":
    main()
