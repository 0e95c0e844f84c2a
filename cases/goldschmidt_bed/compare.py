#!/usr/bin/python3
"""Verdict on a run of in.goldschmidt_bed, and its pictures.

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
from verdict import NO_PICTURES, Bed, Verdict, carries_weight, command_line, correlated_mean, fluidises_as_wen_yu, ledgers, left_and_right, save, save_compared, usual_pictures  # noqa: E402

D_P, RHO_P = 2.5e-3, 2526.0      # as in.goldschmidt_bed has it
LOW = (0.5, 0.9)                 # m/s, held before
ALARMS, LEAST = 1e-3, 0.5        # of the check of symmetry: rate of false alarms, s of means that it needs


def bubbling(bed, verdict, short):
    """Bubbles stir the bed: grains rise in its middle and sink at the walls."""
    inside = bed.averaged(bed.now)
    mean, error, independent = correlated_mean(bed.now[inside, 11])
    verdict.note(f"mean height of the grains {1e3 * mean:.1f} +- {1e3 * error:.1f} mm, at rest {1e3 * bed.now[0, 11]:.1f} mm: expanded by {100 * (mean / bed.now[0, 11] - 1):.0f} %; highest grain {1e3 * bed.now[inside, 3].max():.0f} mm")
    average = bed.file["average/particle_grid"]
    x, _, z = (plot_fields.centres(e) for e in plot_fields.nodes(bed.file, "particle_grid"))
    flux = average["solids_flux"][:].mean(axis=1)[..., 2]
    k = (z > 0.4 * 2 * bed.now[0, 11]) & (z < 1.2 * 2 * bed.now[0, 11])
    width = np.ptp(bed.x)
    middle, side = np.abs(x - x.mean()) < 0.2 * width, np.abs(x - x.mean()) > 0.4 * width
    up, down = flux[k][:, middle].mean(), flux[k][:, side].mean()
    verdict.within(f"flux of grains in the upper bed: {up:+.4f} m/s in the middle, {down:+.4f} m/s at the walls (wanted: up and down)", ("up", 0, up, np.inf), ("down", -np.inf, down, 0), short=short)


def curve(bed):
    plt = plot_fields.plt
    figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.2), layout="constrained")
    axes[0].plot(bed.mean[:, 0] * bed.step, bed.mean[:, 1], linewidth=0.7)
    axes[0].axhline(bed.weight / bed.section, color="k", linestyle="--", linewidth=1, label="buoyant weight / area")
    axes[0].set_xlabel("time / s"), axes[0].set_ylabel("pressure drop / Pa"), axes[0].legend()
    axes[1].plot(bed.now[:, 0] * bed.step, 2e3 * bed.now[:, 11], linewidth=0.7)
    axes[1].set_xlabel("time / s"), axes[1].set_ylabel("twice the grains' mean height / mm")
    for ax in axes:
        ax.axvline(bed.begin, color="0.6", linewidth=0.8)
    return figure


def main():
    folder, short = command_line(__doc__)
    now = np.loadtxt(os.path.join(folder, "now.txt"), ndmin=2)
    bed, verdict = Bed(folder, D_P, RHO_P, (now[-1, 4] - now[0, 4]) / (now[-1, 0] - now[0, 0])), Verdict()
    verdict.note(f"{bed.n:.0f} grains, {bed.inflow / bed.section:.3f} m/s, {bed.length:.2f} s, means from {bed.begin:.2f} s")
    ledgers(bed, verdict)
    drag_check.check(bed.file, verdict)
    carries_weight(bed, verdict, short)
    fluidises_as_wen_yu(bed, verdict, short, LOW, 12)
    bubbling(bed, verdict, short)
    left_and_right(bed, verdict, short, bed.n * np.pi / 6 * D_P**3 * RHO_P, ALARMS, LEAST)
    t = bed.mean[:, 0] * bed.step
    save_compared(folder, [dict(title="Pressure drop", x_label="time / s", y_label="pressure drop / Pa", x=t[::10], mean=bed.mean[::10, 1], error=None, references=[dict(label="buoyant weight / area", x=[0, t[-1]], y=2 * [bed.weight / bed.section], line=True)])])
    if not NO_PICTURES:
        save({**usual_pictures(bed, [50e-3, 100e-3, 150e-3], top=0.35), "curve": curve(bed)}, bed.folder)
    picture_3d.draw(os.path.join(bed.folder, "bed.h5"), os.path.join(bed.folder, "grains.png"), cut="none")
    verdict.end()


if __name__ == "__main__":
    main()
