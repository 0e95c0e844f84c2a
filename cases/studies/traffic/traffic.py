#!/usr/bin/python3
"""Messages and bytes that the ranks exchange in a fluid step, by method and number of ranks.

Usage: traffic.py EXECUTABLE MPI_COUNT_LIBRARY [RANKS ...]     (default 2 4 8 16 32 64)

The library (tests/bench/mpi_count.c, in the build folder) notes every send with its chain of callers. Two run lengths are
differenced, so that set-up drops out; the chains tell the particles' own traffic (DEM), the coupling's (deposit, read,
react, prolong) and the fluid solver's apart. Writes table.csv and traffic.png beside this file.
"""
import bisect
import collections
import csv
import os
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "..", "tests", "system"))
from harness import data_file  # noqa: E402

D, L, SIDE = 1e-3, 16e-3, 14
GRIDS = {2: (1, 1, 2), 4: (1, 2, 2), 8: (2, 2, 2), 16: (2, 2, 4), 32: (2, 4, 4), 64: (4, 4, 4)}
SHORT, LONG, EVERY = 20, 100, 10  # DEM steps of the two runs, and to a coupling
# name: ratio, deposit, prolong, read
METHODS = {
    "two-grid, centroid (the paper)": (8, "centroid", "constant", "cell"),
    "two-grid, trilinear, linear": (8, "trilinear", "linear", "trilinear"),
    "two-grid, trilinear, reads fine/trilinear": (8, "trilinear", "constant", "fine/trilinear"),
    "single grid, centroid": (1, "centroid", "constant", "fine"),
    "exact on the fine grid": (1, "exact", "constant", "fine"),
    "porous cube of 4 d": (1, "cube 0.004", "constant", "cube 0.004"),
}
PARTS = ("dem", "coupling", "fluid")


class Symbols:
    """Names of the functions of an executable, by address."""

    def __init__(self, executable):
        text = subprocess.run(["nm", "-C", "--defined-only", executable], capture_output=True, text=True, check=True).stdout
        rows = sorted((int(a), n) for a, n in ((int(w[0], 16), w[2]) for w in (line.split(None, 2) for line in text.splitlines())
                                               if len(w) == 3 and w[1] in "tTwW"))
        self.at, self.name = [r[0] for r in rows], [r[1] for r in rows]
        self.base = os.path.basename(executable)

    def __call__(self, frame):
        file, _, offset = frame.rpartition("+")
        if os.path.basename(file) != self.base:
            return os.path.basename(file)
        i = bisect.bisect_right(self.at, int(offset, 16) - 1) - 1
        return self.name[i] if i >= 0 else file


def part_of(chain):
    if any("FluidSolver::" in f for f in chain):
        return "fluid"
    if any("Coupling" in f or "FixTwogrid" in f for f in chain):
        return "coupling"
    return "dem"


def particles():
    """A jittered lattice, each sphere with a velocity of up to 0.1 m/s."""
    rng = np.random.default_rng(5)
    q = (np.arange(SIDE) + 0.5) * L / SIDE
    x = np.array([(a, b, c) for c in q for b in q for a in q])
    x += rng.uniform(-0.5, 0.5, x.shape) * (L / SIDE - D)
    return data_file(f"0 {L!r} 0 {L!r} 0 {L!r}", x, D, 2500, rng.uniform(-0.1, 0.1, x.shape))


def measure(executable, library, ranks, method, steps, symbols):
    """Counts of a run by part: {part: array over ranks of messages, bytes, collectives, their bytes}; fluid steps, iterations."""
    ratio, deposit, prolong, read = METHODS[method]
    p = GRIDS[ranks]
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "particles.data"), "w") as f:
            f.write(particles())
        command = [os.path.join(HERE, "..", "..", "mpirun.sh"), str(ranks), "env", f"LD_PRELOAD={library}", "MPI_COUNT=count",
                   executable, "-in", os.path.join(HERE, "in.traffic")]
        for name, value in dict(px=p[0], py=p[1], pz=p[2], r=ratio, steps=steps, deposit=deposit, prolong=prolong, read=read).items():
            command += ["-var", name, str(value)]
        done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            sys.exit(done.stdout[-3000:])
        counts = {part: np.zeros((ranks, 4)) for part in PARTS}
        names = collections.Counter()
        for rank in range(ranks):
            with open(os.path.join(folder, f"count.{rank}")) as f:
                for line in f:
                    kind, calls, size, *frames = line.split()
                    chain = [symbols(f) for f in frames]
                    at = 0 if kind == "p2p" else 2
                    counts[part_of(chain)][rank, at:at + 2] += int(calls), int(size)
                    names[(part_of(chain), kind, " < ".join(chain[:4]))] += int(calls)
        if os.environ.get("SHOW"):
            for (part, kind, chain), n in names.most_common(40):
                print(n, part, kind, chain)
        rows = []
        for line in done.stdout.splitlines():
            words = line.split()
            if len(words) == 6 and words[0].isdigit() and words[1] == str(SIDE**3):
                rows.append([float(w) for w in words])
    return counts, np.array(rows)


def main():
    executable, library = (os.path.abspath(a) for a in sys.argv[1:3])
    wanted = [int(a) for a in sys.argv[3:]] or list(GRIDS)
    symbols = Symbols(executable)
    table = os.path.join(HERE, "table.csv")
    out = []
    if os.path.exists(table):  # rows of other numbers of ranks stay
        with open(table) as f:
            out = [r for r in csv.DictReader(f) if int(r["ranks"]) not in wanted]
    for ranks in wanted:
        for method in METHODS:
            (short, _), (long, rows) = (measure(executable, library, ranks, method, s, symbols) for s in (SHORT, LONG))
            steps = (LONG - SHORT) / EVERY
            row = dict(ranks=ranks, method=method)
            for part in PARTS:
                per = (long[part] - short[part]) / steps
                for name, q in zip(("messages", "bytes", "collectives", "collective_bytes"), range(4)):
                    row[f"{part}_{name}"] = round(per[:, q].mean(), 1)
                row[f"{part}_bytes_most"] = round(per[:, 1].max(), 1)
            now = rows[rows[:, 0] > SHORT]
            row["pressure_iterations"] = round(now[:, 5].mean(), 2)
            row["fluid_steps"] = round((1e-5 * EVERY / now[:, 2]).mean(), 3)
            out.append(row)
            print(" ".join(f"{k}={v}" for k, v in row.items()), flush=True)
            out.sort(key=lambda r: int(r["ranks"]))
            with open(table, "w", newline="") as f:
                w = csv.DictWriter(f, row.keys(), lineterminator="\n")
                w.writeheader()
                w.writerows(out)


if __name__ == "__main__":
    main()
