#!/usr/bin/python3
"""Our contact kernel, plane walls and integrator give the same bits as LIGGGHTS' own (-particles stock): position, velocity
and spin of every particle after 3000 steps of a bed that settles, one that flows down a slope, one that gas blows up; two types with
laws of their own and five sizes; absolute damping; forces that never pull; frozen particles; 1 and 2 ranks; through restart files; by each instruction set that the processor has.

Without this test an order of operations that differs, a contact that the list of near pairs misses, a spring that is
kept where LIGGGHTS drops it, or a wall's history that is left behind would change results by little, and nothing else would notice.
That our kernel ran is read from the scene report; that stock runs differ when a parameter does is checked as well.
Usage: same_bits.py EXECUTABLE RANKS...
"""
import numpy as np

from harness import Checks, Run, arguments

STEPS = 3000
SCRIPT = """
units si
atom_style granular
newton off
communicate single vel yes
boundary f f f
processors {ranks} 1 1
{create}
neighbor 0.3e-3 bin
neigh_modify delay 0
soft_particles yes
fix kn all property/global kn peratomtypepair 2 {kn}
fix kt all property/global kt peratomtypepair 2 80 50 50 20
fix gn all property/global gamman{abs} peratomtypepair 2 {gn}
fix gt all property/global gammat{abs} peratomtypepair 2 {gt}
fix mu all property/global coefficientFriction peratomtypepair 2 0.3 0.2 0.2 0.1
pair_style gran model hooke/stiffness tangential history {switches}
pair_coeff * *
timestep 1e-5
fix motion all nve/sphere
fix weight all gravity 9.81 vector {down}
fix xlo all wall/gran model hooke/stiffness tangential history primitive type 2 xplane 0 {switches}
fix xhi all wall/gran model hooke/stiffness tangential history primitive type 2 xplane 0.012 {switches}
fix ylo all wall/gran model hooke/stiffness tangential history primitive type 1 yplane 0 {switches}
fix yhi all wall/gran model hooke/stiffness tangential history primitive type 1 yplane 0.008 {switches}
fix zlo all wall/gran model hooke/stiffness tangential history primitive type 2 zplane 0 {switches}
{extra}
fix gas all twogrid fine 6 4 16 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 {U} boundary zhi pressure 0
fix_modify gas output off
thermo 1000
thermo_style custom step atoms ke
thermo_modify lost error norm no
dump out all custom {steps} state.* id x y z vx vy vz omegax omegay omegaz
dump_modify out format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g" sort id first no
"""
NEW = """
region box block 0 0.012 0 0.008 0 0.032 units box
create_box 2 box
region fill block 0 0.012 0 0.008 0 0.018 units box
fix a all particletemplate/sphere 15485863 atom_type 1 density constant 1000 radius constant {r[0]}
fix b all particletemplate/sphere 32452843 atom_type 2 density constant 2500 radius constant {r[1]}
fix c all particletemplate/sphere 49979687 atom_type 1 density constant 1500 radius constant {r[2]}
fix mix all particledistribution/discrete 67867967 3 a 0.4 b 0.3 c 0.3
fix fill all insert/pack seed 86028121 distributiontemplate mix vel constant 0 0 -0.3 insert_every once overlapcheck yes &
    all_in yes maxattempt 200 volumefraction_region 0.28 region fill
"""
BASE = dict(kn="100 120 120 300", gn="700 500 500 900", gt="350 250 250 450", abs="", switches="", down="0 0 -1", extra="", U="0", steps=STEPS,
            r=(0.5e-3, 0.5e-3, 0.5e-3))
SCENES = {
    "settled": dict(steps=9000),
    "flowing down a slope": dict(down="1 0.3 -1"),
    "blown up by gas": dict(U="0.8"),
    "two types, sizes 1:3": dict(r=(0.35e-3, 0.6e-3, 1.05e-3), down="0.4 0 -1"),
    "absolute damping": dict(abs="_abs", gn="2e-4 3e-4 3e-4 1e-4", gt="1e-4 1e-4 1e-4 1e-4", switches="absolute_damping on"),
    "forces that don't pull, no tangential damping": dict(switches="limitForce on tangential_damping off", gn="4000 4000 4000 4000"),
    # LIGGGHTS' own kernel serves the steps with stress, among them some at which the neighbour list is made anew.
    "stress asked for every 3 steps": dict(U="0.8", extra="compute s all stress/atom\ncompute sum all reduce sum c_s[1]\n"
                                           "fix stress all ave/time 3 1 3 c_sum"),
    "some particles frozen": dict(extra="region low block 0 0.012 0 0.008 0 0.004 units box\ngroup low region low\nfix ice low freeze"),
}


def script(values, ranks, create=None, **more):
    v = {**BASE, **values, **more}
    return SCRIPT.format(**{**v, "ranks": ranks, "create": create or NEW.format(r=v["r"])})


def state(run, step):
    return np.loadtxt(run.file(f"state.{step}"), skiprows=9)


def differing(a, b):
    """Numbers that are not the same bits."""
    return -1 if a.shape != b.shape else int(np.count_nonzero(a.view(np.int64) != b.view(np.int64)))


def both(executable, text, ranks, files=None):
    return [Run(executable, text, ranks, ["-particles", kernel], files=files) for kernel in ("stock", "auto")]


def main():
    executable, ranks = arguments()
    c = Checks("the same bits as LIGGGHTS' own contacts, walls and integrator")
    seen = {}
    for name, values in SCENES.items():
        for n in ranks:
            if n > 1 and name in ("settled", "absolute damping"):
                continue
            steps = values.get("steps", STEPS)
            stock, ours = both(executable, script(values, n) + f"run {steps}\n", n)
            c.true(f"{name}, {n} ranks: our kernel ran, LIGGGHTS' in the other",
                   "twogrid's kernel" in ours.output and "twogrid's kernel" not in stock.output)
            a, b = state(stock, steps), state(ours, steps)
            speed = np.abs(a[:, 4:7]).max()
            c.true(f"{name}, {n} ranks: {len(a)} particles, fastest {speed:.2g} m/s, {differing(a, b)} numbers differ",
                   len(a) > 300 and speed > 0 and np.all(np.isfinite(a)) and differing(a, b) == 0)
            seen[name, n] = a
    for kernel in ("plain", "AVX2", "AVX-512"):
        for name in ("two types, sizes 1:3", "some particles frozen"):
            run = Run(executable, script(SCENES[name], 1) + f"run {STEPS}\n", 1, ["-particles", kernel], expect_success=False)
            if run.code != 0 and "wanted auto" in run.output:
                print(f"     {kernel}: not on this processor")
                break
            c.true(f"{name}, kernel {kernel}: {differing(seen[name, 1], state(run, STEPS))} numbers differ",
                   f"twogrid's kernel ({kernel})" in run.output and differing(seen[name, 1], state(run, STEPS)) == 0)
    other = script(SCENES["blown up by gas"], 1, kn="100.00000001 120 120 300")
    changed = Run(executable, other + f"run {STEPS}\n", 1, ["-particles", "stock"])
    c.true("a change of kn by 1e-10 would be seen", differing(seen["blown up by gas", 1], state(changed, STEPS)) > 0)

    one = script(SCENES["blown up by gas"], 1)
    first = both(executable, one.replace(f"custom {STEPS}", "custom 1500") + "run 1000\nwrite_restart half\nrun 500\n", 1)
    c.true("across the end of a run, restart file written", differing(*(state(r, 1500) for r in first)) == 0)
    again = [Run(executable, script({}, 1, create=f"read_restart {r.file('half')}", steps=1500) + "run 500\n", 1, ["-particles", kernel])
             for r, kernel in zip(first, ("stock", "auto"))]
    c.true("after a restart, each from its own file", differing(*(state(r, 1500) for r in again)) == 0)
    c.end()


if __name__ == "__main__":
    main()
