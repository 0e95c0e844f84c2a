#!/usr/bin/python3
"""Particles exactly on faces, edges and corners of both grids, of the ranks' bricks and of the domain, on 1, 2 and 4 ranks;
one particle; no particle; all particles leave at once.

Bounded: no error and no particle lost but those that cross an open side; the deposited volume, summed from the written void
fraction, is the particles'; the fields don't depend on the number of ranks; action and reaction cancel.
Without this test a particle on a border could be counted by both sides or by none, or be lost when it is handed over; and
sums over no particles could divide by nothing.
"""
import math

import h5py
import numpy as np

from hard import Checks, Run, arguments, column, data_file, head, head_with_particles, walls

L, D, RHO_P = 0.012, 1e-3, 2500.0
V_P = math.pi / 6 * D**3
BRICKS = {1: "1 1 1", 2: "2 1 1", 4: "2 1 2"}  # borders at x = z = L/2
NODES = np.arange(7) * 0.002


def lattice(periodic):
    """A particle on every node of the fine grid: each is also on faces, edges or corners of particle cells, ranks, domain."""
    q = NODES[:-1] if periodic else NODES
    return np.array([(a, b, c) for c in q for b in q for a in q])


def script(x, boundary, box, n, gas, v=None, steps=20, every=5):
    """Springs too weak to feel: the coupling alone acts."""
    return {"particles.data": data_file(box, x, D, RHO_P, v)}, head_with_particles(
        1e-5, boundary=boundary, processors=BRICKS[n], kn=1e-9, kt=1e-9) + f"""
fix integrate all nve/sphere
fix gas all twogrid fine 6 6 6 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every {every} {gas}
fix_modify gas output every {every} file bed.h5 fields u p eps
thermo {every}
thermo_style custom step atoms f_gas[5] f_gas[6] f_gas[7] f_gas[9]
thermo_modify format float %.17g lost ignore
run {steps}
"""


def solid_volume(path):
    """Of every frame: sum of (1 - eps) V, and the field; compensated sum."""
    with h5py.File(path) as f:
        x, y, z = (np.diff(f["grid/" + a][()]) for a in "xyz")
        V = z[:, None, None] * y[:, None] * x
        eps = [f["fluid/" + k + "/eps"][()] for k in sorted(f["fluid"])]
        finite = all(np.isfinite(f["fluid/" + k + "/" + q][()]).all() for k in f["fluid"] for q in ("u", "p"))
        return np.array([math.fsum(((1 - e) * V).ravel()) for e in eps]), eps, finite


def on_the_borders(c, executable, ranks):
    side = "fix_modify gas boundary {}lo noslip boundary {}hi noslip"
    still = "\n" + "\n".join(side.format(a, a) for a in "xyz") + "\nfix_modify gas initial u 0.3 0.2 -0.1"
    scenes = [  # the domain's own sides: inside a larger box, and as sides of the box
        ("inside a larger box", lattice(False), "f f f", "-0.002 0.014 -0.002 0.014 -0.002 0.014",
         f"domain 0 {L} 0 {L} 0 {L}" + still, ("centroid", "exact")),
        ("the box itself", np.minimum(lattice(False), math.nextafter(L, 0)), "f f f", f"0 {L} 0 {L} 0 {L}", still, ("trilinear",)),
        ("periodic", lattice(True), "p p p", f"0 {L} 0 {L} 0 {L}", "\nfix_modify gas initial u 0.3 0.2 -0.1", ("exact",))]
    for name, x, boundary, box, gas, deposits in scenes:
        for deposit in deposits:
            first = None
            for n in ranks:
                files, text = script(x, boundary, box, n, gas + f"\nfix_modify gas deposit {deposit}", steps=10)
                r = Run(executable, text, n, files=files)
                t, what = r.thermo(), f"{name}, {deposit}, {n} rank(s)"
                volume, eps, finite = solid_volume(r.file("bed.h5"))
                c.true(f"{what}: {len(x)} particles, all there, fields finite", finite and np.all(t["Atoms"] == len(x)))
                if box[0] == "-":
                    volume = volume[:1]  # later, the gas has pushed some of those on its sides out of its domain
                c.below(f"{what}: volume from the written eps against the particles'", np.abs(volume / (len(x) * V_P) - 1).max(), 1e-13)
                c.below(f"{what}: momentum exchange error", column(t, "f_gas[7]").max(), 1e-12)
                first = first if first is not None else eps[0]
                c.below(f"{what}: eps at first, against that on {ranks[0]} rank(s)", np.abs(eps[0] - first).max(), 0)


def few(c, executable, ranks):
    open_box = f"""
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
fix_modify gas boundary zlo inlet 0 0 0.5 boundary zhi pressure 0
"""
    box = f"0 {L} 0 {L} 0 {L}"
    for n in ranks:
        text = head(box, 1e-5, boundary="f f f", processors=BRICKS[n]) + script([[0, 0, 0]], "f f f", box, n, open_box)[1].split("timestep 1e-05\n")[1]
        text = text.replace("fix integrate", walls(zplane=(0,)) + "fix integrate")
        # LIGGGHTS itself wants a type in use (the wall's), and can't sort nothing.
        text = text.replace("newton off", "newton off\natom_modify sort 0 0")
        r = Run(executable, text, n)
        volume, _, finite = solid_volume(r.file("bed.h5"))
        c.true(f"no particle, {n} rank(s): runs, eps 1, fields finite", finite and np.all(volume == 0) and np.all(r.thermo()["Atoms"] == 0))
        # One particle, on the corner where four bricks meet, moving along the border between two.
        files, text = script([[L / 2, L / 2, L / 2]], "f f f", box, n, open_box, v=[[0, 0.5, 0]], steps=100, every=20)
        r = Run(executable, text, n, files=files)
        volume, _, finite = solid_volume(r.file("bed.h5"))
        c.true(f"one particle on a rank border, {n} rank(s): there, fields finite", finite and np.all(r.thermo()["Atoms"] == 1))
        c.below(f"one particle, {n} rank(s): its volume", np.abs(volume / V_P - 1).max(), 1e-13)
        c.below(f"one particle, {n} rank(s): momentum exchange error", column(r.thermo(), "f_gas[7]").max(), 1e-12)
        # All leave by the top, at 10 m/s; those above the middle first.
        x = lattice(True) + 0.001
        files, text = script(x, "f f f", box, n, open_box, v=np.tile([0, 0, 10.0], (len(x), 1)), steps=160, every=20)
        r = Run(executable, text, n, files=files)
        t, (volume, eps, finite) = r.thermo(), solid_volume(r.file("bed.h5"))
        # A particle counts until LIGGGHTS deletes it: when it is out of the box and the lists are rebuilt.
        left = t["Atoms"]
        gone_at = np.array([np.count_nonzero(x[:, 2] + 10.0 * 1.001 * s * 1e-5 < L) for s in t["Step"]])
        c.true(f"all leave, {n} rank(s): none before its time", np.all(left >= gone_at))
        c.true(f"all leave, {n} rank(s): none left, fields finite, eps 1", finite and left[0] == len(x) and left[-1] == 0 and np.all(eps[-1] == 1))
        c.below(f"all leave, {n} rank(s): momentum exchange error", column(t, "f_gas[7]").max(), 1e-12)
        c.below(f"all leave, {n} rank(s): solid volume error", column(t, "f_gas[6]").max(), 1e-13)


def main():
    executable, ranks = arguments()
    c = Checks("particles on borders, few particles, none")
    on_the_borders(c, executable, ranks)
    few(c, executable, ranks)
    c.end()


if __name__ == "__main__":
    main()
