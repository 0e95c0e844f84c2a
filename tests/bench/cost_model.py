#!/usr/bin/python3
"""What a step costs on many ranks: a model out of counted messages, bytes and collectives and of measured work, and what breaks first.

    cost_model.py [--traffic TABLE.csv] [--scaling SCALING.csv] [--particle US --cell US] [options]

An interval: ten DEM steps, one coupling, one fluid step (the paper's method: two-grid, centroid). Its time on P ranks is the sum of
  work         particles and cells a rank, times us measured on one rank (scaling.csv: the largest coupled box; or --particle, a DEM
               step, and --cell, a fluid step)
  dem, coupling, fluid     messages x latency + bytes / bandwidth, each part, fitted to the counts of cases/studies/traffic (table.csv, up to
               64 ranks): messages to the neighbours of a brick (faces; corners too for the coupling), bytes to the area of
               its cuts; of the fluid a part for each pressure iteration besides, its messages to the levels of the multigrid. Messages are taken one after the other: nothing overlaps, nothing is hidden.
  collectives  counted ones x (2 log2 P) latencies
  gathered     the pressure multigrid merges cells across ranks only once a level is gathered on every rank (at 1000 cells, or where each
               rank has one left): 48 bytes a cell of it a fluid step and 8 an iteration to every rank, and its cycles, at the cost a
               cell and iteration that fluid_bench measures on 2250 cells
Bricks that are thinner than what particles reach need more (up to 2.5 times the coupling's messages, where a rank has a single particle
cell; the fit prints counted over fitted).
Assumed: bricks are cubes of equal work (no imbalance by dense regions); as many fine cells to a particle as --cells; pressure iterations
don't grow with size (measured: 5 from 14,000 to 885,000 cells); no output. Weak: --weak particles a rank. Strong: --strong in all.

Prints the fit, the two tables in ms an interval, the number of ranks from which each term takes a tenth and a half of the work, and memory
that grows with ranks or with all particles. Writes cost_model.csv and cost_model.png into --out. Seconds; nothing is run.
"""
import argparse
import csv
import os

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
STUDY = os.path.join(HERE, "..", "..", "cases", "studies", "traffic")
# Rank grids and box of the study (traffic.py).
GRIDS = {2: (1, 1, 2), 4: (1, 2, 2), 8: (2, 2, 2), 16: (2, 2, 4), 32: (2, 4, 4), 64: (4, 4, 4)}
CELLS, SIDE, ADDED = 32, 14, 10
PAPER = "two-grid, centroid (the paper)"
GATHER = 1000  # cells: Multigrid::kGather
SET_UP, CYCLE = 34e-9, 31e-9  # s a cell, and a cell and iteration: fluid_bench, pressure/small
TERMS = ("work", "dem", "coupling", "fluid", "collectives", "gathered")


def neighbours(grid):
    """Mean over bricks of the faces they share, of all neighbours (corners too), and the mean area of their cuts over a box of 1."""
    faces = sum(2 * (p - 1) / p for p in grid)
    all_ = np.prod([1 + 2 * (p - 1) / p for p in grid]) - 1
    area = sum(2 * (p - 1) / p * p / np.prod(grid) for p in grid)
    return faces, all_, area


def scale(basis, y):
    """Least-squares factor in relative terms."""
    basis, y = np.asarray(basis, float), np.asarray(y, float)
    q = basis / y
    return q.sum() / (q * q).sum()


class Traffic:
    """Fits of the counts."""

    def __init__(self, path):
        with open(path) as f:
            rows = [{k: v if k == "method" else float(v) for k, v in r.items()} for r in csv.DictReader(f)]
        paper = sorted((r for r in rows if r["method"] == PAPER), key=lambda r: r["ranks"])
        ranks = [int(r["ranks"]) for r in paper]
        f, n, area = np.array([neighbours(GRIDS[p]) for p in ranks]).T
        column = lambda name: np.array([r[name] for r in paper])
        # Each number of ranks: fluid's counts against pressure iterations, over the methods that take one fluid step.
        per_iteration, rest = {}, {}
        for name in ("messages", "bytes", "collectives"):
            per_iteration[name], rest[name] = [], []
            for p in ranks:
                mine = [r for r in rows if int(r["ranks"]) == p and r["fluid_steps"] == 1]
                slope, at_0 = np.polyfit([r["pressure_iterations"] for r in mine], [r[f"fluid_{name}"] for r in mine], 1)
                per_iteration[name].append(slope)
                rest[name].append(at_0)
        surface = area * CELLS**2  # cells along the cuts of a brick
        # Particles of a layer one diameter thick along the cuts.
        layer = area * SIDE**2
        self.levels = np.log2(CELLS) - 1  # of the study's multigrid: 32 to 4 cells a side
        self.dem = scale(f, column("dem_messages")), scale(layer, column("dem_bytes"))
        self.coupling = scale(n, column("coupling_messages")), scale(surface, column("coupling_bytes"))
        self.fluid_rest = scale(f, rest["messages"]), scale(surface, rest["bytes"])
        self.fluid_iteration = scale(f, per_iteration["messages"]), scale(surface, per_iteration["bytes"])
        self.collective = float(np.mean(column("dem_collectives") + column("coupling_collectives"))), float(np.mean(rest["collectives"])), \
            float(np.mean(per_iteration["collectives"]))
        print("fitted to the counts: an interval and rank")
        print(f"  dem        {self.dem[0]:6.2f} messages a face neighbour     {self.dem[1]:8.0f} bytes a particle along the cuts")
        print(f"  coupling   {self.coupling[0]:6.2f} messages a neighbour          {self.coupling[1]:8.1f} bytes a fine cell along the cuts")
        print(f"  fluid      {self.fluid_rest[0]:6.2f} messages a face neighbour     {self.fluid_rest[1]:8.1f} bytes a fine cell along the cuts")
        print(f"             {self.fluid_iteration[0]:6.2f} and                          {self.fluid_iteration[1]:8.1f} a pressure iteration ({self.levels:.0f} levels)")
        print(f"  collectives {self.collective[0]:.1f}, of the fluid {self.collective[1]:.1f} and {self.collective[2]:.2f} a pressure iteration")
        print("  counted over fitted, by ranks " + " ".join(f"{p:>6d}" for p in ranks))
        it = column("pressure_iterations")
        for name, counted, fitted in (
                ("dem, messages", column("dem_messages"), self.dem[0] * f), ("dem, bytes", column("dem_bytes"), self.dem[1] * layer),
                ("coupling, messages", column("coupling_messages"), self.coupling[0] * n),
                ("coupling, bytes", column("coupling_bytes"), self.coupling[1] * surface),
                ("fluid, messages", column("fluid_messages"), (self.fluid_rest[0] + self.fluid_iteration[0] * it) * f),
                ("fluid, bytes", column("fluid_bytes"), (self.fluid_rest[1] + self.fluid_iteration[1] * it) * surface)):
            print(f"    {name:27s} " + " ".join(f"{q:6.2f}" for q in counted / fitted))
        self.largest = max(ranks)


def work(options):
    """us a particle and DEM step, us a cell and fluid step."""
    particle, cell = options.particle, options.cell
    if particle is None or cell is None:
        if not os.path.exists(options.scaling):
            raise SystemExit(f"neither --particle and --cell nor {options.scaling} (made by scaling.py)")
        with open(options.scaling) as f:
            rows = [r for r in csv.DictReader(f) if r["series"] == "coupled"]
        r = max(rows, key=lambda r: int(r["particles"]))
        share = lambda *names: sum(float(r["share_" + n]) for n in names) / 100
        if particle is None:
            particle = float(r["cpu_us"]) * share("dem", "deposit", "forces") / int(r["particles"])
        if cell is None:
            cell = float(r["cpu_us"]) * 10 * share("map", "fluid") / float(r["fluid_steps"]) / int(r["cells"])
    return particle, cell


def interval(t, o, particle, cell, ranks, particles):
    """ms of the terms, for so many particles in all."""
    n_p, n_c = particles / ranks, particles / ranks * o.cells
    side = max(1, round(ranks**(1 / 3)))
    grid = (side, side, max(1, ranks / side**2)) if ranks > 1 else (1, 1, 1)
    f, n, _ = neighbours(grid)
    surface, layer = f * n_c**(2 / 3), f * n_p**(2 / 3)
    levels = max(1.0, np.log2(max(n_c, 1)) / 3 + 1) / t.levels  # over the study's
    seconds = lambda messages, size: messages * o.latency * 1e-6 + size / (o.bandwidth * 1e9)
    log = np.ceil(np.log2(ranks)) if ranks > 1 else 0
    collectives = t.collective[0] + t.collective[1] + t.collective[2] * o.iterations
    # The messages of a coarse level are as many as of a fine one; bytes are the finest's, nearly.
    result = dict(
        work=(n_p * 10 * particle + n_c * cell) * 1e-6,
        dem=seconds(t.dem[0] * f, t.dem[1] * layer),
        coupling=seconds(t.coupling[0] * n, t.coupling[1] * surface),
        fluid=seconds((t.fluid_rest[0] + t.fluid_iteration[0] * o.iterations * levels) * f,
                      (t.fluid_rest[1] + t.fluid_iteration[1] * o.iterations) * surface),
        collectives=collectives * 2 * log * o.latency * 1e-6,
        gathered=0.0)
    if ranks > 1:
        cells = max(ranks, GATHER)
        result["gathered"] = cells * (SET_UP + CYCLE * o.iterations) + seconds(0, cells * (48 + 8 * o.iterations))
    return {k: 1e3 * v for k, v in result.items()}


def table(title, t, o, particle, cell, particles_of):
    print(f"{title}: ms an interval")
    print(f"  {'ranks':>6s} {'particles':>10s} {'a rank':>9s} " + " ".join(f"{k:>11s}" for k in TERMS) + "   work/time")
    rows, reached = [], {}
    for ranks in RANKS:
        n = particles_of(ranks)
        c = interval(t, o, particle, cell, ranks, n)
        whole = sum(c.values())
        rows.append(dict(kind=title.split(",")[0], ranks=ranks, particles=int(n), **{k: round(v, 6) for k, v in c.items()}))
        if ranks in SHOWN:
            print(f"  {ranks:6d} {n:10.3g} {n / ranks:9.3g} " + " ".join(f"{c[k]:11.4g}" for k in TERMS)
                  + f"   {c['work'] / whole:9.3f}")
        for k in TERMS[1:]:
            for part in (0.1, 0.5):
                if c[k] > part * c["work"]:
                    reached.setdefault((k, part), ranks)
    print("  ranks from which a term takes a tenth of the work, and half of it, first to break first:")
    for k in sorted(TERMS[1:], key=lambda k: (reached.get((k, 0.1), 1e9), reached.get((k, 0.5), 1e9))):
        print(f"    {k:12s} " + ", ".join(str(reached.get((k, part), f"not up to {RANKS[-1]}")) for part in (0.1, 0.5)))
    return rows


RANKS = sorted({int(round(r)) for r in np.logspace(0, 4, 81)})
SHOWN = (1, 10, 100, 1000, 3162, 10000)


def draw(tables, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(1, len(tables), figsize=(5.4 * len(tables), 4.2), squeeze=False)
    for ax, (title, rows) in zip(axes[0], tables):
        for i, k in enumerate(TERMS):
            points = [(r["ranks"], r[k]) for r in rows if r[k] > 0]
            ax.plot(*zip(*points), "k-" if k == "work" else f"C{i}-", lw=2 if k == "work" else 1.2, label=k)
        ax.set(xscale="log", yscale="log", xlabel="ranks", ylabel="ms an interval of 10 DEM steps", title=title)
        ax.grid(True, lw=0.3, alpha=0.5)
    axes[0][-1].legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    fig.tight_layout()
    fig.savefig(path, dpi=100, bbox_inches="tight")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--traffic", default=os.path.join(STUDY, "table.csv"))
    parser.add_argument("--scaling", default=os.path.join(HERE, "scaling.csv"))
    parser.add_argument("--particle", type=float, help="us a particle and DEM step, with drag and deposit")
    parser.add_argument("--cell", type=float, help="us a fine cell and fluid step, with map")
    parser.add_argument("--latency", type=float, default=1.5, help="us a message (default 1.5)")
    parser.add_argument("--bandwidth", type=float, default=10, help="GB/s a rank (default 10)")
    parser.add_argument("--iterations", type=float, default=7, help="pressure iterations (default 7)")
    parser.add_argument("--cells", type=float, default=1, help="fine cells a particle (default 1)")
    parser.add_argument("--weak", type=float, default=1e5, help="particles a rank (default 1e5: 1e9 on 1e4 ranks)")
    parser.add_argument("--strong", type=float, nargs="+", default=[1e7, 1e9], help="particles in all (default 1e7 and 1e9)")
    parser.add_argument("--out", default=HERE)
    o = parser.parse_args()
    t = Traffic(o.traffic)
    particle, cell = work(o)
    print(f"work: {particle:.4f} us a particle and DEM step, {cell:.3f} us a fine cell and fluid step; {o.cells:g} cells a particle")
    print(f"network: {o.latency:g} us a message, {o.bandwidth:g} GB/s a rank, collective 2 log2 P latencies; {o.iterations:g} pressure iterations")
    print(f"counted up to {t.largest} ranks: all above is extrapolated")
    tables = [("weak", table(f"weak, {o.weak:g} particles a rank", t, o, particle, cell, lambda p: o.weak * p))]
    for n in o.strong:
        tables.append((f"strong, {n:g}", table(f"strong {n:g}, particles in all", t, o, particle, cell, lambda p: n)))
    n, p = o.weak * RANKS[-1], RANKS[-1]
    print(f"memory a rank at {n:g} particles on {p} ranks that all of them hold: LIGGGHTS' map of identifiers (atom_modify map array, 4 bytes a particle "
          f"in all) {4e-9 * n:.1f} GB;\n  boxes of all ranks on {6 + 3} levels and exchanges, 24 bytes each: {24e-6 * p * 9:.1f} MB")
    with open(os.path.join(o.out, "cost_model.csv"), "w", newline="") as f:
        w = csv.DictWriter(f, ["kind", "ranks", "particles", *TERMS], lineterminator="\n")
        w.writeheader()
        w.writerows(r for _, rows in tables for r in rows)
    draw(tables, os.path.join(o.out, "cost_model.png"))


if __name__ == "__main__":
    main()
