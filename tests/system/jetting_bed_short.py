#!/usr/bin/python3
"""The short mode of cases/jetting_bed: script, comparison and pictures work, on a thin bed; and half the drag fails.

Without this test the case could rot: a renamed keyword, a comparison that reads the wrong column, a jet of another width. A jet's length
wants a long mean and a deep bed, and is printed by the comparison without a verdict.
"""
import tempfile

from harness import Checks, arguments, half_the_drag, pictures_are_there, run_case


def main():
    executable, ranks = arguments()
    c = Checks("short run of the jetting bed")
    with tempfile.TemporaryDirectory() as out:
        done = run_case("jetting_bed", executable, ranks[-1], out)
        c.true("run and comparison pass", done.returncode == 0 and done.stdout.count("PASS") >= 7 and "FAIL" not in done.stdout)
        pictures_are_there(c, out, "mean_void_fraction", "snapshots", "profiles", "pressure")
        half_the_drag(c, "jetting_bed", out)
    c.end()


if __name__ == "__main__":
    main()
