#!/usr/bin/python3
"""Verdict on a run of in.round_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check that needs no measured curve, draws FOLDER/*.png, ends with 0 if all passed. --short: of a
run of some tenths of a second; what needs a long mean is told without a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import picture_3d  # noqa: E402
import plot_fields  # noqa: E402
from verdict import Bed, Verdict, command_line, in_open_cells, ledgers, momentum, packed_fluidisation, save, usual_pictures  # noqa: E402

# As in.round_bed has it.
D_P, RHO_P, DEM_STEP = 1.5e-3, 1000.0, 2.5e-5
RADIUS, X0, Y0 = 30e-3, 31e-3, 31e-3
SECTION = np.pi * RADIUS**2
LEVELS = (0.2, 0.3)   # m/s, held for LEVEL_STEPS DEM steps each before the bed bubbles
LEVEL_STEPS = 2400


def vessel(bed, verdict):
    """The vessel's volume, and no grain's centre behind its wall."""
    error = np.sum(bed.theta * bed.volume) / (SECTION * np.ptp(bed.z)) - 1
    verdict.between(-0.002, error, 0.002, f"volume of the vessel on the grid: {100 * error:+.3f} % of the cylinder's (wanted 0.2 %)")
    p = bed.grains("position")
    r = np.hypot(p[:, 0] - X0, p[:, 1] - Y0).max()
    verdict.between(-np.inf, r, RADIUS - 0.45 * D_P, f"the outermost grain's centre is {1e3 * r:.3f} mm from the axis (wanted: at most {1e3 * (RADIUS - 0.45 * D_P):.3f})")


def forces(bed, verdict, short):
    floor, wall, rub = bed.mean[:, 2:5].T
    dp, share, scatter = momentum(bed, verdict, {"floor": floor, "wall on grains": -wall, "wall on gas": -rub}, 3e-3 if short else 1e-3, ("wall on gas",))
    verdict.between(1 - max(0.03, 3 * scatter), share, 1 + max(0.03, 3 * scatter), f"mean pressure drop {dp.mean():.2f} Pa carries {100 * share:.2f} +- {100 * scatter:.2f} % "
                    "of the buoyant weight (wanted 100 +- 3 %)", short)


def fluidisation(bed, verdict, short):
    U_mf, wen_yu, drops = packed_fluidisation(bed, LEVELS, LEVEL_STEPS, bed.weight / bed.section)
    verdict.between(0.7, U_mf / wen_yu, 1.3, f"minimum fluidisation {U_mf:.3f} m/s, from the packed bed at {LEVELS[0]} and {LEVELS[1]} m/s ({drops[0]:.1f}, "
                    f"{drops[1]:.1f} Pa); Wen & Yu (1966) {wen_yu:.3f} m/s (wanted: within their scatter of 30 %)", short)


def symmetry(bed, verdict, short):
    """Nothing in the vessel tells one side from another: means in the four quarters, and the bed's centre."""
    average = bed.file["average/particle_grid"]
    x, y, z = plot_fields.nodes(bed.file, "particle_grid")
    theta = plot_fields.open_share(bed.file, "particle_grid")
    solids = (1 - average["eps"][:]) * theta * np.diff(z)[:, None, None]
    half = (len(x) - 1) // 2
    quarters = np.array([solids[:, :half, :half].sum(), solids[:, :half, -half:].sum(), solids[:, -half:, :half].sum(), solids[:, -half:, -half:].sum()])
    off = 4 * quarters / quarters.sum() - 1
    verdict.at_most(0.06, np.abs(off).max(), "mean solids in the four quarters, less a fourth: " + ", ".join(f"{100 * q:+.1f}" for q in off) + " % (wanted 6 %)", short)
    turned = solids[:, ::-1].transpose(0, 2, 1)
    column, other = solids.sum(axis=0), turned.sum(axis=0)
    verdict.note(f"columns of solids less the same turned by 90 degrees: {100 * np.sqrt(np.mean((column - other)**2)) / column.max():.1f} % of the largest (root mean square)")
    mass = bed.n * np.pi / 6 * D_P**3 * RHO_P
    inside = bed.now[:, 0] * DEM_STEP > bed.begin
    cx, cy = bed.now[inside, 10].mean() / mass - X0, bed.now[inside, 11].mean() / mass - Y0
    verdict.at_most(0.02 * 2 * RADIUS, np.hypot(cx, cy), f"the bed's centre is {1e3 * cx:+.2f}, {1e3 * cy:+.2f} mm off the axis (wanted 2 % of the diameter)", short)


def section(bed, height):
    """Mean void fraction in a horizontal cut."""
    plt = plot_fields.plt
    k = int(np.searchsorted(bed.z, height)) - 1
    eps = np.ma.masked_where(bed.theta[k] == 0, bed.file["average/fine/eps"][k])
    figure, ax = plt.subplots(figsize=(4.2, 3.6), layout="constrained")
    ax.set_facecolor(plot_fields.SOLID)
    picture = ax.pcolormesh(1e3 * bed.x, 1e3 * bed.y, eps, vmin=0.4, vmax=1, rasterized=True)
    a = np.linspace(0, 2 * np.pi, 181)
    ax.plot(1e3 * (X0 + RADIUS * np.cos(a)), 1e3 * (Y0 + RADIUS * np.sin(a)), color="w", linewidth=0.8)
    ax.set_aspect("equal")
    ax.set_xlabel("x / mm"), ax.set_ylabel("y / mm"), ax.set_title(f"z = {1e3 * 0.5 * (bed.z[k] + bed.z[k + 1]):.1f} mm")
    figure.colorbar(picture, ax=ax, label="mean void fraction")
    return figure


def main():
    folder, short = command_line(__doc__)
    bed, verdict = Bed(folder, D_P, RHO_P, DEM_STEP), Verdict()
    verdict.note(f"{bed.n:.0f} grains, {bed.inflow / SECTION:.3f} m/s, {bed.length:.2f} s, means from {bed.begin:.2f} s")
    ledgers(bed, verdict)
    drag_check.check(bed.file, verdict)
    vessel(bed, verdict)
    in_open_cells(bed, verdict)
    forces(bed, verdict, short)
    fluidisation(bed, verdict, short)
    symmetry(bed, verdict, short)
    pictures = usual_pictures(bed, [5e-3, 15e-3, 25e-3], top=min(1.3 * bed.now[:, 3].max(), bed.z[-1]), depth=Y0)
    save({**pictures, "section": section(bed, 15e-3)}, bed.folder)
    picture_3d.draw(os.path.join(bed.folder, "bed.h5"), os.path.join(bed.folder, "grains.png"), stl=os.path.join(bed.folder, "vessel.stl"))
    verdict.end()


if __name__ == "__main__":
    main()
