#!/usr/bin/python3
"""What a script may do between and before runs, and what LIGGGHTS does beside the fluid: atom types that nothing uses yet, `clear`, `run N pre no`,
regions made anew, reset_timestep, several fixes gravity and such that follow a variable, LIGGGHTS' own fluid forces, a fix for a group, restart files of
another fix, errors of LIGGGHTS' own, boxes with many more neighbour bins than particles.

Wanted values: LIGGGHTS' own kernels (-particles stock) to the last bit; the same script without the command in question; for gravity the sinking speed
of a sphere by Schiller & Naumann (1935). Without this test each of these could end in a segmentation fault, be taken in silence for something else, or
lose its sentence where the output is no terminal.
Usage: script_commands.py EXECUTABLE RANKS...
"""
import os
import re
import subprocess
import tempfile

import h5py
import numpy as np

import harness
from harness import Checks, arguments

HEAD = """
units si
atom_style granular
newton off
communicate single vel yes
boundary f f f
region box block {box} units box
create_box {types} box
neighbor {skin} bin
neigh_modify delay 0
soft_particles yes
fix kn all property/global kn peratomtypepair {types} {kn}
fix kt all property/global kt peratomtypepair {types} {kt}
fix gn all property/global gamman peratomtypepair {types} {gn}
fix gt all property/global gammat peratomtypepair {types} {gt}
fix mu all property/global coefficientFriction peratomtypepair {types} {mu}
pair_style gran model hooke/stiffness tangential history
pair_coeff * *
timestep {dt}
"""
DUMP = """
dump out all custom 1 {name}.* id x y z vx vy vz omegax omegay omegaz
dump_modify out format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g" sort id first no
run 1
undump out
"""


def Run(executable, script, ranks=1, options=(), **more):
    """One rank is started without mpirun, which takes longer than most of these runs."""
    return harness.Run(executable, script, ranks, options, **more)


def head(box, dt=2e-5, skin=4e-4, types=1):
    def table(first):  # symmetric, every pair of its own
        return " ".join(repr(first * (1 + 0.25 * (i + j) + 0.1 * i * j)) for i in range(types) for j in range(types))
    return HEAD.format(box=box, dt=dt, skin=skin, types=types, kn=table(100), kt=table(30), gn=table(500), gt=table(250), mu=table(0.2))


def state(run, name):
    step = max(int(f.rsplit(".", 1)[1]) for f in os.listdir(run.path) if f.startswith(name + ".") and f.rsplit(".", 1)[1].isdigit())
    return np.loadtxt(run.file(f"{name}.{step}"), skiprows=9, ndmin=2)


def same(a, b):
    return a.shape == b.shape and np.array_equal(a.view(np.int64), b.view(np.int64))


def unused_types(c, executable):
    floor = "fix floor all wall/gran model hooke/stiffness tangential history primitive type {} zplane 0\n"
    begin = head("0 0.01 0 0.01 0 0.01", types=4) + """
fix weight all gravity 9.81 vector 0.3 0 -1
fix motion all nve/sphere
create_atoms 1 single 0.003 0.005 0.0006 units box
create_atoms 1 single 0.0042 0.005 0.0006 units box
create_atoms 1 single 0.0054 0.005 0.0007 units box
set group all diameter 1.2e-3 density 2500
"""
    later = DUMP.format(name="one") + "set atom 2 type 2\nrun 200\n" + DUMP.format(name="two") + "set atom 1 type 4\nrun 200\n" + DUMP.format(name="four")
    for title, text in (("walls of type 1", begin + floor.format(1)), ("a wall of type 3", begin + floor.format(3)), ("no wall", begin)):
        stock, ours = [Run(executable, text + "run 200\n" + later, 1, ["-particles", kernel]) for kernel in ("stock", "auto")]
        for name in ("one", "two", "four"):
            c.true(f"types declared, not in use, {title}, highest type in use {name}: LIGGGHTS' bits", same(state(stock, name), state(ours, name)))
    c.true("the types' laws are felt", not same(state(ours, "one")[:, 4:], state(ours, "four")[:, 4:]))


BEADS = head("0 0.008 0 0.008 0 0.016", dt=1e-5) + """
fix floor all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
lattice sc 1.0e-3 origin 0.5 0.5 0.5
region low block 0 0.008 0 0.008 0 0.004 units box
create_atoms 1 region low
set group all diameter 1.01e-3
set group all density 2500
region hole block 0.002 0.006 0.002 0.006 -1 1 units box
"""
GAS = """
fix gas all twogrid fine 8 8 16 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 {U} boundary zhi pressure 0
fix_modify gas boundary zlo patch jet region hole inlet 0 0 2
fix_modify gas output every 50 file {name}.h5
thermo_style custom step f_gas[1] f_gas[4]
thermo 50
"""


def clear(c, executable, ranks):
    """A study of three velocities in one script, and the second and third alone."""
    whole = "variable U index 0.2 0.4 0.6\nvariable i loop 3\nlabel next\n" + BEADS + GAS.format(U="$U", name="gas$i") + "run 99\n" + DUMP.format(
        name="end$i") + "clear\nnext U\nnext i\njump in.test next\n"
    for n in ranks:
        study = Run(executable, whole, n)
        c.true(f"clear, {n} ranks: our kernel in every part", study.output.count("twogrid's kernel") == 3)
        for i, U in ((2, 0.4), (3, 0.6)):
            alone = Run(executable, BEADS + GAS.format(U=U, name="gas") + "run 99\n" + DUMP.format(name="end"), n)
            c.true(f"clear, {n} ranks: the bits of part {i} alone", same(state(study, f"end{i}"), state(alone, "end")))
            with h5py.File(study.file(f"gas{i}.h5")) as a, h5py.File(alone.file("gas.h5")) as b:
                c.true("its frames", list(a["fluid"]) == list(b["fluid"]) and all(np.array_equal(a["fluid"][f]["p"][()], b["fluid"][f]["p"][()]) for f in a["fluid"]))


def map_of_identifiers(c, executable, ranks):
    """Nothing here asks for it: the same bits of particles and fluid with and without."""
    for n in ranks:
        runs = [Run(executable, BEADS.replace("newton off", f"newton off\n{line}") + GAS.format(U=0.5, name="gas") + "run 500\n" + DUMP.format(name="end"), n)
                for line in ("", "atom_modify map array", "atom_modify map hash")]
        bits = state(runs[0], "end")
        c.true(f"atom_modify map, {n} ranks: {len(bits)} particles move", np.ptp(bits[:, 6]) > 1e-2)
        for other, name in ((runs[1], "array"), (runs[2], "hash")):
            c.true(f"atom_modify map {name}, {n} ranks: the particles' bits without", same(bits, state(other, "end")))
            with h5py.File(runs[0].file("gas.h5")) as a, h5py.File(other.file("gas.h5")) as b:
                last = sorted(a["fluid"])[-1]
                c.true("the fluid's", all(np.array_equal(a["fluid"][last][q][()], b["fluid"][last][q][()]) for q in ("u", "p", "eps")))


def ends_with(c, executable, what, script, *sentence):
    run = Run(executable, script, 1, expect_success=False)
    line = next((s for s in run.output.split("\n") if "ERROR" in s), "")
    if not c.true(f"{what}: a sentence", run.code == 1 and all(s in line for s in sentence)):
        c.note(f"code {run.code}: {line}")


def commands_between_runs(c, executable):
    gas = GAS.format(U=0.2, name="gas")
    old = ("run: found 'pre no'", "leave 'pre no' out")
    ends_with(c, executable, "run N pre no first after the fix", BEADS + "run 1\n" + gas + "run 40 pre no\n", *old)
    ends_with(c, executable, "run 0 pre no first after the fix", BEADS + "run 1\n" + gas + "run 0 pre no\n", *old)
    ends_with(c, executable, "pre no after fix_modify", BEADS + gas + "run 10\nfix_modify gas boundary zlo inlet 0 0 0.3\nrun 10 pre no\n", *old)
    ends_with(c, executable, "pre no after the fix was made anew", BEADS + gas + "run 10\nunfix gas\n" + gas.replace("gas.h5", "b.h5") + "run 10 pre no\n", *old)
    ends_with(c, executable, "pre no after the fix was deleted", BEADS + gas + "run 10\nthermo_style one\nunfix gas\nrun 10 pre no\n", *old)
    ends_with(c, executable, "a change in run ... every", BEADS + gas + "run 10\nrun 20 pre no every 10 'fix_modify gas boundary zlo inlet 0 0 0.3'\n", *old)
    anew = "region hole delete\nregion hole block {} 0.006 0.002 0.006 -1 1 units box\n"
    ends_with(c, executable, "a patch's region made anew, another shape", BEADS + gas + "run 50\n" + anew.format(0.003) + "run 50\n", "patch jet region", "another shape")
    ends_with(c, executable, "a patch's region deleted", BEADS + gas + "run 50\nregion hole delete\nrun 50\n", "patch jet region", "no region of that id")
    plain = Run(executable, BEADS + gas + "run 50\nrun 50\n", 1).thermo()
    again = Run(executable, BEADS + gas + "run 50\n" + anew.format(0.002) + "run 50\n", 1).thermo()
    c.true("the same shape made anew: the same pressure", all(np.array_equal(plain[k], again[k]) for k in plain))
    reset = Run(executable, BEADS + "run 3\n" + gas + "reset_timestep 0\nrun 100\n", 1).thermo()
    c.true("reset_timestep before the first run", reset["Step"][-1] == 100 and abs(reset["gas[1]" if "gas[1]" in reset else "f_gas[1]"][-1] - 1e-3) < 1e-12)
    ends_with(c, executable, "reset_timestep after a run", BEADS + gas + "run 10\nreset_timestep 0\nrun 10\n", "reset_timestep: found", "unfix gas")
    for other in ("buoyancy density 1000 dim z level 0.2", "couple/cfd couple_every 10 mpi"):
        ends_with(c, executable, "fix " + other.split()[0], BEADS + f"fix other all {other}\n" + gas + "run 1\n", "found fix other", "twice")
    ends_with(c, executable, "fix buoyancy added later", BEADS + gas + "run 1\nfix other all buoyancy density 1000 dim z level 0.2\nrun 1\n", "fix other buoyancy", "twice")
    viscous = Run(executable, BEADS + "fix slow all viscous 1e-6\n" + gas + "run 1\n", 1)
    c.true("fix viscous: a warning", "WARNING: fix gas twogrid: fix slow viscous" in viscous.output)


def group_and_restart(c, executable):
    some = BEADS + "region part block 0 0.008 0 0.008 0 0.002 units box\ngroup part region part\n" + GAS.format(U=0.2, name="gas")
    text = Run(executable, some.replace("fix gas all", "fix gas part") + "run 1\n", 1).output
    c.true("a fix for a group: the others are counted", re.search(r"outside the group\s+128 particles", text) is not None)
    c.true("none outside: no word of it", "outside the group" not in Run(executable, some + "run 1\n", 1).output)
    first = Run(executable, BEADS + GAS.format(U=0.2, name="gas") + "run 20\nwrite_restart at20\n", 1)
    create = re.search(r"region box .*\ncreate_box .*\n", BEADS).group(0)
    made = BEADS[BEADS.index("lattice"):BEADS.index("region hole")]
    leg = BEADS.replace(create, f"read_restart {first.file('at20')}\n").replace(made, "") + GAS.format(U=0.2, name="b")
    own = Run(executable, leg + "run 1\n", 1).output
    other = Run(executable, leg.replace(" gas ", " air ").replace("f_gas", "f_air") + "run 1\n", 1).output
    c.true("restart, the same ID: as before", "come from a restart file" in own and "of ID" not in own)
    c.true("restart, another ID: a warning", "holds what a fix twogrid of ID gas knew" in other)


def sinking_speed(d, rho_p, rho_f, mu, g):
    """Schiller & Naumann: C_D = 24/Re (1 + 0.15 Re^0.687)."""
    low, high = 0.0, 10.0
    for _ in range(200):
        w = 0.5 * (low + high)
        Re = rho_f * w * d / mu
        drag = 3 * np.pi * mu * d * w * (1 + 0.15 * Re**0.687)
        low, high = (w, high) if drag < (rho_p - rho_f) * g * np.pi / 6 * d**3 else (low, w)
    return w


def weights(c, executable, ranks):
    sphere = head("0 0.032 0 0.032 0 0.064", dt=1e-4, skin=1e-3) + """
create_atoms 1 single 0.016 0.016 0.032 units box
set group all diameter 1e-3
set group all density 1500
group none id 999
group one id 1
variable half equal 9.81/2
variable later equal 9.81*(step>=0)
variable down equal -1
{weights}
fix m all nve/sphere
fix gas all twogrid fine 4 4 8 density 1000 viscosity 1e-3 every 10
fix_modify gas drag schiller/naumann one-way yes boundary zhi pressure 0 formulation {form}
variable v equal vcm(all,z)
thermo_style custom step v_v
thermo 1000
run 2000
"""
    wanted = sinking_speed(1e-3, 1500, 1000, 1e-3, 9.81)
    fix = "fix {} {} gravity {} vector 0 0 {}\n"
    scenes = {
        "one for all": fix.format("a", "all", 9.81, -1),
        "a second one for a group without particles": fix.format("a", "all", 9.81, -1) + fix.format("b", "none", 9.81, -1),
        "one for a group": fix.format("a", "one", 9.81, -1),
        "halves, for all and for a group": fix.format("a", "all", "${half}", -1) + fix.format("b", "one", "${half}", -1),
        "magnitude by a variable": fix.format("a", "all", "v_later", -1),
        "direction by a variable, group": fix.format("a", "one", 9.81, "v_down") + fix.format("b", "none", 30, "v_down"),
        "half by a variable": fix.format("a", "all", "v_half", -1) + fix.format("b", "one", "${half}", -1),
    }
    runs = [(name, form) for name in scenes for form in ("BA" if name.startswith("halves") else "B")]
    text = "clear\n".join(sphere.format(weights=scenes[name], form=form) for name, form in runs)
    for n in ranks:
        t = Run(executable, text, n).thermo()
        for (name, form), v in zip(runs, t["v" if "v" in t else "v_v"][t["Step"] == 2000]):
            c.below(f"gravity, {name} ({form}, {n} ranks): sinking speed against {wanted:.5f} m/s", abs(-v / wanted - 1), 2e-4)


RUN = """create_atoms 1 single 0.005 0.005 0.005 units box
set group all diameter 1e-3 density 2500
variable left equal sqrt(5.5-step)
fix q all print 1 "${left}"
run 10"""


def sentences(c, executable):
    """LIGGGHTS' own errors: without mpirun, output into a file."""
    for what, line, wanted in (("of one rank", "region r block 0 ${nope} 0 1 0 1 units box", "Substitution for illegal variable"),
                               ("of all ranks", "pair_style nonsense", "pair style"), ("in a run", RUN, "Sqrt of negative"),
                               ("of a folder", 'fix t all print 1 "x" file out/t.txt', "annot open(.|\\n)*there is no folder out for the file out/t.txt.*shell mkdir out")):
        with tempfile.TemporaryDirectory(prefix="twogrid_test_") as folder:
            with open(os.path.join(folder, "in.test"), "w") as f:
                f.write(head("0 0.01 0 0.01 0 0.01") + line + "\n")
            with open(os.path.join(folder, "screen"), "w") as screen:
                done = subprocess.run([os.path.abspath(executable), "-in", "in.test"], cwd=folder, stdout=screen, stderr=subprocess.DEVNULL, timeout=60)
            for name in ("screen", "log.liggghts"):
                text = open(os.path.join(folder, name), errors="replace").read()
                c.true(f"an error of LIGGGHTS' own, {what}: in {name}", done.returncode != 0 and re.search("ERROR.*" + wanted, text) is not None)


def instructions(executable, scene, kernel):
    with tempfile.TemporaryDirectory(prefix="twogrid_test_") as folder:
        with open(os.path.join(folder, "in.test"), "w") as f:
            f.write(scene)
        done = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", os.path.abspath(executable), "-in", "in.test", "-particles", kernel],
                              cwd=folder, env={**os.environ, "OMP_NUM_THREADS": "1"}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return int(re.search(r"Collected : (\d+)", done.stdout).group(1))


def sparse_box(c, executable, ranks):
    """64 beads, some of which touch, in 4e5 bins; new lists in every step."""
    scene = head("0 0.05 0 0.05 0 0.05", skin=4e-4).replace("neigh_modify delay 0", "neigh_modify delay 0 every 1 check no") + """
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
lattice sc 1.05e-3 origin 0.5 0.5 0.5
region low block 0.02 0.0242 0.02 0.0242 0.02 0.0242 units box
create_atoms 1 region low
set group all diameter 1.0e-3
set group all density 2500
velocity all set -0.3 0 0.1
region left block 0 0.0221 INF INF INF INF units box
group left region left
velocity left set 0.4 0.05 0
"""
    for n in ranks:
        stock, ours = [Run(executable, scene + "run 150\n" + DUMP.format(name="end"), n, ["-particles", kernel]) for kernel in ("stock", "auto")]
        c.true(f"many bins, few particles, {n} ranks: LIGGGHTS' bits", same(state(stock, "end"), state(ours, "end")) and len(state(ours, "end")) >= 64)
    # In instructions, since seconds depend on what else the machine does. Set-up falls out.
    count = {kernel: instructions(executable, scene + "run 30\n", kernel) - instructions(executable, scene + "run 10\n", kernel) for kernel in ("stock", "auto")}
    c.below("instructions of a step with new lists over LIGGGHTS' own", count["auto"] / count["stock"], 1.1)


def main():
    executable, ranks = arguments()
    c = Checks("commands of the script, and LIGGGHTS beside the fluid")
    unused_types(c, executable)
    clear(c, executable, ranks)
    map_of_identifiers(c, executable, ranks)
    commands_between_runs(c, executable)
    group_and_restart(c, executable)
    weights(c, executable, ranks)
    sentences(c, executable)
    sparse_box(c, executable, ranks)
    c.end()


if __name__ == "__main__":
    main()
