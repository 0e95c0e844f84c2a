"""What the comparisons of flat beds share: a box with plane walls, gas through the floor or through a slot in it, a lid that lets the gas out.

Their tables (see verdict.py) go on with: now.txt, column 10, mass on the right (kg), 11, mean height of the grains (m); mean.txt, columns 2 to 7, vertical forces
of floor, lid, left, right, front and back on the grains (N).
"""
import os

import numpy as np

import drag_check
import picture_3d
import plot_fields
from verdict import G, NO_PICTURES, Bed, Verdict, by_chance, command_line, correlated_mean, ledgers, momentum, packed_fluidisation, save, save_compared, usual_pictures

PACKED = 0.42  # void fraction at rest, for a bed's height


def begin(usage, d, rho):
    """The run that the command line names, of grains of diameter d (m) and density rho; its ledgers and its drag. Returns bed, verdict, whether the run is a short one."""
    folder, short = command_line(usage)
    now = np.loadtxt(os.path.join(folder, "now.txt"), ndmin=2)
    bed, verdict = Bed(folder, d, rho, (now[-1, 4] - now[0, 4]) / (now[-1, 0] - now[0, 0])), Verdict()
    verdict.note(f"{bed.n:.0f} grains, {bed.inflow / bed.section:.3f} m/s over the section, {bed.inlet.max():.2f} m/s in the fastest inlet face, {bed.length:.2f} s, means from {bed.begin:.2f} s")
    ledgers(bed, verdict)
    drag_check.check(bed.file, verdict)
    return bed, verdict, short


def end(bed, verdict, short, heights, top):
    """Symmetry, pictures (profiles at heights, all up to `top`, m), and the exit."""
    left_and_right(bed, verdict, short, bed.solids * bed.rho_p)
    save_compared(bed.folder, compared(bed))
    if not NO_PICTURES:
        save({**usual_pictures(bed, heights, top=top), "curve": curve(bed)}, bed.folder)
    picture_3d.draw(os.path.join(bed.folder, "bed.h5"), os.path.join(bed.folder, "grains.png"), cut="none")
    verdict.end()


def balance(bed, verdict, short):
    """Balance of momentum. Returns the pressure drop's series (Pa), its mean share of the weight and the standard error of that."""
    floor, lid, *sides = bed.mean[:, 2:8].T
    return momentum(bed, verdict, {"floor on grains": floor, "lid on grains": lid, "sides on grains": sum(sides)}, 5e-3 if short else 1e-3)


def carries_weight(bed, verdict, short):
    """Balance of momentum, and the pressure drop of a bed with gas through all its floor."""
    dp, share, scatter = balance(bed, verdict, short)
    verdict.between(0.9 - 3 * scatter, share, 1.03 + 3 * scatter, f"mean pressure drop {dp.mean():.0f} Pa, standard deviation {dp.std():.0f} Pa: it carries {100 * share:.1f} +- {100 * scatter:.1f} % of the buoyant weight "
                    "(wanted: 90 to 103 %, give or take three standard errors; floor and rubbing walls carry the rest)", short)


def fluidises_as_wen_yu(bed, verdict, short, levels, velocity):
    """Minimum fluidisation by the packed bed's pressure drop at two velocities held before, which is returned. velocity: column of bed.now."""
    hold = int(np.argmax(np.diff(bed.now[:, velocity]) != 0)) * (bed.now[1, 0] - bed.now[0, 0])
    U_mf, wen_yu, drops = packed_fluidisation(bed, levels, hold, bed.weight / bed.section)
    verdict.between(0.7, U_mf / wen_yu, 1.3, f"packed bed: {drops[0]:.0f} and {drops[1]:.0f} Pa at {levels[0]} and {levels[1]} m/s; minimum fluidisation by them {U_mf:.3f} m/s, Wen & Yu (1966) {wen_yu:.3f} m/s (wanted: 30 %)", short)
    return U_mf


def left_and_right(bed, verdict, short, mass, alarms=1e-3, least=0.5):
    """Mean mass on the right less that on the left, against what chance gives. mass: of all grains (kg); alarms: rate of false ones; least: s of
    means below which they say nothing."""
    series = 2 * bed.now[bed.averaged(bed.now), 10] / mass - 1
    mean, error, independent, bound = by_chance(series, alarms)
    enough = bed.length - bed.begin >= least and independent >= 4
    verdict.between(-1, mean / max(bound, 1e-12), 1, f"mass right less left: {100 * mean:+.2f} +- {100 * error:.2f} % ({independent:.0f} independent values): {abs(mean) / bound:.2f} of what chance exceeds once in {1 / alarms:.0f} runs (wanted: 1)" + ("" if enough else "; the series is too short for it: no verdict"), short or not enough)


def bubbling(bed, verdict, short):
    """Bubbles stir the bed: grains rise in its middle and sink at the walls."""
    inside = bed.averaged(bed.now)
    mean, error, _ = correlated_mean(bed.now[inside, 11])
    verdict.note(f"mean height of the grains {1e3 * mean:.1f} +- {1e3 * error:.1f} mm, at rest {1e3 * bed.now[0, 11]:.1f} mm: expanded by {100 * (mean / bed.now[0, 11] - 1):.0f} %; highest grain {1e3 * bed.now[inside, 3].max():.0f} mm")
    average = bed.file["average/particle_grid"]
    x, _, z = (plot_fields.centres(e) for e in plot_fields.nodes(bed.file, "particle_grid"))
    flux = average["solids_flux"][:].mean(axis=1)[..., 2]
    k = (z > 0.4 * 2 * bed.now[0, 11]) & (z < 1.2 * 2 * bed.now[0, 11])
    width = np.ptp(bed.x)
    middle, side = np.abs(x - x.mean()) < 0.2 * width, np.abs(x - x.mean()) > 0.4 * width
    up, down = flux[k][:, middle].mean(), flux[k][:, side].mean()
    verdict.within(f"flux of grains in the upper bed: {up:+.4f} m/s in the middle, {down:+.4f} m/s at the walls (wanted: up and down)", ("up", 0, up, np.inf), ("down", -np.inf, down, 0), short=short)


def height_at_rest(bed):
    return bed.solids / (1 - PACKED) / bed.section


def spout(bed, verdict, short):
    """Grains rise fast over the slot, in the middle, and sink beside it; how high they fly."""
    average = bed.file["average/particle_grid"]
    x, _, z = (plot_fields.centres(e) for e in plot_fields.nodes(bed.file, "particle_grid"))
    eps, flux = average["eps"][:].mean(axis=1), average["solids_flux"][:].mean(axis=1)[..., 2]
    H0, width = height_at_rest(bed), np.ptp(bed.x)
    middle, side = np.abs(x - x.mean()) < 1.1 * (x[1] - x[0]), np.abs(x - x.mean()) > 0.25 * width
    k = int(np.argmin(np.abs(z - 0.5 * H0)))
    verdict.within(f"spout at {1e3 * z[k]:.0f} mm, half the height at rest: void fraction {eps[k, middle].mean():.3f} over the slot, {eps[k, side].mean():.3f} beside it (wanted: 0.1 less); flux of grains {flux[k, middle].mean():+.3f} and {flux[k, side].mean():+.3f} m/s (wanted: up and down)",
                   ("void fraction over the slot less beside it", 0.1, eps[k, middle].mean() - eps[k, side].mean(), np.inf), ("flux over the slot", 0, flux[k, middle].mean(), np.inf), ("flux beside it", -np.inf, flux[k, side].mean(), 0), short=short)
    solids = np.cumsum((1 - eps).mean(axis=1)) / np.sum((1 - eps).mean(axis=1))
    verdict.note(f"height at rest {1e3 * H0:.0f} mm; half, 95 and 99 % of the grains stand below {', '.join(f'{1e3 * np.interp(f, solids, z):.0f}' for f in (0.5, 0.95, 0.99))} mm in the mean; highest grain {1e3 * bed.now[bed.averaged(bed.now), 3].max():.0f} mm")


def void_over_the_slot(bed):
    """Height (m) up to which the mean void fraction over the middle stays above 0.7, midway between the packed bed and the empty jet; None if it does through all of the domain."""
    eps = bed.file["average/particle_grid/eps"][:].mean(axis=1)
    height = plot_fields.centres(plot_fields.nodes(bed.file, "particle_grid")[2])
    columns = eps.shape[1]
    axis = eps[:, (columns - 1) // 2:columns // 2 + 1].mean(axis=1)
    if not (axis < 0.7).any():
        return None
    k = int(np.argmax(axis < 0.7))
    return np.interp(0.7, [axis[k], axis[k - 1]], [height[k], height[k - 1]]) if k else 0.0


def rhythm(bed, verdict):
    """The bed's beat: the frequency at which the pressure drop's spectrum peaks."""
    inside = bed.averaged(bed.mean)
    dp, period = bed.mean[inside, 1], (bed.mean[1, 0] - bed.mean[0, 0]) * bed.step
    if inside.sum() * period < 1:
        return
    pieces = max(1, int(inside.sum() * period / 1.0))
    power = np.mean([np.abs(np.fft.rfft((p - p.mean()) * np.hanning(len(p))))**2 for p in np.array_split(dp[:len(dp) // pieces * pieces], pieces)], axis=0)
    frequency = np.fft.rfftfreq(len(dp) // pieces, period)
    verdict.note(f"pressure drop beats at {frequency[1 + np.argmax(power[1:])]:.1f} Hz (spectrum of {pieces} pieces); a bed of that height that swings as a whole: {np.sqrt(G / height_at_rest(bed)) / np.pi:.1f} Hz, by Baskakov, Tuponogov & Filippov (1986)")


def curve(bed):
    """Pressure drop and heights of the grains over time."""
    plt = plot_fields.plt
    figure, axes = plt.subplots(1, 2, figsize=(8.4, 3.2), layout="constrained")
    axes[0].plot(bed.mean[:, 0] * bed.step, bed.mean[:, 1], linewidth=0.7, label="pressure drop")
    axes[0].axhline(bed.weight / bed.section, color="k", linestyle="--", linewidth=1, label="buoyant weight / area")
    axes[0].set_xlabel("time / s"), axes[0].set_ylabel("pressure drop / Pa")
    axes[1].plot(bed.now[:, 0] * bed.step, 1e3 * bed.now[:, 3], linewidth=0.7, label="highest grain")
    axes[1].plot(bed.now[:, 0] * bed.step, 2e3 * bed.now[:, 11], linewidth=0.7, label="twice the mean height")
    axes[1].set_xlabel("time / s"), axes[1].set_ylabel("z / mm")
    for ax in axes:
        ax.axvline(bed.begin, color="0.6", linewidth=0.8, label="means from here on")
        ax.legend(fontsize=8)
    return figure


def compared(bed):
    """For report.py: the pressure drop over time against the weight."""
    t = bed.mean[:, 0] * bed.step
    return [dict(title="Pressure drop", x_label="time / s", y_label="pressure drop / Pa", x=t[::10], mean=bed.mean[::10, 1], error=None,
                 references=[dict(label="buoyant weight / area", x=[0, t[-1]], y=2 * [bed.weight / bed.section], line=True)])]
