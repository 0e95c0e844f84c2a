#!/usr/bin/python3
"""A run as it is seen from outside: status.json beside its log, and runs that go wrong end with a sentence.

    watched.py EXECUTABLE RANKS...

What would pass falsely without it: a status that a reader finds cut in half, says "running" or "finished" of a run that ended with an
error, or holds other figures than the run's own; two runs of a folder that write over each other's; a bed that pours out of the box to
the last particle in a run that ends with exit code 0, or does so unseen because as many are inserted; a particle that is nowhere, which
kills the program by a segmentation fault when LIGGGHTS sorts particles into cells, with and without a fluid; a fluid of given steps
whose Courant number is 10^5 until its pressure is not a number.
"""
import json
import os
import subprocess
import tempfile
import time

import numpy as np

from harness import ENDS_AT_ONCE, Checks, arguments, column, data_file, head_with_particles, launch, walls
from harness import Run as HarnessRun

BOX = "0 0.008 0 0.004 0 0.008"
GAS = """
fix gas all twogrid fine 8 4 8 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every {every}
fix_modify gas boundary zlo inlet 0 0 0.5 boundary zhi pressure 0 {modify}
fix_modify gas output off
thermo_style custom step atoms f_gas[1] f_gas[3] f_gas[6] f_gas[7] f_gas[9]
thermo_modify norm no
thermo {every}
"""
GRID = np.array([[(i + .5) * 1e-3, (j + .5) * 1e-3, (k + .5) * 1e-3] for k in range(6) for j in range(4) for i in range(8)])  # rows of 32




class Run(HarnessRun):
    def __init__(self, executable, script, ranks, *words, **values):
        super().__init__(executable, script, ranks, *words, launcher=ENDS_AT_ONCE, **values)


def script(dt=1e-5, closed=True, motion="fix motion all nve/sphere\n", every=10, modify="", gas=GAS, **values):
    w = walls(xplane=(0, 0.008), yplane=(0, 0.004), zplane=(0, 0.008)) if closed else ""
    return head_with_particles(dt, boundary="f f f", **values) + w + motion + gas.format(every=every, modify=modify)


def status(run, name="status.json"):
    with open(run.file(name)) as f:
        return json.load(f)


def errors(run):
    return [line for line in run.output.splitlines() if line.startswith("ERROR")]


def followed(c, executable, ranks):
    """Read as often as can be while the run goes on: always whole, always plausible; at the end the figures of the log."""
    text = script(gas="thermo 1000\n") + "run 2000\n" + GAS.format(every=10, modify="") + "run 4000\nrun 60000 upto\n"
    with tempfile.TemporaryDirectory(prefix="twogrid_test_") as folder:
        for name, content in (("in.test", text), ("particles.data", data_file(BOX, GRID, 0.9e-3, 2500))):
            with open(os.path.join(folder, name), "w") as f:
                f.write(content)
        command = launch(ranks) + [os.path.abspath(executable), "-in", "in.test", "-log", "log/second.log"]
        os.mkdir(os.path.join(folder, "log"))
        p = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
        path, seen, broken = os.path.join(folder, "log", "second.status.json"), [], 0
        while p.poll() is None:
            try:
                with open(path) as f:
                    seen.append(json.load(f))
            except FileNotFoundError:
                pass
            except ValueError:
                broken += 1
            time.sleep(0.001)
        with open(path) as f:
            last = json.load(f)
        run = Run.__new__(Run)
        run.path = os.path.join(folder, "log")
        os.rename(os.path.join(run.path, "second.log"), os.path.join(run.path, "log.liggghts"))
        t = run.thermo()
        left = sorted(os.listdir(run.path))
    dates = len({(s["step"], s["wall_seconds"]) for s in seen})
    c.true(f"{ranks} rank(s): {len(seen)} times read, {dates} files, {broken} of them not whole", broken == 0 and dates >= 4)
    runs = {(s["run"]["first_step"], s["run"]["last_step"]) for s in seen if s["run"]["running"]}
    c.true(f"runs that were seen: {sorted(runs)}", runs == {(0, 2000), (2000, 6000), (6000, 60000)})
    c.true("a run without a fluid has no figures of one", all(s["time"] is None and s["courant_number"] is None for s in seen if s["step"] < 2000))
    within = [s for s in seen if s["run"]["running"] and 0 < s["run"]["steps_done"] < s["run"]["last_step"] - s["run"]["first_step"]]
    c.true(f"{len(within)} times within a run, with a rate and the time to go", len(within) > 0 and all(
        s["state"] == "running" and s["steps_per_second"] > 0 and
        abs(s["run"]["seconds_to_go"] * s["steps_per_second"] / s["run"]["steps_to_go"] - 1) < 1e-6 for s in within))
    c.true(f"last: {last['state']}, step {last['step']}, {last['particles']} particles", last["state"] == "finished" and last["error"] is None
           and last["step"] == 60000 and last["particles"] == len(GRID) and not last["run"]["running"] and last["run"]["steps_to_go"] == 0)
    for name, value in (("f_gas[1]", last["time"]), ("f_gas[3]", last["courant_number"]), ("f_gas[9]", last["smallest_void_fraction"])):
        c.below(f"{name}, the log's against the status'", abs(value / column(t, name)[-1] - 1), 1e-6)
    c.below("ledger: error of momentum", abs(last["ledger"]["momentum_error"]), 1e-9)
    c.true(f"nothing but the log beside it: {left}", left == ["log.liggghts", "second.status.json"])


def ends(c, executable, ranks):
    files = {"particles.data": data_file(BOX, GRID, 0.9e-3, 2500)}
    go = lambda last, **values: Run(executable, script() + "run 20\n" + last, ranks, files=files, expect_success=False, **values)
    r = go("compute nonsense all nonsense\n")
    s = status(r)
    c.true(f"an error of LIGGGHTS: {s['state']}, {s['error']}", r.code != 0 and s["state"] == "error" and s["error"] and s["error"] in errors(r)[0])
    r = go("fix_modify gas drag nonsense\n")
    s = status(r)
    c.true(f"an error of ours: {s['state']}, {(s['error'] or '')[:60]}", r.code != 0 and s["state"] == "error" and s["error"] in errors(r)[0])
    r = go("quit\nrun 20\n")
    c.true("the command quit is no error", status(r)["state"] == "finished" and status(r)["step"] == 20)
    r = go("", options=["-log", "none"])
    c.true("without a log there is no status", r.code == 0 and not [n for n in os.listdir(r.path) if "status" in n])


TEMPLATES = """
region top block 0 0.008 0 0.004 0.0070 0.0080 units box
fix ball all particletemplate/sphere 10487 atom_type 1 density constant 2500 radius constant 0.00045
fix mix all particledistribution/discrete 32452867 1 ball 1.0
fix more all insert/rate/region seed 32452843 distributiontemplate mix nparticles 500 particlerate 20000 insert_every 50 overlapcheck yes &
  vel constant 0 0 -1 region top
"""


def lost(c, executable, ranks, *trials):
    """Rows of 32 fall at 1 m/s, without forces worth mentioning, through a floor that isn't there: after 4e-3 s the four
    whose centres were within 4 mm are gone."""
    v = np.zeros_like(GRID) + [0, 0, -1.0]
    files = {"particles.data": data_file(BOX, GRID, 0.9e-3, 25000, v)}
    weightless = dict(closed=False, motion="fix motion all nve/sphere\n")
    for limit, pour, ends_early in trials:
        modify = f"one-way yes drag stokes most_lost {limit}"
        r = Run(executable, script(modify=modify, **weightless) + pour + "run 400\n", ranks, files=files, expect_success=False)
        what = f"most_lost {limit}{', with insertion' if pour else ''}"
        s = status(r)
        if ends_early:
            found = [line for line in errors(r) if "most_lost: found 128" in line and "at most 96" in line]
            c.true(f"{what}: {(errors(r) or ['no sentence'])[0][:100]}", r.code != 0 and len(found) == 1 and s["state"] == "error")
        else:
            c.true(f"{what}: code {r.code}, {s['particles_lost']} lost, {s['particles']} there, {column(r.thermo(), 'Atoms')[-1]:.0f} in the log",
                   r.code == 0 and s["particles_lost"] == 128 and s["particles"] == column(r.thermo(), "Atoms")[-1] and
                   (s["particles"] > 64) == bool(pour))


def nowhere(c, executable, ranks):
    """Two spheres in one place; the others are so fast that neighbour lists are built long before the next coupling."""
    x = np.vstack([GRID, GRID[5]])
    v = np.random.default_rng(1).normal(size=x.shape) * 3
    files = {"particles.data": data_file(BOX, x, 0.9e-3, 2500, v)}
    for what, text, options in (("our kernel", script(every=1000), ()), ("LIGGGHTS' own", script(every=1000), ("-particles", "stock")),
                                ("no fluid", script(gas=""), ())):
        r = Run(executable, text + "run 2000\n", ranks, options, files=files, expect_success=False)
        c.true(f"two spheres in one place, {what}: {(errors(r) or ['no sentence'])[0][:110]}",
               r.code == 1 and len(errors(r)) == 1 and "not finite" in errors(r)[0] and "timestep" in errors(r)[0])
        c.true(f"the status says so: {(status(r)['error'] or 'no')[:60]}", status(r)["state"] == "error" and status(r)["error"] in errors(r)[0])


def courant(c, executable, ranks):
    """Fluid steps of 1e-4 s and a jet of 50 m/s into cells of 1 mm: Courant numbers of 5 and more."""
    files = {"particles.data": data_file(BOX, GRID[:1], 0.9e-3, 2500)}
    jet = "boundary zlo patch jet rect 0.002 0.006 0 0.004 inlet 0 0 50"
    r = Run(executable, script(modify=f"dt 1e-4 {jet}") + "run 2000\n", ranks, files=files, expect_success=False)
    said = [line for line in r.output.splitlines() if "WARNING" in line and "Courant number is" in line]
    c.true(f"told: {(said or ['nothing'])[0][:130]}", len(said) >= 1 and "lower 'dt'" in said[0])
    c.true(f"ends: {(errors(r) or ['no sentence'])[0][:130]}", r.code == 1 and len(errors(r)) == 1 and "Courant number" in errors(r)[0])
    r = Run(executable, script(modify=f"cfl 0.4 {jet}") + "run 200\n", ranks, files=files)
    c.true("not where the step follows cfl", "Courant number is" not in r.output)


def main():
    executable, ranks = arguments()
    c = Checks("watched from outside")
    followed(c, executable, ranks[-1])
    ends(c, executable, ranks[-1])
    for n in ranks:
        c.note(f"{n} rank(s)")
        lost(c, executable, n, (96, TEMPLATES, True), (128, TEMPLATES, False))
        nowhere(c, executable, n)
    lost(c, executable, ranks[0], (96, "", True), ("off", "", False))
    courant(c, executable, ranks[-1])
    c.end()


if __name__ == "__main__":
    main()
