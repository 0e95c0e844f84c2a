#!/usr/bin/python3
"""Vessels in the fluid, from the script to the pressure drop: a bed of fixed spheres in a cylinder that is given as a mesh, as a
wall of LIGGGHTS and as a region; grains that fall into a cone; what is written of them; a restart.

What would pass falsely without it: a cylinder along y whose two coordinates are changed over; a mesh of which each rank knows its
own part only; a fluid on the outside of the vessel, or on both sides; flux per area of the box in place of the vessel's; solids
deposited into steel; means of cells weighted by their closed part; a run that goes on from a checkpoint without its vessel, or with a mesh's triangles in
another order on a rank, or with a moving mesh at rest; a torque
with one of its arms the wrong way.

References: Ergun (1952) over the vessel's own section; areas and volumes of cylinder and polygon; exact solids volume.
"""
import re

import h5py
import numpy as np

from harness import Checks, Run, arguments, column, data_file, head, head_with_particles
from same_script import checkpoints, gas, gone_on, text_of

R, H, D = 8e-3, 18e-3, 1e-3
WIDE = 17e-3
C = (8.6e-3, 8.3e-3)  # the axis, in the two directions across it, ascending
U, MU, RHO = 0.3, 1.8e-5, 1.2
FACETS = 240
ACROSS, ALONG = 24, 18  # fine cells: 22.6 a diameter, at which the polygon of the cells' edges has 0.13 % less area than the circle


def spread(n, base):
    """The first n of van der Corput's sequence."""
    out = np.zeros(n)
    for i in range(n):
        f, k = 1.0, i + 1
        while k:
            f /= base
            out[i] += f * (k % base)
            k //= base
    return out


def packing(n, radius):
    """n points spread evenly over the cylinder: across, across, along."""
    r, a = radius * np.sqrt(spread(n, 2)), 2 * np.pi * spread(n, 3)
    return np.stack([C[0] + r * np.cos(a), C[1] + r * np.sin(a), H * spread(n, 5)], axis=1)


def stl(rings, axis=2, centre=C, facets=FACETS, inverted=False):
    """Text of a surface of revolution through rings (radius, height), along an axis, its centre in the other two directions."""
    angle = 2 * np.pi * np.arange(facets) / facets
    points = []
    for r, h in rings:
        p = np.zeros((facets, 3))
        e, f = [d for d in range(3) if d != axis]
        p[:, e], p[:, f], p[:, axis] = centre[0] + r * np.cos(angle), centre[1] + r * np.sin(angle), h
        points.append(p)
    lines = ["solid wall"]
    for low, high in zip(points[:-1], points[1:]):
        for i in range(facets):
            j = (i + 1) % facets
            for t in ((low[i], low[j], high[j]), (low[i], high[j], high[i])):
                if np.linalg.norm(np.cross(t[1] - t[0], t[2] - t[0])) < 1e-14:
                    continue
                t = t[::-1] if inverted else t
                lines += ["facet normal 0 0 0", "outer loop"] + ["vertex " + " ".join(f"{c:.12g}" for c in p) for p in t] + ["endloop", "endfacet"]
    return "\n".join(lines + ["endsolid wall", ""])


WALL = "fix steel all wall/gran model hooke/stiffness tangential history {what} absolute_damping on"


def vessel(kind, axis=2):
    """Lines that make the cylinder, and the words that make it solid."""
    if kind == "region":
        return f"region tube cylinder {'xyz'[axis]} {C[0]!r} {C[1]!r} {R!r} INF INF side out units box", "solid vessel region tube"
    if kind == "wall":
        # LIGGGHTS wants the axis' coordinates in cyclic order
        first, second = (C[1], C[0]) if axis == 1 else C
        return WALL.format(what=f"primitive type 1 {'xyz'[axis]}cylinder {R!r} {first!r} {second!r}"), "solid vessel wall steel"
    return ("fix cad all mesh/surface file tube.stl type 1\n" + WALL.format(what="mesh n_meshes 1 meshes cad"), "solid vessel mesh cad")


def bed(executable, kind, axis=2, ranks=1, words=" slip", extra="", steps=100, empty=False, viscosity=MU, columns="", options=("-fluid_pressure_rtol", "1e-9")):
    """A packed bed from inlet to outlet; gas along the axis."""
    n = int(0.5 * np.pi * R * R * H / (np.pi / 6 * D**3))
    x = packing(n, 0.985 * R)
    place = [d for d in range(3) if d != axis] + [axis]
    turned = np.zeros_like(x)
    for q, d in enumerate(place):
        turned[:, d] = x[:, q]
    diameter = D
    size = [WIDE, WIDE, WIDE]
    size[axis] = H
    fine = [ACROSS, ACROSS, ACROSS]
    fine[axis] = ALONG
    lo, hi = ("xyz"[axis] + s for s in ("lo", "hi"))
    inflow = " ".join(repr(U) if d == axis else "0" for d in range(3))
    made, solid = vessel(kind, axis)
    box = " ".join(f"0 {s!r}" for s in size)
    if empty:  # LIGGGHTS wants one at least
        turned, diameter = 0.5 * (turned.min(axis=0) + turned.max(axis=0)), 1e-5
    begin = head_with_particles(1e-4, boundary="f f f")
    script = begin + f"""{made}
fix gas all twogrid fine {fine[0]} {fine[1]} {fine[2]} ratio 3 3 3 density {RHO} viscosity {viscosity!r} every 10
fix_modify gas drag ergun {solid}{words}
fix_modify gas boundary {lo} inlet {inflow} boundary {hi} pressure 0
{extra}
thermo_style custom step atoms f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[9] f_gas[10] {columns}
thermo_modify format float %.17g lost error norm no
thermo {steps}
run {steps}
"""
    files = {"particles.data": data_file(box, turned, diameter, 2500)}
    if kind == "mesh":
        files["tube.stl"] = stl([(R, 0.0), (R, 0.4 * H), (R, H)], axis)
    solids = n * np.pi / 6 * D**3
    eps = 1 - solids / (np.pi * R * R * H)
    ergun = (150 * MU * (1 - eps)**2 / (eps**3 * D**2) * U + 1.75 * RHO * (1 - eps) / (eps**3 * D) * U * U) * H
    return Run(executable, script, ranks, options, files=files), ergun


def report(run, line):
    found = re.search(rf"^  {re.escape(line)} +(.*)$", run.output, re.M)
    return found.group(1) if found else ""


def number(text, before):
    """The number that stands before the words."""
    found = re.search(r"([-+0-9.e]+) " + re.escape(before), text)
    return float(found.group(1)) if found else np.nan


def last(run, name):
    return column(run.thermo(), name)[-1]


def beds_in_a_cylinder(c, executable):
    drops = {}
    for kind in ("region", "wall", "mesh"):
        run, ergun = bed(executable, kind)
        drops[kind] = last(run, "f_gas[4]")
        c.below(f"{kind}: pressure drop {drops[kind]:.3f} Pa against Ergun's {ergun:.3f} over the vessel's section, relative", abs(drops[kind] / ergun - 1), 0.01)
        c.below(f"{kind}: solids ledger", last(run, "f_gas[6]"), 1e-13)
        c.below(f"{kind}: momentum exchange", last(run, "f_gas[7]"), 1e-12)
        c.below(f"{kind}: wall as resolved, relative", abs(number(report(run, "solid vessel"), "m2 of its surface") / (2 * np.pi * R * H) - 1), 0.005)
        c.below(f"{kind}: open volume, relative", abs(number(report(run, "open to the fluid"), "m3,") / (np.pi * R * R * H) - 1), 0.005)
        c.below(f"{kind}: open area of the inlet, relative", abs(number(report(run, "zlo"), "m2") / WIDE**2 - 1) +
                abs(float(re.search(r"open: (\S+) m2", report(run, "zlo")).group(1)) / (np.pi * R * R) - 1), 0.008)
        c.true(f"{kind}: the side is told: {report(run, 'fluid is')}", report(run, "fluid is") != "")
        c.true(f"{kind}: no warning of walls that the fluid doesn't see", "blows through" not in run.output)
    c.below("wall against region, relative", abs(drops["wall"] / drops["region"] - 1), 1e-6)
    c.below("mesh against region, relative", abs(drops["mesh"] / drops["region"] - 1), 2e-3)
    for axis in (0, 1):
        run, _ = bed(executable, "wall", axis)
        c.below(f"wall along {'xyz'[axis]} against z, relative", abs(last(run, "f_gas[4]") / drops["wall"] - 1), 1e-6)


def friction_of_walls(c, executable):
    """A viscous fluid alone: what the three shapes say of distances."""
    drops = {kind: last(bed(executable, kind, words=" noslip", empty=True, viscosity=1e-2, options=("-fluid_pressure_rtol", "1e-10"))[0], "f_gas[4]")
             for kind in ("region", "wall", "mesh")}
    poiseuille = 8 * 1e-2 * U * H / R**2
    c.true(f"empty: pressure drop {drops['wall']:.3f} Pa, of developed flow {poiseuille:.3f} (wanted: 1.2 to 1.5 times that: the inlet is flat, and the pipe as long as wide)",
           1.2 < drops["wall"] / poiseuille < 1.5)
    c.below("empty: region against wall, relative", abs(drops["region"] / drops["wall"] - 1), 1e-4)
    c.below("empty: mesh against wall, relative", abs(drops["mesh"] / drops["wall"] - 1), 2e-3)


def forces_on_bodies(c, executable):
    """A pipe that is thin against what it holds: what the pressure drop and the gas's momentum push, its wall holds back."""
    run, _ = bed(executable, "wall", words=" noslip", empty=True, viscosity=1e-2, steps=200, columns="f_gas[17] f_gas[18] f_gas[19] f_gas[20] f_gas[21] f_gas[22]",
                 options=("-fluid_pressure_rtol", "1e-10"))
    drop, x, y, z = (last(run, f"f_gas[{i}]") for i in (4, 17, 18, 19))
    push = drop * np.pi * R * R
    c.below(f"force on the pipe along it, {z:.3e} N, against pressure drop times section, {push:.3e} N, relative", abs(z / push - 1), 0.05)
    c.below("force across it, relative", np.hypot(x, y) / push, 0.02)
    c.below("torque about its axis, over force times radius", abs(last(run, "f_gas[22]")) / (push * R), 0.01)


def torque_on_a_ball(c, executable):
    """Held in the middle between two walls that move against each other, slowly: 4 pi mu a^3 times the shear rate."""
    side, a, mu, v = 24e-3, 3e-3, 0.1, 0.01
    run = Run(executable, head(f"0 {side} 0 {side} 0 {side}", 1e-4, boundary="f p p") + f"""create_atoms 1 single 0.001 0.001 0.001 units box
set group all diameter 1e-5 density 2500
region ball sphere {side / 2} {side / 2} {side / 2} {a} units box
fix gas all twogrid fine 24 24 24 ratio 3 3 3 density 1 viscosity {mu} every 10
fix_modify gas solid ball region ball implicit on convection none
fix_modify gas boundary xlo noslip 0 0 {-v} boundary xhi noslip 0 0 {v}
thermo_style custom step f_gas[20] f_gas[21] f_gas[22]
thermo_modify norm no
thermo 60
run 60
""")
    torque = [last(run, f"f_gas[{i}]") / (-4 * np.pi * mu * a**3 * 2 * v / side) for i in (20, 21, 22)]
    c.below(f"torque on a ball in shear, over its Stokes flow's {torque[1]:.4f}; relative", abs(torque[1] - 1), 0.04)
    c.below("torque about the other axes, relative", np.hypot(torque[0], torque[2]), 1e-3)


def same_on_all_ranks(c, executable, ranks):
    out = "fix_modify gas output every 100 file o.h5 average from 0"
    runs = {n: bed(executable, "mesh", ranks=n, extra=out, words="")[0] for n in (1, *ranks)}
    with h5py.File(runs[1].file("o.h5")) as f:
        theta, blank = f["grid/theta"][()], f["grid/blank"][()]
        volume = theta.sum() * (WIDE / ACROSS)**2 * (H / ALONG)
        polygon = 0.5 * FACETS * R * R * np.sin(2 * np.pi / FACETS) * H
        c.below("open volume in the output file, relative", abs(volume / polygon - 1), 0.004)
        c.true("closed cells are blanked, and only they", np.array_equal(blank == 32, theta == 0) and (theta == 0).any())
        nodes, eps, fine = f["particle_grid/theta"][()], f["average/particle_grid/eps"][()], f["average/fine/eps"][()]
        blocks = (theta * fine).reshape(ALONG // 3, 3, ACROSS // 3, 3, ACROSS // 3, 3).sum(axis=(1, 3, 5)) / np.maximum(27 * nodes, 1e-300)
        c.below("means on particle cells are of the open volume", np.abs(blocks - eps)[nodes > 0].max(), 1e-12)
    shown = open(runs[1].file("o.xdmf")).read()
    c.true("ParaView is told", 'Name="theta"' in shown and 'Name="vtkGhostType"' in shown and ":/grid/theta" in shown)
    for n in ranks:
        with h5py.File(runs[n].file("o.h5")) as f:
            c.true(f"{n} ranks: open shares have the same bits", np.array_equal(f["grid/theta"][()], theta) and np.array_equal(f["particle_grid/theta"][()], nodes))
        c.true(f"{n} ranks: smallest void fraction has the same bits", last(runs[n], "f_gas[9]") == last(runs[1], "f_gas[9]"))
        c.below(f"{n} ranks: pressure drop, relative", abs(last(runs[n], "f_gas[4]") / last(runs[1], "f_gas[4]") - 1), 1e-8)


CONE = """
units si
atom_style granular
newton off
communicate single vel yes
boundary f f f
processors * * 1
region box block 0 0.02 0 0.02 0 0.03 units box
create_box 1 box
neighbor 0.0004 bin
neigh_modify delay 0
soft_particles yes
fix m1 all property/global kn peratomtypepair 1 100
fix m2 all property/global kt peratomtypepair 1 28
fix m3 all property/global gamman peratomtypepair 1 800
fix m4 all property/global gammat peratomtypepair 1 400
fix m5 all property/global coefficientFriction peratomtypepair 1 0.2
pair_style gran model hooke/stiffness tangential history
pair_coeff * *
timestep 2e-5
fix cad all mesh/surface file cone.stl type 1
fix steel all wall/gran model hooke/stiffness tangential history mesh n_meshes 1 meshes cad
fix floor all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
fix ball all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.0006
fix mix all particledistribution/discrete 32452843 1 ball 1.0
region pour cylinder z 0.0101 0.0097 0.007 0.015 0.028 units box
fix pour all insert/pack seed 49979687 distributiontemplate mix vel constant 0 0 -0.6 insert_every once overlapcheck yes all_in yes particles_in_region 300 region pour
run 1
fix gas all twogrid fine 20 20 30 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas solid funnel mesh cad
fix_modify gas boundary zlo inlet 0 0 0.4 boundary zhi pressure 0
fix_modify gas output every 400 file bed.h5 fields u p eps faces average from 0.001
fix_modify gas checkpoint every 500 keep 9
thermo_style custom step atoms f_gas[1] f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[9]
thermo_modify format float %.17g
thermo 200
compute high all reduce max z
dump d all custom 600 all.dump id x y z vx vy vz f_gas[1] f_gas[7]
dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
run 1200
"""
# outlet 3 mm from the axis at the floor, 9 mm at 12 mm, then upright
FUNNEL = [(3e-3, 0.0), (9e-3, 12e-3), (9e-3, 30e-3)]


def grains_in_a_cone(c, executable, ranks):
    n = ranks[-1] if ranks else 1
    run = Run(executable, CONE, n, files={"cone.stl": stl(FUNNEL, centre=(0.0101, 0.0097), facets=96)})
    t = run.thermo()
    c.below("cone: solids ledger, at all times", column(t, "f_gas[6]").max(), 1e-13)
    c.below("cone: momentum exchange, at all times", column(t, "f_gas[7]").max(), 1e-12)
    c.true(f"cone: {t['Atoms'][-1]:.0f} grains of {t['Atoms'][0]:.0f}, smallest void fraction {column(t, 'f_gas[9]').min():.3f} (wanted: all, at least 0.3)",
           t["Atoms"][-1] == t["Atoms"][0] and column(t, "f_gas[9]").min() > 0.299)
    with h5py.File(run.file("bed.h5")) as f:
        theta, frame = f["grid/theta"][()], f["fluid"][sorted(f["fluid"])[-1]]
        solids = ((1 - frame["eps"][()]) * theta).sum() * 1e-9
        c.below("cone: solids on the fine cells' open volumes, relative", abs(solids / (300 * np.pi / 6 * 1.2e-3**3) - 1), 1e-12)
        area = 1e-6
        flux, rate = frame["faces/flux_z"], frame["faces/deps_dt"][()]
        into, out = flux[0].sum() * area, flux[-1].sum() * area
        c.below("cone: gas out = gas in + displaced, relative", abs(out - into + rate.sum() * 1e-9) / into, 1e-6)
        throat = 0.5 * 96 * 3e-3**2 * np.sin(2 * np.pi / 96)
        c.below("cone: gas in = velocity times the open area of the inlet, relative", abs(into / (0.4 * throat) - 1), 0.025)  # six cells wide
    if n > 1:
        alone = Run(executable, CONE, 1, files={"cone.stl": stl(FUNNEL, centre=(0.0101, 0.0097), facets=96)}).thermo()
        c.true("cone: the same solids on 1 rank", column(alone, "f_gas[6]").max() <= 1e-13 and alone["Atoms"][-1] == t["Atoms"][-1])
    goes_on(c, executable, n, run, f"cone on {n} ranks")


def goes_on(c, executable, n, run, what):
    """From its first checkpoint to its end, every bit."""
    name = checkpoints(run.path)[0]
    folder, path, again = gone_on(executable, n, run, name, options=("-restart", "auto"))
    c.true(f"{what}, gone on from {name}: code {again.returncode}, every bit of all dumps",
           again.returncode == 0 and text_of(path, "all.dump") == text_of(run.path, "all.dump"))
    one, two = gas(run.path), gas(path)
    c.true(f"{what}, gone on: every bit of the fluid and its means", all(np.array_equal(one[k], two.get(k), equal_nan=True) for k in one))
    folder.cleanup()


def paddle_in_a_cone(c, executable):
    """Triangles that go from rank to rank, and whose velocity the forces see; long ones, which all ranks know."""
    paddle = stl([(2e-3, 8e-3), (2.5e-3, 16e-3), (1e-3, 17e-3)], centre=(0.0101, 0.0097), facets=10)
    scene = CONE.replace("fix steel", "fix pad all mesh/surface file pad.stl type 1\nfix steel").replace("n_meshes 1 meshes cad", "n_meshes 2 meshes cad pad")
    # Behind the wall: the forces of a run's beginning see what the mover has left.
    scene = scene.replace("fix motion", "fix turn all move/mesh mesh pad rotate origin 0.0101 0.0097 0 axis 0 0 1 period 0.02\nfix motion")
    run = Run(executable, scene.replace("custom 600", "custom 100").replace("run 1200", "run 600"), 4, files={"cone.stl": stl(FUNNEL, centre=(0.0101, 0.0097), facets=24), "pad.stl": paddle})
    goes_on(c, executable, 4, run, "paddle that turns in a cone, on 4 ranks")


def main():
    executable, ranks = arguments()
    c = Checks("vessels and bodies in the fluid")
    beds_in_a_cylinder(c, executable)
    friction_of_walls(c, executable)
    forces_on_bodies(c, executable)
    torque_on_a_ball(c, executable)
    same_on_all_ranks(c, executable, [n for n in ranks if n > 1])
    grains_in_a_cone(c, executable, [n for n in ranks if n <= 2])
    paddle_in_a_cone(c, executable)
    c.end()


if __name__ == "__main__":
    main()
