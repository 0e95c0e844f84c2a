#!/usr/bin/python3
"""cases/false_alarms.py: how often a check fails by chance, from what many fillings give.

Without this test a check that fails once in a hundred runs could be said to fail less than once in a thousand (a limit that leaves out that 30 values know their own
scatter badly: by the bare distance in standard deviations it would be too low in half of all cases), only one of two bounds could be looked at, and a filling that
fails could go uncounted.
Right values: the normal distribution's tail (erfc), by 2000 samples of 30 drawn at known distances; the case's own comparison on a run whose drag is half the law's.
"""
import math
import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np
from harness import Checks, arguments

CASES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases")
sys.path.insert(0, CASES)
import false_alarms  # noqa: E402


def drawn(c):
    random = np.random.default_rng(5)
    row = lambda found, least, most: false_alarms.row_of("a check", "", [(least, float(f), most) for f in found], 0)
    for distance in (2.0, 3.09, 5.0):
        true = 0.5 * math.erfc(distance / math.sqrt(2))
        below = np.mean([row(random.normal(10, 0.5, 30), -math.inf, 10 + 0.5 * distance)["rate"] < true for _ in range(2000)])
        c.true(f"{distance:g} standard deviations to a bound: the limit is below the true rate in {100 * below:.1f} % of 2000 samples of 30 (wanted: 5 %, 3 to 8)", 0.03 < below < 0.08)
    found = random.normal(0, 1, 30)
    one, two = row(found, -math.inf, 3.5)["rate"], row(found, -3.5, 3.5)["rate"]
    c.true(f"a second bound adds its rate: {one:.2g} and {two - one:.2g}", two > one > 0 and 0.02 < (two - one) / one < 50)
    c.true("figures far inside", row(found, -9, 9)["rate"] < 1e-3 and row(found, -2.5, 2.5)["rate"] > 1e-3)
    # Errors that scatter over a factor have a bound that is far off in the logarithm.
    errors = 1e-15 * 10 ** random.normal(0, 0.2, 30)
    c.true(f"errors by their logarithm: distance {row(errors, 0, 1e-13)['distance']:.1f} (wanted: about 10)", 7 < row(errors, 0, 1e-13)["distance"] < 14)
    c.true("errors that are all 0", row(np.zeros(30), 0, 1e-13)["rate"] == 0)
    moved = [(0.9 - s, 1.0 - s, math.inf) for s in random.normal(0, 1, 30)]
    c.true("bounds that move with what is found", false_alarms.row_of("a check", "", moved, 0)["rate"] < 1e-6)


def first_bed(c, executable, ranks):
    with tempfile.TemporaryDirectory() as out:
        def run(*words):
            done = subprocess.run([os.path.join(CASES, "false_alarms.py"), "first_bed", "--short", "--fillings", "3", "--ranks", str(ranks), "--out", out, *words], text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env={**os.environ, "TWOGRID": os.path.abspath(executable)})
            print(done.stdout, flush=True)
            return done
        done = run()
        folders = sorted(f for f in os.listdir(out) if os.path.isdir(os.path.join(out, f)))
        at = []
        for folder in folders:
            with h5py.File(os.path.join(out, folder, "first_bed.h5")) as bed:
                at.append(bed["particles"][sorted(bed["particles"])[0]]["position"][:])
        c.true("three fillings, each another", len(folders) == 3 and all(np.abs(a - b).max() > 1e-4 for a, b in zip(at, at[1:])))
        c.true("none fails", "0 of 3 fillings fail" in done.stdout)
        with h5py.File(os.path.join(out, folders[1], "first_bed.h5"), "r+") as bed:
            for key in ("density", "viscosity"):
                bed["record"].attrs[key] = 2 * bed["record"].attrs[key]
        done = run("--compare")
        line = next((text for text in done.stdout.split("\n") if "drag" in text), "")
        c.true("half the drag in one: it fails, and is counted", done.returncode == 1 and "1 of 3 fillings fail" in done.stdout and "1/3" in line)


def main():
    executable, ranks = arguments()
    c = Checks("false alarms of verdicts")
    drawn(c)
    first_bed(c, executable, ranks[-1])
    c.end()


if __name__ == "__main__":
    main()
