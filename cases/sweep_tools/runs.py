"""Runs as processes: several at a time, each with its CPU time, none left over."""
import ctypes
import hashlib
import json
import os
import shutil
import signal
import socket
import subprocess
import time

from .keywords import CASES

LIBC = ctypes.CDLL(None)


def end_with_parent():
    """In a child: have the kernel end it should this program be killed (PR_SET_PDEATHSIG), so that no run is left over."""
    LIBC.prctl(1, signal.SIGTERM)


class Child:
    """A process whose CPU time is told by the kernel when it ends, with that of its own children."""

    def __init__(self, command, folder):
        with open(os.path.join(folder, "output.txt"), "w") as out:
            self.process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT,
                                            start_new_session=True, preexec_fn=end_with_parent)
        self.begin, self.late = time.time(), False

    def ended(self):
        """None, or (exit code, CPU s, wall s)."""
        pid, status, use = os.wait4(self.process.pid, os.WNOHANG)
        if pid == 0:
            return None
        self.process.returncode = os.waitstatus_to_exitcode(status)
        return self.process.returncode, use.ru_utime + use.ru_stime, time.time() - self.begin

    def kill(self):
        """mpirun first by a plain signal, so that it ends its ranks."""
        for s in (signal.SIGTERM, signal.SIGKILL):
            try:
                os.killpg(self.process.pid, s)
            except ProcessLookupError:
                return
            for _ in range(50):
                time.sleep(0.05)
                if self.process.returncode is not None or self.ended() is not None:
                    return


def version(executable):
    with open(executable, "rb") as f:
        return hashlib.sha256(f.read()).hexdigest()[:12]


def free_cores():
    cores = len(os.sched_getaffinity(0))
    return max(1, cores - round(os.getloadavg()[0]))


def reason_of(folder):
    """Why a run ended badly: its own sentence."""
    try:
        with open(os.path.join(folder, "output.txt"), errors="replace") as f:
            lines = f.read().split("\n")
    except OSError:
        return "no output"
    found = [l for l in lines if l.startswith("ERROR")]
    return (found or [l for l in lines if l.strip()] or ["no output"])[0 if found else -1].strip()[:200]


def startup_cost(executable, scratch, cache, ranks):
    """CPU of a run that does nothing: taken off every run, so that short ones can be compared."""
    if str(ranks) not in cache:
        folder = os.path.join(scratch, "empty")
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, "in.run"), "w") as f:
            f.write("units si\n")
        costs = []
        for _ in range(3):
            child = Child([os.path.join(CASES, "mpirun.sh"), str(ranks), executable, "-in", "in.run", "-log", "none"], folder)
            while (end := child.ended()) is None:
                time.sleep(0.02)
            costs.append(end[1])
        cache[str(ranks)] = sorted(costs)[1]
    return cache[str(ranks)]


def execute(jobs, executable, out, cores, again=False, say=print):
    """Runs what has not been run; gives each job its folder and record. A record says code, cpu, wall, late."""
    runs = os.path.join(out, "runs")
    os.makedirs(runs, exist_ok=True)
    program = version(executable)
    startup_file = os.path.join(out, f"startup_{program}.json")
    startup = json.load(open(startup_file)) if os.path.exists(startup_file) else {}
    waiting = []
    for job in jobs:
        new = os.path.join(runs, f".new_{socket.gethostname()}_{os.getpid()}")  # of this process, on whatever machine
        shutil.rmtree(new, ignore_errors=True)
        os.makedirs(new)
        h = job.prepare(new)
        h.update(program.encode())
        job.folder = os.path.join(runs, h.hexdigest()[:16])
        record = os.path.join(job.folder, "done.json")
        if os.path.exists(record) and (not again or json.load(open(record))["code"] == 0):
            shutil.rmtree(new)
        elif any(w.folder == job.folder for w in waiting):
            shutil.rmtree(new)
        else:
            shutil.rmtree(job.folder, ignore_errors=True)
            os.rename(new, job.folder)
            waiting.append(job)
    for ranks in sorted({j.ranks for j in waiting}):
        startup_cost(executable, out, startup, ranks)
    mine = f"{startup_file}.{socket.gethostname()}_{os.getpid()}"  # jobs of an array write it at the same time
    with open(mine, "w") as f:
        json.dump(startup, f)
    os.rename(mine, startup_file)
    total, done, spent, running = len(waiting), 0, 0.0, []
    say(f"{len(jobs)} runs, {total} of them to do (others finished before, or are alike); on {cores} core{'s' * (cores > 1)}")
    begin = time.time()
    try:
        while waiting or running:
            busy = sum(min(j.ranks, cores) for j, _ in running)
            while waiting and (not running or busy + waiting[0].ranks <= cores):
                job = waiting.pop(0)
                running.append((job, Child(job.command(executable), job.folder)))
                busy += job.ranks
            time.sleep(0.02)
            for job, child in list(running):
                end = child.ended()
                if end is None and not child.late and time.time() - child.begin > job.study.timeout:
                    child.kill()
                    end, child.late = (-1, float("nan"), time.time() - child.begin), True
                if end is None:
                    continue
                running.remove((job, child))
                code, cpu, wall = end
                record = dict(name=job.name, code=code, late=child.late, wall=wall, cpu=cpu - startup[str(job.ranks)] if code == 0 else cpu,
                              choices=job.choices)
                with open(os.path.join(job.folder, "done.part"), "w") as f:
                    json.dump(record, f)
                os.rename(os.path.join(job.folder, "done.part"), os.path.join(job.folder, "done.json"))
                done += 1
                left = (time.time() - begin) / done * (total - done)
                state = f"cpu {record['cpu']:.2f} s, wall {wall:.2f} s" if code == 0 else (
                    f"stopped after {wall:.0f} s: timeout" if child.late else f"failed: {reason_of(job.folder)}")
                say(f"[{done}/{total}] {job.name}: {state}; {left / 60:.1f} min left")
    except BaseException:
        for _, child in running:
            child.kill()
        raise
    for job in jobs:
        job.record = json.load(open(os.path.join(job.folder, "done.json")))
