#!/usr/bin/python3
"""The short mode of cases/round_bed: the STL surface, script, comparison and pictures work, on a thin bed and coarse cells.

Without this test the case could rot: a renamed keyword, a comparison that reads the wrong column, a vessel that leaks. What needs a long
mean (pressure against weight, symmetry) is printed by the comparison without a verdict.
"""
import os
import subprocess
import sys
import tempfile

from harness import MPIRUN, Checks, arguments

CASE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases", "round_bed")
SHORT = "N 2500 nx 21 nz 30 tend 0.24 tavg 0.2 tframe 0.03 every 12".split()


def main():
    executable, ranks = arguments()
    c = Checks("short run of the round bed")
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([os.path.join(CASE, "make_stl.py"), os.path.join(out, "vessel.stl")], check=True)
        options = [w for name, value in zip(SHORT[::2], SHORT[1::2]) for w in ("-var", name, value)]
        n = ranks[-1]
        done = subprocess.run(MPIRUN + ["-np", str(n), os.path.abspath(executable), "-in", os.path.join(CASE, "in.round_bed"), "-log", os.path.join(out, "log"),
                                        "-var", "out", out, "-var", "px", str(n), *options], cwd=out, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
        if not c.true("the run ends well", done.returncode == 0):
            print(done.stdout[-3000:])
            c.end()
        compared = subprocess.run([sys.executable, os.path.join(CASE, "compare.py"), out, "--short"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        print(compared.stdout)
        c.true("the comparison passes", compared.returncode == 0 and compared.stdout.count("PASS") >= 7 and "FAIL" not in compared.stdout)
        c.true("all pictures are there", all(os.path.getsize(os.path.join(out, p + ".png")) > 10000 for p in
                                             ("mean_void_fraction", "section", "snapshots", "profiles", "pressure", "grains")))
    c.end()


if __name__ == "__main__":
    main()
