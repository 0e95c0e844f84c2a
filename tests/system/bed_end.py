#!/usr/bin/python3
"""A fixed bed that ends inside the fluid's domain, along x, y and z: pressure drop against Ergun's law and the force on the
particles of its last layer, in formulations A and B, for every way of reading.

Without this test drag would be short where a bed ends, the more the thinner the bed: a particle that reads a velocity across
the jump of the void fraction reads one that has dropped by half. Beds that fill their domain don't show it.

Reference: Ergun (1952), dp = H (150 mu eps_s^2 U/(eps^3 d^2) + 1.75 rho eps_s U^2/(eps^3 d)) plus the momentum the gas gains
on the way in and loses on the way out, rho U^2 (1/eps - 1), which cancels. The lattice fills particle cells evenly and ends
at a side of them; beds that end inside one are the business of the study fixed_bed.
"""
import math

import numpy as np

from harness import Checks, Run, arguments, column, data_file, head_with_particles

D, A, RHO, MU, U = 0.98e-3, 1e-3, 1.2, 1.8e-5, 0.5
N = 8                        # spheres a side; the bed is 8 mm high


def script(axis, down, formulation, read, fine, ratio, method):
    sides = [("xlo", "xhi"), ("ylo", "yhi"), ("zlo", "zhi")][axis]
    into, out = sides[::-1] if down else sides
    cells = [fine, fine, fine]
    cells[axis] *= 2
    size = [N * A] * 3
    size[axis] *= 2
    flow = [0.0] * 3
    flow[axis] = -U if down else U
    q = (np.arange(N) + 0.5) * A
    x = np.array([(i, j, k) for k in q for j in q for i in q])
    if down:
        x[:, axis] += N * A
    others = " ".join(f"boundary {s} slip" for k in range(3) if k != axis for s in [("xlo", "xhi"), ("ylo", "yhi"), ("zlo", "zhi")][k])
    text = head_with_particles(1e-5, boundary="f f f", skin=3e-4) + f"""
fix gas all twogrid fine {cells[0]} {cells[1]} {cells[2]} ratio {ratio} {ratio} {ratio} density {RHO} viscosity {MU} every 50
fix_modify gas drag ergun formulation {formulation} {method} read {read}
fix_modify gas boundary {into} inlet {flow[0]} {flow[1]} {flow[2]} boundary {out} pressure 0 {others}
dump d all custom 3000 end.txt id x y z f_gas[{1 + axis}] f_gas[{4 + axis}]
dump_modify d format "%d %.9g %.9g %.9g %.12g %.12g"
thermo_style custom step f_gas[4] f_gas[6] f_gas[7]
thermo 3000
thermo_modify format float %.12g
run 3000
"""
    return text, data_file(f"0 {size[0]} 0 {size[1]} 0 {size[2]}", x, D, 2500)


def main():
    executable, _ = arguments()
    c = Checks("a fixed bed that ends inside the domain")
    s = math.pi / 6 * (D / A)**3
    e = 1 - s
    dp = N * A * (150 * MU * s**2 * U / (e**3 * D**2) + 1.75 * RHO * s * U**2 / (e**3 * D))
    cases = [(2, False, f, r, 8, 4, "deposit exact") for f in "AB" for r in ("cell", "trilinear", "fine", "fine/trilinear", "kernel 2e-3")]
    cases += [(0, False, "B", "trilinear", 8, 4, "deposit centroid"), (1, True, "B", "cell", 8, 4, "deposit exact"), (0, True, "A", "trilinear", 8, 2, "deposit exact"),
              (2, True, "B", "trilinear", 8, 1, "deposit exact"), (1, False, "B", "fine", 8, 1, "deposit centroid")]
    for axis, down, formulation, read, fine, ratio, method in cases:
        text, data = script(axis, down, formulation, read, fine, ratio, method)
        r = Run(executable, text, 1, files={"particles.data": data})
        t = r.thermo()
        found = column(t, "f_gas[4]")[-1]
        what = f"{'-' if down else ''}{'xyz'[axis]}, {formulation}, {method}, read {read}, {8 / fine:g} mm cells, ratio {ratio}"
        c.below(f"{what}: pressure drop {found:.4f} Pa, wanted {dp:.4f}", abs(found / dp - 1), 0.005)
        c.below(f"{what}: action and reaction", column(t, "f_gas[7]").max(), 1e-12)
    c.end()


if __name__ == "__main__":
    main()
