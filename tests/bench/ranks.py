#!/usr/bin/python3
"""What several ranks gain and cost, on the common case (common_case.py) or the jetting bed.

    ranks.py EXECUTABLE [--case common|jetting] [--part time|work] [--fine NX NY NZ RX RY RZ] [--folder F]
             [--library LIBMPI_COUNT] [--most RANKS] [--quick]

time: wall time of two ranks (side by side in x) against one, from the same bubbling states, of
        coupled         the whole run with gas
        LIGGGHTS alone  the particles of the same states without gas, -particles stock
        ours alone      the same by twogrid's kernel
      Every run takes some steps first, which are not counted; then LIGGGHTS' own loop time is read, so that start-up is out.
      Runs on one and on two ranks take turns, and the least of several repeats counts for each state: other load on the machine only
      adds. On two busy cores give it priority, or it measures the load: as root `setsid sh -c 'echo -19 > /proc/self/autogroup; exec
      ranks.py ...'` (`nice -n -15` where the kernel groups no sessions). Speed-up is t1/t2, overhead 2 t2 - t1 a simulated
      second, both of the sums over states. Beside them, what speed-up could be at best: by balance, if particles were all the work and are
      shared out as they are; by the machine, 2 t1 over the time of two independent runs of one rank side by side.
      Wanted: a speed-up of at least 1.75, an overhead not larger than LIGGGHTS'.
work: (common case only) on 1, 2, 4, 8, 16 ranks, more than there are cores:
        instructions outside MPI, summed over ranks, by valgrind's callgrind: all calls from anything else into MPI's libraries are
        taken out with what they call, so waiting isn't counted. Collected in LIGGGHTS' time loop only, after a first run that warms up.
        Wanted: not more than 10 % above one rank's. By library, and for LIGGGHTS alone too.
        messages and bytes a rank and DEM step (mean and most), by the library mpi_count that is preloaded, as in cases/studies/traffic
      A low bed is cut upright only: 2 1 1, 4 1 1, 4 2 1, 8 2 1. A cut in z at half the box would leave the upper ranks without particles.
      Such cuts are the worst for the fluid, whose rows of cells run along x.

Without --folder everything is made anew (a minute or two more); in a folder the states are kept.
"""
import argparse
import collections
import concurrent.futures
import importlib.util
import os
import re
import sys
import tempfile

import numpy as np

from common_case import EVERY, GAS, HERE, N, SKIP, Bench

CASES = os.path.join(HERE, "..", "..", "cases")
GRIDS = {1: "1 1 1", 2: "2 1 1", 4: "4 1 1", 8: "4 2 1", 16: "8 2 1"}
STOCK = ["-particles", "stock"]
WARM = 100                # steps before those that are timed
IN_MPI = re.compile(r"libmpi|libopen-pal|libopen-rte|/openmpi3?/|libevent|libucp|libuct|libucs|libpmix|libhwloc|libfabric")
LOOP = re.compile(r"^Loop time of ([\d.eE+-]+) on", re.M)
FULLER = re.compile(r"^Nlocal:\s+([\d.eE+-]+) ave\s+([\d.eE+-]+) max", re.M)


class Common:
    """The common case from states between 0.2 and 1 s of bubbling."""
    particles, dt = N, 1e-5

    def __init__(self, bench, fine, states):
        self.bench, self.fine = bench, dict(zip(("nx", "ny", "nz", "rx", "ry", "rz"), fine))
        self.states = [f"gas.{i}" for i in ((3,) if states == 1 else (0, 2, 4, 6) if states == 4 else range(states))]
        bench.settle()
        if not all(os.path.exists(os.path.join(bench.folder, s)) for s in self.states):
            bench.coupled("gas", fine, [SKIP + 0.1 * (i + 1) for i in range(8)])

    def script(self, state, grid, gas):
        text = self.bench.head(f"read_restart {state}", "RANKS").replace("processors RANKS 1 1", f"processors {grid}")
        # A line every coupling would be printed by one of two busy cores, and wake mpirun, which has no core of its own.
        return text + (GAS.format(**self.fine).replace("thermo 10\n", "thermo 1000\n") if gas else "")


class Jetting:
    """One jet in a bed, from states between 0.1 and 0.3 s; scripts are cut out of the case's own."""
    particles, dt = 9600, 1.25e-5

    def __init__(self, bench, _, states):
        self.bench = bench
        self.states = [f"jet.{i}" for i in range(states)]
        with open(os.path.join(CASES, "jetting_bed", "in.jetting_bed")) as f:
            self.text = f.read()
        os.makedirs(os.path.join(bench.folder, "out"), exist_ok=True)
        if not all(os.path.exists(os.path.join(bench.folder, s)) for s in self.states):
            every = int(0.2 / states / self.dt / 400) * 400
            script = self.before("run         ${steps} upto").replace("index 0.025", "index 10") + "run 4800\n"
            bench.run("jet", script + "".join(f"run {every}\nwrite_restart {s}\n" for s in self.states), ["-var", "px", "1"], 1)

    def before(self, mark):
        assert self.text.count(mark) == 1, mark
        return self.text.split(mark)[0]

    def script(self, state, grid, gas):
        head = self.before("region      fill").replace("create_box  1 box", f"read_restart {state}").replace("region      box block", "# ")
        text = re.sub(r"^processors.*", f"processors {grid}", head, flags=re.M)
        if gas:
            # From the full jet on; no frames, no tables.
            part = self.before("variable    frame equal").split("variable    background equal ramp(0,${Ub})")[1]
            text += "variable jet equal ${U}\nvariable background equal ${Ub}\n" + part
        return text + "thermo_style custom step atoms cpu\nthermo_modify lost error norm no\nthermo 1000\n"


def loop_time(bench, script, steps, ranks, options, name="timed"):
    """Wall seconds, and the particles of a rank in the mean over those of the fullest at the end."""
    _, text = bench.run(name, script + f"run {WARM}\nrun {steps}\n", options, ranks)
    mean, most = map(float, FULLER.findall(text)[-1])
    return float(LOOP.findall(text)[-1]), mean / most


def time_part(case, steps, repeats):
    kinds = (("coupled", True, []), ("LIGGGHTS alone", False, STOCK), ("ours alone", False, []))
    least, balance = collections.defaultdict(lambda: np.inf), {}
    for _ in range(repeats):
        for state in case.states:
            for name, gas, options in kinds:
                for ranks in (1, 2):
                    t, balance[name, state, ranks] = loop_time(case.bench, case.script(state, GRIDS[ranks], gas), steps, ranks, options)
                    least[name, state, ranks] = min(least[name, state, ranks], t)
                with concurrent.futures.ThreadPoolExecutor() as two:
                    script = case.script(state, GRIDS[1], gas)
                    both = list(two.map(lambda i: loop_time(case.bench, script, steps, 1, options, f"side{i}")[0], (1, 2)))
                least[name, state, "both"] = min(least[name, state, "both"], max(both))
    simulated = steps * case.dt * len(case.states)
    print(f"wall seconds a simulated second, {case.particles} particles, {len(case.states)} states of {steps} steps, least of {repeats}")
    print(f"  {'':16s} {'1 rank':>8s} {'2 ranks':>8s} {'speed-up':>9s} {'of states':>13s} {'overhead 2 t2 - t1':>19s}   at best by balance, machine")
    result = {}
    for name, _, _ in kinds:
        t = np.array([[least[name, s, r] for r in (1, 2, "both")] for s in case.states])
        t1, t2, both = t.sum(0) / simulated
        of = t[:, 0] / t[:, 1]
        balanced = t[:, 0].sum() / sum(least[name, s, 1] / 2 / balance[name, s, 2] for s in case.states)
        result[name] = t1 / t2, 2 * t2 - t1
        print(f"  {name:16s} {t1:8.1f} {t2:8.1f} {t1 / t2:9.3f} {of.min():6.2f}-{of.max():.2f} {2 * t2 - t1:16.1f} s {balanced:18.2f} {2 * t1 / both:14.2f}")
    fast, over, stock = result["coupled"][0], result["coupled"][1], result["LIGGGHTS alone"][1]
    print(f"{'ok  ' if fast >= 1.75 else 'FAIL'} speed-up of the coupled run on two ranks {fast:.3f} (wanted at least 1.75)")
    print(f"{'ok  ' if over <= stock else 'FAIL'} its overhead {over:.1f} s a simulated second (wanted at most LIGGGHTS': {stock:.1f})")
    return fast >= 1.75 and over <= stock


def outside_mpi(path):
    """Instructions in a callgrind file that MPI's libraries did not cause, and those of each other library itself."""
    objects, own, into_mpi = {}, collections.Counter(), 0
    here = callee = ""
    call = False
    with open(path) as f:
        for line in f:
            if line.startswith(("ob=", "cob=")):
                key, _, text = line.rstrip("\n").partition("=")
                number, _, rest = text.partition(" ")
                if rest:
                    objects[number] = rest
                if key == "ob":
                    here = objects[number]
                else:
                    callee = objects[number]
            elif line.startswith("calls="):
                call = True
            elif line[0] in "0123456789+-*" and " " in line:
                cost = int(line.split()[1])
                if not call:
                    own[here] += cost
                elif callee and IN_MPI.search(callee) and not IN_MPI.search(here):
                    into_mpi += cost
                if call:
                    call, callee = False, ""
    return sum(own.values()) - into_mpi, {o: n for o, n in own.items() if not IN_MPI.search(o)}


def instructions(bench, script, ranks, options, warm, steps):
    """Sum over ranks of instructions a DEM step outside MPI; by library."""
    loop = "LAMMPS_NS::Verlet::run(int)"
    # Bound at start, or calls would seem to come from the loader.
    bench.run("counted", script + f"run {warm}\nrun {steps}\n", options, ranks, prefix=[
        "env", "LD_BIND_NOW=1", "valgrind", "--tool=callgrind", "--callgrind-out-file=callgrind.%q{OMPI_COMM_WORLD_RANK}",
        f"--toggle-collect={loop}", f"--zero-before={loop}"])
    total, parts = 0, collections.Counter()
    for rank in range(ranks):
        n, own = outside_mpi(os.path.join(bench.folder, f"callgrind.{rank}"))
        total += n / steps
        for o, c in own.items():
            name = os.path.basename(o)
            parts["twogrid" if o == bench.executable else re.split(r"[._-]", name)[0]] += c / steps
    return total, parts


def traffic_module():
    spec = importlib.util.spec_from_file_location("count_traffic", os.path.join(CASES, "studies", "traffic", "traffic.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def messages(bench, script, ranks, options, library, warm, steps):
    """Array over ranks: messages and bytes a DEM step, collectives and their bytes, by part of the program."""
    traffic = traffic_module()
    symbols = traffic.Symbols(bench.executable)
    counts = {}
    for n in (warm, warm + steps):
        bench.run("sent", script + f"run {n}\n", options, ranks, prefix=["env", f"LD_PRELOAD={library}", "MPI_COUNT=count"])
        counts[n] = {part: np.zeros((ranks, 4)) for part in traffic.PARTS}
        for rank in range(ranks):
            with open(os.path.join(bench.folder, f"count.{rank}")) as f:
                for line in f:
                    kind, calls, size, *frames = line.split()
                    chain = [symbols(f) for f in frames]
                    if any(f.startswith("LAMMPS_NS::Verlet::run(") for f in chain):
                        at = 0 if kind == "p2p" else 2
                        counts[n][traffic.part_of(chain)][rank, at:at + 2] += int(calls), int(size)
    return {part: (counts[warm + steps][part] - counts[warm][part]) / steps for part in traffic.PARTS}


def work_part(case, fine, library, quick, wanted):
    warm, steps = (10, 20) if quick else (20, 100)
    state, most = case.states[len(case.states) // 2], 0
    print(f"{np.prod(fine[:3])} fine cells; instructions outside MPI, all ranks, a particle and DEM step ({steps} steps from {state})")
    kinds = (("coupled", True, []), ("LIGGGHTS alone", False, STOCK))
    for name, gas, options in kinds:
        one = None
        for ranks in wanted:
            script = case.script(state, GRIDS[ranks], gas)
            n, parts = instructions(case.bench, script, ranks, options, warm, steps)
            one = one or n
            main = {k: v for k, v in parts.items() if v > 0.01 * n}
            print(f"  {name:15s} {ranks:2d} ranks ({GRIDS[ranks]}) {n / case.particles:7.1f}  {100 * (n / one - 1):+6.1f} %   "
                  + ", ".join(f"{k} {v / case.particles:.1f}" for k, v in sorted(main.items(), key=lambda m: -m[1])), flush=True)
            if gas:
                most = max(most, n / one - 1)
    print(f"{'ok  ' if most <= 0.1 else 'FAIL'} growth of the coupled run's instructions {100 * most:.1f} % (wanted at most 10 %)")
    if library:
        print(f"messages and bytes a rank and DEM step, mean (most); collectives, mean; coupled every {EVERY} steps")
        for ranks in wanted[1:]:
            sent = messages(case.bench, case.script(state, GRIDS[ranks], True), ranks, [], library, 20, steps)
            sent["all"] = sum(sent.values())
            for part, c in sent.items():
                print(f"  {ranks:2d} ranks {part:9s} {c[:, 0].mean():7.1f} ({c[:, 0].max():.1f})  {c[:, 1].mean():9.0f} ({c[:, 1].max():.0f}) bytes  "
                      f"{c[:, 2].mean():6.2f} collectives", flush=True)
    return most <= 0.1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("executable")
    parser.add_argument("--case", choices=("common", "jetting"), default="common")
    parser.add_argument("--part", choices=("time", "work"), help="default: both")
    parser.add_argument("--fine", type=int, nargs=6, default=[15, 3, 50, 1, 1, 1], metavar="N", help="fine cells and ratio, common case")
    parser.add_argument("--folder", help="where states and runs are kept; those that are there are used again")
    parser.add_argument("--library", help="libmpi_count.so of the build folder; without it no messages are counted")
    parser.add_argument("--steps", type=int, default=2000, help="DEM steps that are timed in each state")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--most", type=int, default=16, help="ranks up to which work is counted")
    parser.add_argument("--quick", action="store_true", help="one state, few steps, two ranks: shows that it works")
    a = parser.parse_args()
    steps, repeats, states = (200, 1, 1) if a.quick else (a.steps, a.repeats, 4 if a.case == "common" else 2)
    good = True
    with tempfile.TemporaryDirectory() as scratch:
        folder = os.path.abspath(a.folder or scratch)
        os.makedirs(folder, exist_ok=True)
        case = {"common": Common, "jetting": Jetting}[a.case](Bench(a.executable, folder, 1), a.fine, states)
        if a.part != "work":
            good &= time_part(case, steps, repeats)
        if a.part != "time" and a.case == "common":
            good &= work_part(case, a.fine, a.library and os.path.abspath(a.library), a.quick, [1, 2] if a.quick else [r for r in GRIDS if r <= a.most])
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
