#!/usr/bin/python3
"""Gas that bodies blow into the fluid, from the script to the pressure drop: a ball, part of a ball, a plate under a bed; a velocity that
follows a variable; a restart; what is refused.

What would pass falsely without it: a volume flow that is not velocity times surface, or is lost or counted twice in the balances; a part of
the surface that is not the region's; a bed over a plate that feels another gas than over an inlet; a variable that is read once; a run that
goes on from a checkpoint with another flow, or on more ranks with a part of it.

References: area of a sphere; the same bed over an inlet; the buoyant weight of a fluidised bed.
"""
import re

import h5py
import numpy as np

from bodies import WALL, spread, stl
from harness import Checks, Run, arguments, column, data_file, gas_balance, head, head_with_particles, walls

SIDE, HIGH, N, R, U = 17e-3, 18e-3, 18, 5e-3, 0.4
BALL = f"region ball sphere 0.0083 0.0087 0.0086 {R} units box"
HALF = "region half block INF INF INF INF 0.0086 INF units box"
FLOW = "f_gas[4] f_gas[5] f_gas[17] f_gas[18] f_gas[19]"


def empty(before, modify, run="run 40", boundary="boundary zhi pressure 0"):
    """A box without grains to speak of, open above."""
    return head(f"0 {SIDE} 0 {SIDE} 0 {HIGH}", 1e-4, boundary="f f f") + f"""create_atoms 1 single 0.001 0.001 0.001 units box
set group all diameter 1e-5 density 2500
{before}
fix gas all twogrid fine {N} {N} {N} ratio 3 3 3 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas {boundary}
fix_modify gas {modify}
thermo_style custom step {FLOW}
thermo_modify norm no
thermo 10
{run}
"""


OUTPUT = "output every 10 file o.h5 fields u p faces"
TIGHT = ("-fluid_pressure_rtol", "1e-9")


def outflows(run):
    """Through the top, of every frame but the first, m3/s."""
    with h5py.File(run.file("o.h5")) as f:
        x, y = (np.diff(f["grid/" + a][()]) for a in "xy")
        return np.array([np.sum(f["fluid/" + n]["faces/flux_z"][-1] * np.outer(y, x)) for n in sorted(f["fluid"])[1:]])


def said(run, words):
    """The numbers in the line of the output that has these words, after them."""
    line = [line for line in run.output.split("\n") if words in line][-1]
    return [float(q) for q in re.findall(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?", line.split(words)[1].replace("m2", "m").replace("m3", "m"))]


def ball(c, executable, most_ranks):
    """The whole of it, its upper half, from mesh and region; on more ranks."""
    sphere = stl([(R * np.sin(a), 0.0086 - R * np.cos(a)) for a in np.linspace(0, np.pi, 48)], centre=(0.0083, 0.0087), facets=96)
    mesh = "fix cad all mesh/surface file a.stl type 1\n" + WALL.format(what="mesh n_meshes 1 meshes cad")
    flows = {}
    for name, before, words, share, ranks in (("region", BALL, "region ball", 1, 1), ("mesh", mesh, "mesh cad", 1, 1), ("mesh on more ranks", mesh, "mesh cad", 1, most_ranks),
                                               ("upper half", BALL + "\n" + HALF, "region ball", 0.5, 1)):
        part = " from region half" if share < 1 else ""
        run = Run(executable, empty(before, f"solid sparger {words} blow {U}{part} {OUTPUT}"), ranks=ranks, files={"a.stl": sphere}, options=TIGHT)
        wanted, out = share * 4 * np.pi * R * R * U, outflows(run)
        numbers = said(run, "cells cut, blows ")
        area, flow = numbers[1], numbers[-1]
        c.below(f"{name}: volume flow against velocity times the drawn area, relative", abs(out[-1] / wanted - 1), 0.012 if share == 1 else 0.03)
        c.below("steady all the time, relative", np.abs(out / out[-1] - 1).max(), 1e-8)
        c.below("the report's flow, relative", abs(flow / out[-1] - 1), 1e-3)
        c.below("the report's area times velocity, relative", abs(area * U / out[-1] - 1), 1e-3)
        c.below("at the end of the run, relative", abs(said(run, "at the end, ")[0] / out[-1] - 1), 1e-3)
        c.below("gas out = gas in + displaced, relative", gas_balance(run.file("o.h5"), wanted), 1e-6)
        if "mesh" in name:
            c.below("the report's drawn area, relative", abs(numbers[2] / (4 * np.pi * R * R) - 1), 3e-3)
        t = run.thermo()
        c.below("continuity of every cell", column(t, "f_gas[5]").max(), 1e-6)
        flows[name] = [out[-1]] + [column(t, f"f_gas[{i}]")[-1] for i in (4, 19)]
    a, b = np.array(flows["mesh"]), np.array(flows["mesh on more ranks"])
    c.below("flow, pressure drop and force on more ranks, relative", np.abs(b / a - 1).max(), 1e-6)


def variable(c, executable):
    """A ramp: every frame has the flow of its time. And in two runs, and from a checkpoint."""
    ramp = f"variable U equal {U}*(1-exp(-step/15))\n" + BALL
    words = "solid sparger region ball blow v_U "
    run = Run(executable, empty(ramp, words + OUTPUT), options=TIGHT)
    out, steady = outflows(run), 4 * np.pi * R * R * U
    steps = 10 * np.arange(1, len(out) + 1)
    area = said(run, "through ")[0]
    c.below("a ramp: flow of every frame, relative to the last velocity", np.abs(out - U * area * (1 - np.exp(-steps / 15))).max() / steady, 2e-3)
    c.true("and the report says that it follows a variable", "blows 0 m/s now (variable)" in run.output)
    text = empty(ramp, words + OUTPUT, "run 20\nwrite_restart a.restart\nfix_modify gas checkpoint write a.h5\nrun 20")
    whole = Run(executable, text, options=TIGHT)
    t, one = whole.thermo(), run.thermo()
    c.below("two runs against one: force, relative", abs(column(t, "f_gas[19]")[-1] / column(one, "f_gas[19]")[-1] - 1), 1e-9)
    lines = [line for line in text.split("\n") if not line.startswith(("region box", "create_atoms", "set group"))]
    text = "\n".join(f"read_restart {whole.path}/a.restart" if line.startswith("create_box") else line for line in lines)
    text = text.replace("run 20\nwrite", f"fix_modify gas checkpoint read {whole.path}/a.h5\nrun 20\nwrite").split("write_restart")[0].replace(OUTPUT, "")
    on = Run(executable, text, options=TIGHT)
    names = [f"f_gas[{i}]" for i in (4, 17, 18, 19)]
    c.true("from a checkpoint: the same bits", [column(on.thermo(), n)[-1] for n in names] == [column(t, n)[-1] for n in names])


def fixed_bed(c, executable):
    """Grains that don't move, over a plate not in the grid's planes, and over an inlet on the side."""
    plate, n, d = 2.37e-3, 1000, 1e-3
    x = np.stack([SIDE * spread(n, 2), SIDE * spread(n, 3), spread(n, 5)], axis=1)
    x[:, 2] = 8e-3 + 7e-3 * x[:, 2] / x[:, 2].max()  # away from the plate, whose cut cells share grains out otherwise
    drops = {}
    for name in ("plate", "inlet"):
        before = f"region plate block INF INF INF INF INF {plate} units box" if name == "plate" else ""
        words = f"solid plate region plate blow {U}" if name == "plate" else f"boundary zlo inlet 0 0 {U}"
        run = Run(executable, head_with_particles(1e-4, boundary="f f f") + f"""{before}
fix gas all twogrid fine {N} {N} {N} density 1.2 viscosity 1.8e-5 every 10
fix_modify gas drag ergun boundary zhi pressure 0 {words}
thermo_style custom step {' '.join(f'f_gas[{i}]' for i in (4, 5, 6, 7))}
thermo_modify norm no
thermo 20
run 60
""", files={"particles.data": data_file(f"0 {SIDE} 0 {SIDE} 0 {HIGH}", x, d, 2500)}, options=TIGHT)
        t = run.thermo()
        drops[name] = column(t, "f_gas[4]")[-1]
        c.below(f"{name}: continuity, solids volume, momentum exchange", max(column(t, "f_gas[5]").max(), column(t, "f_gas[6]").max(), column(t, "f_gas[7]").max()), 1e-6)
    c.below(f"a bed over a plate, {drops['plate']:.3f} Pa, against over an inlet, {drops['inlet']:.3f} Pa, relative", abs(drops["plate"] / drops["inlet"] - 1), 3e-3)


def fluidised(c, executable):
    """Over a plate that is the grains' wall, too: over a window, pressure drop and floor carry them and give them their momentum."""
    L, H, d, low = 7.5e-3, 30e-3, 1e-3, 1.3e-3
    rng = np.random.default_rng(11)
    x = [(a + 1e-4 * rng.uniform(), b + 1e-4 * rng.uniform(), low + z) for z in np.arange(0.6, 8) * 1.02 * d for b in np.arange(0.6, 6.3) * 1.1 * d for a in np.arange(0.6, 6.3) * 1.1 * d]
    run = Run(executable, head_with_particles(2e-5, boundary="f f f", mu=0.0, gamman=0.01, kn=300, kt=300) + walls(xplane=(0, L), yplane=(0, L), zplane=(H,)) + f"""
{WALL.format(what=f'primitive type 1 zplane {low}').replace("absolute_damping", "store_force yes absolute_damping")}
fix grav all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 5 5 20 density 1.2 viscosity 1.8e-5 every 5
fix_modify gas boundary zhi pressure 0 solid floor wall steel blow 1.2 fluid_at 0.004 0.004 0.02
variable mvz atom mass*vz
compute mvz all reduce sum v_mvz
compute fz all reduce sum f_force_steel[3]
thermo 1
thermo_style custom step atoms f_gas[4] f_gas[5] f_gas[6] f_gas[7] c_mvz c_fz
thermo_modify format float %.14g
run 6000
""", files={"particles.data": data_file(f"0 {L} 0 {L} 0 {H}", x, d, 2500)})
    t = run.thermo()
    weight = len(x) * np.pi / 6 * d**3 * (2500 - 1.2) * 9.81
    after = t["Step"] > 2000
    drop, floor = column(t, "f_gas[4]")[after].mean() * L * L, column(t, "c_fz")[after].mean()
    gained = (column(t, "c_mvz")[-1] - column(t, "c_mvz")[after][0]) / (2e-5 * (after.sum() - 1))
    c.note(f"pressure drop {drop / weight:.4f}, floor {floor / weight:.4f}, momentum gained {gained / weight:.4f} of the weight")
    c.below("a fluidised bed over a plate: what is missing, over the weight", abs(drop + floor - gained - weight) / weight, 0.03)
    c.true("no grain has left", t["Atoms"][-1] == len(x))
    c.below("solids volume, momentum exchange", max(column(t, "f_gas[6]").max(), column(t, "f_gas[7]").max()), 1e-11)
    c.true("its velocity over that of minimum fluidisation is told", "U_s/U_mf" in run.output)


def refused(c, executable):
    one = "solid sparger region ball blow "
    for name, before, modify, words, more in (
            ("suction", BALL, one + "-0.1", ("solid sparger blow", "not below 0", "pressure 0"), {}),
            ("not a number", BALL, one + "fast", ("solid sparger blow", "fast", "a number or v_NAME"), {}),
            ("a variable that is not there", BALL, one + "v_gone", ("solid sparger blow", "no variable of that name"), {}),
            ("a variable below 0 later", "variable U equal 0.1-0.01*step\n" + BALL, one + "v_U", ("solid sparger blow", "v_U = -", "not below 0"), {}),
            ("a variable that is not finite", "variable U equal exp(60*step)\n" + BALL, one + "v_U", ("solid sparger blow", "v_U"), {}),
            ("no region", BALL, one + "0.1 from region gone", ("blow from region", "gone", "the id of a region"), {}),
            ("a region away from the surface", BALL + "\nregion away block 0 0.001 0 0.001 0 0.001 units box", one + "0.1 from region away", ("solid sparger blow", "no part of its surface", "region"), {}),
            ("a sheet", "fix cad all mesh/surface file a.stl type 1", "solid sparger mesh cad sheet blow 0.1", ("solid sparger blow", "sheet"), {}),
            ("twice", BALL, one + "0.1 blow 0.2", ("blow twice",), {}),
            ("no outlet", BALL, one + "0.1", ("solid sparger blow", "no outlet", "pressure 0"), dict(boundary="boundary zhi slip"))):
        run = Run(executable, empty(before, modify, **more), files={"a.stl": stl([(R, 0.0), (R, HIGH)])}, expect_success=False)
        errors = [line for line in run.output.split("\n") if line.startswith("ERROR")]
        c.true(f"{name}: {errors}", run.code != 0 and len(errors) == 1 and all(w in errors[0] for w in words))


def main():
    executable, ranks = arguments()
    c = Checks("bodies that blow")
    ball(c, executable, max(ranks))
    variable(c, executable)
    fixed_bed(c, executable)
    fluidised(c, executable)
    refused(c, executable)
    c.end()


if __name__ == "__main__":
    main()
