#!/usr/bin/python3
"""Mixtures of sizes in formulations A and B: the force of the fluid on every particle of a fixed bed, and a large light
sphere in a bed of small ones.

Without this test formulation B could divide every particle's drag by the void fraction, which holds for one size only: a
sphere of thrice the size among small ones then gets a third to a half of its force, with mass and momentum conserved to
the last digit, and a light one never rises.

References. Fixed bed whose particle cells all hold the same spheres: the flow is uniform, F_i = b_i u + V_i (-grad p) with
-grad p = sum over the cell of b_j u / (V eps), b = 3 pi mu d eps F by Ergun's F = (150 eps_s + 1.75 Re)/(18 eps^2), computed here.
A lone large sphere among small ones: A against B, which share no assumption about the pressure gradient.
"""
import math

import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles

RHO, MU, U = 1.2, 1.8e-5, 0.4
CELL = 4e-3


def ergun(d, eps, u):
    """b_i (kg/s) by Ergun (1952): drag without the pressure gradient."""
    re = eps * RHO * u * d / MU
    return 3 * math.pi * MU * d * eps * (150 * (1 - eps) + 1.75 * re) / (18 * eps**2)


def packed_cell(axis):
    """A sphere of 3 mm and twenty of 1 mm in a cell of 4 mm, not the same in all directions."""
    x, d = [(2.0, 2.0, 2.0)], [3.0]
    for a in (0.6, 3.4):
        for b in (0.6, 3.4):
            x += [(0.6, a, b), (3.4, a, b)]
            x += [(2.0, a - 0.1 if a < 2 else a + 0.1, b), (a, 2.0, b + 0.1 if b > 2 else b - 0.1), (a, b, 2.0)]
    d += [1.0] * (len(x) - 1)
    return np.roll(np.array(x), axis, axis=1) * 1e-3, np.array(d) * 1e-3


def fixed(formulation, read, deposit, axis, rank):
    x, d = packed_cell(axis)
    n = 3
    shift = np.array([(i, j, k) for k in range(n) for j in range(n) for i in range(n)]) * CELL
    x, d = (x[None] + shift[:, None]).reshape(-1, 3), np.tile(d, n**3)
    L = n * CELL
    rate = "xyz"[axis]
    text = head_with_particles(1e-4, skin=1e-3) + f"""
fix gas all twogrid fine {4 * n} {4 * n} {4 * n} ratio 4 4 4 density {RHO} viscosity {MU} every 10
fix_modify gas drag ergun formulation {formulation} deposit {deposit} read {read} flow_rate {rate} {U} initial u {'0 ' * axis}{U / 0.6} {'0 ' * (2 - axis)}
dump d all custom 400 dump.txt id f_gas[{1 + axis}] f_gas[{4 + axis}] f_gas[7]
dump_modify d format "%d %.12g %.12g %.12g"
thermo_style custom step f_gas[7]
thermo_modify format float %.12g
run 400
"""
    return text, data_file(f"0 {L} 0 {L} 0 {L}", x, d, 2500), d


def lone_large(formulation, read):
    """A sphere of 3 mm in a lattice of 1 mm spheres that make room for it; gas from below."""
    n, a = 12, 1.1e-3
    q = (np.arange(n) + 0.5) * a
    x = np.array([(i, j, k) for k in q for j in q for i in q])
    middle = np.array([n / 2 * a + 0.2e-3] * 3)
    x = x[np.linalg.norm(x - middle, axis=1) > 2.0e-3]
    d = np.concatenate([[3e-3], np.full(len(x), 1e-3)])
    x = np.concatenate([[middle], x])
    L = n * a
    text = head_with_particles(1e-4, skin=1e-3) + f"""
fix gas all twogrid fine 12 12 12 ratio 3 3 3 density {RHO} viscosity {MU} every 10
fix_modify gas drag beetstra/poly formulation {formulation} deposit exact read {read} flow_rate z {U} initial u 0 0 {U / 0.6}
dump d all custom 2000 dump.txt id f_gas[3] f_gas[6] f_gas[7]
dump_modify d format "%d %.12g %.12g %.12g"
thermo_style custom step f_gas[7]
run 2000
"""
    return text, data_file(f"0 {L} 0 {L} 0 {L}", x, d, 2500)


def main():
    executable, ranks = arguments()
    c = Checks("mixtures of sizes, formulations A and B")
    for read, deposit, axis, rank in (("cell", "centroid", 2, 1), ("trilinear", "exact", 0, 1), ("cell", "exact", 1, 2)):
        if rank > max(ranks):
            continue
        for formulation in "AB":
            text, data, d = fixed(formulation, read, deposit, axis, rank)
            r = Run(executable, text, rank, ["-fluid_pressure_rtol", "1e-9"], files={"particles.data": data})
            last = r.dump("dump.txt")[-1][1]
            force = last[f"f_gas[{1 + axis}]"] + last[f"f_gas[{4 + axis}]"]
            eps = 1 - math.pi / 6 * (d**3).sum() / (3 * CELL)**3
            b, V = np.array([ergun(q, eps, U / eps) for q in d]), math.pi / 6 * d**3
            wanted = b * U / eps + V * (b.sum() * U / eps) / ((3 * CELL)**3 * eps)
            for name, size in (("large", d > 2e-3), ("small", d < 2e-3)):
                # With cells that differ from particle to particle only the sum is that of the uniform bed.
                e = np.abs(force[size] / wanted[size] - 1).max() if read == "cell" and deposit == "centroid" else abs(force[size].mean() / wanted[size].mean() - 1)
                c.below(f"{formulation}, read {read}, deposit {deposit}, along {'xyz'[axis]}: force on the {name} ones "
                        f"{force[size].mean():.5g} N, wanted {wanted[size].mean():.5g}; relative error", e, 0.005)
            c.below("action and reaction", r.thermo()["f_gas[7]" if "f_gas[7]" in r.thermo() else "gas[7]"].max(), 1e-12)
    for read in ("cell", "trilinear"):
        force = []
        for formulation in "AB":
            text, data = lone_large(formulation, read)
            last = Run(executable, text, 1, ["-fluid_pressure_rtol", "1e-9"], files={"particles.data": data}).dump("dump.txt")[-1][1]
            force.append(last["f_gas[3]"] + last["f_gas[6]"])
        A, B = force
        c.below(f"lone large sphere, read {read}: {A[0]:.5g} N in A, {B[0]:.5g} N in B; relative difference", abs(B[0] / A[0] - 1), 0.01)
        c.below(f"small spheres around it, read {read}: largest difference of A and B over the mean force", np.abs(B[1:] - A[1:]).max() / A[1:].mean(), 0.01)
    c.end()


if __name__ == "__main__":
    main()
