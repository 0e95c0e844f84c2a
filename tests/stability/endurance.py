#!/usr/bin/python3
"""A small bubbling bed for a long time: no particle lost, solid volume and exchanged momentum exact at the end as at the
beginning, memory and time a step not growing. 20,000 DEM steps in the suite, 1,000,000 with --long.

Without this test a leak of a few hundred bytes a coupling, a list that is searched from end to end, or a slow creep of mass
would pass: no other run is long enough to show it.
"""
import os
import re
import subprocess
import sys
import tempfile
import time

import numpy as np

from hard import Checks, arguments, column, long_form, read_thermo
from small_bed import N, small_bed


def watch(executable, data, text, steps, period):
    """Runs on one rank, without mpirun, so that the process is ours to look at. Table of step, CPU seconds, resident
    memory of its own (kB; the libraries' pages come and go)."""
    folder = tempfile.TemporaryDirectory(prefix="twogrid_test_")
    for name, content in (("particles.data", data), ("in.test", text)):
        with open(os.path.join(folder.name, name), "w") as f:
            f.write(content)
    log = os.path.join(folder.name, "log.liggghts")
    tick, rows = os.sysconf("SC_CLK_TCK"), []
    with open(os.path.join(folder.name, "output"), "w") as out:
        run = subprocess.Popen([os.path.abspath(executable), "-in", "in.test"], cwd=folder.name, stdout=out, stderr=out)
        while run.poll() is None:
            time.sleep(period)
            try:
                with open(f"/proc/{run.pid}/stat") as f:
                    stat = f.read().rsplit(")", 1)[1].split()
                with open(f"/proc/{run.pid}/status") as f:
                    resident = int(re.search(r"RssAnon:\s+(\d+) kB", f.read()).group(1))
                with open(log) as f:
                    last = [line.split() for line in f.read()[-4000:].split("\n")[:-1]]
            except (OSError, IndexError, AttributeError):
                continue
            numbers = [int(w[0]) for w in last if len(w) == 11 and w[0].isdigit()]
            if numbers and resident:
                rows.append((numbers[-1], (int(stat[11]) + int(stat[12])) / tick, resident))
    if run.returncode:
        with open(os.path.join(folder.name, "output")) as f:
            sys.exit(f"FAIL: the run ended with code {run.returncode}\n{f.read()[-3000:]}")
    return np.array(rows), read_thermo(log)


def main():
    executable, _ = arguments()
    steps, often = (1000000, 2000) if long_form() else (20000, 100)
    c = Checks(f"a small bubbling bed for {steps} DEM steps")
    data, text = small_bed(steps, thermo=often)
    begin = 5000
    rows, t = watch(executable, data, text, steps, 0.02 if steps < 1e5 else 2.0)
    t = {n: v[t["Step"] > begin] for n, v in t.items()}
    c.true("no particle lost", t["Step"][-1] == begin + steps and np.all(t["Atoms"] == N))
    c.below("solid volume error, at any time", column(t, "f_gas[6]").max(), 1e-13)
    c.below("momentum exchange error, at any time", column(t, "f_gas[7]").max(), 1e-12)
    c.below("continuity error, at any time", column(t, "f_gas[5]").max(), 1e-4)
    weight = column(t, "f_gas[4]")
    half = len(weight) // 2
    c.note(f"mean pressure drop, first and second half: {weight[:half].mean():.2f}, {weight[half:].mean():.2f} Pa")
    step, cpu, kb = rows.T
    later = step > begin + 0.25 * steps
    c.note(f"{cpu[-1]:.0f} s CPU, {1e6 * (cpu[-1] - cpu[0]) / (step[-1] - step[0]):.0f} us a step; resident {kb[0]:.0f} kB, "
           f"at a quarter {kb[later][0]:.0f} kB, at the end {kb[-1]:.0f} kB")
    c.below("growth of resident memory after the first quarter (kB)", kb[later].max() - kb[later][0], 64)
    # Once the bed bubbles, for that costs more than a bed at rest. The median over pieces of the run: other processes on
    # the machine disturb some of them.
    pieces = np.diff(np.interp(begin + np.linspace(0.25, 0.99, 31) * steps, step, cpu)) / (0.74 / 30 * steps)
    first, last = np.median(pieces[:10]), np.median(pieces[20:])
    c.note(f"median of CPU time a step: first third {1e6 * first:.0f} us, last third {1e6 * last:.0f} us")
    if long_form():  # seconds of a busy machine say nothing
        c.below("CPU time a step, last third / first third", last / first, 1.15)
    c.end()


if __name__ == "__main__":
    main()
