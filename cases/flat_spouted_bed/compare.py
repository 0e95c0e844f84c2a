#!/usr/bin/python3
"""Verdict on a run of in.flat_spouted_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run of some tenths of a second; what needs a long
mean is told without a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import picture_3d  # noqa: E402
import plot_fields  # noqa: E402
from verdict import G, NO_PICTURES, Bed, Verdict, carries_weight, command_line, fluidises_as_wen_yu, ledgers, left_and_right, save, usual_pictures  # noqa: E402

D_P, RHO_P = 3.0e-3, 2505.0      # as in.flat_spouted_bed has it
WIDTH, DEPTH, SLOT = 145.0e-3, 20.0e-3, 5.0e-3
LOW = (0.5, 0.9)                 # m/s, held before
PACKED = 0.42                    # void fraction at rest, for the bed's height
ALARMS, LEAST = 1e-3, 0.5        # of the check of symmetry: rate of false alarms, s of means that it needs


def height_at_rest(bed):
    return bed.n * np.pi / 6 * D_P**3 / (1 - PACKED) / (WIDTH * DEPTH)


def spout(bed, verdict, short):
    """Grains rise fast over the slot and sink beside it; how far the jet reaches, how high grains fly."""
    average = bed.file["average/particle_grid"]
    x, _, z = (plot_fields.centres(e) for e in plot_fields.nodes(bed.file, "particle_grid"))
    eps, flux = average["eps"][:].mean(axis=1), average["solids_flux"][:].mean(axis=1)[..., 2]
    H0 = height_at_rest(bed)
    at = lambda f: int(np.argmin(np.abs(z - f * H0)))
    middle, side = np.abs(x - WIDTH / 2) < 1.1 * (x[1] - x[0]), (np.abs(x - WIDTH / 2) > 0.25 * WIDTH)
    k = at(0.5)
    verdict.within(f"spout at {1e3 * z[k]:.0f} mm, half the height at rest: void fraction {eps[k, middle].mean():.3f} over the slot, {eps[k, side].mean():.3f} beside it (wanted: 0.1 less); flux of grains {flux[k, middle].mean():+.3f} and {flux[k, side].mean():+.3f} m/s (wanted: up and down)",
                   ("void fraction over the slot less beside it", 0.1, eps[k, middle].mean() - eps[k, side].mean(), np.inf), ("flux over the slot", 0, flux[k, middle].mean(), np.inf), ("flux beside it", -np.inf, flux[k, side].mean(), 0), short=short)
    solids = np.cumsum((1 - eps).mean(axis=1)) / np.sum((1 - eps).mean(axis=1))
    verdict.note(f"height at rest {1e3 * H0:.0f} mm; half, 95 and 99 % of the grains stand below {', '.join(f'{1e3 * np.interp(f, solids, z):.0f}' for f in (0.5, 0.95, 0.99))} mm in the mean; highest grain {1e3 * bed.now[bed.averaged(bed.now), 3].max():.0f} mm")
    jet(bed, verdict, short, H0)


def jet(bed, verdict, short, H0):
    """Height up to which the mean void fraction over the slot stays above 0.7, midway between the packed bed and the empty jet."""
    eps = bed.file["average/particle_grid/eps"][:].mean(axis=1)
    height = plot_fields.centres(plot_fields.nodes(bed.file, "particle_grid")[2])
    middle = eps.shape[1] // 2
    axis = eps[:, middle - 1:middle + 1].mean(axis=1)
    U = bed.inlet.max()
    k = int(np.argmax(axis < 0.7))
    through = not (axis < 0.7).any()
    reach = H0 if through else 0.0 if k == 0 else np.interp(0.7, [axis[k], axis[k - 1]], [height[k], height[k - 1]])
    d0 = np.sqrt(4 / np.pi * SLOT * DEPTH)  # circle of the slot's area
    froude = U**2 / (G * d0)
    keairns = 6.5 * d0 * np.sqrt(bed.rho_f / (RHO_P - bed.rho_f) * froude)
    merry = 5.2 * d0 * (bed.rho_f * d0 / (RHO_P * D_P))**0.3 * (1.3 * froude**0.2 - 1)
    low, high = 0.6 * min(merry, keairns), 1.4 * max(merry, keairns)
    verdict.between(low, reach, high, "the void over the slot reaches " + ("through the whole bed" if through else f"{1e3 * reach:.0f} mm") + f"; jets of that slot reach {1e3 * merry:.0f} mm by Merry (1975), {1e3 * keairns:.0f} mm by Yang & Keairns (1978), the bed's height at rest is {1e3 * H0:.0f} mm "
                    "(wanted: between the lower less 40 % and the higher plus 40 %; through the bed counts as its height)", short)


def rhythm(bed, verdict):
    """The bed's beat: the frequency at which the pressure drop's spectrum peaks."""
    inside = bed.averaged(bed.mean)
    dp, period = bed.mean[inside, 1], (bed.mean[1, 0] - bed.mean[0, 0]) * bed.step
    if inside.sum() * period < 1:
        return
    pieces = max(1, int(inside.sum() * period / 1.0))
    power = np.mean([np.abs(np.fft.rfft((p - p.mean()) * np.hanning(len(p))))**2 for p in np.array_split(dp[:len(dp) // pieces * pieces], pieces)], axis=0)
    frequency = np.fft.rfftfreq(len(dp) // pieces, period)
    H0 = height_at_rest(bed)
    verdict.note(f"pressure drop beats at {frequency[1 + np.argmax(power[1:])]:.1f} Hz (spectrum of {pieces} pieces); a bed of that height that swings as a whole: {np.sqrt(G / H0) / np.pi:.1f} Hz, by Baskakov, Tuponogov & Filippov (1986)")


def curve(bed):
    plt = plot_fields.plt
    figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.2), layout="constrained")
    t = bed.mean[:, 0] * bed.step
    axes[0].plot(t, bed.mean[:, 1], linewidth=0.7)
    axes[0].axhline(bed.weight / bed.section, color="k", linestyle="--", linewidth=1, label="buoyant weight / area")
    axes[0].axvline(bed.begin, color="0.6", linewidth=0.8)
    axes[0].set_xlabel("time / s"), axes[0].set_ylabel("pressure drop / Pa"), axes[0].legend()
    axes[1].plot(bed.now[:, 0] * bed.step, 1e3 * bed.now[:, 3], linewidth=0.7, label="highest grain")
    axes[1].plot(bed.now[:, 0] * bed.step, 2e3 * bed.now[:, 11], linewidth=0.7, label="twice the mean height")
    axes[1].set_xlabel("time / s"), axes[1].set_ylabel("z / mm"), axes[1].legend()
    return figure


def main():
    folder, short = command_line(__doc__)
    now = np.loadtxt(os.path.join(folder, "now.txt"), ndmin=2)
    bed, verdict = Bed(folder, D_P, RHO_P, (now[-1, 4] - now[0, 4]) / (now[-1, 0] - now[0, 0])), Verdict()
    verdict.note(f"{bed.n:.0f} grains, {bed.inflow / bed.section:.2f} m/s over the section, {bed.inlet.max():.1f} m/s in the slot on the grid, {bed.length:.2f} s, means from {bed.begin:.2f} s")
    ledgers(bed, verdict)
    drag_check.check(bed.file, verdict)
    carries_weight(bed, verdict, short)
    fluidises_as_wen_yu(bed, verdict, short, LOW, 13)
    spout(bed, verdict, short)
    rhythm(bed, verdict)
    left_and_right(bed, verdict, short, bed.n * np.pi / 6 * D_P**3 * RHO_P, ALARMS, LEAST)
    if not NO_PICTURES:
        save({**usual_pictures(bed, [30e-3, 60e-3, 100e-3], top=0.4), "curve": curve(bed)}, bed.folder)
    picture_3d.draw(os.path.join(bed.folder, "bed.h5"), os.path.join(bed.folder, "grains.png"), cut="none")
    verdict.end()


if __name__ == "__main__":
    main()
