#!/usr/bin/python3
"""The same bed in the same round vessel, turned about its axis and shifted on the grid: the same pressure drop and the same minimum
fluidisation.

    turned_bed.py EXECUTABLE [RANKS] [--long]      --long: beds that bubble and settle, five packings, instead of one that is held

What would pass falsely without it: cut cells in whose particles feel another drag than those of whole ones, or gas that passes along a wall
at an angle to the grid otherwise than along one that lies in it: such faults hang on how the grid lies, and nothing else here does.

In the short form the packing is held, and turns and moves with the vessel. The gas sees it through other particle cells each time, so the
drop is the same but for what a mean over cells of three diameters makes of a packing.
"""
import os

import numpy as np

from harness import Checks, Run, arguments, column, data_file, head_with_particles, long_form
from bodies import stl

D, RHO_P, R = 1.5e-3, 1000.0, 12e-3
WIDE, HIGH, CELL = 27e-3, 54e-3, 1.5e-3
RHO, MU, G = 1.2, 1.8e-5, 9.81
COUNT, FACETS, DT, EVERY = 2400, 48, 2.5e-5, 10
SECTION = 0.5 * FACETS * R * R * np.sin(2 * np.pi / FACETS)
WEIGHT = COUNT * np.pi / 6 * D**3 * (RHO_P - RHO) * G / SECTION  # buoyant, over the section (Pa)
U_HELD, U_BUBBLING = 0.2, 0.8
TIMES = (0.2, 0.5, 0.8)  # s: rising, held, falling
# degrees; the axis, in fine cells from the middle of the box
PLACES = ((0, 0, 0), (17, 0, 0), (45, 0, 0), (0, 0.37, -0.71), (17, -0.9, 0.45))
WALLS = """fix cad all mesh/surface file vessel.stl type 1
fix steel all wall/gran model hooke/stiffness tangential history mesh n_meshes 1 meshes cad absolute_damping on
fix floor all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0 absolute_damping on
"""
HEAD = dict(boundary="f f f", kn=50, kt=14.3, gamman=1.4e-3, gammat=7e-4, skin=0.5e-3)


def turned(x, degrees):
    a = np.radians(degrees)
    return np.stack([x[:, 0] * np.cos(a) - x[:, 1] * np.sin(a), x[:, 0] * np.sin(a) + x[:, 1] * np.cos(a), x[:, 2]], axis=1)


def box():
    return f"0 {WIDE!r} 0 {WIDE!r} 0 {HIGH!r}"


def vessel(x, place):
    """The packing (about the axis) and its wall, turned and moved: files of a run."""
    degrees, i, j = place
    centre = np.array([0.5 * WIDE + i * CELL, 0.5 * WIDE + j * CELL])
    a = np.radians(degrees)
    ring = stl([(R, 0.0), (R, HIGH)], 2, (0.0, 0.0), FACETS)
    lines = []
    for line in ring.split("\n"):
        if line.startswith("vertex"):
            p, q, z = (float(w) for w in line.split()[1:])
            line = f"vertex {centre[0] + p * np.cos(a) - q * np.sin(a):.12g} {centre[1] + p * np.sin(a) + q * np.cos(a):.12g} {z:.12g}"
        lines.append(line)
    at = turned(x, degrees)
    at[:, :2] += centre
    return {"particles.data": data_file(box(), at, D, RHO_P), "vessel.stl": "\n".join(lines)}


def packing(executable, seed):
    """A settled bed, its axis in the origin."""
    rng = np.random.default_rng(seed)
    step = 1.08 * D
    spots = np.array([[i * step, j * step, (k + 0.5) * step] for k in range(40) for j in range(-8, 9) for i in range(-8, 9)
                      if np.hypot(i, j) * step < R - 0.65 * D])[:COUNT]
    x = spots + rng.uniform(-0.035 * D, 0.035 * D, spots.shape)
    script = head_with_particles(DT, **HEAD) + WALLS + f"""
fix weight all gravity {G} vector 0 0 -1
fix motion all nve/sphere
velocity all set 0 0 -0.2 units box
fix slow all viscous 2e-6
thermo 20000
dump d all custom 20000 settled.txt id x y z
dump_modify d format "%d %.17g %.17g %.17g"
run 20000
"""
    last = Run(executable, script, files=vessel(x, (0, 0, 0)), timeout=600).dump("settled.txt")[-1][1]
    return np.stack([last[a] - (0.5 * WIDE if a != "z" else 0) for a in "xyz"], axis=1)


def gas(words):
    n, m = round(WIDE / CELL), round(HIGH / CELL)
    return f"""fix gas all twogrid fine {n} {n} {m} ratio 3 3 3 density {RHO} viscosity {MU} every {EVERY}
fix_modify gas drag ergun/wenyu formulation B solid vessel mesh cad
fix_modify gas boundary zlo inlet 0 0 {words} boundary zhi pressure 0
"""


def held(executable, x, place, ranks):
    run = Run(executable, head_with_particles(DT, **HEAD) + WALLS + gas(repr(U_HELD)) + """
thermo_style custom step f_gas[4] f_gas[6]
thermo_modify format float %.17g lost error norm no
thermo 1000
run 1000
""", ranks, files=vessel(x, place), timeout=300)
    return column(run.thermo(), "f_gas[4]")[-1]


def bubbling(executable, x, place, ranks):
    """Through bubbling and back: mean drop over the weight at U_BUBBLING, and the velocity at which a fit of the fixed bed's drop is the weight."""
    t = np.round(np.cumsum(TIMES) / DT).astype(int)
    script = head_with_particles(DT, **HEAD) + WALLS + f"""
fix weight all gravity {G} vector 0 0 -1
fix motion all nve/sphere
variable rise equal ramp({U_HELD},{U_BUBBLING})
variable fall equal ramp({U_BUBBLING},0.12)
variable U equal {U_HELD}
""" + gas("v_U") + f"""
fix now all ave/time {EVERY} 20 {20 * EVERY} v_U f_gas[4] f_gas[6] file now.txt
thermo_modify lost error norm no
thermo 10000
variable U equal v_rise
run {t[0]}
variable U equal {U_BUBBLING}
run {t[1] - t[0]}
variable U equal v_fall
run {t[2] - t[1]}
"""
    run = Run(executable, script, ranks, files=vessel(x, place), timeout=3000)
    step, U, drop, ledger = np.loadtxt(run.file("now.txt"), unpack=True)
    steady, falling = (step > 0.5 * (t[0] + t[1])) & (step <= t[1]), step > t[1]
    at_rest = step > step[falling & (drop > 0.85 * WEIGHT)].max()  # slugs make the drop swing until then
    fixed = at_rest & (drop < 0.75 * WEIGHT) & (drop > 0.1 * WEIGHT)
    (a, b), *_ = np.linalg.lstsq(np.stack([U[fixed], U[fixed]**2], axis=1), drop[fixed], rcond=None)
    return drop[steady].mean() / WEIGHT, 2 * WEIGHT / (a + np.sqrt(a * a + 4 * b * WEIGHT)), ledger.max()


def no_effect_of_place(c, name, value, most_error):
    """value[packing, place]: what the places differ by, beside what is left when each packing's and each place's mean are taken off."""
    packings, places = value.shape
    of_place = value.mean(axis=0) - value.mean()
    rest = value - value.mean(axis=1, keepdims=True) - of_place
    error = np.sqrt(np.sum(rest**2) / ((packings - 1) * (places - 1)) * (1 - 1 / places) / packings)
    for place, mean in zip(PLACES, value.mean(axis=0)):
        c.note(f"{name}, turned by {place[0]} degrees, moved by {place[1]}, {place[2]} cells: {mean:.4f} +- {error:.4f} ({100 * (mean / value.mean() - 1):+.2f} % of the mean)")
    c.below(f"{name}: largest effect of a place over its standard error", np.abs(of_place).max() / error, 4)
    c.below(f"{name}: that error over the mean", error / value.mean(), most_error)


def main():
    executable, ranks = arguments()
    c = Checks("the same bed, turned and shifted")
    seeds = (1, 2, 3) if long_form() else (1,)
    beds = [packing(executable, seed) for seed in seeds]
    x = beds[0]
    c.note(f"{len(x)} spheres, top at {1e3 * x[:, 2].max():.1f} mm, outermost centre at {1e3 * np.hypot(x[:, 0], x[:, 1]).max():.3f} mm of {1e3 * R:.1f}")
    drops = np.array([[held(executable, x, place, ranks[-1]) / WEIGHT for place in PLACES] for x in beds])
    for place, drop in zip(PLACES, drops.mean(axis=0)):
        c.note(f"held, turned by {place[0]} degrees, moved by {place[1]}, {place[2]} cells: drop over weight {drop:.4f}, {100 * (drop / drops.mean() - 1):+.2f} % of the mean")
    c.below("held: largest difference between places over the mean", (drops.max(axis=1) - drops.min(axis=1)).max() / drops.mean(), 0.015)
    if long_form():
        results = np.array([[bubbling(executable, x, place, ranks[-1]) for place in PLACES[:4]] for x in beds])
        c.below("solids ledger", results[:, :, 2].max(), 1e-13)
        no_effect_of_place(c, "bubbling, drop over weight", results[:, :, 0], 0.02)
        no_effect_of_place(c, "minimum fluidisation, m/s", results[:, :, 1], 0.02)
    c.end()


if __name__ == "__main__":
    main()
