#!/usr/bin/python3
"""A jet under a bed and its mirror image stay mirror images: particles and gas know no left and right. 4680 grains at shaken places, the jet
in the middle; one run from x, one from L - x. They part only by round-off, which grows as beds of colliding grains are chaotic.

Without this test a rule for ties, an order of sums or a stencil that leans to one side would pass every check of conservation, and
a jet would lean with it. That it would be seen: the same run with the jet one cell off the middle.
Usage: mirror.py EXECUTABLE RANKS...
"""
import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles, walls

L, D, H = 0.0312, 0.00495, 0.072
STEPS = 400


def places():
    shake = np.random.default_rng(3)
    return np.array([((i + 0.5) * 0.8e-3 + shake.uniform(-2e-5, 2e-5), (j + 0.5) * 0.8e-3 + shake.uniform(-2e-5, 2e-5), (k + 0.5) * 0.79e-3)
                     for k in range(20) for j in range(6) for i in range(39)])


def last(executable, x, methods, ranks, jet=(0.0148, 0.0164)):
    script = head_with_particles(1.25e-5, processors=f"{ranks} 1 1", boundary="f f f", gamman=2e-4, gammat=1e-4) + walls(
        xplane=(0, L), yplane=(0, D), zplane=(0,)) + f"""
fix weight all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 78 1 48 ratio 6 1 2 density 1.2 viscosity 1.8e-5 every 4
fix_modify gas {methods}
fix_modify gas boundary zlo inlet 0 0 0.35 boundary zhi pressure 0
fix_modify gas boundary zlo patch jet rect {jet[0]} {jet[1]} 0 {D} inlet 0 0 6
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
fix_modify gas output off
thermo 1000
dump end all custom {STEPS} end.* id x y z vx vy vz
dump_modify end format "%d %.17g %.17g %.17g %.17g %.17g %.17g" sort id first no
run {STEPS}
"""
    run = Run(executable, script, ranks, ["-fluid_pressure_rtol", "1e-13"],
              files={"particles.data": data_file(f"0 {L} 0 {D} 0 {H}", [tuple(p) for p in x], 0.75e-3, 2500)})
    return np.loadtxt(run.file(f"end.{STEPS}"), skiprows=9)[:, 1:]


def main():
    executable, ranks = arguments()
    c = Checks("a jet and its mirror image")
    x = places()
    mirrored = x * [-1, 1, 1] + [L, 0, 0]
    flip, shift = np.array([-1, 1, 1, -1, 1, 1]), np.array([L, 0, 0, 0, 0, 0])
    for n in ranks:
        for methods in ("deposit centroid prolong constant read cell", "deposit trilinear prolong linear read trilinear",
                        "deposit exact prolong linear read fine/trilinear"):
            a, b = last(executable, x, methods, n), last(executable, mirrored, methods, n) * flip + shift
            apart, speed = np.abs(a - b)[:, 3:].max(), np.abs(a[:, 3:]).max()
            c.true(f"{n} ranks, {methods}: velocities {apart / speed:.1e} of the largest ({speed:.2g} m/s) apart", speed > 0.05 and apart < 1e-9 * speed)
    a = last(executable, x, "deposit trilinear prolong linear read trilinear", 1, (0.0152, 0.0168))
    b = last(executable, mirrored, "deposit trilinear prolong linear read trilinear", 1, (0.0152, 0.0168)) * flip + shift
    apart = np.abs(a - b)[:, 3:].max() / np.abs(a[:, 3:]).max()
    c.true(f"a jet off the middle is seen: {apart:.1e}", apart > 1e-3)
    c.end()


if __name__ == "__main__":
    main()
