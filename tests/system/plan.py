#!/usr/bin/python3
"""twogrid -plan: a script with a loop, an `if`, `every`, a second scene, dumps, restarts, tables, folders and a restart file that it reads back is planned
and run. Nothing is written or touched by the plan; its scene report is that of the run; steps, particles, fluid's file, dump, tables, memory are the run's;
twice the steps take twice the time; bad scripts end it with the run's sentence and code.

What would pass falsely without it: a plan that leaves a log, a folder or an empty dump behind, writes over a result, counts the steps that it has made in
place of those that there would be, goes round a loop for ever, or calls a script good that the run refuses.
"""
import os
import re
import subprocess
import sys
import tempfile

from harness import MPIRUN, Checks, arguments, narrow_bed, poured, walls

GAS = """
fix gas all twogrid fine 18 1 20 ratio 3 1 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 v_U boundary zhi pressure 0
fix_modify gas output every 100 file {file} fields u p eps average from 0.002
"""
SCENE = narrow_bed() + poured(300) + """
variable times index 1
shell mkdir made
shell touch made/by_shell
dump d all custom 500 made/all.dump id x y z vx vy vz
restart 400 one.restart two.restart
variable U equal ramp(0,0.4)
""" + GAS.format(file="bed.h5") + """
fix_modify gas checkpoint every 10 min folder kept
variable dp equal f_gas[4]
fix table all ave/time 1 10 10 v_U v_dp file table.txt
print "a line" file said.txt
log other.log
thermo_style custom step atoms f_gas[1] f_gas[4]
thermo 500
variable i loop 3
label again
variable steps equal 100*v_i*v_times
run ${steps}
if "$i > 1" then "variable U equal 0.5"
next i
jump SELF again
run 300 every 100 "print 'a part is done'"
variable steps equal 1000*${times}
run ${steps} upto
write_restart bed.restart
fix_modify gas checkpoint write bed.checkpoint.h5
write_data bed.data
clear
units si
atom_style granular
newton off
communicate single vel yes
processors * * *
boundary f f f
read_restart bed.restart
neighbor 0.0005 bin
fix m3 all property/global kn peratomtypepair 1 100
fix m4 all property/global kt peratomtypepair 1 100
fix m5 all property/global gamman_abs peratomtypepair 1 0.01
fix m6 all property/global gammat_abs peratomtypepair 1 0.005
fix m7 all property/global coefficientFriction peratomtypepair 1 0.1
pair_style gran model hooke/stiffness tangential history absolute_damping on
pair_coeff * *
timestep 1.5e-5
""" + walls(xplane=(0, 0.0216), yplane=(0, 0.0048), zplane=(0,)) + """
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
variable U equal 0.4
""" + GAS.format(file="second.h5") + """
fix_modify gas checkpoint read bed.checkpoint.h5
run 200
run_time 0.0015
"""


def run(executable, folder, script, ranks=1, options=(), name="in.test"):
    """Code, what was said, largest memory of all processes (MB)."""
    with open(os.path.join(folder, name), "w") as f:
        f.write(script)
    # Of a small process' children: Linux counts what the parent had before them.
    measured = "import resource, subprocess, sys; c = subprocess.call(sys.argv[1:]); print('MEMORY', resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss); sys.exit(c)"
    command = [sys.executable, "-c", measured] + ([*MPIRUN, "-np", str(ranks)] if ranks > 1 else []) + [os.path.abspath(executable), "-in", name, *options]
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=100)
    return done.returncode, done.stdout, float(re.search(r"MEMORY (\d+)", done.stdout).group(1)) / 1000


def listing(folder):
    """Every name below it, with size, time of its last change and content's beginning."""
    found = {}
    for top, names, files in os.walk(folder):
        for n in names + files:
            path = os.path.join(top, n)
            s = os.stat(path)
            found[os.path.relpath(path, folder)] = (s.st_size, s.st_mtime_ns, s.st_ino)
    return found


def scenes(text):
    """The scene reports in an output."""
    reports, inside = [], False
    for line in text.splitlines():
        if line.startswith("twogrid: the scene of fix"):
            reports.append([])
            inside = True
        inside = inside and (line.startswith("  ") or line.startswith("twogrid: the scene"))
        if inside:
            reports[-1].append(line)
    return reports


def planned(text):
    """Rows of the table of runs: line, steps, particles; seconds of all; bytes by file; memory (MB)."""
    rows = [(m.group(1).strip(), int(m.group(2)), int(m.group(3))) for m in re.finditer(r"^ +\d+  (\S.*?)  +(?:at most )?(\d+) +(\d+) +\S+ +.*%$", text, re.M)]
    units = {"B": 1, "kB": 1e3, "MB": 1e6, "GB": 1e9}
    files = {m.group(1): float(m.group(2)) * units[m.group(3)] for m in re.finditer(r"^    (\S+) +([\d.e+]+) (B|kB|MB|GB)\b", text, re.M)}
    memory = re.search(r"^  memory +([\d.]+) MB", text, re.M)
    return rows, files, float(memory.group(1)) if memory else 0.0


def good_script(c, executable, ranks):
    for n in ranks:
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "tmp"))
            os.environ["TMPDIR"] = os.path.join(folder, "tmp")
            with open(os.path.join(folder, "in.test"), "w") as f:
                f.write(SCENE)
            before = listing(folder)
            code, text, memory = run(executable, folder, SCENE, n, ("-plan",))
            after = listing(folder)
            changed = sorted(k for k in {*before, *after} if before.get(k) != after.get(k) and not k.startswith(("in.test", "tmp/ompi")) and k != "tmp")
            c.true(f"{n} ranks: plan ends with {code}; files made or changed: {', '.join(changed) or 'none'}", code == 0 and not changed)
            rows, files, said = planned(text)
            wanted = [1, 100, 200, 300, 300, 99, 200, 100]
            c.true(f"steps {[r[1] for r in rows]}, wanted {wanted}", [r[1] for r in rows] == wanted)
            c.true(f"particles {sorted({r[2] for r in rows})}", {r[2] for r in rows} == {300})

            code, output, real = run(executable, folder, SCENE, n)
            c.true(f"the run itself: code {code}", code == 0)
            c.true(f"scene reports: {len(scenes(text))}, as the run's", len(scenes(text)) == 2 and scenes(text) == scenes(output))
            for name, bound in (("bed.h5", 0.02), ("second.h5", 0.02), ("made/all.dump", 0.1), ("table.txt", 0.6), ("bed.restart", 0.02), ("bed.data", 0.1), ("one.restart", 0.3), ("bed.checkpoint.h5", 0.02), ("other.log", 0.5)):
                size = os.path.getsize(os.path.join(folder, name))
                c.below(f"{name}: {files.get(name, 0):.3g} bytes planned, {size:.3g} written; relative", abs(files.get(name, 0) / size - 1), bound)
            c.below(f"memory: {said} MB planned, {real:.1f} MB of the largest process; relative", abs(said / real - 1), 0.15)
            left = [f for f in os.listdir(os.path.join(folder, "tmp")) if f.startswith("twogrid_plan")]
            c.true(f"folders of the moment that are left: {left or 'none'}", not left)
            # Results stay as they are.
            before = listing(folder)
            code, text, _ = run(executable, folder, SCENE, n, ("-plan",))
            after = listing(folder)
            changed = sorted(k for k in {*before, *after} if before.get(k) != after.get(k) and not k.startswith(("in.test", "tmp/ompi")) and k != "tmp")
            c.true(f"again, beside the run's results: changed {', '.join(changed) or 'none'}; says what is there: {'bed.h5' in text and 'would end' in text}",
                   code == 0 and not changed and "would end at its beginning" in text)
            del os.environ["TMPDIR"]


def long_script(c, executable):
    """Runs that are cut: their steps, their particles that are still to come, and time in proportion."""
    with tempfile.TemporaryDirectory() as folder:
        took = []
        for times in ("300", "600"):
            code, text, _ = run(executable, folder, SCENE, 1, ("-plan", "1", "-var", "times", times))
            rows, files, _ = planned(text)
            n = int(times)
            wanted = [1, 100 * n, 200 * n, 300 * n, 300, 1000 * n - 600 * n - 301, 200, 100]
            c.true(f"times {times}: code {code}, steps {[r[1] for r in rows]}, wanted {wanted}", code == 0 and [r[1] for r in rows] == wanted)
            took.append(seconds(text))
            # A frame in every 100 steps, and the first.
            frames = re.search(r"bed.h5 .* (\d+) frames", text)
            c.true(f"frames {frames and frames.group(1)}, wanted {10 * n + 1}", bool(frames) and int(frames.group(1)) == 10 * n + 1)
        c.true(f"twice the steps: {took[0]:.4g} and {took[1]:.4g} s, ratio {took[1] / took[0]:.2f} (wanted 1.2 to 3.3; the machine's own changes)", 1.2 < took[1] / took[0] < 3.3)

        pouring = INSERTION.replace("EVERY", "500").replace("RATE", "2000")
        code, text, _ = run(executable, folder, pouring, 1, ("-plan", "1"))
        rows, _, _ = planned(text)
        # 2000 particles a second: the first at step 1, each 500 steps of 1.5e-5 s then 15 of them, up to 700.
        wanted = [(40000, 700), (20000, 700)]
        c.true(f"insertion by and by: steps and particles {[r[1:] for r in rows]}, wanted {wanted}", code == 0 and [r[1] for r in rows] == [40000, 20000] and
               all(abs(r[2] - w[1]) <= 15 for r, w in zip(rows, wanted)))


INSERTION = narrow_bed() + """
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
fix ball all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.0004
fix mix all particledistribution/discrete 32452843 1 ball 1.0
region pour block 0.0007 0.0209 0.0007 0.0041 0.02 0.034 units box
fix pour all insert/rate/region seed 49979687 distributiontemplate mix vel constant 0 0 -0.1 insert_every EVERY overlapcheck yes all_in yes &
    nparticles 700 particlerate RATE region pour
thermo_style custom step atoms
run 40000
fix gas all twogrid fine 18 1 20 ratio 3 1 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 0.3 boundary zhi pressure 0
run 20000
"""


def bad_scripts(c, executable, ranks):
    """The plan ends with the sentence and the code of the run."""
    head, tail = SCENE.split("shell mkdir made\n")
    bad = {"a command that there isn't": SCENE.replace("variable times", "sing a song\nvariable times"),
           "a restart file that isn't there": SCENE.replace("read_restart bed.restart", "read_restart none.restart"),
           "a folder that isn't there": head + tail.replace("shell touch made/by_shell\n", "").replace("made/", "").replace("file bed.h5", "file nowhere/bed.h5"),
           "a checkpoint that isn't there": SCENE.replace("checkpoint read bed.checkpoint.h5", "checkpoint read none.h5"),
           "a keyword that there isn't": SCENE.replace("fields u p eps", "fields u p heat"),
           "a ratio that doesn't divide": SCENE.replace("ratio 3 1 2", "ratio 4 1 2"),
           "a variable that there isn't": SCENE.replace("inlet 0 0 v_U", "inlet 0 0 v_V"),
           "a table in a folder that isn't there": SCENE.replace("file table.txt", "file nowhere/table.txt").replace("shell touch made/by_shell\n", "")}
    for n in ranks[-1:]:
        for what, script in bad.items():
            with tempfile.TemporaryDirectory() as folder:
                found = []
                for options in (("-plan", "1"), ()):
                    code, text, _ = run(executable, folder, script, n, options)
                    sentence = next((line for line in text.splitlines() if line.startswith("ERROR")), "none")
                    found.append((code, sentence))
                c.true(f"{what}: code {found[0][0]}, {found[0][1][:130]}", found[0][0] != 0 and found[0][1] != "none" and same(found[0], found[1]))
                if not same(found[0], found[1]):
                    c.note(f"the run: code {found[1][0]}, {found[1][1]}")


def same(a, b):
    """Codes, and sentences up to their reasons."""
    return a[0] == b[0] and a[1].split("(")[0] == b[1].replace(".part", "").split("(")[0]


def seconds(text):
    """Of the line `time`."""
    said = re.search(r"^  time +(?:about|at most) (.*?) on \d+ rank", text, re.M).group(1)
    units = {"s": 1, "min": 60, "h": 3600, "days": 86400}
    return sum(float(m.group(1)) * units[m.group(2)] for m in re.finditer(r"([\d.e+-]+) (s|min|h|days)", said))


def main():
    executable, ranks = arguments()
    c = Checks("a script that is planned")
    good_script(c, executable, ranks)
    long_script(c, executable)
    bad_scripts(c, executable, ranks)
    c.end()


main()
