#!/usr/bin/python3
"""A run that is ended at any moment, by a signal or by SIGKILL, of one rank or of all, goes on: from the checkpoint that the signal left, or from
the last one, and after SIGKILL it ends in the bits of the run that nobody disturbed. Its output file opens whatever moment it was.

Without this test a signal could hang one rank in a message that the others no longer send, leave half a checkpoint that is taken for a whole one,
or end a run with code 0 that is not done; a kill while a frame is written could cost all frames.
Usage: kills.py EXECUTABLE RANKS... [--long] [--signal | --SIGKILL]: 50 moments each in place of 3; one kind only.
Last long run: 2026-11-28, 6c9fd9d, SIGTERM and SIGUSR1: 50 of 50, at the longest 8.2 s from the signal to the end on two busy cores. What comes
while mpirun starts is lost by it, and told again by cases/mpirun.sh (legs.py).
"""
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

from harness import Checks, arguments, long_form, narrow_bed, poured

LAUNCH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases", "mpirun.sh")
SCRIPT = narrow_bed() + poured(300, regions="region high block 0.001 0.02 0.0007 0.0041 0.025 0.035 units box\n") + """\
run 1500
fix rain all insert/rate/region seed 123457 distributiontemplate mix nparticles 100 particlerate 16000 insert_every 50 overlapcheck yes vel constant 0 0 -0.3 region high ntry_mc 1000
fix gas all twogrid fine 36 2 40 ratio 6 2 4 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 0.4 boundary zhi pressure 0 dt 4e-5
fix_modify gas output every 10 file bed.h5 fields u p eps faces average from 0.0005
fix_modify gas checkpoint every 57 keep 9
dump d all custom 300 end.* id x y z vx vy vz omegax omegay omegaz f_gas[1] f_gas[7]
dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
reset_timestep 0
run 300
"""
END, FRAMES = 300, 31
# Step 57 lies between two couplings, when the fluid's void fraction, which is followed smoothly, is above 1 at some places.


def start(executable, ranks, folder, *options):
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "in.test"), "w") as f:
        f.write(SCRIPT)
    log = open(os.path.join(folder, "out.txt"), "a")
    return subprocess.Popen([LAUNCH, str(ranks), os.path.abspath(executable), "-in", "in.test", *options], cwd=folder, stdout=log, stderr=subprocess.STDOUT, start_new_session=True)


def ranks_of(launcher, executable):
    """Processes of the program below the launcher."""
    name = os.path.basename(executable)[:15]
    below, found = [launcher], []
    while below:
        out = subprocess.run(["pgrep", "-P", ",".join(map(str, below))], stdout=subprocess.PIPE, text=True).stdout.split()
        below = [int(p) for p in out]
        for p in below:
            try:
                with open(f"/proc/{p}/comm") as f:
                    found += [p] if f.read().strip() == name else []
            except OSError:
                pass
    return found


def send(number, process):
    try:
        os.kill(process, number)
    except ProcessLookupError:
        pass  # it has just ended


def ended(p, seconds):
    try:
        return p.wait(seconds)
    except subprocess.TimeoutExpired:
        os.killpg(p.pid, signal.SIGKILL)
        p.wait()
        return None


def state(folder):
    out = {"dump": open(os.path.join(folder, f"end.{END}")).read()}
    with h5py.File(os.path.join(folder, "bed.h5")) as f:
        out["steps"] = [int(f["fluid"][k]["step"][()]) for k in sorted(f["fluid"])]
        for group in ("fluid/" + sorted(f["fluid"])[-1], "average"):
            f[group].visititems(lambda n, d: out.__setitem__(group + "/" + n, d[...]) if isinstance(d, h5py.Dataset) else None)
    return out


def same(a, b):
    return sorted(k for k in {*a, *b} if k not in a or k not in b or not (np.array_equal(a[k], b[k], equal_nan=True) if isinstance(a[k], np.ndarray) else a[k] == b[k]))


def opens(folder):
    path = os.path.join(folder, "bed.h5")
    if not os.path.exists(path):
        return True, 0
    try:
        with h5py.File(path) as f:
            return True, sum(1 for k in f["fluid"] if np.isfinite(f["fluid"][k]["p"][...]).all())
    except (OSError, KeyError, RuntimeError) as e:
        print("     ", e)
        return False, 0


def go_on(executable, ranks, folder):
    """-restart auto until the script is done. The codes."""
    codes = []
    while len(codes) < 3 and (not codes or codes[-1] != 0):
        codes.append(ended(start(executable, ranks, folder, "-restart", "auto"), 60))
    return codes


def main():
    executable, ranks = arguments()
    n, moments = ranks[-1], 50 if long_form() else 3
    c = Checks(f"ended at {moments} moments each, {n} ranks")
    random.seed(7)
    work = tempfile.TemporaryDirectory(prefix="twogrid_test_")
    begin = time.time()
    whole = os.path.join(work.name, "whole")
    code = ended(start(executable, n, whole), 100)
    length = time.time() - begin
    undisturbed = state(whole) if code == 0 else {}
    c.true(f"undisturbed: {length:.1f} s, code {code}, {len(undisturbed.get('steps', []))} frames", code == 0 and len(undisturbed["steps"]) == FRAMES)
    early = os.path.join(work.name, "early")
    shutil.copytree(whole, early)
    kept = sorted(os.listdir(os.path.join(early, "in.test.checkpoints")))
    for name in kept[1:]:
        shutil.rmtree(os.path.join(early, "in.test.checkpoints", name))
    codes = go_on(executable, n, early)
    differ = same(undisturbed, state(early)) if codes[-1] == 0 else ["not at its end"]
    c.true(f"from {kept[0]}, between two couplings: codes {codes}, every bit{': but ' + ', '.join(differ[:4]) if differ else ''}", codes == [0] and not differ)
    worst_wait, killed = 0.0, 0
    kinds = ("SIGKILL", "signal")
    for kind in [k for k in kinds if "--" + k in sys.argv] or kinds:
        for i in range(moments):
            folder = os.path.join(work.name, "run")
            shutil.rmtree(folder, ignore_errors=True)
            p = start(executable, n, folder)
            # From before LIGGGHTS is there to after the last step.
            moment = (i + random.random()) / moments * 1.02 * length
            time.sleep(moment)
            number = signal.SIGKILL if kind == "SIGKILL" else (signal.SIGTERM, signal.SIGUSR1)[i % 2]
            processes = ranks_of(p.pid, executable)
            one = random.random() < 0.5 and processes
            sent = time.time()
            if kind == "SIGKILL":
                killed += len(processes) > 0
                for q in ([random.choice(processes)] if one else processes):
                    send(number, q)
            elif p.poll() is None:
                send(number, random.choice(processes) if one else p.pid)
            code = ended(p, 20)
            worst_wait = max(worst_wait, time.time() - sent)
            what = f"{signal.Signals(number).name} to {'one rank' if one else 'all' if kind == 'SIGKILL' else 'the launcher'} after {moment:.2f} s: code {code}"
            good, frames = opens(folder)
            codes = go_on(executable, n, folder) if code != 0 else []
            if kind == "SIGKILL":
                differ = same(undisturbed, state(folder)) if not codes or codes[-1] == 0 else ["not at its end"]
                c.true(f"{what}, file opens with {frames} frames; goes on with codes {codes}, every bit{': but ' + ', '.join(differ[:4]) if differ else ''}",
                       code is not None and good and len(codes) <= 1 and not differ)
            else:  # cases/mpirun.sh hands all signals on as SIGUSR1; a launcher that has not started a rank yet ends by itself, with code 1
                t = state(folder) if not codes or codes[-1] == 0 else {"steps": [], "dump": ""}
                c.true(f"{what}, file opens with {frames} frames; goes on with codes {codes}, {len(t['steps'])} frames, {t['dump'].count(chr(10)) - 9} particles",
                       code in (0, 128 + number, 128 + signal.SIGUSR1) + (() if processes else (1,)) and good and len(codes) <= 1 and t["steps"] == undisturbed["steps"] and t["dump"].count("\n") == undisturbed["dump"].count("\n"))
    if "--signal" not in sys.argv:
        c.true(f"SIGKILL met a rank {killed} times", killed >= moments // 2)
    c.below("longest time from a signal to the end (s)", worst_wait, 20)
    c.end()


if __name__ == "__main__":
    main()
