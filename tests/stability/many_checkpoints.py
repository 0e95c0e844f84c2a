#!/usr/bin/python3
"""A million steps of a small bed with a checkpoint every 10^4: memory, open files and disk stay what they are after the first ten checkpoints, the
ledger stays flat.

Without this test every checkpoint, and the set-up of a run behind it, could leave something behind that no short run shows.
Usage: many_checkpoints.py EXECUTABLE RANKS [--long]: 10^6 steps in place of 10^5, of a checkpoint every 10^4 in place of 10^3.
"""
import os
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))
from harness import Checks, arguments, head, long_form, poured, read_thermo, walls  # noqa: E402

SCRIPT = head("0 0.006 0 0.0024 0 0.024", 1.5e-5, boundary="f f f", skin=0.4e-3, gamman=0.01, gammat=0.005) + walls(xplane=(0, 0.006), yplane=(0, 0.0024), zplane=(0, 0.024)) + poured(60, "0.0006 0.0054 0.0006 0.0018 0.0006 0.02", 0.0005) + """\
reset_timestep 0
fix gas all twogrid fine 6 2 24 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 20
variable blow equal 0.8+0.8*sin(2*PI*step/3000)
fix_modify gas boundary zlo inlet 0 0 v_blow boundary zhi pressure 0
fix_modify gas output every EACH0 file bed.h5 average from 0.01
fix_modify gas checkpoint every EACH keep 2
thermo_style custom step atoms ke f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[14] f_gas[15]
thermo EACH
run STEPS
"""


def use(process, folder):
    """Memory (kB), open files, bytes on the disk but for output and log, checkpoints so far."""
    with open(f"/proc/{process}/status") as f:
        memory = next((int(line.split()[1]) for line in f if line.startswith("VmRSS")), 0)
    kept = os.path.join(folder, "in.test.checkpoints")
    there = sorted(n for n in os.listdir(kept) if "_step_" in n) if os.path.isdir(kept) else []
    bytes_ = 0
    for path, _, files in os.walk(kept):
        for name in files:
            try:
                bytes_ += os.path.getsize(os.path.join(path, name))
            except OSError:
                pass  # being removed
    return memory, len(os.listdir(f"/proc/{process}/fd")), bytes_, int(there[-1][:6]) if there else 0


def main():
    executable, _ = arguments()
    c = Checks("many checkpoints")
    steps = 1000000 if long_form() else 100000
    each = steps // 100
    with tempfile.TemporaryDirectory(prefix="twogrid_test_") as folder:
        with open(os.path.join(folder, "in.test"), "w") as f:
            f.write(SCRIPT.replace("EACH0", str(10 * each)).replace("EACH", str(each)).replace("STEPS", str(steps)))
        p = subprocess.Popen([os.path.abspath(executable), "-in", "in.test"], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
        seen = []
        while p.poll() is None:
            try:
                seen.append(use(p.pid, folder))
            except OSError:
                pass  # it has just ended
            time.sleep(0.02)
        settled = [s for s in seen if 10 <= s[3] < 20]
        late = [s for s in seen if s[3] >= 90 and s[0] > 0]
        c.true(f"code {p.returncode}, {len(settled)} looks in checkpoints 10 to 19, {len(late)} from 90 on", p.returncode == 0 and len(settled) > 5 and len(late) > 5)
        for i, what in enumerate(("memory, kB", "open files", "bytes of checkpoints")):
            # Contacts are part of a checkpoint, and more or fewer from one to the next; one of a hundred that stays behind is a third more.
            # A look may fall into the writing of a checkpoint, with its file open: the least of the open files. Memory: 1 % are 9 kB a checkpoint.
            of = min if i == 1 else max
            first, last = of(s[i] for s in settled), of(s[i] for s in late)
            c.below(f"{what}: {first} then {last}, {of.__name__}; growth", (last - first) / first, (0.01, 0, 0.25)[i])
        t = read_thermo(os.path.join(folder, "log.liggghts"))
        c.true(f"{int(t['Step'][-1])} steps, {len(t['Step'])} lines, {t['Atoms'].min():.0f} to {t['Atoms'].max():.0f} particles", t["Step"][-1] == steps and t["Atoms"].min() == t["Atoms"].max() > 40)
        for name, what in (("gas[6]", "error of the solids' volume"), ("gas[7]", "error of the momentum exchange")):
            c.below(f"{what}, largest", abs(t[name]).max(), 1e-12)
        c.below("volume inserted and vanished", abs(t["gas[14]"]).max() + abs(t["gas[15]"]).max(), 0)
        kinetic, weight = t["KinEng"][len(t["Step"]) // 2:], t["Atoms"][-1] * 2500 * 5.24e-10 * 9.81
        c.true(f"the bed moves: kinetic energy {kinetic.mean():.2g} J in the second half, that of a fall of {kinetic.mean() / weight:.2g} m", kinetic.mean() / weight > 1e-5)
    c.end()


if __name__ == "__main__":
    main()
