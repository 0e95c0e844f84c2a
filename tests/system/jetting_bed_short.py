#!/usr/bin/python3
"""The short mode of cases/jetting_bed: script, comparison and pictures work, on a thin bed; and half the drag fails. The same bed on a
single grid of the particle cells, whose faces are wider than a jet, and on one of the fluid's cells; and jets.py, which compares them.

Without this test the case could rot: a renamed keyword, a comparison that reads the wrong column, a jet of another width. On the coarse grid a jet that kept
its velocity in a face 1.5 times as wide would feed half as much gas again, and what is said to be lost without two grids would be more gas. Two runs of
the same file must lie 0 apart, in a table that finds differences. A jet's length wants a long mean and a deep bed, and is printed by the
comparison without a verdict.
"""
import csv
import os
import shutil
import subprocess
import tempfile

import h5py
import numpy as np
from harness import Checks, Run, arguments, half_the_drag, pictures_are_there, run_case

CASE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases", "jetting_bed")
JET = 1.6e-3 * 4.95e-3  # m2, drawn
KINDS = {"two": ("two", "flux", [78, 1, 48], [6, 1, 2], 6.0), "coarse": ("coarse", "flux", [13, 1, 24], [1, 1, 1], 6.0),
         "coarse_velocity": ("coarse", "velocity", [13, 1, 24], [1, 1, 1], 9.0), "fine": ("fine", "flux", [78, 1, 48], [1, 1, 1], 6.0)}


def grids(c, executable, ranks, out):
    """Some couplings of a bed of few grains on each kind of grid."""
    with open(os.path.join(CASE, "in.jetting_bed")) as f:
        script = f.read()
    for kind, (name, keep, fine, ratio, gas) in KINDS.items():
        words = f"-var grids {name} -var keep {keep} -var Neach 400 -var tend 0.05 -var tavg 0.042 -var tframe 0.005 -var out . -var px {ranks}"
        run = Run(executable, script, ranks, ["-log", "log.liggghts", *words.split()])
        with h5py.File(run.file("bed.h5")) as bed:
            record = bed["record"].attrs
            c.true(f"{kind}: fine {list(record['fine'])}, ratio {list(record['ratio'])}", list(record["fine"]) == fine and list(record["ratio"]) == ratio)
            flux = bed["fluid"][sorted(bed["fluid"])[-1]]["faces/flux_z"][0]
            cell = np.outer(np.diff(bed["grid/y"][:]), np.diff(bed["grid/x"][:]))
            through = np.sum((flux * cell)[flux > 1.0])
            c.below(f"{kind}: gas through the jet, against {gas:g} m/s in the area drawn", abs(through / (gas * JET) - 1), 1e-10)
        folder = os.path.join(out, f"jets1_U6_{kind}")
        shutil.copytree(run.path, folder)
        open(os.path.join(folder, "finished"), "w").close()
    # The same once more, as if it were on other grids.
    shutil.copytree(os.path.join(out, "jets1_U6_two"), os.path.join(out, "jets1_U6_fine_exact"))
    done = subprocess.run([os.path.join(CASE, "jets.py"), "--short", "--compare", "--out", out], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(done.stdout, flush=True)
    c.true("jets.py compares them", done.returncode == 0)
    pictures_are_there(c, out, "jets", "jets_all")
    with open(os.path.join(out, "jets.csv")) as f:
        rows = {row["grids"]: row for row in csv.DictReader(line for line in f if not line.startswith("#"))}
    c.true("a row for each", sorted(rows) == sorted([*KINDS, "fine_exact"]))
    same, other = (float(rows[k]["void_fraction_apart"]) for k in ("fine_exact", "coarse_velocity"))
    c.below("void fractions of the same run, apart", same, 0)
    c.true(f"and of one with half as much gas again in the jet: {other:.3f}", other > 0.005)


def main():
    executable, ranks = arguments()
    c = Checks("short runs of jetting_bed")
    with tempfile.TemporaryDirectory() as out:
        done = run_case("jetting_bed", executable, ranks[-1], out)
        c.true("jetting_bed: run and comparison pass", done.returncode == 0 and done.stdout.count("PASS") >= 7 and "FAIL" not in done.stdout)
        pictures_are_there(c, out, "mean_void_fraction", "snapshots", "profiles", "pressure")
        half_the_drag(c, "jetting_bed", out)
    with tempfile.TemporaryDirectory() as out:
        grids(c, executable, ranks[-1], out)
    c.end()


if __name__ == "__main__":
    main()
