#!/usr/bin/python3
"""What commands change between runs: sizes, places, the time step, walls, the box; and a run cut in pieces.

Without this test a bed could keep the void fraction of sizes and places that it no longer has; a command could push fluid about as if particles
had moved in no time (thousands of pascals in a bed of tens); particles that grow could be booked as deleted; the fluid could go on in a box that has become
another; what a first run is warned of could come unsaid in a later one; and a run in pieces could give another result. References: volumes of
spheres; a bed that had its size from the start; the run in one piece.
Usage: between_runs.py EXECUTABLE RANKS...
"""
import re

import numpy as np

from harness import Checks, Run, arguments, column, data_file, head, head_with_particles, walls

BOX = "0 0.008 0 0.008 0 0.016"
MOTION = {"nothing moves": "", "frozen": "fix motion all nve/sphere\nfix ice all freeze\n"}
GAS = """fix gas all twogrid fine 4 4 8 ratio 2 2 2 density {rho} viscosity {mu} every 10
fix_modify gas deposit exact boundary zlo inlet 0 0 {U} boundary zhi pressure 0
fix_modify gas {more}
compute e all reduce ave f_gas[7]
thermo_style custom step atoms f_gas[4] f_gas[6] f_gas[9] f_gas[14] f_gas[15] f_gas[16] c_e
thermo_modify format float %.15g
thermo 10
"""
WATER = dict(rho=1000, mu=1e-3, U=0.02, more="drag ergun")


def rows(run):
    t = run.thermo()
    return {n: column(t, f"f_gas[{n}]") for n in (4, 6, 9, 14, 15, 16)} | {"step": t["Step"], "e": t["e"]}


def sphere(executable, c, ranks):
    """One sphere of 1 mm in cells of 4 mm; twice as large, then in another cell."""
    small, large, cell = np.pi / 6 * 1e-9, np.pi / 6 * 8e-9, 64e-9
    for name, motion in MOTION.items():
        script = head_with_particles(1e-5, boundary="f f f", skin=1e-3) + motion + GAS.format(**{**WATER, "more": "drag ergun"}) + """
run 105
set group all diameter 2e-3 density 2500
run 100
displace_atoms all move 0.004 0.004 0.004 units box
run 100
"""
        t = rows(Run(executable, script, ranks, files={"particles.data": data_file(BOX, [(0.0021, 0.002, 0.006)], 1e-3, 2500)}))
        first, second = t["step"] < 106, (t["step"] > 105) & (t["step"] < 206)
        coupled = t["step"] % 10 == 0
        c.below(f"{name}: void fraction of the small sphere", abs(t[9][first] - (1 - small / cell)).max(), 1e-12)
        c.below(f"{name}: of the large one, from the next coupling on", abs(t[9][coupled & ~first] - (1 - large / cell)).max(), 1e-12)
        c.below(f"{name}: read by the sphere after it was moved", abs(t["e"][-1] - (1 - large / cell)), 1e-12)
        c.below(f"{name}: solids on the grid against those of the sphere", t[6].max(), 1e-13)
        c.below(f"{name}: pressure of the coupling after a command over the run's own", np.abs(t[4][coupled & ~first]).max() / np.abs(t[4][-1]), 3)
        c.below(f"{name}: growth booked, relative", abs(t[16][-1] / (large - small) - 1), 1e-12)
        c.below(f"{name}: inserted and deleted", t[14].max() + abs(t[15]).max(), 0)


def bed(executable, c, ranks):
    """Held spheres in water that become larger between runs, are moved by half a cell, and some are deleted."""
    x = np.array([(1e-3 * (i + 0.5), 1e-3 * (j + 0.5), 1e-3 * (k + 2.5)) for k in range(6) for j in range(8) for i in range(8)])

    def run(d, x, motion, after, more="drag ergun prolong linear"):
        script = head_with_particles(1e-5, boundary="f f f", skin=4e-4) + motion + GAS.format(**{**WATER, "more": more}) + "run 200\n" + after
        return rows(Run(executable, script, ranks, files={"particles.data": data_file(BOX, x, d, 2500)}))

    for name, motion in MOTION.items():
        t = run(0.8e-3, x, motion, "set group all diameter 0.98e-3 density 2500\nrun 10\nrun 300\n")
        fresh = run(0.98e-3, x, motion, "run 300\n")
        later = (t["step"] > 200) & (t["step"] % 10 == 0)
        c.note(f"{name}: {t[4][t['step'] == 200][0]:.4f} Pa, larger {t[4][-1]:.4f} Pa, fresh {fresh[4][-1]:.4f} Pa; after the command {np.abs(t[4][later]).max():.3f} Pa")
        c.below(f"{name}, larger: pressure at any coupling after the command over the bed's own", np.abs(t[4][later]).max() / fresh[4][-1], 2)
        c.below(f"{name}, larger: pressure in the end against a bed of that size, relative", abs(t[4][-1] / fresh[4][-1] - 1), 1e-3)
        c.below(f"{name}, larger: growth booked, relative", abs(t[16][-1] / (384 * np.pi / 6 * (0.98e-3**3 - 0.8e-3**3)) - 1), 1e-12)
        t = run(0.98e-3, x, motion, "displace_atoms all move 0 0 0.0031 units box\nrun 300\n")
        fresh = run(0.98e-3, x + (0, 0, 0.0031), motion, "run 300\n")
        later = (t["step"] > 200) & (t["step"] % 10 == 0)
        c.below(f"{name}, moved: pressure at any coupling after the command over the bed's own", np.abs(t[4][later]).max() / fresh[4][-1], 2)
        c.below(f"{name}, moved: pressure in the end against a bed there, relative", abs(t[4][-1] / fresh[4][-1] - 1), 1e-3)
        c.below(f"{name}, moved: inserted, deleted, grown", np.abs(t[14]).max() + np.abs(t[15]).max() + np.abs(t[16]).max(), 0)
    # all at once: what remains is told apart
    t = run(0.8e-3, x, MOTION["frozen"], """region low block INF INF INF INF 0 0.0045 units box
delete_atoms region low
set group all diameter 0.9e-3 density 2500
run 100
""")
    c.below("deleted and larger at once: deleted volume, relative", abs(t[15][-1] / (128 * np.pi / 6 * 0.8e-3**3) - 1), 1e-10)
    c.below("deleted and larger at once: growth, relative", abs(t[16][-1] / (256 * np.pi / 6 * (0.9e-3**3 - 0.8e-3**3)) - 1), 1e-12)


def growth(executable, c, ranks):
    """Spheres that grow during a run displace fluid: it is booked as growth, and the fluid that leaves is what they displace."""
    x = [(2e-3 * (i + 0.5), 2e-3 * (j + 0.5), 1e-3 * (k + 4.5)) for k in range(6) for j in range(4) for i in range(4)]
    for name, motion in MOTION.items():
        script = head_with_particles(1e-5, boundary="f f f", skin=1e-3) + motion + GAS.format(**{**WATER, "U": 0, "more": "drag ergun"}) + f"""
variable d equal 0.5e-3*(1+0.002*step)
fix grow all adapt 1 atom diameter v_d  # after the coupling of the same step
thermo 20
run 100
run 20
"""
        t = rows(Run(executable, script, ranks, files={"particles.data": data_file(BOX, x, 0.5e-3, 2500)}))
        V = lambda step: len(x) * np.pi / 6 * (0.5e-3 * (1 + 0.002 * step))**3
        c.below(f"{name}, growing: booked as growth at couplings, relative", max(abs(t[16][q] / (V(s - 1) - V(0)) - 1) for q, s in enumerate(t["step"]) if s % 20 == 0 and s > 0), 1e-9)
        c.below(f"{name}, growing: inserted and deleted", t[14].max() + abs(t[15]).max(), 0)
        c.below(f"{name}, growing: solids on the grid against those of the spheres", t[6].max(), 1e-13)


def sentences(executable, c, ranks):
    """What can't be served ends with a sentence on all ranks; what can, goes on."""
    begin = lambda boundary="f f f": head_with_particles(1e-5, boundary=boundary, skin=1e-3) + "fix motion all nve/sphere\n"
    data = {"particles.data": data_file(BOX, [(0.0021, 0.002, 0.006), (0.0061, 0.006, 0.006)], 1e-3, 2500)}
    gas = GAS.format(rho=1.2, mu=1.8e-5, U=0.1, more="drag ergun")
    for name, before, after, words in (
            ("larger box", "", "run 10\nchange_box all z final 0 0.02 units box\nrun 10\n", ["z from 0 to 0.02", "0 to 0.016", "change_box before"]),
            ("smaller box", "", "run 10\nchange_box all x final 0 0.007 units box\nrun 10\n", ["x from 0 to 0.007"]),
            ("periodic", "", "run 10\nchange_box all boundary p f f\nrun 10\n", ["direction x periodic"]),
            ("no longer periodic", "p f f", "run 10\nchange_box all boundary f f f\nrun 10\n", ["direction x not periodic"]),
            ("deform at once", "", "fix pull all deform 10 x scale 1.2\nrun 10\n", ["fix pull (deform)", "unfix pull"]),
            ("deform later", "", "run 10\nfix pull all deform 10 z vel 0.1\nrun 10\n", ["fix pull (deform)"]),
            ("respa at once", "", "run_style respa 2 2\nrun 10\n", ["run_style", "respa", "verlet"]),
            ("respa later", "", "run 10\nrun_style respa 2 2\nrun 10\n", ["run_style", "respa", "verlet"]),
            ("setforce in a region", "", "region r block INF INF INF INF 0 0.008 units box\nfix hold all setforce 0 0 0 region r\nrun 10\n", ["fix hold setforce", "a region"]),
            ("a plane across", "", "fix hold all planeforce 1 1 0\nrun 10\n", ["fix hold planeforce", "across"])):
        r = Run(executable, begin(before or "f f f") + gas + after, ranks, expect_success=False, files=data)
        line = next((line for line in r.output.splitlines() if line.startswith("ERROR")), "none")
        c.true(f"{name} ends with a sentence: {line}", r.code != 0 and all(w in line for w in words))
    for name, after in (("a box changed before the first run", "change_box all z final 0 0.02 units box\nrun 10\n"),
                        ("respa and back", "run 10\nrun_style respa 2 2\nrun_style verlet\nrun 10\n"),
                        ("deform and away with it", "run 10\nfix pull all deform 10 z vel 0.1\nunfix pull\nrun 10\n"),
                        ("no set-up", "run 15\nrun 10 pre no\nrun 10 pre no\n")):
        r = Run(executable, begin() + gas + after, ranks, files=data)
        c.true(f"{name} goes on", "ERROR" not in r.output)


def scene(executable, c):
    """Warnings of a later run, each once; the report of a scene whose particles are still to come."""
    data = {"particles.data": data_file(BOX, [(0.0021, 0.002, 0.006)], 1e-3, 2500)}
    gas = GAS.format(rho=1.2, mu=1.8e-5, U=0.1, more="drag ergun")
    r = Run(executable, head_with_particles(1e-5, boundary="f f f", skin=1e-3) + "fix motion all nve/sphere\n" + gas + "run 10\nrun 10\n" + walls(zplane=(0.012,)) + "run 10\nrun 10\ntimestep 1e-4\nrun 10\nrun 10\n", files=data)
    pieces = re.split(r"Setting up run|Setting up Verlet run|Memory usage per processor", r.output)
    said = [[w for w in re.findall(r"WARNING: fix gas twogrid: (.*)", p)] for p in r.output.split("Loop time")]
    c.true("nothing new, nothing said", not said[1])
    c.true("a wall is reported when it has come", len(said[2]) == 1 and "stands inside" in said[2][0])
    c.true("once", not said[3])
    c.true("a longer time step is", any("a contact lasts" in w for w in said[4]))
    c.true("once", not said[5])
    insertion = """fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
fix a all particletemplate/sphere 15485863 atom_type 1 density constant 2000 radius constant 0.0004
fix b all particletemplate/sphere 15485867 atom_type 1 density constant 2000 radius constant 0.0006
fix mix all particledistribution/discrete 32452843 2 a 0.5 b 0.5
region fill block 0.001 0.007 0.001 0.007 0.001 0.015 units box
fix pour all insert/rate/region seed 49979687 distributiontemplate mix nparticles 100 particlerate 1000 insert_every 100 overlapcheck yes all_in yes region fill
"""
    r = Run(executable, head(BOX, 1e-5, boundary="f f f", skin=1e-3) + insertion + gas + "run 10\n")
    report = r.output[r.output.index("twogrid: the scene"):]
    value = lambda name: float(re.search(re.escape(name) + r"\s+([\d.e+-]+)", report).group(1))
    line = re.search(r"DEM step .*", report).group(0)
    d = value("mean") if "mean" in re.search(r"particles .*", report).group(0) else 0
    c.true(f"templates: diameters, mean and density: {re.search(r'particles .*', report).group(0)}", "0.0008 to 0.0012" in report and "density 2000" in report and 0.0008 < d < 0.0012)
    c.true(f"templates: contact time: {line}", "unknown" not in line and "a contact lasts" in line)
    beta, alpha = 150 * 1.8e-5 * 0.6 / (0.064 * d**2), 1.75 * 1.2 / (0.064 * d)
    umf = (-beta + np.sqrt(beta**2 + 4 * alpha * (2000 - 1.2) * 9.81)) / (2 * alpha)
    c.below("templates: U_mf against Ergun's, relative", abs(value("U_mf") / umf - 1), 1e-3)
    c.true("templates: response time", "response times of the bed" in report)


def pieces(executable, c, ranks):
    """Grains without contacts, whole and in pieces that end at couplings and between them."""
    x = [(2e-3 * (i + 0.5), 2e-3 * (j + 0.5), 2e-3 * (k + 1.5)) for k in range(4) for j in range(4) for i in range(4)]
    for name, d, dt, mu, more in (("short steps", 4e-4, 1e-5, 1.8e-5, "drag ergun/wenyu"), ("formulation A", 4e-4, 1e-5, 1.8e-5, "drag difelice formulation A"),
                              ("stiff", 1e-4, 2e-5, 1.8e-3, "drag schiller/naumann"), ("flux held", 2e-4, 1e-5, 1.8e-4, "drag ergun/wenyu hold on")):
        ends = []
        for split in ("run 120\n", "run 60\nrun 60\n", "run 120 every 7 NULL\n", "run 33\nrun 0\nrun 87\n", "run 45\nrun 75 pre no\n"):
            script = head_with_particles(dt, boundary="p p f", skin=1e-3) + "fix weight all gravity 9.81 vector 0 0 -1\nfix motion all nve/sphere\n" + GAS.format(
                rho=1.2, mu=mu, U=0.4, more=more + " initial u 0 0 0.4") + """
dump end all custom 120 end.txt id x y z vx vy vz
dump_modify end format "%d %.17g %.17g %.17g %.17g %.17g %.17g"
""" + split
            r = Run(executable, script, ranks, ["-fluid_pressure_rtol", "1e-12"], files={"particles.data": data_file(BOX, x, d, 1000)})
            ends.append(r.dump("end.txt")[-1][1])
            c.below(f"{name}, {split.strip()!r}: solids on the grid", rows(r)[6].max(), 1e-12)
        speed = np.abs(ends[0]["vz"]).max()
        for split, end in zip(("two", "many, between couplings", "with a run of no step", "without set-up"), ends[1:]):
            c.below(f"{name}, in pieces ({split}): velocities, relative", max(np.abs(end[q] - ends[0][q]).max() for q in ("vx", "vy", "vz")) / speed, 1e-11)
            c.below(f"{name}, in pieces ({split}): ways, relative to the box", max(np.abs(end[q] - ends[0][q]).max() for q in "xyz") / 0.016, 1e-13)


def main():
    executable, ranks = arguments()
    c = Checks("between runs")
    for n in ranks:
        sphere(executable, c, n)
    bed(executable, c, ranks[-1])
    growth(executable, c, ranks[-1])
    sentences(executable, c, ranks[-1])
    scene(executable, c)
    pieces(executable, c, 1)
    c.end()


if __name__ == "__main__":
    main()
