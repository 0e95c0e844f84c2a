#!/usr/bin/python3
"""A run that is killed goes on with its own script, unchanged: every bit of particles, fluid, means and dumps is that of the run that
was never killed. Scripts with filling, loops, if, include, run every, groups, variables of the state, reset_timestep.

Without this test what a script did before its checkpoint could be done again (particles poured twice, commands applied to particles as
they lie later, a variable read anew), or be left out, and the run would go on with something else.
Usage: same_script.py EXECUTABLE RANKS...
"""
import os
import shutil
import subprocess
import tempfile

import h5py
import numpy as np

from harness import Checks, Run, arguments, launch, long_form, narrow_bed, poured, walls

WALLS = walls(xplane=(0, 0.0216), yplane=(0, 0.0048), zplane=(0,))
POUR = poured(300).replace("run 1\n", "variable poured equal count(all)\nrun 1\n") + """\
group low region pour
variable there equal ${poured}
"""
GAS = """
reset_timestep 0
fix gas all twogrid fine 18 1 20 ratio 3 1 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 0.4 boundary zhi pressure 0
fix_modify gas boundary zlo patch jet rect 0.0096 0.0120 0 0.0048 inlet 0 0 5.0
fix_modify gas output every 40 file bed.h5 fields u p eps faces average from 0.0005
fix_modify gas checkpoint every 80 keep 9
thermo_style custom step atoms f_gas[1] f_gas[3] f_gas[4] f_gas[9] f_gas[14]
thermo_modify format float %.17g
thermo 20
dump d all custom 40 all.dump id x y z vx vy vz omegax omegay omegaz f_gas[1] f_gas[7]
dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
fix says all print 40 "$(step) $(count(low))" file says.txt screen no
"""
SCENES = {
    "one run, then another inlet": "variable blow equal ramp(3,5)\n" + GAS.replace("inlet 0 0 5.0", "inlet 0 0 v_blow") + """
run 200
fix_modify gas boundary zlo patch jet rect 0.0096 0.0120 0 0.0048 inlet 0 0 4.0
set region pour vz 0.01
run 120
""",
    "loop, if, run every": GAS + """
variable i loop 3
label again
if "$(step) < 120 && ${there} > 100" then "run 70 every 35 'set group low vx 0.001' 'print between'" "variable q${i} equal $(count(all))" else "include more.txt"
group moving region pour
next i
jump SELF again
run 100
""",
}
TWO_TYPES = {"kn": 100, "kt": 28, "gamman": 300, "gammat": 150, "coefficientFriction": 0.1}
INSERTION = """
units si
atom_style granular
newton off
communicate single vel yes
boundary f f f
processors * 1 1
region box block 0 0.0216 0 0.0048 0 0.036 units box
create_box 2 box
neighbor 0.0004 bin
neigh_modify delay 0
soft_particles yes
""" + "".join(f"fix m{i} all property/global {name} peratomtypepair 2 {v} {v} {v} {v}\n" for i, (name, v) in enumerate(TWO_TYPES.items())) + """
pair_style gran model hooke/stiffness tangential history
pair_coeff * *
timestep 1.5e-5
""" + WALLS.replace(" absolute_damping on", "") + """
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
fix ball all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.00055
fix ball2 all particletemplate/sphere 86028121 atom_type 2 density constant 1500 radius constant 0.0006
fix mix all particledistribution/discrete 32452843 2 ball 0.4 ball2 0.6
region high block 0.01 0.02 0.0007 0.0041 0.02 0.03 units box
region pour block 0.0007 0.0209 0.0007 0.0041 0.0007 0.02 units box
fix pour all insert/pack seed 49979687 distributiontemplate mix vel constant 0 0 -0.1 insert_every once overlapcheck yes all_in yes particles_in_region 200 region pour
run 1
unfix pour
fix rain all insert/rate/region seed 123457 distributiontemplate mix nparticles 600 particlerate 16000 insert_every 30 overlapcheck yes vel constant 0 0 -0.3 region high ntry_mc 1000
fix few all insert/rate/region seed 67867967 distributiontemplate mix nparticles 9 particlerate 16000 insert_every 10 overlapcheck yes vel constant 0 0 -0.3 region high ntry_mc 1000
fix face all mesh/surface/planar file face.stl type 1
fix stream all insert/stream seed 67867979 distributiontemplate mix nparticles 400 particlerate 30000 overlapcheck yes all_in no vel constant 0 0 -4 insertion_face face extrude_length 0.004
fix tilt all mesh/surface file tilt.stl type 1
fix tiltwall all wall/gran model hooke/stiffness tangential history mesh n_meshes 1 meshes tilt
fix gas all twogrid fine 18 1 20 ratio 3 1 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 0.4 boundary zhi pressure 0 formulation A
fix_modify gas output every 40 file bed.h5 fields u p eps faces average from 0.0005
fix_modify gas checkpoint every 80 keep 9
thermo_style custom step atoms f_gas[1] f_gas[3] f_gas[4] f_gas[9] f_gas[14]
thermo_modify format float %.17g
thermo 20
dump d all custom 40 all.dump id type radius x y z vx vy vz omegax omegay omegaz f_gas[1] f_gas[7]
dump_modify d sort id format "%d %d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
fix says all print 40 "$(step) $(count(all))" file says.txt screen no
run 340
"""


def plate(corners):
    a, b, d, e = corners
    facets = "".join("facet normal 0 0 1\nouter loop\n" + "".join("vertex %g %g %g\n" % q for q in t) + "endloop\nendfacet\n" for t in ((a, b, d), (a, d, e)))
    return f"solid plate\n{facets}endsolid plate\n"


PLATES = {"face.stl": plate([(0.003, 0.0008, 0.0305), (0.003, 0.004, 0.0305), (0.009, 0.004, 0.0305), (0.009, 0.0008, 0.0305)]),
          "tilt.stl": plate([(0.012, -0.001, 0.004), (0.0215, -0.001, 0.012), (0.0215, 0.006, 0.012), (0.012, 0.006, 0.004)])}
MORE = "velocity low set NULL NULL 0.02 units box\nrun 90\n"


def whole(executable, ranks, script):
    return Run(executable, script, ranks, options=("-var", "kind", "1"), files={"more.txt": MORE, **PLATES})


def checkpoints(folder):
    return sorted(os.listdir(os.path.join(folder, "in.test.checkpoints")))


def gone_on(executable, ranks, run, name, change=lambda s: s, options=("-var", "kind", "1", "-restart", "auto")):
    """In a folder as a run leaves it that is killed after checkpoint `name` and before the next: all files are there, later frames too."""
    folder = tempfile.TemporaryDirectory(prefix="twogrid_test_")
    path = os.path.join(folder.name, "run")
    shutil.copytree(run.path, path)
    for other in checkpoints(path):
        if other > name:
            shutil.rmtree(os.path.join(path, "in.test.checkpoints", other))
    with open(os.path.join(path, "in.test")) as f:
        script = change(f.read())
    with open(os.path.join(path, "in.test"), "w") as f:
        f.write(script)
    again = subprocess.run([*launch(ranks), os.path.abspath(executable), "-in", "in.test", *options], cwd=path, stdout=subprocess.PIPE,
                           stderr=subprocess.STDOUT, text=True, errors="replace", timeout=100)
    return folder, path, again


def text_of(path, name):
    with open(os.path.join(path, name)) as f:
        return f.read()


def gas(path):
    """All frames of the fluid, and the means with their batches."""
    out = {}
    with h5py.File(os.path.join(path, "bed.h5")) as f:
        for group in ("fluid", "average"):
            f[group].visititems(lambda n, d: out.__setitem__(group + "/" + n, d[...]) if isinstance(d, h5py.Dataset) else None)
    return out


def main():
    executable, ranks = arguments()
    c = Checks("the same script goes on")
    for scene, lines in {**SCENES, "insertion of three kinds, two types, plate, formulation A": INSERTION}.items():
        for n in ranks:
            script = lines if "create_box" in lines else narrow_bed() + POUR + lines
            a = whole(executable, n, script)
            names = checkpoints(a.path)
            c.true(f"{scene}, {n} ranks: {len(names)} checkpoints, all kept", len(names) >= 4)
            for name in names if long_form() else names[1::2] if n == ranks[0] else names[1:2]:
                folder, path, b = gone_on(executable, n, a, name)
                if b.returncode != 0:
                    print(b.stdout[-2000:])
                c.true(f"from {name}: code {b.returncode}", b.returncode == 0 and "goes on from the checkpoint" in b.stdout)
                c.true("particles, groups and what they know, every bit of all dumps", text_of(path, "all.dump") == text_of(a.path, "all.dump"))
                c.true("what a fix says into a file, no line twice but that of the checkpoint's step", [x for x in dict.fromkeys(text_of(path, "says.txt").splitlines())][1:] == [x for x in dict.fromkeys(text_of(a.path, "says.txt").splitlines())][1:])
                one, two = gas(a.path), gas(path)
                differ = sorted(k for k in {*one, *two} if k not in one or k not in two or not np.array_equal(one[k], two[k], equal_nan=True))
                c.true(f"fluid and means, every bit of {len(one)} datasets{': but ' + ', '.join(differ) if differ else ''}", not differ and len(one) >= 99)
                c.true("checkpoints go on", checkpoints(path) == names and os.path.exists(os.path.join(path, "log.liggghts.1")))
                folder.cleanup()
    a = whole(executable, n, narrow_bed() + POUR + GAS + "run 200\n")
    name = checkpoints(a.path)[-1]
    for what, change, options, wanted in (
            ("a line that is done is another", lambda s: s.replace("density 1.2", "density 1.3"), ("-var", "kind", "1", "-restart", "auto"), "another text in the first"),
            ("another variable", lambda s: s, ("-var", "kind", "2", "-restart", "auto"), "-var kind 2"),
            ("another script", lambda s: s, ("-var", "kind", "1", "-in", "more.txt", "-restart", "in.test.checkpoints"), "wanted in.test"),
            ("no such folder", lambda s: s, ("-var", "kind", "1", "-restart", "nowhere"), "found no whole checkpoint in nowhere"),
            ("a run that is shorter than what is done", lambda s: s.replace("run 200", "run 100"), ("-var", "kind", "1", "-restart", "auto"), "a run that ends later")):
        folder, path, b = gone_on(executable, n, a, name, change, options)
        sentence = next((line for line in b.stdout.splitlines() if line.startswith("ERROR")), "none")
        c.true(f"{what}: code {b.returncode}, {sentence[:170]}", b.returncode == 1 and wanted in sentence)
        folder.cleanup()
    clock = whole(executable, n, narrow_bed() + POUR + GAS.replace("every 80 keep 9", "every 0.0005 min folder kept/there keep 3") + "run 600\n")
    there = sorted(os.listdir(os.path.join(clock.path, "kept", "there")))
    c.true(f"by the clock, in a folder of its own: {', '.join(there)}", 1 <= len(there) <= 3)  # how many depends on the machine; 3 are kept
    folder, path, b = gone_on(executable, n, clock, "the last")
    c.true(f"found by -restart auto: code {b.returncode}", b.returncode == 0 and "goes on from the checkpoint kept/there/" + there[-1] in b.stdout)
    folder.cleanup()
    folder, path, b = gone_on(executable, n, a, name, lambda s: s.replace("run 200", "run 240"))
    c.true(f"a run that is made longer: code {b.returncode}, frames up to 240", b.returncode == 0 and "ITEM: TIMESTEP\n240\n" in text_of(path, "all.dump"))
    folder.cleanup()
    c.end()


if __name__ == "__main__":
    main()
