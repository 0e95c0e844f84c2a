#!/usr/bin/python3
"""Messages and bytes that the ranks exchange in a fluid step, by method and number of ranks.

Usage: traffic.py EXECUTABLE MPI_COUNT_LIBRARY [RANKS ...]     (default 2 4 8 16 32 64)

The library (tests/bench/mpi_count.c, in the build folder) notes every send with its chain of callers. The chains tell the
particles' own traffic (DEM), the coupling's (deposit, read, react, prolong) and the fluid solver's apart, and steps from
set-up. Two run lengths are differenced, so that the first steps drop out too. Writes table.csv and traffic.png beside this file.
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
MANY = 16
FEW_RANKS_ONLY = ("two-grid, trilinear, linear", "two-grid, trilinear, reads fine/trilinear")
PARTS = ("dem", "coupling", "fluid")


class Symbols:
    """Names of functions of the executable and of LIGGGHTS' library, by file and offset; of others the file."""

    def __init__(self, executable):
        self.executable, self.tables = os.path.basename(executable), {}

    def table(self, file):
        name = os.path.basename(file)
        if name not in self.tables:
            known = name == self.executable or "liggghts" in name
            flags = ["-C", "--defined-only"] + (["-D"] if ".so" in name else [])
            text = subprocess.run(["nm", *flags, file], capture_output=True, text=True, check=True).stdout if known else ""
            words = (line.split(None, 2) for line in text.splitlines())
            rows = sorted((int(w[0], 16), w[2]) for w in words if len(w) == 3 and w[1] in "tTwW")
            self.tables[name] = [r[0] for r in rows], [r[1] for r in rows]
        return self.tables[name]

    def __call__(self, frame):
        file, _, offset = frame.rpartition("+")
        at, names = self.table(file)
        i = bisect.bisect_right(at, int(offset, 16) - 1) - 1
        return names[i] if i >= 0 else os.path.basename(file)


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
    """Counts of a run, of the time steps alone (what Verlet::run called, but for what a run's end costs), by part: {part: array over ranks of messages, bytes,
    collectives, their bytes}; and the thermo table."""
    ratio, deposit, prolong, read = METHODS[method]
    p = GRIDS[ranks]
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "particles.data"), "w") as f:
            f.write(particles())
        command = [os.path.join(HERE, "..", "..", "mpirun.sh"), str(ranks), "env", f"LD_PRELOAD={library}", "MPI_COUNT=count",
                   executable, "-in", os.path.join(HERE, "in.traffic")]
        for name, value in dict(px=p[0], py=p[1], pz=p[2], r=ratio, steps=steps, deposit=deposit, prolong=prolong, read=read).items():
            command += ["-var", name, str(value)]
        command += ["-fluid_bricks", ",".join(map(str, p))]  # where the particles are, whatever costs least
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
                    # Coupling::rest: once at a run's end, the solids are laid out for what commands may change.
                    if not any(f.startswith("LAMMPS_NS::Verlet::run(") for f in chain) or any("Coupling::rest(" in f for f in chain):
                        continue
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


def draw(rows):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(1, 2, figsize=(11.5, 4.4))
    paper = list(METHODS)[0]
    for ax, what, label in ((axes[0], "bytes", "bytes a rank and fluid step"), (axes[1], "messages", "messages a rank and fluid step")):
        for i, method in enumerate(METHODS):
            mine = [(int(r["ranks"]), float(r[f"coupling_{what}"])) for r in rows if r["method"] == method]
            ax.plot(*zip(*mine), "osD^v<"[i] + "-", ms=5, lw=1, label=f"coupling: {method}")
        for part, style, name in (("dem", "k:", "particles' own (10 DEM steps)"), ("fluid", "k--", f"fluid solver, {paper}")):
            mine = [(int(r["ranks"]), float(r[f"{part}_{what}"])) for r in rows if r["method"] == paper]
            ax.plot(*zip(*mine), style, lw=1.2, label=name)
        ax.set(xscale="log", yscale="log", xlabel="ranks", ylabel=label)
        ax.set_xscale("log", base=2)
        ax.grid(True, which="both", lw=0.3, alpha=0.5)
    axes[1].legend(fontsize=7, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    fig.tight_layout()
    fig.savefig(os.path.join(HERE, "traffic.png"), dpi=100, bbox_inches="tight")


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
            if ranks > MANY and method in FEW_RANKS_ONLY:
                continue
            # On many ranks starting the program costs most: one short run, its first steps and all.
            short, rows = measure(executable, library, ranks, method, SHORT, symbols) if ranks <= MANY else (None, None)
            long, rows = measure(executable, library, ranks, method, LONG if ranks <= MANY else 2 * SHORT, symbols)
            row = dict(ranks=ranks, method=method)
            for part in PARTS:
                per = (long[part] - short[part]) / ((LONG - SHORT) / EVERY) if short else long[part] / (2 * SHORT / EVERY)
                for name, q in zip(("messages", "bytes", "collectives", "collective_bytes"), range(4)):
                    row[f"{part}_{name}"] = round(per[:, q].mean(), 1)
                row[f"{part}_bytes_most"] = round(per[:, 1].max(), 1)
            now = rows[rows[:, 0] > (SHORT if short else 0)]
            row["pressure_iterations"] = round(now[:, 5].mean(), 2)
            row["fluid_steps"] = round((1e-5 * EVERY / now[:, 2]).mean(), 3)
            out.append(row)
            print(" ".join(f"{k}={v}" for k, v in row.items()), flush=True)
            out.sort(key=lambda r: int(r["ranks"]))
            with open(table, "w", newline="") as f:
                w = csv.DictWriter(f, row.keys(), lineterminator="\n")
                w.writeheader()
                w.writerows(out)
    draw(out)


if __name__ == "__main__":
    main()
