#!/usr/bin/python3
"""A run that goes on in another process from a restart file and a checkpoint: every bit of particles, fluid and figures is that of the
run that was never left; on other ranks it goes on with nothing lost. Files that don't belong there are refused.

Without this test a coupled run could begin its fluid anew, or leave out a part of what a next step reads (the levels before, the first
guess of the pressure, the flux that is held), and go on with other numbers that look as good.
Usage: checkpoint.py EXECUTABLE RANKS...
"""
import os
import re
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np

from harness import Checks, Run, arguments, data_file, head, head_with_particles, walls

BOX, D = "0 0.008 0 0.008 0 0.016", 1e-3
WALLS = walls(zplane=(0,))
SCENES = {
    "bed, formulation B": ("1.2", "1.8e-5", "boundary zlo inlet 0 0 0.6 boundary zhi pressure 0"),
    "bed, formulation A": ("1.2", "1.8e-5", "formulation A method paper boundary zlo inlet 0 0 0.6 boundary zhi pressure 0"),
    "liquid, flux held": ("1000", "1e-3", "hold on method jets boundary zlo inlet 0 0 0.02 boundary zhi pressure 0"),
    "flow rate, implicit, central": ("1.2", "1.8e-3", "boundary zlo periodic flow_rate z 0.3 implicit on convection central method kernel 0.004"),
}
DUMP = """dump bits all custom {at} {name} id x y z vx vy vz omegax omegay omegaz f_gas[1] f_gas[3] f_gas[6] f_gas[7] f_gas[10]
dump_modify bits sort id first no format "%d""" + 14 * " %.17g" + """"
"""


def gas(scene, name):
    rho, mu, more = SCENES[scene]
    periodic = "periodic" in more
    return (WALLS if not periodic else "") + f"""
fix weight all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 8 8 16 ratio 4 4 4 density {rho} viscosity {mu} every 10
fix_modify gas {more}
fix_modify gas output every 100 file {name}.h5 fields u p eps faces
thermo_style custom step atoms ke f_gas[1] f_gas[2] f_gas[3] f_gas[4] f_gas[8] f_gas[9] f_gas[14]
thermo_modify format float %.17g
thermo 10
""".replace("boundary zlo periodic", "")


def positions():
    return [(1e-3 * (i + 0.7), 1e-3 * (j + 0.7), 1e-3 * (k + 0.7)) for k in range(8) for j in range(6) for i in range(6)]


def first(executable, ranks, scene):
    random = np.random.default_rng(2)
    x = positions()
    z = "p" if "periodic" in SCENES[scene][2] else "f"
    script = head_with_particles(1e-5, boundary=f"p p {z}", skin=0.4e-3, gamman=0.01, gammat=0.005) + gas(scene, "one")
    return Run(executable, script + "run 205\nwrite_restart half\nfix_modify gas checkpoint write half.h5\n" + DUMP.format(at=100, name="one.dump") + "run 195\nfix_modify gas checkpoint write late.h5\n", ranks,
               files={"particles.data": data_file(BOX, x, D, 2500, random.uniform(-0.05, 0.05, (len(x), 3)))})


def second(executable, ranks, before, scene, checkpoint="half.h5", change=lambda s: s, success=True):
    z = "p" if "periodic" in SCENES[scene][2] else "f"
    script = head(BOX, 1e-5, boundary=f"p p {z}", skin=0.4e-3, gamman=0.01, gammat=0.005)
    script = script[:script.index("region box")] + f"read_restart {before.file('half')}\n" + script[script.index("neighbor"):]
    script += gas(scene, "two") + f"fix_modify gas checkpoint read {before.file(checkpoint)}\n" + DUMP.format(at=100, name="two.dump") + "run 195\n"
    return Run(executable, change(script), ranks, expect_success=success)


def fields(run, name):
    with h5py.File(run.file(name + ".h5")) as f:
        last = sorted(f["fluid"])[-1]
        out = {}
        f["fluid"][last].visititems(lambda n, d: out.__setitem__(n, d[...]) if isinstance(d, h5py.Dataset) else None)
        return out


def same(a, b):
    return a.shape == b.shape and a.dtype == b.dtype and np.array_equal(a.view(np.int64), b.view(np.int64))


def thermo_since(run, step):
    """Of the last run: its first line is that of this step."""
    t = run.thermo()
    first = np.flatnonzero(t["Step"] == step)[-1]
    return np.array([v[first:] for v in t.values()])


def main():
    executable, ranks = arguments()
    c = Checks("a run goes on from a checkpoint")
    for scene in SCENES:
        for n in ranks:
            a = first(executable, n, scene)
            b = second(executable, n, a, scene)
            lines = [open(r.file(f)).read() for r, f in ((a, "one.dump"), (b, "two.dump"))]
            c.true(f"{scene}, {n} ranks: particles and what they know, every bit ({lines[0].count('TIMESTEP')} dumps)", lines[0] == lines[1] and "ITEM" in lines[0])
            one, two = fields(a, "one"), fields(b, "two")
            differ = [k for k in one if k not in two or not same(one[k], two[k])]
            c.true(f"fluid, every bit of {len(one)} datasets{': but ' + ', '.join(differ) if differ else ''}", not differ and len(one) == len(two) >= 9)
            x, y = thermo_since(a, 205), thermo_since(b, 205)
            c.true(f"figures of {x.shape[1]} thermo lines", x.shape == y.shape and x.shape[1] > 15 and same(x, y))
            c.true("says so, and no longer that the fluid starts anew", "goes on from" in b.output and "holds no fluid" not in b.output)
            c.true("nothing half-written", not os.path.exists(a.file("half.h5.part")))
    scene = "bed, formulation B"
    a = first(executable, ranks[-1], scene)
    for n in {1, 4} - {ranks[-1]}:
        b = second(executable, n, a, scene)
        t, s = a.thermo(), b.thermo()
        c.true(f"from {ranks[-1]} ranks on {n}: all particles, none counts as inserted", s["Atoms"][-1] == 288 and s["gas[14]"][-1] == 0)
        for name in ("gas[1]", "gas[4]", "gas[9]"):
            c.below(f"{name} at the first coupling, relative difference", abs(s[name][s["Step"] == 210][0] / t[name][t["Step"] == 210][0] - 1), 1e-5)
    refused = (("another grid", lambda s: s.replace("fine 8 8 16", "fine 8 8 32"), "half.h5", "another scene"),
                                             ("other convection", lambda s: s.replace("fix_modify gas checkpoint", "fix_modify gas convection central interpolate linear\nfix_modify gas checkpoint"), "half.h5", "another scene"),
                                             ("another way of coupling", lambda s: s.replace("fix_modify gas checkpoint", "fix_modify gas one-way yes\nfix_modify gas checkpoint"), "half.h5", "another scene"),
                                             ("no such file", lambda s: s, "none.h5", "No such file"),
                                             ("an output file", lambda s: s, "one.h5", "no checkpoint"),
                                             ("a restart file", lambda s: s, "half", "no checkpoint"),
                                             ("a file cut short", lambda s: s, "cut.h5", "cut.h5"),
                                             ("one bit flipped", lambda s: s, "flipped.h5", "is damaged"),
                                             ("no restart file", lambda s: re.sub(r"read_restart \S+", f"read_data {a.file('particles.data')}", s).replace("fix gas all", "reset_timestep 205\nfix gas all"), "half.h5", "read_restart in place"),
                                             ("another ID", lambda s: s.replace("gas ", "air ").replace("f_gas", "f_air"), "half.h5", "read_restart in place"),
                                             ("of a later step", lambda s: s, "late.h5", "of step 400 with 288 particles, wanted one of step 205"))
    with open(a.file("half.h5"), "rb") as whole, open(a.file("cut.h5"), "wb") as cut:
        data = whole.read()
        cut.write(data[:len(data) * 2 // 3])
    with open(a.file("flipped.h5"), "wb") as flipped:
        at = len(data) * 2 // 3
        flipped.write(data[:at] + bytes([data[at] ^ 16]) + data[at + 1:])
    with ThreadPoolExecutor(3) as pool:  # most of their time is mpirun's beginning and end
        runs = list(pool.map(lambda r: second(executable, ranks[-1], a, scene, r[2], r[1], False), refused))
    for (what, _, _, wanted), b in zip(refused, runs):
        sentence = next((line for line in b.output.splitlines() if line.startswith("ERROR")), "none")
        c.true(f"{what}: {sentence[:150]}", b.code != 0 and wanted in sentence)
    c.end()


if __name__ == "__main__":
    main()
