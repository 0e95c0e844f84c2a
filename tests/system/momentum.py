#!/usr/bin/python3
"""Action and reaction, measured from outside the coupling: in a periodic box without gravity, momentum of the fluid
(from the written face velocities and void fractions) plus the sum of m v (from LIGGGHTS' dump) stays what it was.

Without this test the reaction could be dropped, doubled, lost at rank borders, or computed from other velocities than
the particles got, and every run would still look right. Pending terms are counted: the half kick that LIGGGHTS has
applied but not yet handed to the fluid, and the half step by which the backward differences of the fluid lag behind.
"""
import h5py
import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles


def script(formulation, deposit, read, every, cells, ratio):
    rng = np.random.default_rng(5)
    L, d, n = 0.02, 1e-3, 150
    x = []
    while len(x) < n:
        q = rng.uniform(0, L, 3)
        if all(np.linalg.norm((q - p + L / 2) % L - L / 2) > 1.05 * d for p in x):
            x.append(q)
    data = data_file(f"0 {L} 0 {L} 0 {L}", np.array(x), d * rng.uniform(0.8, 1.0, n), 2500, rng.uniform(-0.5, 0.5, (n, 3)))
    return data, head_with_particles(1e-5, skin=1e-3, gamman=0.01, gammat=0.01) + f"""
fix integrate all nve/sphere
fix gas all twogrid fine {cells} {cells} {cells} ratio {ratio} {ratio} {ratio} density 1.2 viscosity 1.8e-5 every {every}
fix_modify gas drag ergun/wenyu formulation {formulation}
fix_modify gas deposit {deposit} prolong constant read {read}
fix_modify gas initial u 2 -1 0.5
fix_modify gas dt {every * 1e-5!r}
fix_modify gas output every {every} file bed.h5 fields u p eps faces
dump d all custom {every} dump.txt id mass vx vy vz f_gas[1] f_gas[2] f_gas[3] f_gas[4] f_gas[5] f_gas[6]
dump_modify d format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
thermo {every}
thermo_style custom step f_gas[1] f_gas[6] f_gas[7] f_gas[9]
run {20 * every}
"""


def momentum_of_fluid(frame, widths, rho):
    """rho times the sum over faces of eps u V, in periodic directions, where faces wrap; 0 in others."""
    eps = frame["eps"][()]
    total = np.zeros(3)
    for d in range(3):
        axis = 2 - d  # arrays are [z][y][x]
        u = frame["faces/u" + "xyz"[d]][()]
        if u.shape != eps.shape:
            continue
        total[d] = rho * np.sum(0.5 * (eps + np.roll(eps, 1, axis)) * u) * np.prod(widths)
    return total


def main():
    executable, ranks = arguments()
    c = Checks("momentum of fluid and particles in a periodic box")
    for formulation in "BA":
        for deposit, read, every, cells, ratio in (("centroid", "cell", 10, 12, 3), ("trilinear", "trilinear", 10, 12, 3),
                                                   ("exact", "fine", 5, 10, 1), ("centroid", "kernel 4e-3", 10, 12, 3)):
            for n in ranks:
                data, text = script(formulation, deposit, read, every, cells, ratio)
                r = Run(executable, text, n, ["-fluid_pressure_rtol", "1e-13"], files={"particles.data": data})
                dump = dict(r.dump("dump.txt"))
                total, scale = [], 0
                with h5py.File(r.file("bed.h5")) as f:
                    names = sorted(k for k in f["fluid"])
                    widths = [f["grid/" + a][1] - f["grid/" + a][0] for a in "xyz"]
                    before = None
                    for name in names:
                        frame = f["fluid/" + name]
                        step = int(np.array(frame.attrs["step"] if "step" in frame.attrs else frame["step"][()]).item())
                        M = momentum_of_fluid(frame, widths, 1.2)
                        pending = 0.5 * (M - before) if before is not None else 0 * M
                        before = M
                        p = dump[step]
                        mv = np.array([np.sum(p["mass"] * p["v" + a]) for a in "xyz"])
                        force = np.array([np.sum(p[f"f_gas[{i + 1}]"] + p[f"f_gas[{i + 4}]"]) for i in range(3)])
                        scale = np.sum(p["mass"] * np.sqrt(p["vx"]**2 + p["vy"]**2 + p["vz"]**2))
                        total.append(M + pending + mv - 0.5 * 1e-5 * force)
                # The first step is backward Euler: its balance has no pending part; count from the second frame on.
                total = np.array(total)[2:]
                worst = np.max(np.abs(total - total[0])) / scale
                c.below(f"{formulation} {deposit}/{read.split()[0]} ratio {ratio} on {n} ranks: drift / sum m|v|", worst, 1e-12)
    c.end()


if __name__ == "__main__":
    main()
