#!/usr/bin/python3
"""Verdict on a run of in.jetting_bed, and its pictures.

    compare.py FOLDER [--short]      FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check that needs no measured curve, draws FOLDER/*.png, ends with 0 if all passed. --short: of a
run of some hundredths of a second; a jet's length is told without a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import plot_fields  # noqa: E402
from verdict import G, Bed, Verdict, batch_error, command_line, jackknife, ledgers, momentum, save, student, usual_pictures  # noqa: E402

# As in.jetting_bed has it.
D_P, RHO_P, DEM_STEP = 0.75e-3, 2500.0, 1.25e-5
ALARMS = 1e-3  # rate of false alarms of the check of the jets' length


class Jets(Bed):
    """The run, and where its jets enter."""

    def __init__(self, folder):
        super().__init__(folder, D_P, RHO_P, DEM_STEP)
        inlet = self.inlet.mean(axis=0)  # one cell deep: over x
        self.U, self.U_background = inlet.max(), inlet.min()
        jet = (inlet > 0.5 * (self.U + self.U_background)).astype(int)
        edges = np.diff(np.concatenate([[0], jet, [0]]))
        self.jets = list(zip(np.nonzero(edges == 1)[0], np.nonzero(edges == -1)[0]))  # [first, last) of each
        self.jet_width = self.x[self.jets[0][1]] - self.x[self.jets[0][0]]


def patches(bed, verdict):
    """What enters by a jet is what its velocity and its width say."""
    worst = 0
    for name in bed.frames:
        if bed.file["fluid"][name]["time"][()] < bed.begin:
            continue
        flux = bed.file["fluid"][name]["faces/flux_z"][0]
        for first, last in bed.jets:
            got = np.sum(flux[:, first:last] * bed.cell[:, first:last])
            worst = np.maximum(worst, abs(got / (bed.U * bed.jet_width * np.ptp(bed.y)) - 1))
    verdict.at_most(1e-10, worst, f"flux through a jet's patch: relative error at most {worst:.1e} (wanted 1e-10)")


def height_of_void(axis, height):
    """Up to which the void fraction along an axis stays above 0.7; infinity where it does so through the whole bed."""
    if (axis >= 0.7).all():
        return np.inf
    k = int(np.argmax(axis < 0.7))  # the first that is not void
    return 0.0 if k == 0 else np.interp(0.7, [axis[k], axis[k - 1]], [height[k], height[k - 1]])


def penetration(bed, verdict, short):
    """Height above the nozzle up to which the mean void fraction on a jet's axis stays above 0.7, midway between the packed bed and the empty jet.
    Its error is that of the batches of the means."""
    x, _, z = plot_fields.nodes(bed.file, "particle_grid")
    height = plot_fields.centres(z)
    over = [(x[1:] > bed.x[first] + 1e-6) & (x[:-1] < bed.x[last] - 1e-6) for first, last in bed.jets]  # the columns of cells above each
    lengths_of = lambda eps: np.array([height_of_void(eps[:, columns].mean(axis=1), height) for columns in over])
    lengths = lengths_of(bed.file["average/particle_grid/eps"][:].mean(axis=1))
    L = np.mean(lengths)
    weight, batch = plot_fields.batches(bed.file)
    eps = batch("eps").mean(axis=2)
    error = float(jackknife(lambda w: lengths_of(np.average(eps, axis=0, weights=w)).mean(), weight)[1]) if len(weight) > 2 else np.nan
    by_chance = student(len(weight) - 1, ALARMS) * error if np.isfinite(error) else 0.0
    d0 = np.sqrt(4 / np.pi * bed.jet_width * np.ptp(bed.y))  # circle of the slot's area
    froude = bed.U**2 / (G * d0)
    yang_keairns = 6.5 * d0 * np.sqrt(bed.rho_f / (RHO_P - bed.rho_f) * froude)
    merry = 5.2 * d0 * (bed.rho_f * d0 / (RHO_P * D_P))**0.3 * (1.3 * froude**0.2 - 1)
    lo, hi = 0.6 * min(merry, yang_keairns), 1.4 * max(merry, yang_keairns)
    each = ", ".join(f"{1e3 * l:.1f}" if np.isfinite(l) else "through the bed" for l in lengths)
    enough, alone = by_chance <= 0.5 * (hi - lo), len(bed.jets) == 1
    verdict.between(lo - by_chance, L, hi + by_chance, f"jets reach {each} mm, the mean +- {1e3 * error:.1f}; Yang & Keairns (1978) {1e3 * yang_keairns:.1f} mm, Merry (1975) "
                    f"{1e3 * merry:.1f} mm, with 40 % of scatter {1e3 * lo:.1f} to {1e3 * hi:.1f} mm (wanted: not outside by more than {1e3 * by_chance:.1f} mm, which chance exceeds once in {1 / ALARMS:.0f} runs)" +
                    ("; no verdict, for neighbours bend towards each other and merge, and the correlations are of one jet" if not alone else "" if enough else "; the run is too short for a verdict"),
                    short or not enough or not alone)
    return L


def symmetry(bed, verdict):
    """How far the means are from their mirror image. No verdict: a jet leans to one side for as long as a short run lasts, and a few
    batches of a correlated series carry no bound with a known rate of false alarms. That the program itself prefers no side is
    tested by tests/system/mirror.py, particle by particle."""
    weight, batch = plot_fields.batches(bed.file)
    x, _, z = plot_fields.nodes(bed.file, "particle_grid")
    from_middle = plot_fields.centres(x) - 0.5 * (x[0] + x[-1])
    solids, flux, eps = (np.average(batch(n), axis=0, weights=weight) for n in ("solids_fraction", "solids_flux", "eps"))
    solids, up, eps = solids.mean(axis=1), flux[..., 2].mean(axis=1), eps.mean(axis=1)  # z, x
    low = z[1:] < 20e-3
    off = 1e3 * (solids * from_middle).sum() / solids.sum()
    lean = (up * np.sign(from_middle))[low].mean()
    bed_cells = eps < 0.95
    mirrored = 0.5 * (eps - eps[:, ::-1])[bed_cells]
    verdict.note(f"left and right: particles' centre {off:+.2f} mm off the middle, mean upward particle flux, right less left, {lean:+.2g} m/s, "
                 f"void fraction less its mirror image {np.sqrt(np.mean(mirrored**2)):.3f} (root mean square); a jet that leans, no verdict")


def main():
    folder, short = command_line(__doc__)
    bed, verdict = Jets(folder), Verdict()
    verdict.note(f"{len(bed.jets)} jet(s) of {1e3 * bed.jet_width:.1f} mm at {bed.U:.1f} m/s, background "
                 f"{bed.U_background:.2f} m/s, {bed.length:.2f} s, means from {bed.begin:.2f} s")
    ledgers(bed, verdict)
    drag_check.check(bed.file, verdict)
    patches(bed, verdict)
    dp, _, _ = momentum(bed, verdict, {"walls": bed.mean[:, 2]}, 3e-3 if short else 1e-3)
    verdict.note(f"mean pressure drop {dp.mean():.1f} +- {batch_error(dp):.1f} Pa (8 batches), standard deviation {dp.std():.1f} Pa")
    L = penetration(bed, verdict, short)
    symmetry(bed, verdict)
    L = min(L, 0.5 * bed.now[:, 3].max())
    save(usual_pictures(bed, [0.5 * L, L, 1.5 * L], top=min(1.15 * bed.now[:, 3].max(), bed.z[-1])), bed.folder)
    verdict.end()


if __name__ == "__main__":
    main()
