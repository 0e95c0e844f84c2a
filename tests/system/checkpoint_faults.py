#!/usr/bin/python3
"""Checkpoints where the disk is full, read-only or gone, and checkpoints that are cut short or have a bit flipped: each is told in a sentence, no
checkpoint that was whole is lost, and the newest whole one is used.

Without this test a half-written checkpoint could be taken for a whole one (LIGGGHTS doesn't look whether its restart file could be written), a
failed one could take the place of a good one, or a run of days could learn at its first checkpoint that nothing can be written.
Usage: checkpoint_faults.py EXECUTABLE RANKS... [--long]: every 1/20 of every file's length, 200 flipped bits.
"""
import os
import random
import shutil
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

from harness import Checks, Run, arguments, launch, long_form, narrow_bed, poured

SCRIPT = narrow_bed() + poured(300) + """\
fix gas all twogrid fine 36 1 40 ratio 6 1 4 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 0.4 boundary zhi pressure 0
fix_modify gas output off
fix_modify gas checkpoint every 40 folder FOLDER keep KEEP
run 199
"""


def run(executable, ranks, folder, where, *options, keep=2, between=None):
    """between(): called while it runs, after the first checkpoint is there."""
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "in.test"), "w") as f:
        f.write(SCRIPT.replace("FOLDER", where).replace("KEEP", str(keep)))
    command = launch(ranks) + [os.path.abspath(executable), "-in", "in.test", *options]
    p = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    if between:
        while p.poll() is None and not names(os.path.join(folder, where)):
            time.sleep(0.002)
        between()
    out = p.communicate(timeout=100)[0]
    return p.returncode, out, next((line for line in out.splitlines() if "ERROR" in line), "no sentence")


def names(folder):
    return sorted(n for n in os.listdir(folder) if "_step_" in n) if os.path.isdir(folder) else []


class Tmpfs:
    def __init__(self, path, options):
        os.makedirs(path, exist_ok=True)
        self.path, self.there = path, subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", path], stderr=subprocess.DEVNULL).returncode == 0

    def again(self, options):
        subprocess.run(["mount", "-o", "remount," + options, self.path], check=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.there:
            subprocess.run(["umount", self.path], check=True)


def full_disk(c, executable, ranks, work, size):
    """Room for so many checkpoints."""
    with Tmpfs(os.path.join(work, "disk"), f"size={int(size)}k") as disk:
        if not disk.there:
            print("     a full disk was not tried: no tmpfs may be mounted here")
            return
        folder, where = os.path.join(work, "full"), os.path.join(disk.path, "kept")
        shutil.rmtree(folder, ignore_errors=True)
        code, out, sentence = run(executable, ranks, folder, where, keep=9)
        there = names(where)
        wrong = "can't be written" in sentence or "No space left" in sentence or "does not fit" in sentence or "no room" in sentence
        c.true(f"disk of {size:.0f} kB, {ranks} ranks: code {code}, {len(there)} checkpoints stay, {sentence[:150]}", code == 1 and wrong and os.listdir(where) == [n for n in os.listdir(where) if n in there])
        disk.again("size=100m")
        code, out, sentence = run(executable, ranks, folder, where, "-restart", where if there else "auto", keep=9)
        c.true(f"with room again it goes on: code {code}, {len(names(where))} checkpoints", code == 0 and len(names(where)) == 5 and (not there or "goes on from the checkpoint" in out))


def main():
    executable, ranks = arguments()
    c = Checks("faults of checkpoints")
    with tempfile.TemporaryDirectory(prefix="twogrid_test_") as work:
        good = os.path.join(work, "good")
        code, out, sentence = run(executable, 1, good, "kept")
        kept = names(os.path.join(good, "kept"))
        size = sum(os.path.getsize(os.path.join(good, "kept", kept[-1], f)) for f in os.listdir(os.path.join(good, "kept", kept[-1]))) / 1024
        c.true(f"without faults: code {code}, the last two of {kept[-1][:6]} are kept, {size:.0f} kB each", code == 0 and len(kept) == 2 and kept[-1] == "000005_step_200")

        for n in ranks:
            for k in (0.05, 0.3, 0.8, 1.3, 2.1, 3.05) if long_form() or n == 1 else (1.7,):
                full_disk(c, executable, n, work, k * size)

        with Tmpfs(os.path.join(work, "disk"), "size=100m") as disk:
            if disk.there:
                disk.again("ro")
                code, out, sentence = run(executable, ranks[-1], os.path.join(work, "ro"), os.path.join(disk.path, "kept"))
                c.true(f"read-only from the beginning: code {code}, before the first step, {sentence[:150]}", code == 1 and "Read-only" in sentence and "checkpoint" in sentence and "twogrid: run of" not in out)
                disk.again("rw")
                where = os.path.join(disk.path, "kept")
                code, out, sentence = run(executable, ranks[-1], os.path.join(work, "ro"), where, between=lambda: disk.again("ro"))
                c.true(f"read-only after the first: code {code}, {len(names(where))} kept, {sentence[:150]}", code == 1 and "Read-only" in sentence and len(names(where)) >= 1)
        with open(os.path.join(work, "file"), "w") as f:
            f.write("not a folder")
        code, out, sentence = run(executable, ranks[-1], os.path.join(work, "other"), os.path.join(work, "file"))
        c.true(f"a file in the folder's place: code {code}, {sentence[:150]}", code == 1 and "checkpoint" in sentence and open(os.path.join(work, "file")).read() == "not a folder")
        gone = os.path.join(work, "gone")
        code, out, sentence = run(executable, ranks[-1], gone, "kept", between=lambda: shutil.rmtree(os.path.join(gone, "kept"), ignore_errors=True))
        c.true(f"the folder removed during the run: code {code}, {names(os.path.join(gone, 'kept'))[-1:]}", code in (0, 1) and (code == 0 and names(os.path.join(gone, "kept"))[-1:][0].endswith("_step_200") or "checkpoint" in sentence))

        # Before a checkpoint the output file, in which it goes on, is brought to the disk.
        gone = Run(executable, SCRIPT.replace("output off", "output every 20 file bed.h5").replace("FOLDER", "kept").replace("KEEP", "2").replace(
            "run 199", "run 30\nfix_modify gas checkpoint write one.h5\nshell rm bed.h5\nfix_modify gas checkpoint write two.h5"), ranks[-1])
        told = [line for line in gone.output.splitlines() if "could not be brought to the disk" in line]
        c.true(f"no output file any more: {told[0][:120] if told else 'nothing said'}", len(told) == 1 and gone.output.index("one.h5") < gone.output.index(told[0]) and os.path.exists(gone.file("two.h5")))

        # What a file can suffer later.
        random.seed(3)
        last = os.path.join(good, "kept", kept[-1])
        tries = []
        for name in sorted(os.listdir(last)):
            length = os.path.getsize(os.path.join(last, name))
            tries += [(name, "cut", length * k // 20) for k in (range(20) if long_form() else (random.randrange(20),))]
            tries += [(name, "bit", random.randrange(8 * length)) for _ in range(3)]
            tries += [(name, "gone", 0)]
        lengths = [os.path.getsize(os.path.join(last, n)) for n in sorted(os.listdir(last))]
        if long_form():
            tries += [(name, "bit", random.randrange(8 * n)) for name, n in random.choices(list(zip(sorted(os.listdir(last)), lengths)), weights=lengths, k=188)]
        silent, told = [], set()

        def goes_on(of):
            number, (name, kind, at) = of
            folder = os.path.join(work, f"hurt{number}")
            shutil.copytree(good, folder)
            path = os.path.join(folder, "kept", kept[-1], name)
            with open(path, "rb") as f:
                data = bytearray(f.read())
            if kind == "bit":
                data[at // 8] ^= 1 << at % 8
            with open(path, "wb") as f:
                f.write(data[:at] if kind == "cut" else data)
            if kind == "gone":
                os.remove(path)
            code, out, sentence = run(executable, 1, folder, "kept", "-restart", "auto")
            shutil.rmtree(folder)
            said = next((line for line in out.splitlines() if "is not used" in line), "nothing said")
            return code == 0 and "goes on from the checkpoint kept/" + kept[0] in out and kept[-1] in said, code, said

        with ThreadPoolExecutor(2) as pool:
            for (name, kind, at), (good_end, code, said) in zip(tries, pool.map(goes_on, enumerate(tries))):
                told.add((name, kind, said[-60:]))
                if not good_end:
                    silent.append(f"{name} {kind} {at}: code {code}, {said}")
        for t in sorted(told)[:8]:
            print("    ", *t)
        c.true(f"{len(tries)} hurt checkpoints ({sum(t[1] == 'cut' for t in tries)} cut, {sum(t[1] == 'bit' for t in tries)} bits flipped): each told and the one before used{': but ' + '; '.join(silent[:3]) if silent else ''}", not silent)
        folder = os.path.join(work, "none")
        shutil.copytree(good, folder)
        os.remove(os.path.join(folder, "kept", kept[0], "gas.h5"))
        os.remove(os.path.join(folder, "kept", kept[1], "record.txt"))
        code, out, sentence = run(executable, ranks[-1], folder, "kept", "-restart", "auto")
        c.true(f"none whole: code {code}, {sentence[:200]}", code == 1 and "no whole checkpoint" in sentence and kept[0] in sentence and kept[-1] in sentence)
    c.end()


if __name__ == "__main__":
    main()
