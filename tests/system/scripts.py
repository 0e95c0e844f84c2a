#!/usr/bin/python3
"""LIGGGHTS' own commands beside the fluid: gravity, primitive and mesh walls, insertion during the run, several `run`
commands, `run 0`, dumps with the fix's columns, its vector in thermo output, `run N pre no`.

Without this test a fix that works in one kind of script only, advances the fluid in `run 0`, shifts the phase of the
coupling at run boundaries, or takes a burst of inserted particles for a flow would pass.
"""
import h5py
import numpy as np

from harness import Checks, Run, arguments, head

STL = """solid floor
facet normal 0 0 1
outer loop
vertex 0.00001 0.00001 0.002
vertex 0.01199 0.00001 0.002
vertex 0.00001 0.01199 0.002
endloop
endfacet
facet normal 0 0 1
outer loop
vertex 0.01199 0.00001 0.002
vertex 0.01199 0.01199 0.002
vertex 0.00001 0.01199 0.002
endloop
endfacet
endsolid floor
"""

SCRIPT = head("0 0.012 0 0.012 0 0.03", 1e-5, boundary="f f f", skin=1e-3, gamman=0.01, gammat=0.01) + """
fix grav all gravity 9.81 vector 0 0 -1
fix floor all mesh/surface file floor.stl type 1
fix meshwall all wall/gran model hooke/stiffness tangential history mesh n_meshes 1 meshes floor absolute_damping on
fix xl all wall/gran model hooke/stiffness tangential history primitive type 1 xplane 0.0 absolute_damping on
fix xh all wall/gran model hooke/stiffness tangential history primitive type 1 xplane 0.012 absolute_damping on
fix yl all wall/gran model hooke/stiffness tangential history primitive type 1 yplane 0.0 absolute_damping on
fix yh all wall/gran model hooke/stiffness tangential history primitive type 1 yplane 0.012 absolute_damping on
fix zh all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0.03 absolute_damping on
fix pts all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.0005
fix pdd all particledistribution/discrete 15485867 1 pts 1.0
region top block 0.001 0.011 0.001 0.011 0.015 0.028 units box
fix ins all insert/pack seed 32452843 distributiontemplate pdd maxattempt 200 insert_every 100 overlapcheck yes all_in yes vel constant 0 0 -0.2 region top particles_in_region 60
fix integrate all nve/sphere
fix gas all twogrid fine 8 8 20 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 7
fix_modify gas boundary zlo inlet 0 0 0.3 boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
fix_modify gas output every 70 file bed.h5 fields u p eps average from 0.0
thermo 50
thermo_style custom step atoms ke f_gas[1] f_gas[2] f_gas[3] f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[8] f_gas[9] f_gas[10]
thermo_modify format float %.12g
dump d all custom 100 dump.txt id x y z vz f_gas[1] f_gas[3] f_gas[7] f_gas[10]
run 0
run 123
run 177
run 0
run 100 pre no
"""


def column(t, i):
    return t[f"f_gas[{i}]"] if f"f_gas[{i}]" in t else t[f"gas[{i}]"]


def main():
    executable, ranks = arguments()
    c = Checks("LIGGGHTS' own commands beside the fluid")
    for n in ranks:
        r = Run(executable, SCRIPT, n, ["-fluid_pressure_rtol", "1e-8"],
                files={"floor.stl": STL})
        t = r.thermo()
        time = column(t, 1)
        c.below(f"{n} ranks: fluid time at the end against the last multiple of 7 steps", abs(time[-1] - 399e-5), 1e-12)
        c.below(f"{n} ranks: fluid time after run 0", abs(time[0]), 0)
        c.true(f"{n} ranks: particles were inserted ({t['Atoms'][0]:.0f} to {t['Atoms'][-1]:.0f})", t["Atoms"][-1] >= 60)
        c.below(f"{n} ranks: solid volume error", column(t, 6).max(), 1e-13)
        c.below(f"{n} ranks: momentum exchange error", column(t, 7).max(), 1e-12)
        c.below(f"{n} ranks: divergence error", column(t, 5)[time > 0].max(), 1e-5)
        # A burst of 60 particles replaces fluid: without its source in the ledger 60 V_p/(7 dt A) = 3.1 m/s would rush out.
        c.below(f"{n} ranks: Courant number, insertion or not", column(t, 3).max(), 0.8)
        frames = r.dump("dump.txt")
        last = frames[-1][1]
        c.true(f"{n} ranks: dump has the fix's columns, eps between 0.3 and 1",
               bool(np.all((last["f_gas[7]"] > 0.3) & (last["f_gas[7]"] <= 1 + 1e-12))))
        c.true(f"{n} ranks: gas pushes up", float(np.mean(last["f_gas[3]"])) > 0)
        with h5py.File(r.file("bed.h5")) as f:
            c.true(f"{n} ranks: frames {len(f['fluid'])}", len(f["fluid"]) >= 5)
            c.true(f"{n} ranks: the script is in the record", "fix gas all twogrid" in str(np.array(f["record/input_text"][()]).item()))
        c.true(f"{n} ranks: scene report and shares are in the log",
               all(w in r.output.lower() for w in ("re = rho", "deposit", "fluid")))
    c.end()


if __name__ == "__main__":
    main()
