#!/usr/bin/python3
"""Wrong scripts end with one clear sentence.

    bad_input.py EXECUTABLE RANKS [--only NAME]

Every script below is the same small scene, which runs, with one thing wrong. Wanted of each: a non-zero exit code within
5 s, one line that begins with ERROR (on screen, all ranks together), in it the words listed with the script (the keyword,
the value found, the remedy), and no file left but the log and its status.

What would pass falsely without it: a mistake that is taken as something else and simulated; an error that only one rank
sees, so that the others hang; a sentence that names neither the keyword nor the value; an output file begun before the
mistake is found. The right script runs first, or else a scene that fails for a reason of its own would pass everywhere.
"""

import argparse
import concurrent.futures
import os
import shutil
import subprocess
import sys
import tempfile
import time

from harness import ENDS_AT_ONCE, launch

LIMIT = 5.0  # s of wall time for each wrong script
AT_ONCE = 2   # scripts side by side

SCENE = """\
atom_style      {atom_style}
boundary        {boundary}
newton          off
communicate     single vel yes
units           si
region          box block 0 0.008 0 0.008 0 0.016 units box
create_box      1 box
neighbor        0.0005 bin
neigh_modify    delay 0
fix             m1 all property/global kn peratomtypepair 1 1000
fix             m2 all property/global kt peratomtypepair 1 300
fix             m3 all property/global gamman_abs peratomtypepair 1 1e-3
fix             m4 all property/global gammat_abs peratomtypepair 1 1e-3
fix             m5 all property/global coefficientFriction peratomtypepair 1 0.3
{pair}
timestep        1e-5
{floor}
fix             weight all gravity 9.81 vector 0 0 -1
create_atoms    1 single 0.004 0.004 0.006 units box
{sizes}
variable        U equal 0.1
variable        S string text
region          nowhere block 0.1 0.2 0.1 0.2 0.1 0.2 units box
{before}
fix             gas {group} twogrid {fix}
{modify}
run             {steps}
{after}
"""

PAIR = """pair_style      gran model hooke/stiffness tangential history absolute_damping on
pair_coeff      * *"""
FLOOR = """fix             floor all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0.0 absolute_damping on
fix             integrate all nve/sphere"""

FIX = "fine 8 8 16 ratio 4 4 4 density 1.2 viscosity 1.8e-5 every 10"
THROUGH = "fix_modify gas boundary zlo inlet 0 0 0.1 boundary zhi pressure 0\n"

CASES = []


def wrong(name, words, fix=FIX, modify="", flow=THROUGH, **scene):
    """words: what the sentence must contain."""
    CASES.append((name, words, dict(scene, fix=fix, modify=flow + ("fix_modify gas " + modify if modify else ""))))


# the fix command
wrong("unknown keyword", ["colour", "unknown", "fine"], fix=FIX + " colour 3")
wrong("missing value", ["density", "kg/m3"], fix="fine 8 8 16 ratio 4 4 4 viscosity 1.8e-5 every 10 density")
wrong("no density", ["density", "no such keyword"], fix="fine 8 8 16 ratio 4 4 4 viscosity 1.8e-5 every 10")
wrong("word for a number", ["fine", "eight"], fix=FIX.replace("fine 8", "fine eight"))
wrong("zero fine cells", ["fine", "0", "at least 1"], fix=FIX.replace("fine 8", "fine 0"))
wrong("half a cell", ["fine", "7.5"], fix=FIX.replace("fine 8", "fine 7.5"))
wrong("ratio that does not divide", ["ratio", "3", "8", "multiple"], fix=FIX.replace("ratio 4", "ratio 3"))
wrong("negative viscosity", ["viscosity", "-1.8e-5", "above 0"], fix=FIX.replace("1.8e-5", "-1.8e-5"))
wrong("no density at all", ["density", "0", "above 0"], fix=FIX.replace("1.2", "0"))
wrong("not a number", ["density", "nan"], fix=FIX.replace("1.2", "nan"))
wrong("every 0", ["every", "0", "at least 1"], fix=FIX.replace("every 10", "every 0"))
wrong("domain outside the box", ["domain", "0.02", "0.016", "box"], fix=FIX + " domain 0 0.008 0 0.008 0 0.02")
wrong("domain upside down", ["domain", "lower"], fix=FIX + " domain 0 0.008 0.008 0 0 0.016")
wrong("stretch out of range", ["stretch", "5"], fix=FIX + " stretch z 5")
wrong("keyword twice", ["viscosity", "twice"], fix=FIX + " viscosity 1e-5")
wrong("unknown group", ["group"], group="nobody")
# the box and the particles
wrong("shrinking box", ["boundary", "s", "'boundary f f f'"], boundary="f f s")
wrong("box with a minimum", ["boundary", "m", "'boundary p f f'"], boundary="p f fm")
wrong("points for particles", ["atom_style", "radius", "granular"], atom_style="atomic", sizes="mass 1 1.0", floor="",
      pair="pair_style none")
wrong("clumps", ["multisphere", "single"], before="""\
fix   clump all particletemplate/multisphere 15485863 atom_type 1 density constant 2500 nspheres 2 ntry 1000 &
      spheres file two.spheres scale 1.0 type 1
fix   sizes all particledistribution/discrete 15485867 1 clump 1.0
fix   bodies all multisphere""")
# fix_modify
wrong("unknown keyword of fix_modify", ["colour", "unknown", "drag"], modify="colour 3")
wrong("unknown drag law", ["drag", "newton", "ergun/wenyu"], modify="drag newton")
wrong("formulation C", ["formulation", "C", "A or B"], modify="formulation C")
wrong("eps bound above 1", ["eps bound", "1.4"], modify="eps bound move 1.4")
wrong("fewer than no particles lost", ["most_lost", "-1", "at least 0"], modify="most_lost -1")
wrong("a model", ["model", "turbulence"], modify="model turbulence k-omega")
wrong("unknown side", ["boundary", "top", "zhi"], modify="boundary top slip")
wrong("unknown condition", ["boundary xlo", "sticky", "noslip"], modify="boundary xlo sticky")
wrong("side twice", ["boundary zlo", "second"], modify="boundary zlo noslip")
wrong("inlet without its velocity", ["boundary xlo", "inlet", "v_NAME"], modify="boundary xlo inlet 0 0")
wrong("unknown variable", ["v_speed", "equal-style"], modify="boundary xlo inlet v_speed 0 0")
wrong("variable of another style", ["v_S", "equal-style"], modify="boundary xlo inlet v_S 0 0")
wrong("patch off its face", ["patch jet", "0.009", "0.008"],
      modify="boundary zlo patch jet rect 0.003 0.009 0 0.008 inlet 0 0 5")
wrong("circle off its face", ["patch jet", "circle", "0.001"], modify="boundary zlo patch jet circle 0.001 0.004 0.003 inlet 0 0 5")
wrong("patch between the cells", ["patch jet", "no fine face"],
      modify="boundary zlo patch jet rect 0.0031 0.0032 0 0.008 inlet 0 0 5")
wrong("patch without a name's shape", ["patch jet", "rect, circle or region"], modify="boundary zlo patch jet inlet 0 0 5")
wrong("unknown region", ["patch jet", "hole", "region"], modify="boundary zlo patch jet region hole inlet 0 0 5")
wrong("region elsewhere", ["patch jet", "no fine face"], modify="boundary zlo patch jet region nowhere inlet 0 0 5")
wrong("no outlet", ["boundary", "no outlet", "pressure 0"], flow="fix_modify gas boundary zlo inlet 0 0 0.1\n")
wrong("periodic side in a fixed box", ["boundary xlo", "periodic", "p instead of f"],
      modify="boundary xlo periodic boundary xhi periodic")
wrong("wall in a periodic direction", ["boundary xlo", "periodic", "f instead of p"], boundary="p f f",
      modify="boundary xlo noslip")
wrong("no-slip one cell deep", ["boundary ylo", "noslip", "fine 1", "gap friction"],
      fix="fine 8 1 16 ratio 4 1 4 density 1.2 viscosity 1.8e-5 every 10", modify="boundary ylo noslip boundary yhi noslip")
wrong("gap friction without a gap", ["gap friction", "one fine cell"], modify="gap friction on")
wrong("gradient that is not periodic", ["pressure_gradient", "not periodic"], modify="pressure_gradient 0 0 -10")
wrong("flow rate that is not periodic", ["flow_rate", "not periodic"], modify="flow_rate x 0.1")
wrong("a moving wall that leaves", ["boundary xlo", "normal"], modify="boundary xlo noslip 0.1 0 0")
wrong("missing table", ["profile table", "missing.txt"], modify="boundary xlo inlet 1 0 0 profile table z missing.txt")
wrong("output that does not fit", ["output every", "15", "10"], modify="output every 15 file out.h5")
wrong("output without a file", ["output", "file"], modify="output every 10")
wrong("output field", ["fields", "vorticity", "eps"], modify="output every 10 file out.h5 fields vorticity")
wrong("unwritable output", ["nowhere/out.h5"], modify="output every 10 file nowhere/out.h5")
wrong("kernel of no width", ["read kernel", "-1"], modify="read kernel -1")
wrong("output together with a later mistake", ["no outlet"], flow="fix_modify gas boundary zlo inlet 0 0 0.1\n",
      modify="output every 10 file out.h5")
# later
wrong("change after the first run", ["drag", "first run"], after="fix_modify gas drag stokes\nrun 1")
wrong("a second fluid", ["second", "gas"], after="fix air all twogrid " + FIX)
# on the command line
wrong("bricks for other ranks", ["-fluid_bricks", "number of ranks"], options=["-fluid_bricks", "3,1,1"])
wrong("two bricks", ["-fluid_bricks", "three numbers"], options=["-fluid_bricks", "1,1"])
wrong("skin of no kind", ["-skin", "best or script", "wide"], options=["-skin", "wide"])
wrong("balance of no kind", ["-balance", "on or off"], options=["-balance", "perhaps"])


def script(scene):
    values = dict(atom_style="granular", boundary="f f f", group="all", before="", after="", modify="", fix=FIX, steps=0,
                  pair=PAIR, floor=FLOOR, sizes="set group all diameter 0.001 density 2500")
    values.update(scene)
    values.pop("options", None)
    return SCENE.format(**values)


def run(executable, ranks, text, folder, options=()):
    with open(os.path.join(folder, "in.scene"), "w") as f:
        f.write(text)
    with open(os.path.join(folder, "two.spheres"), "w") as f:
        f.write("0 0 0 0.0005\n0.0005 0 0 0.0005\n")
    command = [*launch(ranks, ENDS_AT_ONCE), executable, "-in", "in.scene", "-log", "log.scene", *options]
    begin = time.time()
    try:
        done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=6 * LIMIT,
                              encoding="utf-8", errors="replace")
        return done.returncode, done.stdout, time.time() - begin
    except subprocess.TimeoutExpired as late:
        out = late.stdout or b""
        return None, out.decode() if isinstance(out, bytes) else out, time.time() - begin


def judge(code, out, seconds, words, folder):
    errors = [line for line in out.splitlines() if line.startswith("ERROR")]
    found = []
    if code is None:
        return ["hangs"], errors
    if code == 0:
        found.append("exit code 0")
    if seconds > LIMIT:
        found.append("took %.1f s" % seconds)
    # LIGGGHTS' own errors at times repeat themselves with bytes it has freed already; ours must not.
    if "\ufffd" in out and any(line.startswith("ERROR: fix ") for line in errors):
        found.append("bytes that are no text: " + out[max(0, out.index("\ufffd") - 200):][:300])
    if len(errors) != 1:
        found.append("%d lines begin with ERROR" % len(errors))
    else:
        found += ["the sentence lacks '%s'" % w for w in words if w not in errors[0]]
    left = sorted(set(os.listdir(folder)) - {"in.scene", "two.spheres", "log.scene", "scene.status.json"})
    if left:
        found.append("left " + ", ".join(left))
    return found, errors


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("executable")
    parser.add_argument("ranks", type=int)
    parser.add_argument("--only", default="")
    args = parser.parse_args()
    executable = os.path.abspath(args.executable)

    bad = 0
    slowest = 0.0
    folder = tempfile.mkdtemp()
    code, out, seconds = run(executable, args.ranks, script(dict(modify=THROUGH, steps=20)), folder)
    shutil.rmtree(folder)
    print("the right script: exit code %s, %.1f s" % (code, seconds))
    if code != 0:
        print(out[-2000:])
        bad += 1

    def attempt(case):
        name, words, scene = case
        folder = tempfile.mkdtemp()
        code, out, seconds = run(executable, args.ranks, script(scene), folder, scene.get("options", ()))
        problems, errors = judge(code, out, seconds, words, folder)
        shutil.rmtree(folder)
        return name, out, seconds, problems, errors

    chosen = [case for case in CASES if args.only in case[0]]
    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        for name, out, seconds, problems, errors in pool.map(attempt, chosen):
            slowest = max(slowest, seconds)
            bad += bool(problems)
            print("%-4s %-38s %.1f s  %s" % ("BAD" if problems else "ok", name, seconds, " | ".join(errors)))
            for p in problems:
                print("         " + p)
            if problems and not errors:
                print(out[-1500:])
    print("%d wrong scripts, slowest %.1f s, %d failed" % (len(chosen), slowest, bad))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
