#!/usr/bin/python3
"""Verdict on a run of in.tube_bank, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt, empty.txt)

Prints PASS or FAIL for every check that needs no measured curve, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run
of some tenths of a second; what needs a long mean is told without a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import leg_tables  # noqa: E402
import picture_3d  # noqa: E402
import plot_fields  # noqa: E402
from verdict import Bed, G, Verdict, batch_error, by_chance, command_line, in_open_cells, ledgers, momentum, packed_fluidisation, save, usual_pictures  # noqa: E402

# As in.tube_bank has it.
D_P, RHO_P, DEM_STEP = 1.5e-3, 1000.0, 2.5e-5
DEPTH, R = 9e-3, 6e-3
ROW = 20.785e-3
TUBES = [(x, 18e-3 + i * ROW) for i, row in enumerate(((12e-3, 36e-3, 60e-3), (24e-3, 48e-3), (12e-3, 36e-3, 60e-3))) for x in row]
LEVELS = (0.15, 0.25)           # m/s, held before the bed bubbles
EMPTY = dict(D=12e-3, pitch=18e-3, rows=8, U=0.01407)   # the closer bank, in gas alone
ALARMS = 1e-3                   # rate of false alarms of the check of symmetry
LEAST = 0.3                     # s: some periods of bubbles, below which a mean says nothing of symmetry


def tubes(bed, verdict, short):
    """The tubes' volume on the grid, and no grain in a tube."""
    closed, exact = np.sum((1 - bed.theta) * bed.volume), len(TUBES) * np.pi * R**2 * DEPTH
    bound = 0.06 if short else 0.015
    verdict.between(1 - bound, closed / exact, 1 + bound, f"volume of the tubes on the grid: {100 * (closed / exact - 1):+.2f} % of the exact one (wanted {100 * bound:.1f} %)")
    p = bed.grains("position")
    nearest = min(np.hypot(p[:, 0] - x, p[:, 2] - z).min() for x, z in TUBES) - R
    verdict.between(0.4 * D_P, nearest, np.inf, f"the grain nearest to a tube keeps its centre {1e3 * nearest:.3f} mm off its surface (wanted: at least {0.4e3 * D_P:.2f}, soft contacts)")


def empty_bank(bed, verdict, folder):
    """Gas alone through eight rows of tubes 1.5 D apart, against Bergelin, Colburn & Hull (1950) for laminar flow, good to 25 %."""
    table = leg_tables.table(os.path.join(folder, "empty.txt"))
    dp, last = table[-1, 1], table[-1, 0]
    rate = abs(dp / np.interp(0.8 * last, table[:, 0], table[:, 1]) - 1)
    D, P = EMPTY["D"], EMPTY["pitch"]
    V = EMPTY["U"] * P / (P - D)
    Dv = 4 * (P * P * np.sqrt(3) / 2 - np.pi * D**2 / 4) / (np.pi * D)
    reynolds = bed.rho_f * V * Dv / bed.mu
    wanted = 280 * EMPTY["rows"] / reynolds * (D / P)**1.6 * bed.rho_f * V**2 / 2
    verdict.within(f"empty bank at Re = {reynolds:.1f}: {1e3 * dp:.3f} mPa, {100 * rate:.2g} % more or less than at four fifths of the time; "
            f"Bergelin et al. (1950) {1e3 * wanted:.3f} mPa: {100 * (dp / wanted - 1):+.1f} % (wanted 25 %, their scatter)", ("of Bergelin", 0.75, dp / wanted, 1.25), ("still changing", 0, rate, 0.01))


def forces(bed, verdict, short):
    floor, on_grains, on_gas = bed.mean[:, 2], bed.mean[:, 3], bed.mean[:, 4:12]
    dp, share, scatter = momentum(bed, verdict, {"floor, lid and sides": floor, "tubes on grains": on_grains, "tubes on gas": -on_gas.sum(axis=1)}, 3e-3 if short else 1e-3, ("tubes on gas",))
    # In a fluidised bed the tubes are lifted as by a liquid, or not at all where grains lie on them.
    average, z = bed.file["average/particle_grid"], plot_fields.nodes(bed.file, "particle_grid")[2]
    theta = plot_fields.open_share(bed.file, "particle_grid")
    bank = (plot_fields.centres(z) > TUBES[0][1] - R) & (plot_fields.centres(z) < TUBES[-1][1] + R)
    packing = np.average(1 - average["eps"][:][bank], weights=theta[bank])
    lift = packing * (RHO_P - bed.rho_f) * G * len(TUBES) * np.pi * R**2 * DEPTH / bed.weight
    verdict.between(0.97 - 3 * scatter, share, 1.03 + lift + 3 * scatter, f"mean pressure drop {dp.mean():.1f} Pa carries {100 * share:.2f} +- {100 * scatter:.2f} % of the buoyant "
                    f"weight (wanted: 97 to {100 * (1.03 + lift):.0f} %, give or take three standard errors; {100 * lift:.1f} % more than the weight if the tubes were lifted by the bed as by a liquid)", short)
    inside = bed.averaged(bed.mean)
    for name, which in (("lowest", slice(0, 3)), ("middle", slice(3, 5)), ("highest", slice(5, 8))):
        each = on_gas[inside, which]
        verdict.note(f"gas lifts the tubes of the {name} row by " + ", ".join(f"{1e3 * f:.2f} +- {1e3 * batch_error(s):.2f}" for f, s in zip(each.mean(axis=0), each.T)) + " mN")
    return lift


def fluidisation(bed, verdict, short, lift):
    """The packed bed's pressure drop reaches the weight of the bed, that of the tubes' volume of it included. Between tubes the gas has less
    room: in a packed bed a regular bank of share phi of solid section makes the resistance (1 + phi)/(1 - phi) times as large (Rayleigh 1892)."""
    steps = bed.mean[:, 0]
    hold = np.argmax(bed.now[:, 13] > LEVELS[0] + 1e-9)
    hold = bed.now[hold, 0] - (steps[1] - steps[0])
    U_mf, wen_yu, drops = packed_fluidisation(bed, LEVELS, hold, bed.weight * (1 + lift) / bed.section)
    phi = np.pi * R**2 / ((TUBES[1][0] - TUBES[0][0]) * ROW)
    top = bed.now[:int(2 * hold / (steps[1] - steps[0])), 3].mean()
    share = min(3 * ROW / top, 1)
    wanted = wen_yu / (1 - share + share * (1 + phi) / (1 - phi))
    verdict.between(0.7, U_mf / wanted, 1.3, f"minimum fluidisation {U_mf:.3f} m/s, from the packed bed at {LEVELS[0]} and {LEVELS[1]} m/s ({drops[0]:.1f}, {drops[1]:.1f} "
                    f"Pa); Wen & Yu (1966) {wen_yu:.3f} m/s without tubes, {wanted:.3f} m/s with {100 * share:.0f} % of the bed between them (wanted: within their scatter of 30 %)", short)


def symmetry(bed, verdict, short):
    """The bank is its own mirror image. Mean differences between right and left against their statistical error, which counts the series' correlation in time."""
    rows, inside = bed.now[bed.averaged(bed.now)], bed.averaged(bed.mean)
    mass = bed.n * np.pi / 6 * D_P**3 * RHO_P
    lifts = bed.mean[inside, 4:12]
    series = {"mass": 1 - 2 * rows[:, 10] / mass, "mass over the bank": (rows[:, 12] - 2 * rows[:, 11]) / max(rows[:, 12].mean(), 1e-30),
              "gas's lift on tubes": (lifts[:, [2, 4, 7]].sum(axis=1) - lifts[:, [0, 3, 5]].sum(axis=1)) / lifts.sum(axis=1).mean()}
    if rows[:, 12].mean() < 0.02 * mass:
        del series["mass over the bank"]
    worst, lines, enough = 0.0, [], bed.length - bed.begin >= LEAST
    for name, values in series.items():
        mean, error, independent, bound = by_chance(values, ALARMS / len(series))
        enough = enough and independent >= 4
        worst = np.maximum(worst, abs(mean) / bound if bound > 0 else np.inf)
        lines.append(f"{name} {100 * mean:+.2f} +- {100 * error:.2f} % ({independent:.0f} independent values)")
    verdict.at_most(1, worst, "right less left: " + ", ".join(lines) + f": {worst:.2f} of what chance exceeds once in {1 / ALARMS:.0f} runs (wanted: 1)" +
                    ("" if enough else "; the series is too short for it: no verdict"), short or not enough)
    eps = bed.file["average/particle_grid/eps"][:]
    theta = plot_fields.open_share(bed.file, "particle_grid")
    off = (eps - eps[:, :, ::-1])[(theta > 0) & (eps < 0.95)]
    verdict.note(f"void fraction less its mirror image: {np.sqrt(np.mean((0.5 * off)**2)):.3f} (root mean square)")


def cut(bed):
    """Mean void fraction, gas and solids flux, means over the tubes' length, solid in its colour."""
    plt = plot_fields.plt
    figure, axes = plt.subplots(1, 3, figsize=(11, 4.8), sharey=True, layout="constrained")
    fine, coarse = bed.file["average/fine"], bed.file["average/particle_grid"]
    theta, theta2 = plot_fields.open_share(bed.file), plot_fields.open_share(bed.file, "particle_grid")
    edges, edges2 = [bed.x, bed.y, bed.z], plot_fields.nodes(bed.file, "particle_grid")
    flux = coarse["solids_flux"][..., 2]
    most = np.abs(flux).max()
    for ax, e, t, values, label, options in ((axes[0], edges, theta, fine["eps"][:], "mean void fraction", dict(vmin=0.4, vmax=1)),
                                             (axes[1], edges, theta, fine["u"][..., 2], "gas, mean vertical velocity / (m/s)", dict(cmap="magma")),
                                             (axes[2], edges2, theta2, flux, "grains, mean vertical flux / (m/s)", dict(cmap="coolwarm", vmin=-most, vmax=most))):
        picture = plot_fields.map_on(ax, e, 0, plot_fields.plane(values, e, 1, None, t), **options)
        for x, z in TUBES:
            ax.add_patch(plt.Circle((1e3 * x, 1e3 * z), 1e3 * R, facecolor=plot_fields.SOLID, edgecolor="w", linewidth=0.8))
        figure.colorbar(picture, ax=ax, label=label, shrink=0.8)
    axes[0].set_ylabel("z / mm")
    return figure


def main():
    folder, short = command_line(__doc__)
    bed, verdict = Bed(folder, D_P, RHO_P, DEM_STEP), Verdict()
    verdict.note(f"{bed.n:.0f} grains, {bed.inflow / bed.section:.3f} m/s, {bed.length:.2f} s, means from {bed.begin:.2f} s")
    ledgers(bed, verdict)
    drag_check.check(bed.file, verdict)
    tubes(bed, verdict, short)
    in_open_cells(bed, verdict)
    empty_bank(bed, verdict, folder)
    lift = forces(bed, verdict, short)
    fluidisation(bed, verdict, short, lift)
    symmetry(bed, verdict, short)
    save({**usual_pictures(bed, [8e-3, 28e-3, 70e-3]), "cut": cut(bed)}, bed.folder)
    picture_3d.draw(os.path.join(bed.folder, "bed.h5"), os.path.join(bed.folder, "grains.png"), cut=0.25e3 * D_P, azimuth=15, elevation=12)
    verdict.end()


if __name__ == "__main__":
    main()
