#!/usr/bin/python3
"""Every way to deposit and to read, in both formulations, goes on from a checkpoint with every bit: particles, fluid, means.

Without this test a way of coupling could keep something from one coupling to the next that no list of state names.
Usage: checkpoint_methods.py EXECUTABLE RANKS... [--long]: all of them, on all ranks, in place of one of each.
"""
import itertools
import os
import shutil
import subprocess
import tempfile

import h5py
import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles, launch, long_form, walls

BOX = "0 0.008 0 0.008 0 0.016"
DEPOSITS = ("centroid", "trilinear", "exact", "cube 0.004")
READS = ("cell", "trilinear", "fine", "fine/trilinear", "kernel 0.004", "cube 0.004")
OTHERS = ("prolong linear", "interpolate linear", "hold on", "hold off", "implicit on", "convection central interpolate smooth", "convection none", "eps bound clip 0.5", "one-way yes",
          "accuracy 0.01", "drag beetstra/poly", "tolerance 1e-10", "dt 3e-5")


def script(ranks, methods):
    return head_with_particles(1e-5, boundary="p p f", skin=0.4e-3, gamman=0.01, gammat=0.005) + walls(zplane=(0,)) + f"""
fix weight all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 8 8 16 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 0.6 boundary zhi pressure 0
fix_modify gas {methods}
fix_modify gas output every 30 file bed.h5 fields u p eps faces average from 0
fix_modify gas checkpoint every 45 keep 3
dump d all custom 30 all.dump id x y z vx vy vz omegax omegay omegaz f_gas[1] f_gas[4] f_gas[7] f_gas[8]
dump_modify d sort id format "%d{13 * ' %.17g'}"
run 120
"""


def results(path):
    out = {}
    with open(os.path.join(path, "all.dump")) as f:
        out["particles"] = f.read()
    with h5py.File(os.path.join(path, "bed.h5")) as f:
        for group in ("fluid", "average"):
            f[group].visititems(lambda n, d: out.__setitem__(group + "/" + n, d[...]) if isinstance(d, h5py.Dataset) else None)
    return out


def differences(a, b):
    return sorted(k for k in {*a, *b} if k not in a or k not in b or not (np.array_equal(a[k], b[k], equal_nan=True) if isinstance(a[k], np.ndarray) else a[k] == b[k]))


def main():
    executable, ranks = arguments()
    c = Checks("every way of coupling goes on")
    random = np.random.default_rng(2)
    x = [(1e-3 * (i + 0.7), 1e-3 * (j + 0.7), 1e-3 * (k + 0.7)) for k in range(6) for j in range(6) for i in range(6)]
    particles = data_file(BOX, x, 1e-3, 2500, random.uniform(-0.05, 0.05, (len(x), 3)))
    pairs = list(itertools.product("AB", DEPOSITS, READS))
    if not long_form():  # each once
        pairs = [("AB"[i % 2], DEPOSITS[i % 4], READS[i]) for i in range(6)]
    ways = [f"formulation {f} deposit {d} read {r}" for f, d, r in pairs] + list(OTHERS if long_form() else OTHERS[::3])
    for n in ranks if long_form() else ranks[-1:]:
        bad = []
        for methods in ways:
            a = Run(executable, script(n, methods), n, files={"particles.data": particles})
            with tempfile.TemporaryDirectory(prefix="twogrid_test_") as folder:
                path = os.path.join(folder, "run")
                shutil.copytree(a.path, path)
                kept = sorted(os.listdir(os.path.join(path, "in.test.checkpoints")))
                shutil.rmtree(os.path.join(path, "in.test.checkpoints", kept[1]))
                again = subprocess.run([*launch(n), os.path.abspath(executable), "-in", "in.test", "-restart", "auto"], cwd=path, stdout=subprocess.PIPE,
                                       stderr=subprocess.STDOUT, text=True, errors="replace", timeout=100)
                differ = differences(results(a.path), results(path)) if again.returncode == 0 and "goes on from" in again.stdout else ["not gone on"]
            if differ or len(kept) != 2:
                bad.append(f"{methods} ({', '.join(differ[:3])})")
        c.true(f"{n} ranks, {len(ways)} ways: every bit of particles, fluid and means{': but ' + '; '.join(bad) if bad else ''}", not bad)
    c.end()


if __name__ == "__main__":
    main()
