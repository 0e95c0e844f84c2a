#!/usr/bin/python3
"""Output files are never lost: not to a second run in the same folder, a run that is refused, fix and unfix, or a kill within a frame; a run
that goes on from a checkpoint goes on in its file, with the means and batches of the run that was never left, to the last bit.

Without this test a day's results could be destroyed by starting the script once more, two runs could write into one file, a killed run could leave
a file that nothing opens, and means could begin anew in silence at each leg of a long run.
Usage: output_files.py EXECUTABLE RANKS...
"""
import contextlib
import glob
import hashlib
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

from harness import Checks, arguments, data_file, head, head_with_particles, launch, walls

BOX, D = "0 0.008 0 0.004 0 0.012", 1e-3
GAS = walls(zplane=(0,)) + """
fix weight all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 8 4 12 ratio 4 2 4 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 0.8 boundary zhi pressure 0
fix_modify gas output every {every} file bed.h5 fields u p eps {more}
thermo {thermo}
"""


def script(more="", every=20, thermo=100):
    return head_with_particles(2e-5, boundary="p p f", skin=0.4e-3, gamman=0.01, gammat=0.005) + GAS.format(more=more, every=every, thermo=thermo)


def script_from_restart(more=""):
    text = head(BOX, 2e-5, boundary="p p f", skin=0.4e-3, gamman=0.01, gammat=0.005)
    return text[:text.index("region box")] + "read_restart half\n" + text[text.index("neighbor"):] + GAS.format(more=more, every=20, thermo=100) + "fix_modify gas checkpoint read half.h5\n"


class Folder:
    """Several runs one after the other."""

    def __init__(self, executable, ranks):
        self.executable, self.ranks = os.path.abspath(executable), ranks
        self.folder = tempfile.TemporaryDirectory(prefix="twogrid_test_")
        self.path = self.folder.name
        x = [(1e-3 * (i + 0.6), 1e-3 * (j + 0.6), 1e-3 * (k + 0.6)) for k in range(4) for j in range(3) for i in range(7)]
        self.put("particles.data", data_file(BOX, x, D, 2500, np.random.default_rng(3).uniform(-0.1, 0.1, (len(x), 3))))

    def file(self, name):
        return os.path.join(self.path, name)

    def put(self, name, text):
        with open(self.file(name), "w") as f:
            f.write(text)

    def start(self, text, ranks=None, options=()):
        self.put("in.test", text)
        return subprocess.Popen([*launch(ranks or self.ranks), self.executable, "-in", "in.test", *options], cwd=self.path, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, errors="replace")

    def run(self, text, ranks=None, success=True, options=()):
        child = self.start(text, ranks, options)
        output = child.communicate(timeout=100)[0]
        if success and child.returncode != 0:
            print(output[-3000:])
            sys.exit(f"FAIL: the run ended with code {child.returncode}")
        self.code = child.returncode
        self.sentence = next((line[line.index("ERROR"):] for line in output.splitlines() if "ERROR" in line), "none")
        return output

    def bytes(self):
        sums = {}
        for path in glob.glob(self.file("bed*")):
            with open(path, "rb") as f:
                sums[os.path.basename(path)] = hashlib.sha256(f.read()).hexdigest()
        return sums

    def clear(self):
        for path in glob.glob(self.file("bed*")):
            os.unlink(path)

    def datasets(self, name="bed.h5"):
        """All of frames and means; particles sorted by id."""
        all = {}
        with h5py.File(self.file(name)) as f:
            for group in ("fluid", "particles", "average"):
                f[group].visititems(lambda n, d, g=group: all.__setitem__(f"{g}/{n}", d[...]) if isinstance(d, h5py.Dataset) else None)
            for frame in f["particles"]:
                order = np.argsort(all[f"particles/{frame}/id"])
                for n in f["particles"][frame]:
                    if n not in ("time", "step"):
                        all[f"particles/{frame}/{n}"] = all[f"particles/{frame}/{n}"][order]
        return all

    def steps(self, name="bed.h5"):
        with h5py.File(self.file(name)) as f:
            return [int(f["fluid"][n]["step"][()]) for n in sorted(f["fluid"])]

    def series(self):
        """What ParaView is shown: (file, step) of the frames, in order."""
        with open(self.file("bed.xdmf")) as f:
            shown = re.findall(r"/>\n<Grid Name=\"fluid\".*?>([^<>]*\.h5):/grid/x.*?:/fluid/(\d+)/", f.read(), re.S)
        result = []
        for name, frame in shown:
            with h5py.File(self.file(name)) as f:
                result.append((name, int(f["fluid"][frame]["step"][()])))
        return result


def same(a, b):
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


def never_destroyed(c, executable, n):
    f = Folder(executable, n)
    f.run(script("average from 0") + "run 40\nrun 20\n")
    c.true("two runs of one fix are one series", f.steps() == [0, 20, 40, 60])
    c.true("nothing is left of lock and unfinished files", sorted(f.bytes()) == ["bed.h5", "bed.xdmf", "bed_average.xdmf"])
    first = f.bytes()
    refused = lambda text, *options: (f.run(text, success=False, options=options), f.code != 0 and "there already" in f.sentence and "overwrite yes" in f.sentence)[1]
    c.true("again in the same folder: refused", refused(script("average from 0") + "run 20\n"))
    c.note(f.sentence[:230])
    f.run(script("overwrite yes") + "fix_modify gas boundary zlo periodic\nrun 20\n", success=False)
    c.true(f"a run that is refused for something else, `overwrite yes`: {f.sentence[:60]}", f.code != 0 and f.sentence != "none")
    c.true("nothing has changed", f.bytes() == first)
    os.rename(f.file("bed.h5"), f.file("old.h5"))
    c.true("the XDMF file of one that was moved: refused", refused(script() + "run 20\n"))
    f.clear()
    os.rename(f.file("old.h5"), f.file("elsewhere"))
    os.symlink("elsewhere", f.file("bed.h5"))
    c.true("through a link: refused", refused(script() + "run 20\n") and f.steps("elsewhere") == [0, 20, 40, 60])
    f.run(script("overwrite yes") + "run 20\n")
    c.true("through a link, overwrite yes: its target is replaced", os.path.islink(f.file("bed.h5")) and f.steps("elsewhere") == [0, 20])
    f.clear()
    f.put("bed.h5", "my thesis\n")
    c.true("a file of another kind: refused", refused(script() + "run 20\n") and open(f.file("bed.h5")).read() == "my thesis\n")
    f.clear()
    again = script() + "run 20\nunfix gas\n" + script()[script().index("fix gas all"):] + "run 20\n"
    c.true("unfix and fix: the second is refused", refused(again) and f.steps() == [0, 20])


def one_at_a_time(c, executable, n):
    f = Folder(executable, n)
    child = f.start(script("overwrite yes") + "run 1000000\n")
    while not os.path.exists(f.file("bed.h5")):
        time.sleep(0.02)
    f.run(script("overwrite yes") + "run 20\n", success=False)
    c.true(f"a second run while the first goes on: {f.sentence[:110]}", f.code != 0 and "another run" in f.sentence)
    kill(child)
    c.true("after a kill of the first its lock is in nobody's way", (f.run(script("overwrite yes") + "run 20\n"), f.steps() == [0, 20])[1])


def kill(child):
    """SIGKILL to the ranks and to mpirun."""
    ranks = subprocess.run(["pgrep", "-P", str(child.pid)], capture_output=True, text=True).stdout.split()
    for pid in [*ranks, child.pid]:
        with contextlib.suppress(ProcessLookupError):
            os.kill(int(pid), signal.SIGKILL)
    child.communicate()


def goes_on(c, executable, n):
    f = Folder(executable, n)
    first = script("average from 0.002") + "run 210\nwrite_restart half\nfix_modify gas checkpoint write half.h5\n"
    f.run(first + "run 200\n")
    whole = f.datasets()
    f.run(script_from_restart("average from 0.002") + "run 200\n")
    again = f.datasets()
    differ = [k for k in whole if k not in again or not same(whole[k], again[k])]
    c.true(f"frames, means and batches, every bit of {len(whole)} datasets{': but ' + ', '.join(differ[:5]) if differ else ''}", not differ and len(whole) == len(again) > 200)
    c.true("one series in ParaView", f.series() == [("bed.h5", s) for s in range(0, 401, 20)])
    with h5py.File(f.file("bed.h5")) as h:
        leg = h["record/leg_2"].attrs
        c.true("the record tells of the restart", leg["checkpoint_step"] == 210 and leg["ranks"][0] == n and b"in.test" in leg["command_line"])
    said = f.run(script_from_restart("average from 0.002") + "run 10\n")
    c.true("later frames are taken out, with a sentence", "10 later ones" in said and f.steps() == list(range(0, 201, 20)) + [220])
    other = {1: 2, 2: 1}[n]
    f.run(script_from_restart("average from 0.002") + "run 200\n", ranks=other)
    again = f.datasets()
    worst = max(np.max(np.abs(whole[k] - again[k])) / np.max(np.abs(whole[k])) for k in
                ("average/fine/eps", "average/fine/p", "average/particle_grid/solids_fraction", "average/particle_grid/batch/eps", "average/particle_grid/batch/weight"))
    c.below(f"on {other} ranks: means and batches, relative difference", worst, 2e-4)
    c.true("as many frames", f.steps() == list(range(0, 401, 20)))

    f.run(script_from_restart("average from 0.002 legs many") + "run 200\n")
    c.true("legs many: a file of its own, one series",
           f.steps("bed.2.h5") == list(range(220, 401, 20)) and len(f.steps()) == 21
           and f.series() == [("bed.h5", s) for s in range(0, 201, 20)] + [("bed.2.h5", s) for s in range(220, 401, 20)])
    with h5py.File(f.file("bed.2.h5")) as h:
        means = {k: h["average/" + k][...] for k in ("fine/u", "particle_grid/batch/solids_flux", "particle_grid/solids_velocity")}
    c.true("its means are those of the whole run", all(same(v, whole["average/" + k]) for k, v in means.items()))
    with open(f.file("bed.2.h5"), "r+b") as h:
        h.truncate(5000)
    said = f.run(script_from_restart("average from 0.002") + "run 20\n")
    c.true("a damaged file is left alone, with a sentence", "bed.2.h5 is damaged" in said and os.path.getsize(f.file("bed.2.h5")) == 5000 and f.steps("bed.3.h5") == [220])
    f.clear()
    said = f.run(script_from_restart("average from 0.002") + "run 40\n")
    c.true("a file that is gone: a new one, with a sentence", "not there any more" in said and f.steps() == [220, 240])
    f.clear()
    f.run(script() + "run 20\n")
    before = f.bytes()
    f.run(script_from_restart() + "run 20\n", success=False)
    c.true(f"another run's file: {f.sentence[:110]}", f.code != 0 and "of another run" in f.sentence and f.bytes() == before)


def kills(c, executable, n, moments):
    f = Folder(executable, n)
    draw = random.Random(7)
    frames, wrong = [], []
    for _ in range(moments):
        f.clear()
        child = f.start(script(every=10, thermo=1000) + "run 1000000\n")
        while not os.path.exists(f.file("bed.h5")):
            time.sleep(0.005)
        time.sleep(draw.uniform(0, 0.5))
        kill(child)
        try:
            with h5py.File(f.file("bed.h5")) as h:
                names = sorted(h["fluid"])
                good = names == [f"{i:06d}" for i in range(len(names))] == sorted(h["particles"])
                for i, m in enumerate(names):
                    g, p = h["fluid"][m], h["particles"][m]
                    good = good and int(g["step"][()]) == 10 * i and np.isfinite(g["u"][()]).all() and 0.2 < g["eps"][()].min() and g["eps"][()].max() <= 1
                    good = good and len(set(p["id"][()])) == 84 and p["position"].shape == (84, 3)
                frames.append(len(names))
                if not good:
                    wrong.append(f"frame {len(names)}")
        except OSError as e:
            wrong.append(str(e))
    c.true(f"{moments} kills, up to frame {max(frames)}: the file opens and every frame is whole{': but ' + '; '.join(wrong) if wrong else ''}", not wrong and max(frames) > 20)


def main():
    executable, ranks = arguments()
    c = Checks("output files")
    for n in ranks:
        c.note(f"{n} ranks")
        goes_on(c, executable, n)
    never_destroyed(c, executable, ranks[-1])
    one_at_a_time(c, executable, ranks[-1])
    kills(c, executable, ranks[-1], 200 if "--long" in sys.argv else 8)
    c.end()


if __name__ == "__main__":
    main()
