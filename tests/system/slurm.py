#!/usr/bin/python3
"""A job under a real Slurm, which is started here and stopped at the end: legs that end by signals, kills and its limit, until the job ends
by itself with the bits of a run that was never ended; cases/batch in the hands of what it is written for.

    slurm.py EXECUTABLE RANKS [--long]      --long: legs that end by the job's own time limit, too (minutes)

What would pass falsely without it: a batch script that Slurm doesn't take; a signal that ends the launcher, or the batch script, before the
ranks have written their checkpoint; a job that isn't put back into the queue, begins anew each time, is put back for ever after an error, or
is done with another result.
Last long run: 2026-11-28, 6c9fd9d: seven legs by a limit of one minute on two busy cores, the same bits; 7 min.
Needs root, or sudo, and Slurm's packages, which it installs as tests/run.sh does others; where that can't be it ends with 77, skipped.
"""
import contextlib
import json
import os
import pwd
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

from harness import Checks, arguments, data_file, head_with_particles, long_form, read_dump, walls

TOP = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
SKIP = 77
PACKAGES = ["slurmctld", "slurmd", "slurm-client", "munge"]
BOX = "0 0.0216 0 0.0048 0 0.036"

CONFIGURATION = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={port2}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmUser=root
MpiDefault=none
JobRequeue=1
KillWait=20
SchedulerParameters=sched_interval=1,batch_sched_delay=0,bf_interval=1
OverTimeLimit=0
ReturnToService=2
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory=500 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def skip(why):
    print(f"SKIP: {why}")
    sys.exit(SKIP)


def install():
    if os.geteuid() != 0:
        if subprocess.run(["sudo", "-n", "true"], stderr=subprocess.DEVNULL).returncode != 0 if shutil.which("sudo") else True:
            skip("Slurm's daemons need root, and sudo asks for a password here")
        os.execvp("sudo", ["sudo", "-n", "-E", sys.executable, *sys.argv])
    done = subprocess.run([os.path.join(TOP, "cases", "setup.sh"), *PACKAGES], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        skip(f"Slurm can't be installed here: {done.stdout.strip()[-300:]}")


def free_ports(n):
    sockets = [socket.socket() for _ in range(n)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Slurm:
    """A controller, a node and munge, all in one folder. Stopped at the end, whatever happens."""

    def __init__(self, folder):
        self.folder, self.daemons = folder, []
        self.environment = {**os.environ, "SLURM_CONF": os.path.join(folder, "slurm.conf")}

    def __enter__(self):
        os.chmod(self.folder, 0o755)
        munge = os.path.join(self.folder, "munge")
        os.mkdir(munge)
        with open(os.path.join(munge, "key"), "wb") as f:
            f.write(os.urandom(1024))
        user = pwd.getpwnam("munge")
        for name in (munge, os.path.join(munge, "key")):
            os.chown(name, user.pw_uid, user.pw_gid)
        os.chmod(os.path.join(munge, "key"), 0o400)
        os.chmod(munge, 0o755)
        for name in ("state", "spool"):
            os.mkdir(os.path.join(self.folder, name))
        ports = free_ports(2)
        with open(self.environment["SLURM_CONF"], "w") as f:
            f.write(CONFIGURATION.format(folder=self.folder, host=socket.gethostname().split(".")[0], port=ports[0], port2=ports[1],
                                         cores=len(os.sched_getaffinity(0))))
        try:
            self.start(["runuser", "-u", "munge", "--", "munged", "--foreground", "--force", "--socket=" + munge + "/socket",
                        "--key-file=" + munge + "/key", "--pid-file=" + munge + "/pid", "--log-file=" + munge + "/log",
                        "--seed-file=" + munge + "/seed"])
            self.wait(lambda: os.path.exists(munge + "/socket"), "munge's socket")
            self.start(["slurmctld", "-D"])
            self.start(["slurmd", "-D", "-N", socket.gethostname().split(".")[0]])
            self.wait(lambda: "idle" in self.ask("sinfo", "-h", "-o", "%T"), "an idle node")
        except BaseException:
            self.__exit__()
            raise
        return self

    def start(self, command):
        name = os.path.join(self.folder, f"{[w for w in command if 'd' in w and '-' not in w][-1].split('/')[-1]}.out")
        with open(name, "w") as out:
            self.daemons.append(subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL, stdout=out,
                                                 stderr=subprocess.STDOUT, start_new_session=True))

    def __exit__(self, *_):
        with contextlib.suppress(Exception):
            self.ask("scancel", "--user=root")
            self.wait(lambda: not self.ask("squeue", "-h").strip(), "an empty queue", 10)
        for sign in (signal.SIGTERM, signal.SIGKILL):
            for d in reversed(self.daemons):
                if d.poll() is None:
                    with contextlib.suppress(ProcessLookupError):
                        os.killpg(d.pid, sign)
            end = time.time() + 10
            while time.time() < end and any(d.poll() is None for d in self.daemons):
                time.sleep(0.05)

    def ask(self, *command):
        return subprocess.run(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60).stdout

    def wait(self, condition, what, seconds=30):
        end = time.time() + seconds
        while time.time() < end:
            if condition():
                return
            if any(d.poll() is not None for d in self.daemons):
                break
            time.sleep(0.1)
        logs = ""
        for name in sorted(os.listdir(self.folder)):
            if name.endswith((".log", ".out")):
                with open(os.path.join(self.folder, name), errors="replace") as f:
                    logs += f"--- {name}\n{f.read()[-1500:]}\n"
        print(logs)
        raise RuntimeError(f"{what}: not there after {seconds} s")

    def submit(self, where, *words):
        said = subprocess.run(["sbatch", "--parsable", *words], cwd=where, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, timeout=60)
        if said.returncode != 0:
            raise RuntimeError(f"sbatch {' '.join(words)}: {said.stdout}")
        return said.stdout.strip()

    def state(self, job):
        fields = dict(w.split("=", 1) for w in self.ask("scontrol", "show", "job", job).split() if "=" in w)
        return fields.get("JobState", "gone"), int(fields.get("Restarts", 0)), fields.get("ExitCode", "")


def particles():
    x = np.array([[(i + .5) * 1.25e-3, (j + .5) * 1.2e-3, (k + .5) * 1.25e-3] for k in range(10) for j in range(4) for i in range(17)])
    return data_file(BOX, x + np.random.default_rng(3).uniform(-2e-5, 2e-5, x.shape), 1.15e-3, 2500)


def script(runs, more="", between=""):
    every = runs[-1] // 2  # frames and dumps; the last step has both
    return head_with_particles(2e-5, boundary="f f f", kn=100, kt=30, gamman=2e-3, gammat=1e-3, processors="* 1 1") + walls(
        xplane=(0, 0.0216), yplane=(0, 0.0048), zplane=(0,)) + f"""
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
fix gas all twogrid fine 36 2 60 ratio 3 2 3 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 0.5 boundary zhi pressure 0
fix_modify gas output every {every} file bed.h5 fields u p eps faces
{more}
thermo 50
thermo_modify flush yes
dump d all custom {every} all.dump id x y z vx vy vz omegax omegay omegaz
dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
""" + between.join(f"run {n} upto\n" for n in runs)


SUBMIT = """#!/bin/bash
#SBATCH --job-name=bed
#SBATCH --ntasks={ranks}
#SBATCH --mem=100M
#SBATCH --time={time}
#SBATCH --output=%x_%j.out
#SBATCH --signal=B:USR1@{before}
#SBATCH --requeue
#SBATCH --open-mode=append
exec {top}/cases/batch/slurm.sh "$SLURM_SUBMIT_DIR" --done "$SLURM_SUBMIT_DIR/done.sh" "$SLURM_SUBMIT_DIR/{script}"
"""


def last_state(folder):
    """Particles and fluid at the end, as bytes."""
    step, frame = read_dump(os.path.join(folder, "all.dump"))[-1]
    with h5py.File(os.path.join(folder, "bed.h5")) as f:
        fluid = f["fluid"][sorted(f["fluid"])[-1]]
        fields = []
        fluid.visititems(lambda name, d: fields.append((name, d[()].tobytes())) if isinstance(d, h5py.Dataset) else None)
        frames = len(f["fluid"])
    return step, {**{n: v.tobytes() for n, v in frame.items()}, **dict(fields)}, frames


def status(folder):
    try:
        with open(os.path.join(folder, "status.json")) as f:
            return json.load(f)
    except (OSError, ValueError):
        return None


def log_step(folder):
    """The last step that the log's table shows; -1: none, or the run is over."""
    try:
        with open(os.path.join(folder, "log.liggghts"), errors="replace") as f:
            text = f.read()
    except OSError:
        return -1
    rows = re.findall(r"^ +(\d+) +680 ", text, re.M)
    return int(rows[-1]) if rows and "ended by signal" not in text else -1


def checkpoint_steps(folder):
    """Of the newest one after each leg."""
    try:
        with open(os.path.join(folder, "legs.txt")) as f:
            words = f.read().split()
    except OSError:
        return []
    return [int(w.split("_step_")[1].split(",")[0]) for w in words if "_step_" in w]


def same_as_one_run(c, executable, ranks, run, whole, runs, splits, timeout):
    """One that was never ended, its runs split where the other's checkpoints were: a run's set-up computes forces anew."""
    os.mkdir(whole)
    steps = runs[-1]
    for name, text in (("in.bed", script(sorted({*splits, *runs}))), ("particles.data", particles())):
        with open(os.path.join(whole, name), "w") as f:
            f.write(text)
    subprocess.run([os.path.join(TOP, "cases", "mpirun.sh"), str(ranks), executable, "-in", "in.bed"], cwd=whole, stdout=subprocess.DEVNULL,
                   check=True, timeout=timeout)
    (step, mine, frames), (step2, theirs, frames2) = last_state(run), last_state(whole)
    differ = [n for n in theirs if mine.get(n) != theirs[n]]
    c.true(f"the last state, step {step}, of {len(theirs)} columns and fields: bit by bit that of one run" +
           (f"; different: {differ}" if differ else ""), step == step2 == steps and not differ)
    c.true(f"{frames} frames, as the one run has", frames == frames2)


def follow(slurm, c, job, run, end_leg, legs, patience=90):
    """Ends each leg by the next way once it has got on, until the job ends by itself."""
    begin, ways, ended, at, back = time.time(), list(legs), [], 0, None
    while time.time() - begin < patience:
        state, restarts, code = slurm.state(job)
        if state in ("COMPLETED", "FAILED", "TIMEOUT", "CANCELLED", "gone"):
            time.sleep(1.5)  # on its way back into the queue a job is FAILED for a moment
            if slurm.state(job)[0] == state:
                return state, restarts, code, ended
        back = None if state != "PENDING" or restarts == 0 else back or time.time()
        if back and time.time() > back + 2.5:  # Slurm lets it wait for two minutes; within the first second its credential is revoked
            slurm.ask("scontrol", "update", f"JobId={job}", "StartTime=now")
        step = log_step(run)
        if ways and state == "RUNNING" and restarts == len(ended) and step >= at + 600:
            end_leg(ways[0])
            ended.append((ways.pop(0), step))
            at = step
        time.sleep(0.1)
    print(slurm.ask("scontrol", "show", "job", job))
    raise RuntimeError(f"the job is {slurm.state(job)} after {patience} s")


def several_legs(c, slurm, executable, ranks, work, how, runs, time_limit="5", before=10, patience=90, between=""):
    case = os.path.join(work, "case" + "_".join(how))
    os.mkdir(case)
    steps = runs[-1]
    files = {"in.bed": script(runs, between=between), "particles.data": particles(), "done.sh": "#!/bin/sh\ntouch \"$1/all_done\"\n",
             "submit.slurm": SUBMIT.format(ranks=ranks, time=time_limit, before=before, top=TOP, script="in.bed")}
    for name, text in files.items():
        with open(os.path.join(case, name), "w") as f:
            f.write(text)
    os.chmod(os.path.join(case, "done.sh"), 0o755)
    job = slurm.submit(case, "submit.slurm")
    run = os.path.join(case, "out", f"job_{job}")
    os.makedirs(run)
    shutil.copy(os.path.join(case, "particles.data"), run)
    ways = {"usr1": lambda: slurm.ask("scancel", "--batch", "--signal=USR1", job),      # as before the limit
            "term": lambda: slurm.ask("scancel", "--full", "--signal=TERM", job),       # as at preemption: to all processes
            "requeue": lambda: slurm.ask("scontrol", "requeue", job)}                   # kills
    kept = sum(w != "requeue" for w in how)
    begin = time.time()
    legs = how if how[0] in ways else ()
    state, restarts, code, ended = follow(slurm, c, job, run, lambda way: ways[way](), legs, patience)
    c.note(f"{time.time() - begin:.0f} s" + "".join(f"; {w} sent after step {s}" for w, s in ended))
    at = checkpoint_steps(run) if os.path.exists(os.path.join(run, "legs.txt")) else []
    splits = sorted(set(s for s in at if s < steps))
    if not (c.true(f"legs ended by {', '.join(how)}: the job ends by itself: {state}, code {code}, after {restarts} restarts, checkpoints at {splits}",
                   state == "COMPLETED" and restarts >= len(how) and len(splits) >= kept) and
            c.true("what follows the run is done once", os.path.exists(os.path.join(run, "all_done")))):
        for name in (os.path.join(case, f"bed_{job}.out"), os.path.join(run, "legs.txt"), os.path.join(slurm.folder, "slurmctld.log"),
                     os.path.join(slurm.folder, "slurmd.log")):
            if os.path.exists(name):
                with open(name, errors="replace") as f:
                    print(f.read()[-3000:])
        return
    last = status(run)
    # The newest on the disk: a signal that comes at the last step leaves one there.
    newest = max((int(name.split("_step_")[1]) for name in os.listdir(os.path.join(run, "in.bed.checkpoints")) if "_step_" in name), default=None)
    c.true(f"its status: {last['state']}, {last['checkpoint']}", last["state"] == "finished" and last["step"] == steps and
           (last["checkpoint"] or {"step": None})["step"] == newest)
    same_as_one_run(c, executable, ranks, run, os.path.join(work, "whole" + "_".join(how)), runs, splits, max(200, 3 * (time.time() - begin)))


def error_is_not_put_back(c, slurm, ranks, work):
    case = os.path.join(work, "wrong")
    os.mkdir(case)
    for name, text in (("in.bed", script([200], "fix_modify gas drag nonsense")), ("done.sh", "#!/bin/sh\n"),
                       ("submit.slurm", SUBMIT.format(ranks=ranks, time="5", before=10, top=TOP, script="in.bed"))):
        with open(os.path.join(case, name), "w") as f:
            f.write(text)
    job = slurm.submit(case, "submit.slurm")
    run = os.path.join(case, "out", f"job_{job}")
    os.makedirs(run)
    with open(os.path.join(run, "particles.data"), "w") as f:
        f.write(particles())
    state, restarts, code, _ = follow(slurm, c, job, run, None, (), 60)
    with open(os.path.join(case, f"bed_{job}.out"), errors="replace") as f:
        said = [line for line in f if line.startswith("leg.sh") and "nonsense" in line]
    c.true(f"a wrong script: {state}, {restarts} restarts: {(said or ['no sentence'])[0].strip()[-120:]}", state == "FAILED" and restarts == 0 and said)


def arrays(c, slurm, work):
    """Each index of an array does its own run, in a folder of its own."""
    case = os.path.join(work, "array")
    os.mkdir(case)
    with open(os.path.join(case, "submit.slurm"), "w") as f:
        f.write(SUBMIT.format(ranks=1, time="5", before=10, top=TOP, script="in.bed").replace("%x_%j", "%x_%A_%a").replace('in.bed"\n', 'in.bed" -var x $SLURM_ARRAY_TASK_ID\n'))
    with open(os.path.join(case, "in.bed"), "w") as f:
        f.write("variable x index 0\nunits si\nprint 'this is ${x}' file x.txt\n")
    with open(os.path.join(case, "done.sh"), "w") as f:
        f.write("#!/bin/sh\ntouch \"$1/all_done\"\n")
    os.chmod(os.path.join(case, "done.sh"), 0o755)
    job = slurm.submit(case, "--array=3-4", "submit.slurm")
    slurm.wait(lambda: not slurm.ask("squeue", "-h", "-j", job).strip(), "the end of the array", 40)
    got = []
    for i in (3, 4):
        with contextlib.suppress(OSError), open(os.path.join(case, "out", f"job_{job}_{i}", "x.txt")) as f:
            got.append(f.read().strip())
    c.true(f"a job array: {got}", got == ["this is 3", "this is 4"])


def main():
    executable, ranks = arguments()
    install()
    c = Checks("jobs under Slurm")
    os.environ.update(TWOGRID=os.path.abspath(executable), TWOGRID_GRACE="3")
    os.environ.pop("TWOGRID_LAUNCHER", None)
    n = min(ranks[-1], len(os.sched_getaffinity(0)))
    with tempfile.TemporaryDirectory(prefix="twogrid_slurm_") as scratch:
        work = os.path.join(scratch, "work")
        os.mkdir(work)
        os.mkdir(os.path.join(scratch, "slurm"))
        os.chmod(scratch, 0o755)
        with Slurm(os.path.join(scratch, "slurm")) as slurm:
            for case in sorted(os.listdir(os.path.join(TOP, "cases"))):
                path = os.path.join(TOP, "cases", case, "submit.slurm")
                if os.path.exists(path):
                    said = slurm.ask("sbatch", "--test-only", "--ntasks=1", "--mem-per-cpu=100M", path)
                    c.true(f"{case}/submit.slurm is taken by sbatch: {said.strip()[:80]}", "to start at" in said)
            arrays(c, slurm, work)
            error_is_not_put_back(c, slurm, n, work)
            # Some 5 s on two quick cores: a leg has got on by 600 steps and Slurm has told it long before the end.
            several_legs(c, slurm, os.path.abspath(executable), n, work, ("usr1", "term", "requeue"), [20000], patience=240)
            if long_form():
                # The pauses, two minutes in all, see to several legs on any machine: Slurm signals 20 to 50 s before the limit of a minute.
                several_legs(c, slurm, os.path.abspath(executable), n, work, ("limit", "of one minute"), list(range(800, 24001, 800)), "1", 20, 1200,
                             between="shell sleep 4\n")
    c.end()


if __name__ == "__main__":
    main()
