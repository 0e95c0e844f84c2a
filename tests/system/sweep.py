#!/usr/bin/python3
"""cases/sweep.py: choices reach the script, a killed sweep goes on where it was, wrong input gives a sentence, and the
arithmetic of its report is right.

Without this test a choice could be dropped in silence (all runs alike, and every study flat), a half-written run could be
taken for a finished one, and the recommendation could name a run that another beats. Wanted values: from the definition of the
Pareto front on made-up rows, and a conserved integral for fields put onto another grid. Some 15 s.
"""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np

from harness import Checks, arguments, head

HERE = os.path.dirname(os.path.abspath(__file__))
TOOL = os.path.join(HERE, "..", "..", "cases", "sweep.py")

SCRIPT = head("0 0.0048 0 0.0048 0 0.0096", 1.5e-5, boundary="f f f") + """
variable gap index 1.5e-3
fix motion all nve/sphere
lattice sc ${gap} origin 0.5 0.5 0.5
region fill block 0 0.0048 0 0.0048 0 0.005
create_atoms 1 region fill
set group all diameter 0.0012 density 1000
fix gas all twogrid fine 4 4 8 &
    ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 10   # a comment
fix_modify gas deposit centroid
fix_modify gas boundary zlo inlet 0 0 0.6 boundary zhi pressure 0
fix_modify gas output every 1000 file bed.h5 average from 0
run 200
"""


def sweep(folder, executable, *words, **more):
    command = [sys.executable, TOOL, "in.bed", "--executable", executable, "-j", "1", *words]
    return subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=200, **more)


def runs(folder):
    """choices and script of every finished run."""
    out = []
    base = os.path.join(folder, "sweep", "out", "runs")
    for name in sorted(os.listdir(base)) if os.path.isdir(base) else []:
        record = os.path.join(base, name, "done.json")
        if os.path.exists(record):
            out.append((json.load(open(record))["choices"], open(os.path.join(base, name, "in.run")).read(), os.path.getmtime(record)))
    return out


def wrong_input(c, folder, executable):
    cases = {"unknown choice": (["--choice", "depositt=exact", "--reference", "finest"], ["depositt", "fix twogrid", "gap"]),
             "no values": (["--choice", "deposit", "--reference", "finest"], ["deposit", "KEY=VALUE"]),
             "nothing to vary": (["--reference", "finest"], ["nothing to run"]),
             "no reference": (["--choice", "every=5,10"], ["no reference"]),
             "unknown method": (["--choice", "method=best", "--reference", "finest"], ["best", "two-grid, exact"]),
             "wrong value": (["--choice", "deposit=heap", "--reference", "finest"], ["reference run failed", "deposit", "heap"])}
    for name, (words, wanted) in cases.items():
        done = sweep(folder, executable, *words)
        sentence = done.stdout.strip().split("\n")[-1]
        good = done.returncode != 0 and "Traceback" not in done.stdout and all(w in sentence for w in wanted)
        c.true(f"{name}: {sentence[:150]}", good)
    before = len(runs(folder))
    with open(os.path.join(folder, "in.bed")) as f:
        script = f.read()
    with open(os.path.join(folder, "in.meanless"), "w") as f:
        f.write(script.replace(" average from 0", ""))
    done = subprocess.run([sys.executable, TOOL, "in.meanless", "--executable", executable, "--choice", "every=5,10", "--reference", "finest"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    c.true(f"no means: {done.stdout.strip()[:120]}", done.returncode != 0 and "average from" in done.stdout and len(runs(folder)) == before)
    done = sweep(folder, os.path.join(folder, "nothing"), "--choice", "every=5", "--reference", "finest")
    c.true(f"no executable: {done.stdout.strip()[:120]}", done.returncode != 0 and "build it" in done.stdout and "Traceback" not in done.stdout)


def choices_reach_script(c, folder, executable):
    done = sweep(folder, executable, "--choice", "every=10,20", "--choice", "ratio=1 1 2", "--fixed", "deposit=exact", "--fixed",
                 "timestep=1e-5", "--fixed", "kn=55", "--fixed", "gap=1.6e-3", "--fixed", "eps bound=clip 0.4",
                 "--fixed", "method=paper", "--fixed", "stretch=z symmetric 1.01", "--reference", "finest")
    c.true("a sweep of two runs ends well", done.returncode == 0) or c.note(done.stdout[-500:])
    made = {choices["every"]: text for choices, text, _ in runs(folder)}
    c.true("one run for each value", sorted(made) == ["10", "20"])
    text = made.get("20", "")
    for wanted in ("every 20", "fine 4 4 8 ratio 1 1 2", "stretch z symmetric 1.01", "fix_modify gas method paper\nfix_modify gas deposit exact", "fix_modify gas eps bound clip 0.4", "timestep 1e-05",
                   "kn peratomtypepair 1 55"):
        c.true(f"the script says '{wanted}'", wanted in text)
    table = open(os.path.join(folder, "sweep", "table.csv")).read() if done.returncode == 0 else ""
    c.true("table: the run that is not the reference", table.count("every=20") == 1 and "every=10" not in table and "compared with the run of every 10" in table)
    c.true("picture and recommendation are there", all(os.path.exists(os.path.join(folder, "sweep", f)) for f in ("error_cost.png", "recommendation.txt")))


def goes_on_after_kill(c, folder, executable):
    words = [sys.executable, TOOL, "in.bed", "--executable", executable, "-j", "1", "--choice", "every=1,2,4", "--reference", "finest"]
    before = len(runs(folder))
    with subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as p:
        for line in p.stdout:
            if line.startswith("[1/3]"):
                break
        time.sleep(0.2)
        p.send_signal(signal.SIGKILL)
    first = runs(folder)
    c.true(f"killed in its second run: one finished, found {len(first) - before}", len(first) - before == 1)
    done = sweep(folder, executable, "--choice", "every=1,2,4", "--reference", "finest")
    c.true("the same command finishes the other two", done.returncode == 0 and "2 of them to do" in done.stdout) or c.note(done.stdout[-500:])
    kept = {tuple(sorted(ch.items())): t for ch, _, t in runs(folder)}
    c.true("the finished run was not touched", all(kept.get(tuple(sorted(ch.items()))) == t for ch, _, t in first))
    c.true("the table holds both", open(os.path.join(folder, "sweep", "table.csv")).read().count("every=") == 2)


def arithmetic(c):
    sys.path.insert(0, os.path.dirname(TOOL))
    from sweep_tools.errors import onto
    from sweep_tools.tables import front_of, recommendation
    made_up = [("slow", 9.0, 0.005, 0), ("middle", 3.0, 0.02, 0), ("beaten", 4.0, 0.05, 0), ("quick", 1.0, 0.2, 0), ("noisy", 2.0, 0.009, 0.05)]
    rows = [dict(name=n, method=n, state="ok", cpu_s=t, e=e, e_err=s) for n, t, e, s in made_up]
    c.true("front", [r["name"] for r in front_of(rows, "e")] == ["quick", "noisy", "slow"])
    said = recommendation("made up", rows, ["e"], ["method"])
    c.true("1 % is reached by the slow one only: noise counts", "1 %: slow" in said and "3 %: middle" in said and "10 %: noisy" in said)
    c.true("never pays: the beaten one alone", "more accurate): beaten\n" in said) or c.note(said)
    rng = np.random.default_rng(1)
    nodes = [np.concatenate(([0], np.sort(rng.uniform(0, 1, n - 1)), [1])) for n in (5, 7, 9)]
    common = [np.linspace(0, 1, n) for n in (3, 4, 5)]
    field = rng.uniform(0, 1, (9, 7, 5))
    volume = lambda n: np.einsum("i,j,k->ijk", np.diff(n[2]), np.diff(n[1]), np.diff(n[0]))
    was, now = np.sum(field * volume(nodes)), np.sum(onto(nodes, common, field) * volume(common))
    c.below("integral lost between grids", abs(now / was - 1), 1e-13)


def main():
    executable = os.path.abspath(arguments()[0])
    c = Checks("the sweep tool")
    arithmetic(c)
    for check in (wrong_input, choices_reach_script, goes_on_after_kill):
        with tempfile.TemporaryDirectory(prefix="twogrid_sweep_") as folder:
            with open(os.path.join(folder, "in.bed"), "w") as f:
                f.write(SCRIPT)
            check(c, folder, executable)
    c.end()


if __name__ == "__main__":
    main()
