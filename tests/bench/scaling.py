#!/usr/bin/python3
"""How cost and memory grow with the number of particles and of fine cells: 1e4 to 1e6 of each.

    scaling.py EXECUTABLE [--out FOLDER] [--largest N] [--quick]
    scaling.py EXECUTABLE --thin        only: bytes a cell of a bed 40 x 8 cells wide, at ratio 4, 2 and 1 (a minute)

A closed box of n x n x n spheres (1 mm, 2500 kg/m3) on a shaken lattice, solid fraction 0.45, random velocities up to 0.2 m/s, gas
from below at 0.3 m/s; one rank; DEM step 1e-5 s, coupled every 10; particle cells of 4 spacings (64 spheres), trilinear deposit.
  particles   n = 20 to 100, one fine cell a sphere (ratio 4). Also LIGGGHTS alone (-particles stock, no gas), and, up to 3.2e5, our
              kernel alone.
  cells       n = 24 (13,824 spheres), ratio 4 to 16: 13,824 to 884,736 fine cells, one fluid step a coupling.
CPU seconds (user and system) of a run less those of a shorter one, so that start-up and reading the particles are out; the
median of several pairs for small boxes. Particles: the same window of time for all sizes, DEM steps 50 to 150. Cells: the shares of
fluid, map and deposit that the log states, a fluid step.
Memory: peak resident set of the process. Bytes a cell: between the smallest and the largest of the cells' runs. Bytes a particle:
between two boxes with 64 spheres a fine cell, less LIGGGHTS alone at the same sizes. Thin bed: between heights of 400 and 3200 cells with
two spheres in them, less the same without gas (bins of neighbour lists).
Exponents: slope of log cost against log size, least squares over all sizes. Wanted: at most 1.08; at most 400 bytes a fine cell, and 1000
bytes a particle over LIGGGHTS alone. Writes scaling.csv and scaling.png into FOLDER (default: here). Some 10 minutes on one core, up to 3 GB.
"""
import argparse
import csv
import os
import re
import resource
import subprocess
import sys
import tempfile

import numpy as np

from common_case import MPIRUN
from harness import data_file, read_thermo

D, SPACING, EVERY, FIRST, LAST = 1e-3, 1.05e-3, 10, 50, 150
SCENE = """
units si
atom_style granular
newton off
communicate single vel yes
boundary f f f
processors 1 1 1
read_data {data}
neighbor 0.3e-3 bin
neigh_modify delay 0
soft_particles yes
fix kn all property/global kn peratomtypepair 1 200.0
fix kt all property/global kt peratomtypepair 1 60.0
fix gn all property/global gamman peratomtypepair 1 500.0
fix gt all property/global gammat peratomtypepair 1 250.0
fix mu all property/global coefficientFriction peratomtypepair 1 0.1
pair_style gran model hooke/stiffness tangential history
pair_coeff * *
timestep 1e-5
{walls}
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
"""
WALL = "fix {a}{i} all wall/gran model hooke/stiffness tangential history primitive type 1 {a}plane {at!r}\n"
GAS = """
fix gas all twogrid fine {nx} {ny} {nz} ratio {r} {r} {r} density 1.2 viscosity 1.8e-5 every 10
fix_modify gas deposit trilinear prolong constant read cell cfl 1
fix_modify gas boundary zlo inlet 0 0 0.3 boundary zhi pressure 0 initial u 0 0 0.5
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
thermo_style custom step atoms ke f_gas[2] f_gas[3] f_gas[9] f_gas[10]
"""


def gas_in(cells, r):
    return GAS.format(nx=cells[0], ny=cells[1], nz=cells[2], r=r)


SHARES = re.compile(r"shares of CPU time: DEM ([\d.]+) %, deposit ([\d.]+) %, map and read ([\d.]+) %, fluid ([\d.]+) %, forces ([\d.]+) %")
FIELDS = ["series", "particles", "cells", "cpu_us", "share_dem", "share_deposit", "share_map", "share_fluid", "share_forces", "fluid_steps",
          "iterations", "peak_MB"]


# Starts the program from a small process, since a child's peak begins with its parent's.
PEAK = "import os, sys; p = os.spawnv(os.P_NOWAIT, sys.argv[1], sys.argv[1:]); _, s, u = os.wait4(p, 0); print('peak kB', u.ru_maxrss); sys.exit(s != 0)"


class Boxes:
    def __init__(self, executable, folder):
        self.executable, self.folder = os.path.abspath(executable), folder

    def data(self, n):
        name = os.path.join(self.folder, f"particles.{n}")
        if not os.path.exists(name):
            rng = np.random.default_rng(7)
            q = (np.arange(n) + 0.5) * SPACING
            z, y, x = np.meshgrid(q, q, q, indexing="ij")
            at = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
            at += rng.uniform(-0.5, 0.5, at.shape) * (SPACING - D)
            L = n * SPACING
            with open(name, "w") as f:
                f.write(data_file(f"0 {L!r} 0 {L!r} 0 {L!r}", at, D, 2500, rng.uniform(-0.2, 0.2, at.shape)))
        return name

    def run(self, n, gas, options, steps):
        """CPU seconds, peak memory (bytes), output."""
        return self.run_box(self.data(n), 3 * [n * SPACING], gas, options, steps)

    def thin(self, cells, gas):
        """Peak memory (bytes) of a bed of cells of 1 mm."""
        size = [1e-3 * c for c in cells]
        data = os.path.join(self.folder, "thin")
        with open(data, "w") as f:
            f.write(data_file(" ".join(f"0 {L!r}" for L in size), np.outer((0.3, 0.6), size), D, 2500, np.zeros((2, 3))))
        return self.run_box(data, size, gas, [], 20)[1]

    def run_box(self, data, size, gas, options, steps):
        walls = "".join(WALL.format(a=a, i=i, at=at) for a, L in zip("xyz", size) for i, at in enumerate((0.0, L)))
        script = SCENE.format(data=data, walls=walls) + gas + f"thermo 50\nthermo_modify lost error norm no\nrun {steps}\n"
        with open(os.path.join(self.folder, "in.box"), "w") as f:
            f.write(script)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([MPIRUN, "1", sys.executable, "-S", "-c", PEAK, self.executable, "-in", "in.box", *options], cwd=self.folder,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode:
            sys.exit(done.stdout[-3000:])
        peak = 1024.0 * int(re.search(r"peak kB (\d+)", done.stdout).group(1))
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, peak, done.stdout

    def measure(self, series, n, cells, gas, options, first, last, repeats):
        """CPU us a DEM step, with shares; a row of the table."""
        times, peak = [], 0
        for _ in range(repeats):
            short, _, _ = self.run(n, gas, options, first)
            long, memory, text = self.run(n, gas, options, last)
            times.append((long - short) / (last - first))
            peak = max(peak, memory)
        row = dict.fromkeys(FIELDS, "")
        row.update(series=series, particles=n**3, cells=cells, cpu_us=round(float(np.median(times)) * 1e6, 2), peak_MB=round(peak / 1e6, 1))
        found = SHARES.search(text)
        if found:
            row.update(zip(FIELDS[4:9], map(float, found.groups())))
            t = read_thermo(os.path.join(self.folder, "log.liggghts"))
            late = t["Step"] > first
            row.update(fluid_steps=round(float(np.mean(1e-5 * EVERY / t["gas[2]"][late])), 2), iterations=round(float(np.mean(t["gas[10]"][late])), 1))
        print(f"  {series:15s} {n**3:8d} particles {cells:8d} cells  {row['cpu_us'] / n**3:8.4f} us a particle and DEM step  peak {row['peak_MB']:7.1f} MB"
              + (f"  fluid steps {row['fluid_steps']}, iterations {row['iterations']}, shares " + " ".join(str(row[k]) for k in FIELDS[4:9]) if found else ""), flush=True)
        return row


def fluid_us(row):
    """CPU us a fluid step of what goes with the cells: fluid, map, deposit."""
    return row["cpu_us"] * EVERY * (row["share_fluid"] + row["share_map"] + row["share_deposit"]) / 100 / row["fluid_steps"]


def exponent(x, y):
    return np.polyfit(np.log(x), np.log(y), 1)[0]


def draw(rows, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(1, 2, figsize=(10, 4))
    for name, marker in (("coupled", "o"), ("ours alone", "s"), ("LIGGGHTS alone", "D")):
        mine = [(r["particles"], r["cpu_us"] / r["particles"]) for r in rows if r["series"] == name]
        axes[0].plot(*zip(*mine), marker + "-", ms=5, lw=1, label=name)
    axes[0].set(xscale="log", xlabel="particles", ylabel="CPU us a particle and DEM step", ylim=(0, None))
    mine = [r for r in rows if r["series"] == "cells"]
    n = [r["cells"] for r in mine]
    axes[1].plot(n, [r["cpu_us"] * EVERY * r["share_fluid"] / 100 / r["fluid_steps"] / r["cells"] for r in mine], "o-", ms=5, lw=1, label="fluid")
    axes[1].plot(n, [fluid_us(r) / r["cells"] for r in mine], "s-", ms=5, lw=1, label="fluid, map, deposit")
    axes[1].set(xscale="log", xlabel="fine cells", ylabel="CPU us a cell and fluid step", ylim=(0, None))
    for ax in axes:
        ax.grid(True, lw=0.3, alpha=0.5)
        ax.legend(fontsize=8, frameon=False)
    fig.tight_layout()
    fig.savefig(path, dpi=100)


def thin_bed(executable):
    low, high = (40, 8, 400), (40, 8, 3200)
    good = True
    with tempfile.TemporaryDirectory() as folder:
        b = Boxes(executable, folder)
        alone = b.thin(high, "") - b.thin(low, "")
        for r in (4, 2, 1):
            more = b.thin(high, gas_in(high, r)) - b.thin(low, gas_in(low, r))
            value = (more - alone) / (np.prod(high) - np.prod(low))
            good &= bool(value <= 400)
            print(f"{'ok  ' if value <= 400 else 'FAIL'} memory a fine cell, bed of 40 x 8 cells, ratio {r}: {value:.0f} bytes (wanted at most 400)", flush=True)
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("executable")
    parser.add_argument("--out", default=os.path.dirname(os.path.abspath(__file__)))
    parser.add_argument("--largest", type=int, default=1000000, help="particles")
    parser.add_argument("--quick", action="store_true", help="small sizes, once: shows that it works")
    parser.add_argument("--thin", action="store_true")
    a = parser.parse_args()
    if a.thin:
        sys.exit(0 if thin_bed(a.executable) else 1)
    sizes = (20, 32) if a.quick else [n for n in (20, 32, 48, 68, 100) if n**3 <= a.largest]
    rows, good = [], True
    with tempfile.TemporaryDirectory() as folder:
        b = Boxes(a.executable, folder)

        def save():
            with open(os.path.join(a.out, "scaling.csv"), "w", newline="") as f:
                w = csv.DictWriter(f, FIELDS, lineterminator="\n")
                w.writeheader()
                w.writerows(rows)

        # The cells first: they take least.
        for r, last in ((4, 1050), (8, 350)) if a.quick else ((4, 1050), (8, 350), (12, 150), (16, 150)):
            rows.append(b.measure("cells", 24, (6 * r)**3, gas_in(3 * [6 * r], r), [], FIRST, last, 1))
            save()
        lean = {}
        for n in (32, 48) if a.quick else (48, 68):
            for name, gas, options in (("gas", gas_in(3 * [n // 4], 1), []), ("stock", "", ["-particles", "stock"])):
                lean[n, name] = b.run(n, gas, options, 20)[1]
        for n in sizes:
            repeats = 1 if a.quick or n > 60 else {20: 7, 32: 3, 48: 1}[n]
            rows.append(b.measure("coupled", n, n**3, gas_in(3 * [n], 4), [], FIRST, LAST, repeats))
            rows.append(b.measure("LIGGGHTS alone", n, 0, "", ["-particles", "stock"], FIRST, LAST, repeats))
            if n <= 68:
                rows.append(b.measure("ours alone", n, 0, "", [], FIRST, LAST, repeats))
            save()

    def check(what, value, bound, text):
        nonlocal good
        good &= bool(value <= bound)
        print(f"{'ok  ' if value <= bound else 'FAIL'} {what}: {text.format(value)} (wanted at most {text.format(bound)})")

    for name in ("coupled", "LIGGGHTS alone", "ours alone"):
        mine = [r for r in rows if r["series"] == name]
        e = exponent([r["particles"] for r in mine], [r["cpu_us"] for r in mine])
        if name == "coupled":
            check("exponent of cost against particles, coupled", e, 1.08, "{:.3f}")
        else:
            print(f"     exponent, {name}: {e:.3f}")
    cells = [r for r in rows if r["series"] == "cells"]
    n = np.array([r["cells"] for r in cells])
    check("exponent of cost against fine cells, fluid", exponent(n, [r["cpu_us"] * r["share_fluid"] / r["fluid_steps"] for r in cells]), 1.08, "{:.3f}")
    print(f"     exponent, fluid, map and deposit (of which a part belongs to the particles): {exponent(n, [fluid_us(r) for r in cells]):.3f}")
    a_cell = (cells[-1]["peak_MB"] - cells[0]["peak_MB"]) * 1e6 / (n[-1] - n[0])
    check("memory a fine cell", a_cell, 400, "{:.0f} bytes")
    (n0, _), (n1, _) = sorted(k for k in lean if k[1] == "gas")
    per = {name: (lean[n1, name] - lean[n0, name]) / (n1**3 - n0**3) for name in ("gas", "stock")}
    check("memory a particle over LIGGGHTS alone", per["gas"] - per["stock"] - a_cell / 64, 1000, "{:.0f} bytes")
    print(f"     LIGGGHTS alone: {per['stock']:.0f} bytes a particle")
    draw(rows, os.path.join(a.out, "scaling.png"))
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
