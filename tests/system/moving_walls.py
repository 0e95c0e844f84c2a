#!/usr/bin/python3
"""Walls that move along themselves, from the script to the torque: an inner cylinder and a drum that turn, by a mesh's surface_ang_vel, by
the shear of a primitive, by fix move/mesh rotate; a belt.

What would pass falsely without it: gas that a turning drum leaves at rest, or drags the other way than the grains; a sense of turning, or an
axis, taken for another; a body that moves through the grid taken for one that stays; a restart with the drum at rest.

References: Couette flow between cylinders, torque 4 pi mu w r1^2 r2^2/(r2^2 - r1^2) a length; plane Couette flow, force mu U A/gap.
"""
import numpy as np

from bodies import WALL, stl
from harness import Checks, Run, arguments, column, head

R1, R2, W, N = 0.2, 0.42, 1.5, 32
C = (0.503, 0.491)
MU, THIN = 1.0, 1 / N
FACETS = 120
TORQUE = 4 * np.pi * MU * W * R1**2 * R2**2 / (R2**2 - R1**2) * THIN
MESH = "fix cad{n} all mesh/surface file {n}.stl type 1{more}"
STEEL = WALL.format(what="mesh n_meshes 2 meshes cadinner cadouter")


def axis_words(axis):
    e, f = [d for d in range(3) if d != axis]
    origin, along = [0.0] * 3, [0] * 3
    origin[e], origin[f], along[axis] = C[0], C[1], 1
    return "origin {} {} {}".format(*origin) + " axis {} {} {}".format(*along)


def wall(kind, which, axis, turns):
    """Lines, and words for fix_modify, of the cylinder `which` (inner, outer)."""
    radius = R1 if which == "inner" else R2
    if kind == "primitive":
        first, second = (C[1], C[0]) if axis == 1 else C
        shear = f" shear {'xyz'[(axis + 1) % 3]} {W}" if turns else ""
        return WALL.replace("steel", "steel" + which).format(what=f"primitive type 1 {'xyz'[axis]}cylinder {radius} {first} {second}" + shear), f"solid {which} wall steel{which}"
    more = f" surface_ang_vel {axis_words(axis)} omega {W}" if turns and kind == "velocity" else ""
    lines = MESH.format(n=which, more=more)
    if turns and kind == "rotate":
        lines += f"\nfix turn all move/mesh mesh cad{which} rotate {axis_words(axis)} period {2 * np.pi / W!r}"
    return lines, f"solid {which} mesh cad{which}"


def couette(kind, turns="inner", axis=2, run="run 120", more="", grain=False):
    """f_gas[17..] force and torque of the inner cylinder, then of the outer."""
    size, cells, at = [1.0] * 3, [N] * 3, [0.0] * 3
    size[axis], cells[axis] = THIN, 1
    e, f = [d for d in range(3) if d != axis]
    at[e], at[f], at[axis] = C[0] + (R1 + 0.0099 if turns == "inner" else R2 - 0.0099), C[1], THIN / 2
    lines, words = zip(*(wall(kind, which, axis, which == turns) for which in ("inner", "outer")))
    point = [THIN / 2] * 3
    point[e], point[f] = C[0], C[1] + 0.3
    grain = "create_atoms 1 single {} {} {} units box\nset group all diameter 0.02 density 2500\n".format(*(at if grain else point))
    return head("0 {} 0 {} 0 {}".format(*size), 1e-3, boundary="f f f", kn=1e4, kt=1e4, gamman=1, gammat=1, skin=5e-3, mu=0.5) + grain + "\n".join(lines) + f"""
{STEEL if kind != 'primitive' else ''}
fix motion all nve/sphere
fix gas all twogrid fine {cells[0]} {cells[1]} {cells[2]} density 1 viscosity {MU} every 20
fix_modify gas one-way yes convection none {words[0]} {words[1]} fluid_at {point[0]} {point[1]} {point[2]}
{more}
thermo_style custom step {' '.join(f'f_gas[{i}]' for i in range(17, 29))}
thermo_modify norm no
thermo 20
dump grains all custom 5 grains.txt id vx vy vz f_gas[8] f_gas[9] f_gas[10]
{run}
"""


def files(axis, sides=FACETS):
    return {f"{which}.stl": stl([(radius, 0.0), (radius, THIN)], axis=axis, centre=C, facets=sides) for which, radius in (("inner", R1), ("outer", R2))}


def go(executable, text, axis=2, ranks=1, sides=FACETS, **more):
    return Run(executable, text, ranks=ranks, files=files(axis, sides), **more)


def torques(run, axis):
    t = run.thermo()
    return [column(t, f"f_gas[{20 + axis + 6 * b}]")[-1] for b in range(2)]


def cylinders(c, executable, most_ranks):
    of_inner = {}
    for name, kind, turns, axis, ranks in (
            ("a mesh's surface_ang_vel", "velocity", "inner", 2, 1), ("the same on more ranks", "velocity", "inner", 2, most_ranks), ("a primitive's shear", "primitive", "inner", 2, 1),
            ("fix move/mesh rotate", "rotate", "inner", 2, 1), ("a mesh along y", "velocity", "inner", 1, 1), ("a primitive along x", "primitive", "inner", 0, 1),
            ("a drum, shear", "primitive", "outer", 2, 1), ("a drum, rotate", "rotate", "outer", 2, 1)):
        grain = ranks == 1 and axis == 2
        run = go(executable, couette(kind, turns, axis, grain=grain), axis, ranks)
        got = torques(run, axis)
        sign = 1 if turns == "inner" else -1
        c.below(f"{name}: torque on the inner cylinder {got[0]:.5f} N m, relative error", abs(got[0] / (-sign * TORQUE) - 1), 0.03)
        c.below("torque on the outer one, relative error", abs(got[1] / (sign * TORQUE) - 1), 0.03)
        if axis == 2:
            of_inner[name] = sign * got[0]
        c.true("the report says so", run.output.count("its surface turns with") == 1)
        if grain:
            # A grain that touches the wall, when the gas is still at rest; and what it reads of the gas at the end.
            d = run.dump("grains.txt")
            first, last = d[1][1], d[-1][1]
            c.true(f"the grain goes with the wall ({first['vy'][0]:.1e} m/s), and so does the gas ({last['f_gas[9]'][0]:.2f} m/s)", first["vy"][0] > 0 and last["f_gas[9]"][0] > 0)
    same = of_inner["a mesh's surface_ang_vel"]
    for name, value in of_inner.items():
        if "drum" not in name:
            c.below(f"{name} against surface_ang_vel, relative", abs(value / same - 1), 1e-9 if "ranks" in name or "rotate" in name else 0.01)
    slip = go(executable, couette("velocity", more="", run="run 40").replace("solid inner mesh cadinner", "solid inner mesh cadinner slip"))
    c.below("a slip wall that turns: torque", max(map(abs, torques(slip, 2))), 1e-12)


def belt(c, executable):
    U, gap = 0.3, 0.58
    text = head(f"0 0.25 0 1 0 {THIN}", 1e-3, boundary="p f f", skin=5e-3) + f"""create_atoms 1 single 0.1 0.5 {THIN / 2} units box
set group all diameter 0.02 density 2500
{WALL.replace('steel', 'low').format(what=f'primitive type 1 yplane 0.21 shear x {U}')}
{WALL.replace('steel', 'high').format(what='primitive type 1 yplane 0.79')}
fix motion all nve/sphere
fix gas all twogrid fine 8 32 1 density 1 viscosity {MU} every 20
fix_modify gas one-way yes solid low wall low solid high wall high fluid_at 0.1 0.5 {THIN / 2}
thermo_style custom step f_gas[17] f_gas[23]
thermo_modify norm no
run 400
"""
    run = Run(executable, text)
    t = run.thermo()
    wanted = MU * U / gap * 0.25 * THIN
    c.below("a belt: force on it, relative error", abs(column(t, "f_gas[17]")[-1] / -wanted - 1), 1e-5)
    c.below("force on the wall at rest, relative error", abs(column(t, "f_gas[23]")[-1] / wanted - 1), 1e-5)


def runs(c, executable):
    """In two runs as in one; from a checkpoint."""
    for kind in ("velocity", "rotate"):
        one = torques(go(executable, couette(kind, run="run 40")), 2)
        two = torques(go(executable, couette(kind, run="run 20\nrun 20")), 2)
        c.below(f"{kind}: two runs against one, relative", abs(two[0] / one[0] - 1), 1e-9)
    text = couette("velocity", run="run 20\nwrite_restart a.restart\nfix_modify gas checkpoint write a.h5\nrun 20")
    whole = go(executable, text)
    lines = [line for line in text.split("\n") if not line.startswith(("region box", "create_atoms", "set group"))]
    text = "\n".join(f"read_restart {whole.path}/a.restart" if line.startswith("create_box") else line for line in lines)
    text = text.replace("run 20\nwrite", f"fix_modify gas checkpoint read {whole.path}/a.h5\nrun 20\nwrite").split("write_restart")[0]
    on = go(executable, text)
    c.true("from a checkpoint: the same bits", torques(on, 2) == torques(whole, 2))


def refused(c, executable):
    for name, text, sides, words in (
            ("a square that turns", couette("rotate"), 4, ("mesh cadinner", "not round", "stays where it is")),
            ("two movers", couette("rotate").replace("fix motion", "fix up all move/mesh mesh cadinner linear 0 0 0\nfix motion"), FACETS, ("fixes turn and up",)),
            ("another mover", couette("velocity").replace("fix motion", "fix up all move/mesh mesh cadouter linear 0 0 0\nfix motion"), FACETS, ("fix up", "stays where it is")),
            ("checkpoints of a mesh that fix move/mesh turns", couette("rotate", more="fix_modify gas checkpoint every 20 folder keep"), FACETS, ("surface_ang_vel",))):
        run = go(executable, text, sides=sides, expect_success=False)
        errors = [line for line in run.output.split("\n") if line.startswith("ERROR")]
        c.true(f"{name}: {errors}", run.code != 0 and len(errors) == 1 and all(w in errors[0] for w in words))
    for name, text, axis, words in (
            ("shear of a ycylinder", couette("primitive", axis=1, run="run 20"), 1, ("x and z exchanged", "at rest")),
            ("a variable", couette("velocity", run="run 20").replace("fix cadinner", "variable w equal 1.5\nfix cadinner").replace(f"omega {W}", "omega v_w"), 2, ("by a variable", "at rest")),
            ("a square's surface_ang_vel", couette("velocity", run="run 20"), 2, ("not round", "at rest"))):
        run = go(executable, text, axis, sides=4 if "square" in name else FACETS)
        warnings = [line for line in run.output.split("\n") if "The particles feel that" in line]
        c.true(f"{name}: {warnings}", len(warnings) == 1 and all(w in warnings[0] for w in words))
        c.below("and the fluid at rest: torque", max(map(abs, torques(run, axis))), 1e-12)


def main():
    executable, ranks = arguments()
    c = Checks("walls that move along themselves")
    cylinders(c, executable, max(ranks))
    belt(c, executable)
    runs(c, executable)
    refused(c, executable)
    c.end()


if __name__ == "__main__":
    main()
