#!/usr/bin/python3
"""Particles that something holds, or moves on a prescribed way: what a fix does to positions and velocities decides, not where LIGGGHTS calls it.

Without this test a fix that acts where integrators act (heat conduction, moving meshes) could make particles of a fixed bed count as free: they
gather velocity from the coupling, and their drag is too small; or particles on a prescribed way, or held in one direction only, could do so. References: the
same bed with no fix at all; Stokes' law with a steady wind, whose directions don't know of each other.
Usage: held.py EXECUTABLE RANKS...
"""
import numpy as np

from harness import Checks, Run, arguments, column, data_file, head_with_particles

BOX, D, RHO_P, MU = "0 0.008 0 0.008 0 0.016", 0.98e-3, 2500, 1e-3
HEAT = """fix cond all property/global thermalConductivity peratomtype 1
fix capa all property/global thermalCapacity peratomtype 1000
fix heat all heat/gran/conduction initial_temperature 300
"""
MESH = """fix lid all mesh/surface file lid.stl type 1
fix shake all move/mesh mesh lid linear 0 0 0.01
"""
LID = "solid lid\nfacet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x} {y} 0.014\n" for x, y in ((0.001, 0.001), (0.007, 0.001), (0.001, 0.007))) + "endloop\nendfacet\nendsolid lid\n"
NVE = "fix motion all nve/sphere\n"
# before the fluid's fix, behind it
BEDS = {
    "heat/gran": (HEAT, ""),
    "move/mesh": (MESH, ""),
    "freeze": (NVE + "fix ice all freeze\n", ""),
    "nve/noforce": ("fix motion all nve/noforce\n", ""),
    "move linear": ("fix motion all move linear 0 0 0 units box\n", ""),
    "move variable": ("variable none equal 0\nfix motion all move variable v_none v_none v_none v_none v_none v_none\n", ""),
    "setforce": (NVE, "fix hold all setforce 0 0 0\n"),
    "setforce before": (NVE + "fix hold all setforce 0 0 0\n", ""),
    "lineforce, planeforce": (NVE, "fix line all lineforce 0 0 1\nfix plane all planeforce 0 0 -1\n"),
}


def bed(executable, before, behind, dt, every, ranks=1):
    x = [(1e-3 * (i + 0.5), 1e-3 * (j + 0.5), 1e-3 * (k + 1.5)) for k in range(6) for j in range(8) for i in range(8)]
    script = head_with_particles(dt, boundary="f f f", skin=3e-4) + before + f"""
fix gas all twogrid fine 8 8 16 ratio 4 4 4 density 1000 viscosity {MU} every {every}
fix_modify gas drag ergun deposit exact read cell
fix_modify gas boundary zlo inlet 0 0 0.02 boundary zhi pressure 0 boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
{behind}
variable far equal bound(all,zmax)
compute speed all reduce max vx vy vz
compute F all reduce sum f_gas[3]
thermo_style custom step atoms f_gas[4] f_gas[7] c_speed[1] c_speed[3] v_far c_F
thermo_modify format float %.15g
thermo {round(0.05 / dt)}
run {round(0.1 / dt)}
"""
    r = Run(executable, script, ranks, ["-fluid_pressure_rtol", "1e-10"], files={"particles.data": data_file(BOX, x, D, RHO_P), "lid.stl": LID})
    t = r.thermo()
    return dict(dp=column(t, "f_gas[4]")[-1], momentum=column(t, "f_gas[7]").max(), speed=max(abs(t["speed[1]"]).max(), abs(t["speed[3]"]).max()), far=t["far"][-1], F=t["F"][-1])


WIND, G = 0.02, 9.81


def wind(executable, before, behind, dt, every, one_way="yes", steps=40):
    """Spheres far from each other in a wind along x, weight along z, Stokes' drag: t, x, y, z, v, drag of the first."""
    x = [(0.002, 0.004, 0.008), (0.006, 0.004, 0.008)]
    script = head_with_particles(dt, boundary="p p p", skin=3e-4) + "fix weight all gravity 9.81 vector 0 0 -1\n" + before + f"""
fix gas all twogrid fine 4 4 8 ratio 2 2 2 density 1 viscosity {MU} every {every}
fix_modify gas drag stokes formulation A initial u {WIND} 0 0 one-way {one_way}
{behind}
dump d all custom {steps} d.txt id x y z vx vy vz f_gas[1] f_gas[3]
dump_modify d format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
thermo_style custom step atoms f_gas[7]
thermo 1
run {steps}
"""
    r = Run(executable, script, files={"particles.data": data_file(BOX, x, 1e-4, RHO_P)})
    return {k: v[0] for k, v in r.dump("d.txt")[-1][1].items()}, column(r.thermo(), "f_gas[7]").max()


def partly(executable, c):
    m, b = RHO_P * np.pi / 6 * 1e-12, 3 * np.pi * MU * 1e-4
    tau, weight = m / b, (RHO_P - 1.0) / RHO_P * G
    fall = lambda t: -weight * tau * (t - tau * (1 - np.exp(-t / tau)))
    drift = lambda t: WIND * (t - tau * (1 - np.exp(-t / tau)))
    x0, z0 = 0.002, 0.008
    # what may move; Stokes' drag is linear, so each direction has its exact way
    for name, before, behind, free in (
            ("setforce 0 0 NULL", NVE, "fix hold all setforce 0 0 NULL\n", "z"),
            ("planeforce across z", NVE, "fix hold all planeforce 0 0 1\n", "x"),
            ("move linear 0 NULL NULL", "fix motion all move linear 0 NULL NULL units box\n", "", "z"),
            ("free", NVE, "", "xyz")):
        for dt, stiff in ((tau / 400, ""), (tau / 5, " (stiff)")):
            steps = 40
            p, momentum = wind(executable, before, behind, dt, 10, steps=steps)
            t = steps * dt
            size = 1e-9 if stiff else 3e-5  # below kStiff the step has an error of k^2/8
            wx, wz = x0 + (drift(t) if "x" in free else 0), z0 + (fall(t) if "z" in free else 0)
            c.below(f"{name}{stiff}: way along x, relative to the wind's", abs(p["x"] - wx) / (WIND * t), size if "x" in free else 0)
            c.below(f"{name}{stiff}: way along z, relative to the free one", abs(p["z"] - wz) / abs(fall(t)), size if "z" in free else 0)
            if "x" not in free:
                c.below(f"{name}{stiff}: velocity along x", abs(p["vx"]), 0)
                c.below(f"{name}{stiff}: drag along x, against Stokes' law", abs(p["f_gas[1]"] / (b * WIND) - 1), 1e-9)
        p, momentum = wind(executable, before, behind, tau / 20, 10, "no")
        c.below(f"{name}: momentum of both phases and of what holds, two-way", momentum, 1e-12)
        if "x" not in free:
            c.below(f"{name}, two-way: velocity along x", abs(p["vx"]), 0)


def prescribed(executable, c):
    dt, steps = 1e-4, 40
    wiggle = "fix motion all move wiggle 0.001 NULL 0 0.01 units box\n"
    p, momentum = wind(executable, wiggle, "", dt, 10, "no")
    at = 2 * np.pi * steps * dt / 0.01
    c.below("wiggle: x on its way", abs(p["x"] - 0.002 - 0.001 * np.sin(at)), 1e-15)
    c.below("wiggle: velocity", abs(p["vx"] - 0.001 * 2 * np.pi / 0.01 * np.cos(at)), 1e-15)
    c.below("wiggle: momentum of both phases", momentum, 1e-12)
    p, momentum = wind(executable, "fix motion all move rotate 0.004 0.004 0.008 0 0 1 0.1 units box\n", "", dt, 10, "no")
    c.below("rotate: radius", abs(np.hypot(p["x"] - 0.004, p["y"] - 0.004) - 0.002), 1e-15)
    c.below("rotate: height", abs(p["z"] - 0.008), 0)
    c.below("rotate: momentum of both phases", momentum, 1e-12)


def main():
    executable, ranks = arguments()
    c = Checks("particles that something holds")
    reference = bed(executable, "", "", 1e-3, 1)
    c.note(f"nothing: {reference['dp']:.6f} Pa, {reference['F']:.9e} N")
    short = bed(executable, "", "", 1e-4, 10)
    c.below("nothing: drag at a tenth of the DEM step, relative", abs(short["F"] / reference["F"] - 1), 1e-9)
    for name, (before, behind) in BEDS.items():
        r = bed(executable, before, behind, 1e-3, 1, ranks[-1] if name == "heat/gran" else 1)
        c.below(f"{name}: pressure drop against nothing, relative", abs(r["dp"] / reference["dp"] - 1), 1e-9)
        c.below(f"{name}: drag against nothing, relative", abs(r["F"] / reference["F"] - 1), 1e-9)
        c.below(f"{name}: velocity", r["speed"], 0)
        c.below(f"{name}: place", abs(r["far"] - reference["far"]), 0)
        c.below(f"{name}: momentum exchange", r["momentum"], 1e-12)
    partly(executable, c)
    prescribed(executable, c)
    c.end()


if __name__ == "__main__":
    main()
