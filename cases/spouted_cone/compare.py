#!/usr/bin/python3
"""Verdict on a run of in.spouted_cone, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check that needs no measured curve, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run
of some tenths of a second; what needs a long mean, or cells fine enough for a spout, is told without a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import picture_3d  # noqa: E402
import plot_fields  # noqa: E402
from make_stl import BASE, FLOOR, HALF_ANGLE, HEIGHT, NOZZLE, SHOULDER, TOP, X0, Y0, radius  # noqa: E402
from verdict import Bed, G, Verdict, by_chance, command_line, in_open_cells, ledgers, momentum, save, usual_pictures  # noqa: E402

D_P, RHO_P = 2.0e-3, 1040.0      # as in.spouted_cone has it
SLOPE = np.tan(np.radians(HALF_ANGLE))
PACKED = 0.41                    # void fraction of the bed at rest, for its height in the correlations
ALARMS = 1e-3                    # rate of false alarms of the check of symmetry
LEAST = 0.3                      # s: some pulses of the spout, below which a mean says nothing of symmetry


class Cone(Bed):
    def __init__(self, folder, step):
        super().__init__(folder, D_P, RHO_P, step)
        self.top, self.up, self.gas, self.quarters = self.now[:, 3], self.now[:, 10], self.now[:, 11], self.now[:, 12:16]
        # Height of the bed at rest: a frustum of its volume.
        h = np.linspace(0, SHOULDER - FLOOR, 2001)
        volume = np.pi * h / 3 * (BASE**2 + BASE * (BASE + h * SLOPE) + (BASE + h * SLOPE)**2)
        self.H0 = np.interp(self.solids / (1 - PACKED), volume, h)
        self.Db = 2 * (BASE + self.H0 * SLOPE)
        self.nozzle = np.pi * NOZZLE**2
        self.r = np.hypot(plot_fields.centres(self.x)[None, :] - X0, plot_fields.centres(self.y)[:, None] - Y0)


def vessel(bed, verdict, short):
    """The vessel's volume, and no grain's centre behind its wall or in the nozzle."""
    exact = np.pi * (NOZZLE**2 * FLOOR + (SHOULDER - FLOOR) / 3 * (BASE**2 + BASE * TOP + TOP**2) + TOP**2 * (HEIGHT - SHOULDER))
    error, bound = np.sum(bed.theta * bed.volume) / exact - 1, 0.01 if short else 0.003
    verdict.between(-bound, error, bound, f"volume of the vessel on the grid: {100 * error:+.3f} % of the exact one (wanted {100 * bound:.1f} %)")
    verdict.note(f"section of the nozzle on the grid: {100 * (bed.section / bed.nozzle - 1):+.2f} % of the circle's; velocities here are those of the circle")
    p = bed.grains("position")
    r = np.hypot(p[:, 0] - X0, p[:, 1] - Y0)
    cone = (BASE + (p[:, 2] - FLOOR) * SLOPE - r) * np.cos(np.radians(HALF_ANGLE))
    nearest = np.minimum(np.minimum(cone, TOP - r), p[:, 2] - FLOOR).min()
    least = (0.35 if short else 0.4) * D_P
    verdict.between(least, nearest, np.inf, f"the grain nearest to wall or screen keeps its centre {1e3 * nearest:.3f} mm off (wanted: at least {1e3 * least:.2f}, soft contacts)")


def forces(bed, verdict, short):
    wall, screen, rub, lid = bed.mean[:, 2:6].T
    dp, share, scatter = momentum(bed, verdict, {"wall on grains": -wall, "screen on grains": -screen, "lid on grains": lid, "vessel on gas": -rub}, 5e-3 if short else 1e-3, ("vessel on gas",))
    inside = bed.averaged(bed.mean)
    carried = (dp.mean() * bed.section - rub[inside].mean()) / bed.weight
    verdict.note(f"mean pressure drop {dp.mean():.1f} Pa, standard deviation {dp.std():.1f} Pa; pressure at the nozzle and the gas's force on the wall together carry "
                 f"{100 * carried:.1f} % of the buoyant weight, cone and screen the rest")


def spout(bed, verdict, short):
    """On the axis there is more void than in the annulus, grains rise there and sink in the annulus."""
    average, coarse = bed.file["average"], plot_fields.nodes(bed.file, "particle_grid")
    theta = plot_fields.open_share(bed.file, "particle_grid")
    z = plot_fields.centres(coarse[2])
    r = np.hypot(plot_fields.centres(coarse[0])[None, :] - X0, plot_fields.centres(coarse[1])[:, None] - Y0)
    k = int(np.argmin(np.abs(z - FLOOR - 0.6 * bed.H0)))
    axis, annulus = (r < NOZZLE) & (theta[k] > 0), (r > 1.5 * NOZZLE) & (r < radius(z[k])) & (theta[k] > 0)
    if not axis.any() or not annulus.any():
        verdict.note(f"no spout to look at: no particle cells in {'spout' if not axis.any() else 'annulus'} at {1e3 * (z[k] - FLOOR):.0f} mm above the base, 0.6 of the bed's height")
        return
    mean = lambda values, where: np.average(values[where], weights=theta[k][where])
    eps, rise = average["particle_grid/eps"][k], average["particle_grid/solids_flux"][k, ..., 2]
    inner, outer, up, down = mean(eps, axis), mean(eps, annulus), mean(rise, axis), mean(rise, annulus)
    verdict.within(f"spout, {1e3 * (z[k] - FLOOR):.0f} mm above the base: void fraction {inner:.3f} within the nozzle's radius, "
                    f"{outer:.3f} in the annulus (wanted: 0.15 less); flux of grains {up:+.3f} m/s there, {down:+.3f} m/s in the annulus (wanted: up and down)",
                   ("void fraction, spout less annulus", 0.15, inner - outer, np.inf), ("up", 0, up, np.inf), ("down", -np.inf, down, 0), short=short)


def minimum_spouting(bed, verdict, short):
    """The velocity, turned down, at which grains no longer rise fast at the bed's surface, against Olazar et al. (1992)."""
    archimedes = D_P**3 * bed.rho_f * (RHO_P - bed.rho_f) * G / bed.mu**2
    reynolds = 0.126 * archimedes**0.5 * (bed.Db / (2 * NOZZLE))**1.68 * SLOPE**-0.57
    olazar = reynolds * bed.mu / (bed.rho_f * D_P)
    real = bed.section / bed.nozzle
    first = int(np.argmax(bed.gas >= bed.gas.max() - 1e-9))
    falling = np.nonzero(np.diff(bed.gas) < 0)[0] + 1
    falling = falling[falling > first]
    peak = bed.mean[:first + 1, 1].max()
    verdict.note(f"bed at rest: {1e3 * bed.H0:.1f} mm over the base, {1e3 * bed.Db:.1f} mm wide at its surface; largest pressure drop while the gas was turned up {peak:.0f} Pa, "
                 f"{peak / (bed.H0 * (1 - PACKED) * RHO_P * G):.2f} of the weight of such a column")
    reference = bed.up[bed.averaged(bed.now)].mean()
    alive = bed.up[falling] > 0.1 * reference
    if reference <= 0 or not alive.any():
        verdict(False, f"no grains rise fast at the bed's surface while the gas is turned down from {real * bed.gas.max():.1f} m/s: there is no spout; Olazar et al. (1992): "
                        f"{olazar:.1f} m/s", short)
        return
    last = falling[np.nonzero(alive)[0][-1]]
    U = real * bed.gas[last]
    ended = last < falling[-1]
    verdict(ended and abs(U / olazar - 1) <= 0.3, f"minimum spouting at {U:.1f} m/s in the nozzle" + ("" if ended else ", or below, for it spouts to the end of the ramp") +
                    f"; Olazar et al. (1992) {olazar:.1f} m/s (wanted: 30 %)", short, [("of Olazar", 0.7, U / olazar, 1.3)])


def symmetry(bed, verdict, short):
    """Nothing tells one quarter from another. Mean differences of the quarters' mass against their own statistical error, which counts the
    series' correlation in time."""
    q = bed.quarters[bed.averaged(bed.now)] / bed.quarters[0].sum()
    verdict.note("mass in the four quarters, less a fourth: " + ", ".join(f"{100 * (4 * m - 1):+.2f}" for m in q.mean(axis=0)) + " %")
    worst, lines, enough = 0.0, [], bed.length - bed.begin >= LEAST
    for name, series in (("right less left", q[:, 1] + q[:, 3] - q[:, 0] - q[:, 2]), ("back less front", q[:, 2] + q[:, 3] - q[:, 0] - q[:, 1]),
                         ("across", q[:, 0] + q[:, 3] - q[:, 1] - q[:, 2])):
        mean, error, independent, bound = by_chance(series, ALARMS / 3)
        enough = enough and independent >= 4
        worst = np.maximum(worst, abs(mean) / bound if bound > 0 else np.inf)
        lines.append(f"{name} {100 * mean:+.2f} +- {100 * error:.2f} % ({independent:.0f} independent values)")
        if abs(mean) > 0.06:
            worst = np.inf
    verdict.at_most(1, worst, ", ".join(lines) + f": {worst:.2f} of what chance exceeds once in {1 / ALARMS:.0f} runs (wanted: 1, and no more than 6 % of the mass)" +
                    ("" if enough else "; the series is too short for it: no verdict"), short or not enough)


def curve(bed):
    """Pressure drop over the velocity in the nozzle: up, down, up."""
    plt = plot_fields.plt
    at = 0.5 * (bed.mean[1:, 0] + bed.mean[:-1, 0])
    U, dp = np.interp(at, bed.now[:, 0], bed.gas), bed.mean[1:, 1]
    figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.4), layout="constrained")
    picture = axes[0].scatter(U, dp, c=at * bed.step, s=5)
    axes[0].set_xlabel("velocity in the nozzle / (m/s)"), axes[0].set_ylabel("pressure drop / Pa")
    figure.colorbar(picture, ax=axes[0], label="time / s")
    t = bed.now[:, 0] * bed.step
    axes[1].plot(t, bed.up / max(bed.up.max(), 1e-30), label="rising grains at the surface, momentum")
    axes[1].plot(t, bed.gas / bed.gas.max(), label=f"gas, of {bed.gas.max():.1f} m/s")
    axes[1].axvline(bed.begin, color="0.6", linewidth=0.8)
    axes[1].set_xlabel("time / s"), axes[1].set_ylim(0, 1.3), axes[1].legend(loc="upper right")
    return figure


def cut(bed):
    """Mean void fraction and gas velocity in the vertical cut through the axis, solid in its colour."""
    plt = plot_fields.plt
    figure, axes = plt.subplots(1, 2, figsize=(7.2, 5.4), sharey=True, layout="constrained")
    fine, theta = bed.file["average/fine"], plot_fields.open_share(bed.file)
    edges = [bed.x, bed.y, bed.z]
    for ax, values, label, options in ((axes[0], fine["eps"][:], "mean void fraction", dict(vmin=0.4, vmax=1)),
                                       (axes[1], fine["u"][..., 2], "gas, mean vertical velocity / (m/s)", dict(cmap="magma"))):
        picture = plot_fields.map_on(ax, edges, 0, plot_fields.plane(values, edges, 1, Y0, theta), **options)
        z = np.array([0, FLOOR, FLOOR, SHOULDER, HEIGHT])
        r = np.array([NOZZLE, NOZZLE, BASE, TOP, TOP])
        for side in (-1, 1):
            ax.plot(1e3 * (X0 + side * r), 1e3 * z, color="w", linewidth=0.8)
        figure.colorbar(picture, ax=ax, label=label, shrink=0.8)
    axes[0].set_ylabel("z / mm")
    return figure


def main():
    folder, short = command_line(__doc__)
    now = np.loadtxt(os.path.join(folder, "now.txt"), ndmin=2)
    bed, verdict = Cone(folder, (now[-1, 4] - now[0, 4]) / (now[-1, 0] - now[0, 0])), Verdict()
    verdict.note(f"{bed.n:.0f} grains, {bed.inflow / bed.nozzle:.2f} m/s in the nozzle, {bed.length:.2f} s, means from {bed.begin:.2f} s")
    ledgers(bed, verdict)
    drag_check.check(bed.file, verdict)
    vessel(bed, verdict, short)
    in_open_cells(bed, verdict)
    forces(bed, verdict, short)
    spout(bed, verdict, short)
    minimum_spouting(bed, verdict, short)
    symmetry(bed, verdict, short)
    pictures = usual_pictures(bed, [FLOOR + f * bed.H0 for f in (0.3, 0.6, 0.9)], depth=Y0)
    save({**pictures, "cut": cut(bed), "curve": curve(bed)}, bed.folder)
    picture_3d.draw(os.path.join(bed.folder, "bed.h5"), os.path.join(bed.folder, "grains.png"), stl=os.path.join(bed.folder, "vessel.stl"))
    verdict.end()


if __name__ == "__main__":
    main()
