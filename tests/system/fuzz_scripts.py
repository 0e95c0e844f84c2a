#!/usr/bin/python3
"""Whole scripts, mutated by lines and words, end in a sentence or run with numbers.

    fuzz_scripts.py EXECUTABLE [RANKS] [--long N] [--seed S] [--one K] [--keep FOLDER]

A small bed with a jet (some 20 spheres, 20 steps of gas), of which lines are dropped, repeated and swapped, words too, and
numbers become 0, -1, nan, inf, 1e300 and the like: lines of twogrid and of LIGGGHTS alike. Wanted of each try within 10 s: no
end by a signal (segmentation fault, division by zero, abort); an exit code other than 0 comes with a line that begins with
ERROR; after exit code 0 there is no nan or inf in the table of the gas, nor in the particles' positions and velocities.

What would pass falsely without it: a script whose numbers make no sense is simulated, and its result is nonsense that no one
sees; a crash in the place of a sentence. The right script runs first, or else all could fail for a reason of its own.

Left out: what LIGGGHTS itself does on such words. It is what ends by a signal or hangs before the script's line 'fix ... twogrid', which LIGGGHTS
echoes before it does it; and later, where the stack, which Open MPI writes when a signal ends a process (a hang is ended by one), lies in
LIGGGHTS down to the functions of ours that only hand its commands on (DRIVERS). That is listed as 'LIGGGHTS' and doesn't fail the test; a
stack that can't be read does.
"""

import argparse
import collections
import concurrent.futures
import math
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile

LIMIT = 10.0  # s a try
SCENE = """\
units           si
atom_style      granular
newton          off
communicate     single vel yes
boundary        f f f
processors      * 1 1
region          box block 0 0.0072 0 0.0048 0 0.0144 units box
create_box      1 box
neighbor        0.0004 bin
neigh_modify    delay 0
soft_particles  yes
fix             kn all property/global kn peratomtypepair 1 100.0
fix             kt all property/global kt peratomtypepair 1 30.0
fix             gn all property/global gamman peratomtypepair 1 550.0
fix             gt all property/global gammat peratomtypepair 1 275.0
fix             mu all property/global coefficientFriction peratomtypepair 1 0.1
pair_style      gran model hooke/stiffness tangential history
pair_coeff      * *
timestep        1.5e-5
fix             zlo all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0.0
fix             zhi all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0.0144
fix             weight all gravity 9.81 vector 0 0 -1
fix             motion all nve/sphere
lattice         sc 0.0018
region          fill block 0.0004 0.0068 0.0004 0.0044 0.0006 0.006 units box
create_atoms    1 region fill
set             group all diameter 0.0012 density 1000
variable        U equal 5*ramp(0,1)
fix             gas all twogrid fine 6 4 12 ratio 3 2 3 density 1.2 viscosity 1.8e-5 every 5
fix_modify      gas drag ergun/wenyu formulation B
fix_modify      gas method smooth
fix_modify      gas boundary zlo inlet 0 0 0.4 boundary zhi pressure 0
fix_modify      gas boundary zlo patch jet rect 0.0024 0.0048 0 0.0048 inlet 0 0 5.0
fix_modify      gas output every 10 file bed.h5 average from 0
thermo_style    custom step atoms ke f_gas[1] f_gas[2] f_gas[3] f_gas[4] f_gas[9]
thermo          5
dump            last all custom 20 last.dump id x y z vx vy vz radius
run             20
"""
ODD = ["0", "-1", "nan", "inf", "-inf", "1e300", "-1e300", "1e-300", "1e30", "1e9", "2147483648", "9e18", "0.5", "1", "2", "-0.001", "3",
       "''", "v_x", "v_U", "x" * 300, "\u00e9", "NULL", "1e-12", "100", "1e6"]
MORE = ["set group all diameter 0", "set group all diameter nan", "set group all diameter -0.001", "set group all density 1e300",
        "set group all density 0", "velocity all set nan 0 0", "velocity all set 1e9 0 0", "set atom 1 x inf", "set atom 1 z nan", "timestep nan", "timestep 1e300",
        "timestep 0", "timestep -1", "fix g all gravity 1e300 vector 0 0 -1", "fix g all gravity nan vector 0 0 1",
        "fix g all gravity 9.81 vector 0 0 0", "run 0", "clear", "unfix gas", "unfix motion", "delete_atoms group all", "reset_timestep 9000000000000000000",
        "neighbor nan bin", "neighbor 1e300 bin", "neighbor 0 bin", "create_atoms 1 single nan 0 0", "create_atoms 1 single 0.001 0.001 0.001 units box", "run 5 every 2 NULL",
        "fix_modify gas checkpoint every 3 folder cp keep 1", "fix_modify gas checkpoint write a.h5", "displace_atoms all move nan 0 0 units box",
        "change_box all x final 0 1", "velocity all create 1e300 4928459", "fix f all setforce nan 0 0", "fix f all adapt 1 atom diameter v_U"]


def is_number(word):
    try:
        float(word)
        return True
    except ValueError:
        return False


def mutated(dice):
    lines = [line.split() for line in SCENE.splitlines()]
    for _ in range(dice.choice([1, 1, 1, 2, 3])):
        at = dice.randrange(len(lines))
        kind = dice.randrange(10)
        if kind == 0:
            del lines[at]
        elif kind == 1:
            lines.insert(dice.randrange(len(lines)), list(lines[at]))
        elif kind == 2:
            other = dice.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        elif kind == 3:
            lines.insert(dice.randrange(18, len(lines)), dice.choice(MORE).split())
        elif kind == 4:
            line = lines[at]
            del line[dice.randrange(len(line))]
        elif kind == 5:
            line = lines[at]
            line.insert(dice.randrange(1, len(line) + 1), dice.choice(ODD))
        else:
            places = [(i, k) for i, line in enumerate(lines) for k, w in enumerate(line) if is_number(w)]
            i, k = dice.choice(places)
            lines[i][k] = dice.choice(ODD)
        lines = [line for line in lines if line]
    return "\n".join(" ".join(line) for line in lines) + "\n"


def finite_dump(path):
    """Whether all numbers of the last frame of particles are finite."""
    if not os.path.exists(path):
        return True
    with open(path, errors="replace") as f:
        text = f.read()
    rows = text.rsplit("ITEM: ATOMS", 1)[-1].splitlines()[1:] if "ITEM: ATOMS" in text else []
    return all(math.isfinite(float(w)) for row in rows for w in row.split() if is_number(w))


def table_is_finite(out):
    """Whether the tables of runs hold numbers."""
    columns, inside = 0, False
    for line in out.splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            columns, inside = len(words), True
        elif line.startswith("Loop time"):
            inside = False
        elif inside and len(words) == columns and all(is_number(w) for w in words):
            if not all(math.isfinite(float(w)) for w in words):
                return False
    return True


# Functions below which LIGGGHTS works by itself: those that hand on its commands, and the loop over steps.
DRIVERS = re.compile(r"twogrid::(Session|Interpreter)::|twogrid::stock_run|::run_as_it_is|::WatchedVerlet::|::run<|std::_Function_handler<.*main::|^main$")


def lies_in_liggghts(executable, out):
    """Whether the stack of a process that a signal has ended is LIGGGHTS' own, from its top down to one of DRIVERS."""
    frames = re.findall(r"\[ ?\d+\] (\S+?)\((\S*)\+0x([0-9a-f]+)\)\[0x", out)
    inside = False
    for library, name, offset in frames:
        if os.path.basename(library) == os.path.basename(executable):
            function = subprocess.run(["addr2line", "-Cfe", executable, "0x" + offset], stdout=subprocess.PIPE, text=True).stdout.splitlines()[:1]
            return inside and bool(function) and bool(DRIVERS.search(function[0]))
        inside = inside or "liggghts" in os.path.basename(library)
    return False


def attempt(executable, text, keep=None):
    """What is wrong, whose it is, and the output."""
    folder = tempfile.mkdtemp()
    try:
        with open(os.path.join(folder, "in.bed"), "w") as f:
            f.write(text)
        p = subprocess.Popen([executable, "-in", "in.bed", "-echo", "both"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        try:
            out, code = p.communicate(timeout=LIMIT)[0], p.returncode
        except subprocess.TimeoutExpired:
            p.send_signal(signal.SIGABRT)  # writes where it is
            try:
                out = p.communicate(timeout=LIMIT)[0]
            except subprocess.TimeoutExpired:
                p.kill()
                out = p.communicate()[0]
            code = None
        out = out.decode(errors="replace")
        ours = re.search(r"^fix\s+\S+\s+\S+\s+twogrid\b", out, re.M) is not None
        by_signal = code is None or code < 0 or code in (134, 136, 139)
        if ours and by_signal and lies_in_liggghts(executable, out):
            ours = False
        error = any(line.startswith("ERROR") for line in out.splitlines())
        if code is None:
            return "hangs", ours, out
        if by_signal:
            return "ends by signal %d" % abs(code), ours, out
        if code != 0 and not error:
            return "exit code %d without ERROR" % code, ours, out
        if code == 0 and ours and not table_is_finite(out):
            return "exit code 0 with nan or inf in the table", ours, out
        if code == 0 and ours and not finite_dump(os.path.join(folder, "last.dump")):
            return "exit code 0 with nan or inf in the particles", ours, out
        return "ran" if code == 0 else "", ours, out
    finally:
        if keep:
            shutil.copytree(folder, keep, dirs_exist_ok=True)
        shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("executable")
    parser.add_argument("ranks", nargs="*")
    parser.add_argument("--long", type=int, default=40)
    parser.add_argument("--seed", type=int, default=20261128)
    parser.add_argument("--one", type=int, default=-1)
    parser.add_argument("--keep")
    args = parser.parse_args()
    executable = os.path.abspath(args.executable)

    found, ours, out = attempt(executable, SCENE)
    print("the right script: %s" % found)
    if found != "ran" or not ours:
        print(out[-2000:])
        return 1

    def one(k):
        text = mutated(random.Random(args.seed * 1000003 + k))
        return k, text, *attempt(executable, text, args.keep)

    bad = 0
    seen = collections.Counter()
    tries = [args.one] if args.one >= 0 else range(args.long)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for k, text, found, ours, out in pool.map(one, tries):
            seen["ran" if found == "ran" else "refused" if not found else found + ("" if ours else ", in LIGGGHTS")] += 1
            if found in ("", "ran"):
                continue
            bad += ours
            changed = [line for line in text.splitlines() if line.split() not in [s.split() for s in SCENE.splitlines()]]
            print("%s try %d: %s: %s" % ("BAD" if ours else "LIGGGHTS", k, found, " | ".join(line[:160] for line in changed)))
            print("      " + " / ".join(line[:160] for line in out.splitlines()[-4:]), flush=True)
    for what, n in sorted(seen.items()):
        print("%6d %s" % (n, what))
    return 1 if bad or (len(tries) > 20 and not (seen["ran"] and seen["refused"])) else 0


if __name__ == "__main__":
    sys.exit(main())
