#!/usr/bin/python3
"""Particles that nothing moves: a packed bed with no integrator, with `fix freeze`, and with an integrator for a part of it.

Without this test, what a fixed bed saves (contacts between couplings, the deposit of volumes that lie where they lay, the
drag of steps that repeat each other) could change its answer, or its particles, held in place, could gather velocity from
the coupling and feel a drag that is too small. Reference: the same bed run without any saving.
"""
import re

import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles, walls

L, H, D = 0.008, 0.016, 1e-3


def script(motion, extra=""):
    rng = np.random.default_rng(5)
    x = [(a + 4e-5 * rng.uniform(), b, z) for z in np.arange(0.5, 8) * D for b in np.arange(0.5, 8) * D for a in np.arange(0.5, 7.9) * 0.995 * D]
    return data_file(f"0 {L} 0 {L} 0 {H}", x, D, 2500), head_with_particles(1e-5, boundary="f f f", gamman=0.01, gammat=0.005) + walls(
        zplane=(0,)) + f"""
fix weight all gravity 9.81 vector 0 0 -1
{motion}
fix gas all twogrid fine 8 8 16 ratio 4 4 4 density 1000 viscosity 1e-3 every 50
fix_modify gas deposit trilinear prolong linear read trilinear
fix_modify gas boundary zlo inlet 0 0 0.02 boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
{extra}
dump d all custom 2000 d.txt id x y z vx vy vz fx fy fz f_gas[1] f_gas[2] f_gas[3] f_gas[7]
dump_modify d format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
thermo 1000
thermo_style custom step atoms f_gas[4] f_gas[6] f_gas[7]
thermo_modify format float %.17g
run 2000
"""


def run(executable, motion, extra=""):
    data, text = script(motion, extra)
    # Solved to rounding: what an unfinished iteration leaves would hide what is looked for.
    r = Run(executable, text, 1, ["-fluid_pressure_rtol", "1e-12"], files={"particles.data": data})
    pair = [float(m) for m in re.findall(r"Pair  time \(%\) = ([\d.]+)", r.output)]
    t = r.thermo()
    dp = t["f_gas[4]"] if "f_gas[4]" in t else t["gas[4]"]
    return dict(dp=dp[-1], momentum=max(t["f_gas[7]"] if "f_gas[7]" in t else t["gas[7]"]), end=r.dump("d.txt")[-1][1], pair=pair[-1], text=r.output)


def main():
    executable, _ = arguments()
    c = Checks("particles that nothing moves")
    saving = run(executable, "")
    full = run(executable, "", "variable one equal 1\nfix watch all ave/time 1 1 1 v_one")  # something looks at every step
    frozen = run(executable, "fix ice all freeze\nfix integrate all nve/sphere")
    c.note(f"pressure drop {full['dp']:.6f} Pa; contacts took {full['pair']:.3g} s, with the saving {saving['pair']:.3g} s")
    for name, r in (("no integrator", saving), ("frozen", frozen)):
        c.below(f"{name}: pressure drop against the run without savings, relative", abs(r["dp"] / full["dp"] - 1), 1e-12)
        size = np.abs(full["end"]["f_gas[3]"]).max()
        c.below(f"{name}: drag of every particle, relative", max(np.abs(r["end"][f"f_gas[{q}]"] - full["end"][f"f_gas[{q}]"]).max() for q in (1, 2, 3)) / size, 1e-12)
        c.below(f"{name}: velocity of the particles", max(np.abs(r["end"][q]).max() for q in ("vx", "vy", "vz")), 0)
        c.below(f"{name}: momentum exchange", r["momentum"], 1e-12)
    for q in ("fx", "fy", "fz"):
        c.below(f"no integrator: {q} at an output, contacts in it, relative", np.abs(saving["end"][q] - full["end"][q]).max() / np.abs(full["end"]["fz"]).max(), 1e-12)
    c.below("contacts cost, with the saving over without", saving["pair"] / full["pair"], 0.3)
    c.true("the scene report says so", "no particle moves" in saving["text"] and "no particle moves" not in frozen["text"])
    c.end()


if __name__ == "__main__":
    main()
