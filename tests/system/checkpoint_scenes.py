#!/usr/bin/python3
"""A run that goes on in another process from a restart file and a checkpoint, in scenes in which much is kept beside the particles and the
fluid: particles of two types that are thrown in all the time, a wall of triangles, borders between ranks that follow the particles, steps
chosen by `accuracy` and `every auto`. Every bit of particles, fluid and figures is that of the run that was never left.

Without this test the borders could begin as LIGGGHTS sets them and the particles lie in another order in memory, so that contact forces are
summed in another order; steps could be chosen anew by the particles as they lie now; what `accuracy` has learned could be lost.
Usage: checkpoint_scenes.py EXECUTABLE RANKS... [--long]
"""
import re
import sys

import h5py
import numpy as np

from harness import Checks, Run, arguments, data_file

DT = 1e-5
HEAD = """
units si
atom_style granular
newton off
communicate single vel yes
processors {processors}
boundary {boundary}
{create}
neighbor {skin} bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 1e7 1e7
fix m2 all property/global poissonsRatio peratomtype 0.3 0.3
fix m3 all property/global kn peratomtypepair 2 100 120 120 150
fix m4 all property/global kt peratomtypepair 2 100 120 120 150
fix m5 all property/global gamman_abs peratomtypepair 2 0.01 0.01 0.01 0.01
fix m6 all property/global gammat_abs peratomtypepair 2 0.005 0.005 0.005 0.005
fix m7 all property/global coefficientFriction peratomtypepair 2 0.1 0.2 0.2 0.3
pair_style gran model hooke/stiffness tangential history absolute_damping on
pair_coeff * *
timestep 1e-5
"""
WALL = "fix {id} all wall/gran model hooke/stiffness tangential history primitive type 1 {plane} {at!r} absolute_damping on\n"
PLATE = """solid plate
facet normal 0.5 0 -0.8
outer loop
vertex 0.001 -0.001 0.001
vertex 0.001 0.009 0.001
vertex 0.006 -0.001 0.004
endloop
endfacet
facet normal 0.5 0 -0.8
outer loop
vertex 0.006 0.009 0.004
vertex 0.006 -0.001 0.004
vertex 0.001 0.009 0.001
endloop
endfacet
endsolid plate
"""
# Of two triangles, at z = 6.5 mm.
FACE = """solid face
facet normal 0 0 -1
outer loop
vertex 0.0008 0.0008 0.0065
vertex 0.0008 0.0035 0.0065
vertex 0.0035 0.0035 0.0065
endloop
endfacet
facet normal 0 0 -1
outer loop
vertex 0.0008 0.0008 0.0065
vertex 0.0035 0.0035 0.0065
vertex 0.0035 0.0008 0.0065
endloop
endfacet
endsolid face
"""
MESH = """fix plate all mesh/surface file plate.stl type 2
fix plates all wall/gran model hooke/stiffness tangential history mesh n_meshes 1 meshes plate absolute_damping on
"""
GRAINS = """fix small all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.0004
fix large all particletemplate/sphere 15485867 atom_type 2 density constant 1500 radius constant 0.0006
fix both all particledistribution/discrete 32452843 2 small 0.6 large 0.4
region top block 0.001 0.007 0.001 0.007 0.010 0.015 units box
"""
RATE = GRAINS + "fix pour all insert/rate/region seed 32452867 distributiontemplate both nparticles 500 particlerate 40000 insert_every 60 overlapcheck yes vel constant 0 0 -0.5 region top ntry_mc 10000\n"
PACK = GRAINS + "fix pour all insert/pack seed 32452867 distributiontemplate both maxattempt 50 insert_every 70 overlapcheck yes all_in yes vel uniform -0.1 -0.1 -0.5 0.1 0.1 -0.4 region top volumefraction_region 0.08 ntry_mc 10000\n"
BED = "boundary zlo inlet 0 0 0.6 boundary zhi pressure 0"
BOX = "0 0.008 0 0.008 0 0.016"


class Scene:
    """gas: keywords of fix twogrid, after them of fix_modify. other: lines of walls, meshes, insertion. steps: of the two runs."""

    def __init__(self, gas, modify=BED, other="", box=BOX, fine="8 8 16", layers=8, boundary="p p f", steps=(205, 200), options=(), cut=None, output=100, between="", speed=0.0, skin=0.4e-3):
        self.__dict__.update(locals())

    def script(self, create, ranks, name, middle):
        cut = (self.cut or {}).get(ranks, "* * *")
        return HEAD.format(create=create, processors=cut, boundary=self.boundary, skin=self.skin) + f"""
{WALL.format(id='floor', plane='zplane', at=0.0) if self.boundary.endswith('f') else ''}fix weight all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
{self.other}fix gas all twogrid fine {self.fine} ratio 4 4 4 {self.gas}
fix_modify gas {self.modify}
fix_modify gas output every {self.output} file {name}.h5 fields u p eps faces
thermo_style custom step atoms ke f_gas[1] f_gas[2] f_gas[3] f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[8] f_gas[9] f_gas[10] f_gas[11] f_gas[12] f_gas[13] f_gas[14] f_gas[15] f_gas[16]
thermo_modify format float %.17g lost ignore
thermo 5
{middle}dump bits all custom {self.steps[1] // 2} {name}.*.dump id type x y z vx vy vz omegax omegay omegaz radius mass f_gas[1] f_gas[3] f_gas[6] f_gas[7] f_gas[10]
dump_modify bits sort id first no format "%d %d{14 * ' %.17g'} %.17g %.17g"
run {self.steps[1]}
"""

    def particles(self):
        lo = [float(w) for w in self.box.split()]
        nx, ny = int((lo[1] + 1e-9) / 1.3e-3), int((lo[3] + 1e-9) / 1.3e-3)
        return [(1.3e-3 * (i + 0.5), 1.3e-3 * (j + 0.5), 1e-3 * (1.05 * k + 0.7)) for k in range(self.layers) for j in range(ny) for i in range(nx)]

    def first(self, executable, ranks):
        x = self.particles()
        v = np.random.default_rng(2).uniform(-0.05, 0.05, (len(x), 3)) + [0, 0, self.speed]
        data = data_file(self.box, x, 1e-3, 2500, v).replace("1 atom types", "2 atom types")
        middle = f"run {self.steps[0]}\nwrite_restart half\nfix_modify gas checkpoint write half.h5\n{self.between}"
        return Run(executable, self.script("read_data particles.data", ranks, "one", middle), ranks, self.options,
                   files={"particles.data": data, "plate.stl": PLATE, "face.stl": FACE})

    def second(self, executable, ranks, before, middle="", expect_success=True, left_out=None):
        middle = f"fix_modify gas checkpoint read {before.file('half.h5')}\n{self.between}" + middle
        return Run(executable, self.script(f"read_restart {before.file('half')}", ranks, "two", middle), ranks, self.options, files={"plate.stl": PLATE, "face.stl": FACE}, expect_success=expect_success,
                   environment={"TWOGRID_CHECKPOINT_LEAVE_OUT": left_out} if left_out else {})


AIR, LIQUID = "density 1.2 viscosity 1.8e-5 every 10", "density 1000 viscosity 1e-3 every 10"
SCENES = {
    "two types, thrown in at a rate, plate": Scene(AIR, other=MESH + RATE),
    "packs, formulation A": Scene(AIR, BED + " formulation A", other=PACK),
    "borders that move": Scene(AIR, other="", box="0 0.0026 0 0.0026 0 0.128", fine="4 4 64", layers=24, cut={2: "1 1 2", 4: "1 1 4"}),
    "accuracy, every auto": Scene("density 1.2 viscosity 1.8e-5 every auto", BED + " accuracy 0.003", steps=(405, 400)),
}


def fields(run, name):
    """By step."""
    with h5py.File(run.file(name + ".h5")) as f:
        out = {}
        for frame in f["fluid"].values():
            out[int(frame["step"][()])] = found = {}
            frame.visititems(lambda n, d: found.__setitem__(n, d[...]) if isinstance(d, h5py.Dataset) and d.dtype == np.float64 else None)
        return out


def frame_steps(run, name):
    with h5py.File(run.file(name + ".h5")) as f:
        return [int(f["fluid"][k]["step"][()]) for k in sorted(f["fluid"])]


def same(a, b):
    return a.shape == b.shape and a.dtype == b.dtype and np.array_equal(a.view(np.int64), b.view(np.int64))


def differences(scene, a, b):
    """What differs in the second run, in words; empty: no bit."""
    out = []
    steps = [scene.steps[0] + n for n in range(1, scene.steps[1] + 1) if (scene.steps[0] + n) % (scene.steps[1] // 2) == 0]
    for step in steps:
        one, two = (open(r.file(f"{n}.{step}.dump")).read() for r, n in ((a, "one"), (b, "two")))
        if one != two or "ITEM" not in one:
            out.append(f"particles at step {step}")
    one, two = fields(a, "one"), fields(b, "two")
    for at in sorted(two, reverse=True):
        x, y = one.get(at, {}), two[at]
        differ = [f"fluid {k} at {at}" for k in sorted(set(x) | set(y)) if k not in x or k not in y or not same(x[k], y[k])]
        out += differ if at == max(two) else differ[:1]
    s, t = a.thermo(), b.thermo()
    first = np.flatnonzero(s["Step"] == scene.steps[0])[-1]
    for name in s:
        x, y = s[name][first:], t[name]
        if not same(x, y):
            n = np.flatnonzero(x != y)[0] if x.shape == y.shape else 0
            out.append(f"{name} from step {t['Step'][n]:.0f}")
    warned = [[line for line in r.output.splitlines() if (w := re.search(r"WARNING: fix gas.*\bstep (\d+)", line)) and int(w[1]) > scene.steps[0]] for r in (a, b)]
    if warned[0] != warned[1]:
        out.append("warnings")
    frames = [[f for f in frame_steps(r, n) if f > scene.steps[0]] for r, n in ((a, "one"), (b, "two"))]
    if frames[0] != frames[1]:
        out.append("frames")
    return out


def main():
    executable, ranks = arguments()
    only = [a[2:] for a in sys.argv if a.startswith("--") and a != "--long"]
    c = Checks("a run goes on from a checkpoint, in scenes that keep much")
    for name, scene in SCENES.items():
        if only and not any(o in name for o in only):
            continue
        for n in ranks:
            a = scene.first(executable, n)
            b = scene.second(executable, n, a)
            differ = differences(scene, a, b)
            t = b.thermo()
            c.true(f"{name}, {n} ranks: every bit of particles ({t['Atoms'][0]:.0f} to {t['Atoms'][-1]:.0f}), fluid and figures{': but ' + ', '.join(differ) if differ else ''}", not differ)
    c.end()


if __name__ == "__main__":
    main()
