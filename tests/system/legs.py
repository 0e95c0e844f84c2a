#!/usr/bin/python3
"""Runs in legs without a batch system (cases/batch, cases/mpirun.sh), and the batch scripts as far as they can be tried without one.

    legs.py EXECUTABLE RANKS...

What would pass falsely without it: a leg ended at whatever step that goes on with other forces than the run that was never ended; a loop that
goes on after an error, or for ever without getting on; a launcher that nobody asked for; a signal to the script in front that kills the ranks
before they have written, or that is lost while it starts them; batch scripts that no shell takes, or that name files that are not there. slurm.py tries them with a Slurm.
"""
import glob
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time

import numpy as np

from harness import Checks, arguments
from slurm import TOP, checkpoint_steps, log_step, particles, same_as_one_run, script, status

BATCH = os.path.join(TOP, "cases", "batch")


def folder(parent, name, text):
    """A run's folder with what its script reads, and the script beside it."""
    path = os.path.join(parent, name)
    os.mkdir(path)
    with open(os.path.join(path, "particles.data"), "w") as f:
        f.write(particles())
    with open(path + ".in", "w") as f:
        f.write(text)
    return path, path + ".in"


def call(*words, timeout=100, **environment):
    return subprocess.run([str(w) for w in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=timeout,
                          env={**os.environ, **environment})


def a_loop(c, executable, n, work):
    run, text = folder(work, f"loop{n}", script([1600]))
    for target in (300, 800):
        p = subprocess.Popen([BATCH + "/leg.sh", "-n", str(n), run, text], stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
        end = time.time() + 60
        while time.time() < end and p.poll() is None and log_step(run) < target:
            time.sleep(0.01)
        p.send_signal(signal.SIGUSR1)
        c.true(f"a leg that is ended after step {target}: code {p.wait(timeout=30)}", p.returncode == 75)
    r = call(BATCH + "/loop.sh", "-n", n, run, text)
    splits = sorted({s for s in checkpoint_steps(run) if s < 1600})
    c.true(f"{n} rank(s): the loop ends with {r.returncode}, after legs to {splits}", r.returncode == 0 and len(splits) == 2)
    c.true(f"status: {status(run)['state']}", status(run)["state"] == "finished")
    same_as_one_run(c, executable, n, run, run + "_whole", [1600], splits, 200)


def stops(c, n, work):
    run, text = folder(work, "wrong", script([1600], "fix_modify gas drag nonsense"))
    begin = time.time()
    r = call(BATCH + "/loop.sh", "-n", n, run, text)
    with open(os.path.join(run, "legs.txt")) as f:
        legs = len(f.readlines())
    c.true(f"an error ends the loop: code {r.returncode}, {legs} leg(s), {time.time() - begin:.1f} s", r.returncode == 1 and legs == 1 and "nonsense" in r.stdout)
    # A set-up that takes longer than a leg: SIGUSR1 comes before the first run, and there is nothing to keep.
    run, text = folder(work, "slow", "shell sleep 1\n" * 4 + script([1600]))
    r = call(BATCH + "/loop.sh", "-n", 1, "-t", "0.7", run, text)
    with open(os.path.join(run, "legs.txt")) as f:
        legs = len(f.readlines())
    c.true(f"legs that are too short end the loop: code {r.returncode}, {legs} leg(s)", r.returncode == 1 and legs == 2 and "without a new checkpoint" in r.stdout)


def signals(c, n, work):
    """To loop.sh, which stands in front of leg.sh, mpirun.sh, mpirun and the ranks."""
    run, text = folder(work, "signals", script([160000]))
    for number in (signal.SIGTERM, signal.SIGINT):
        before = checkpoint_steps(run)[-1:] or [0]
        p = subprocess.Popen([BATCH + "/loop.sh", "-n", str(n), run, text], stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT, start_new_session=True)
        end = time.time() + 30
        while time.time() < end and log_step(run) < before[0] + 50:
            time.sleep(0.05)
        p.send_signal(number)
        code = p.wait(timeout=30)
        at = checkpoint_steps(run)[-1:] or [0]
        c.true(f"signal {number}: code {code}, checkpoint at step {at[0]}", code == 75 and at[0] > before[0] and status(run)["state"].startswith("ended by signal"))


def launcher(c, work):
    path = os.path.join(work, "launcher")
    with open(path, "w") as f:
        f.write(f'#!/bin/sh\nprintf "%s " "$@" >"{work}/started"\n')
    os.chmod(path, 0o755)
    r = call(os.path.join(TOP, "cases", "mpirun.sh"), 5, "program", "-in", "in.x", TWOGRID_LAUNCHER=f"{path} -n %n --mpi=pmix")
    with open(os.path.join(work, "started")) as f:
        words = f.read().strip()
    c.true(f"TWOGRID_LAUNCHER starts: {words}", r.returncode == 0 and words == "-n 5 --mpi=pmix program -in in.x")
    codes = [call(os.path.join(TOP, "cases", "mpirun.sh"), 1, "sh", "-c", f"exit {k}", TWOGRID_GRACE="0").returncode for k in (0, 3, 138)]
    c.true(f"codes of the program come through: {codes}", codes == [0, 3, 138])


def early_signal(c, work):
    """While mpirun starts it loses signals: the launcher here ends at the second one."""
    path = os.path.join(work, "deaf")
    with open(path, "w") as f:
        f.write("#!/bin/sh\ntrap : USR1\ntouch $0.ready\nsleep 0.5\ntrap 'exit 138' USR1\nfor i in 1 2 3 4 5 6; do sleep 0.5; done\n")
    os.chmod(path, 0o755)
    p = subprocess.Popen([os.path.join(TOP, "cases", "mpirun.sh"), "1", "program"], env={**os.environ, "TWOGRID_LAUNCHER": path})
    while not os.path.exists(path + ".ready"):
        time.sleep(0.01)
    p.send_signal(signal.SIGTERM)
    c.true(f"a signal that the launcher loses is told again: code {p.wait(timeout=30)}", p.returncode == 138)


def start_hanging(work):
    """A launcher named mpirun whose rank is killed and who stays, as OpenMPI's may when that happens while it starts."""
    tools = os.path.join(work, "hangs")
    os.makedirs(tools)
    with open(os.path.join(tools, "mpirun"), "w") as f:
        f.write("#!/usr/bin/python3\nimport subprocess, time\nrank = subprocess.Popen(['sleep', '60'])\ntime.sleep(4)\nrank.kill()\ntime.sleep(60)\n")
    os.chmod(os.path.join(tools, "mpirun"), 0o755)
    env = {**os.environ, "PATH": tools + ":" + os.environ["PATH"], "TWOGRID_GRACE": "0"}
    env.pop("TWOGRID_LAUNCHER", None)
    return subprocess.Popen([os.path.join(TOP, "cases", "mpirun.sh"), "1", "program"], env=env)


def hanging(c, p):
    try:
        code = p.wait(timeout=30)
    except subprocess.TimeoutExpired:
        p.kill()
        code = None
    c.true(f"a launcher that stays without its ranks is ended: code {code}", code == 137)


def scripts(c, executable, work):
    """Every case has both; their own lines run to the program, with a launcher that only counts."""
    path = os.path.join(work, "count")
    with open(path, "w") as f:
        f.write(f'#!/bin/sh\necho "$@" >"{work}/counted"\nexit 0\n')
    os.chmod(path, 0o755)
    cases = sorted(os.path.dirname(p) for p in glob.glob(os.path.join(TOP, "cases", "*", "run.sh")) if "studies" not in p)
    for shell in glob.glob(BATCH + "/*"):
        if not shell.endswith(".md"):
            c.true(f"{os.path.basename(shell)} is valid to the shell", call("bash", "-n", shell).returncode == 0)
    for case in cases:
        name = os.path.basename(case)
        copy = os.path.join(work, "cases", name)
        shutil.copytree(case, copy, ignore=shutil.ignore_patterns("out", "reference", "results"))
        for tool in ("batch", "case_words.sh", "program.sh", "mpirun.sh", "revolve.py"):
            if not os.path.exists(os.path.join(work, "cases", tool)):
                os.symlink(os.path.join(TOP, "cases", tool), os.path.join(work, "cases", tool))
        with open(os.path.join(work, "cases", "run"), "w") as f:  # what compares in the end: nothing has run
            f.write("#!/bin/sh\nexit 0\n")
        os.chmod(os.path.join(work, "cases", "run"), 0o755)
        for kind, variables in (("slurm", dict(SLURM_SUBMIT_DIR=os.path.join(work), SLURM_JOB_ID="7", SLURM_NTASKS="4")),
                                ("pbs", dict(PBS_O_WORKDIR=copy, PBS_JOBID="8.host"))):
            submit = os.path.join(copy, "submit." + kind)
            with open(submit) as f:
                text = f.read()
            wanted = ("job-name", "ntasks", "time", "output", "signal=B:USR1@120", "requeue", "open-mode=append") if kind == "slurm" else ("-N", "-l", "-r y")
            lacking = [w for w in wanted if not re.search(rf"^#(SBATCH --|PBS ){re.escape(w)}", text, re.M)]
            r = call("bash", submit, *(["-var", "extra", "2"] if kind == "slurm" else []), TWOGRID=executable, TWOGRID_LAUNCHER=path + " -n %n", **variables)
            with open(os.path.join(work, "counted")) as f:
                words = f.read().strip()
            out = os.path.join(copy, "out", "job_7" if kind == "slurm" else "job_8")
            # Of several -var of one name LIGGGHTS takes the first: the user's come before the job's.
            mine = "-var extra 2 " if kind == "slurm" else ""
            good = re.search(rf"-in in\.{name} -log log\.liggghts -restart auto {mine}-var out \. -var checkpoint 10 ", words + " ")
            c.true(f"{name}/submit.{kind}: code {r.returncode}, lacking {lacking}: {words[-90:]}",
                   r.returncode == 0 and not lacking and good and os.path.exists(os.path.join(out, "in." + name)))


def tables(c, work):
    import sys
    sys.path.insert(0, os.path.join(TOP, "cases"))
    from leg_tables import table
    path = os.path.join(work, "mean.txt")
    for name, steps in (("mean.txt.1", (10, 20, 30)), ("mean.txt.2", ()), ("mean.txt.10", (30, 40)), ("mean.txt", (50, 60))):
        with open(os.path.join(work, name), "w") as f:
            f.write("# Time-averaged data\n" + "".join(f"{s} {s / 10 + len(name)}\n" for s in steps))
    rows = table(path)
    c.true(f"a table of four legs: {rows[:, 0]}", np.array_equal(rows[:, 0], [10, 20, 30, 40, 50, 60]) and rows[2, 1] == 3 + len("mean.txt.10"))


def main():
    executable, ranks = arguments()
    os.environ.update(TWOGRID=os.path.abspath(executable), TWOGRID_GRACE="0")
    os.environ.pop("TWOGRID_LAUNCHER", None)
    c = Checks("runs in legs")
    with tempfile.TemporaryDirectory(prefix="twogrid_legs_") as work:
        hangs = start_hanging(work)
        for n in ranks:
            a_loop(c, os.path.abspath(executable), n, work)
        stops(c, ranks[-1], work)
        signals(c, ranks[-1], work)
        launcher(c, work)
        early_signal(c, work)
        scripts(c, os.path.abspath(executable), work)
        tables(c, work)
        hanging(c, hangs)
    c.end()


if __name__ == "__main__":
    main()
