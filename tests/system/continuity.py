#!/usr/bin/python3
"""Discrete continuity recomputed from the written fields of a moving bed: max over cells of
|d(eps)/dt + div(eps u)| h/U, with d(eps)/dt from the written void fractions by the solver's own BDF2 formula.

Without this test the figure that the run prints about itself would be the only witness of mass conservation.
"""
import h5py
import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles, walls

L, H, D = 0.02, 0.04, 1e-3


def script(every, extra=""):
    rng = np.random.default_rng(3)
    x = [(a + 1e-4 * rng.uniform(), b, z) for z in np.arange(0.6, 8) * 1.25 * D for b in np.arange(0.6, 14) * 1.3 * D
         for a in np.arange(0.6, 14) * 1.3 * D]
    data = data_file(f"0 {L} 0 {L} 0 {H}", x, D, 2500)
    return data, head_with_particles(1e-5, boundary="f f f", skin=1e-3, gamman=0.01, gammat=0.01) + walls(
        xplane=(0, L), yplane=(0, L), zplane=(0, H)) + f"""
fix grav all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 12 12 24 ratio 3 3 3 density 1.2 viscosity 1.8e-5 every {every}
fix_modify gas boundary zlo inlet 0 0 1.5 boundary zhi pressure 0
fix_modify gas boundary xlo noslip boundary xhi noslip boundary ylo slip boundary yhi slip
fix_modify gas output every {every} file bed.h5 fields u p eps faces
fix_modify gas dt {every * 1e-5!r}
{extra}
thermo {every}
thermo_style custom step f_gas[1] f_gas[2] f_gas[3] f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[8] f_gas[9] f_gas[10]
run {12 * every}
"""


def main():
    executable, ranks = arguments()
    c = Checks("continuity recomputed from the written fields")
    for n in ranks:
        for deposit in ("centroid", "trilinear", "exact"):
            every = 5
            data, text = script(every, f"fix_modify gas deposit {deposit} interpolate linear")
            r = Run(executable, text, n, ["-fluid_pressure_rtol", "1e-13"], files={"particles.data": data})
            worst = 0
            with h5py.File(r.file("bed.h5")) as f:
                names = sorted(f["fluid"])
                h = [f["grid/" + a][1] - f["grid/" + a][0] for a in "xyz"]
                eps = [f["fluid/" + k + "/eps"][()] for k in names]
                dt = every * 1e-5
                for q in range(3, len(names)):
                    frame = f["fluid/" + names[q]]
                    rate = (1.5 * eps[q] - 2 * eps[q - 1] + 0.5 * eps[q - 2]) / dt
                    div, top = 0, 0
                    for d in range(3):
                        axis = 2 - d
                        u = frame["faces/u" + "xyz"[d]][()]
                        e = eps[q]
                        inner = 0.5 * (np.take(e, range(1, e.shape[axis]), axis) + np.take(e, range(e.shape[axis] - 1), axis))
                        first, last = np.take(e, [0], axis), np.take(e, [e.shape[axis] - 1], axis)
                        if d == 2:
                            first = np.ones_like(first)  # in front of the inlet the duct is empty
                        flux = np.concatenate([first, inner, last], axis) * u
                        top = max(top, np.abs(flux).max())
                        div = div + np.diff(flux, axis=axis) / h[d]
                    worst = max(worst, np.abs(rate + div).max() * np.cbrt(np.prod(h)) / top)
            c.below(f"{deposit} on {n} ranks: max |d(eps)/dt + div(eps u)| h/U", worst, 1e-10)
            c.below(f"{deposit} on {n} ranks: solid volume error", r.thermo()["gas[6]" if "gas[6]" in r.thermo() else "f_gas[6]"].max(), 1e-13)
    c.end()


if __name__ == "__main__":
    main()
