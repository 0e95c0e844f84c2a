#!/usr/bin/python3
"""Verdict on a run of in.round_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check that needs no measured curve, draws FOLDER/*.png, ends with 0 if all passed. --short: of a
run of some tenths of a second; what needs a long mean is told without a verdict.
"""
import os
import sys

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import leg_tables  # noqa: E402
import plot_fields  # noqa: E402

# As in.round_bed has it.
D_P, RHO_P, G, DEM_STEP = 1.5e-3, 1000.0, 9.81, 2.5e-5
RADIUS, X0, Y0 = 30e-3, 31e-3, 31e-3
SECTION = np.pi * RADIUS**2
LEVELS = (0.2, 0.3)   # m/s, held for LEVEL_STEPS DEM steps each before the bed bubbles
LEVEL_STEPS = 2400


class Verdict:
    failed = 0

    def __call__(self, good, text):
        self.failed += not good
        print(f"{'PASS' if good else 'FAIL'}  {text}", flush=True)

    def note(self, text):
        print(f"      {text}", flush=True)

    def if_long(self, short, good, text):
        self.note(text) if short else self(good, text)


class Bed:
    """The output file, with what several checks need."""

    def __init__(self, folder):
        self.file = h5py.File(os.path.join(folder, "bed.h5"), "r")
        self.now = leg_tables.table(os.path.join(folder, "now.txt"))
        self.mean = leg_tables.table(os.path.join(folder, "mean.txt"))
        self.x, self.y, self.z = plot_fields.nodes(self.file)
        self.theta = plot_fields.open_share(self.file)
        self.rho_f = float(self.file["record"].attrs["density"])
        self.mu = float(self.file["record"].attrs["viscosity"])
        self.cell = np.outer(np.diff(self.y), np.diff(self.x))
        last = plot_fields.frames(self.file)[-1]
        self.inflow = np.sum(self.file["fluid"][last]["faces/flux_z"][0] * self.cell)  # m3/s
        self.inlet = np.sum((self.file["fluid"][last]["faces/flux_z"][0] != 0) * self.cell)
        self.n = self.now[0, 2]
        self.solids = self.n * np.pi / 6 * D_P**3
        self.weight = self.solids * (RHO_P - self.rho_f) * G


def conservation(bed, verdict):
    now, frames = bed.now, bed.file["fluid"]
    verdict(np.ptp(now[:, 2]) == 0, f"particles: {now[0, 2]:.0f} at the beginning, {now[-1, 2]:.0f} at the end")
    verdict(now[:, 6].max() <= 1e-13, f"solid volume deposited: relative error at most {now[:, 6].max():.1e} (wanted 1e-13)")
    verdict(now[:, 7].max() <= 1e-12, f"action and reaction: relative error at most {now[:, 7].max():.1e} (wanted 1e-12)")
    volume = np.diff(bed.z)[:, None, None] * bed.cell
    worst = 0
    for name in plot_fields.frames(bed.file):
        if frames[name]["time"][()] < bed.file["average"].attrs["from"]:
            continue
        flux, rate = frames[name]["faces/flux_z"], frames[name]["faces/deps_dt"][:]
        inflow, outflow, displaced = np.sum(flux[0] * bed.cell), np.sum(flux[-1] * bed.cell), -np.sum(rate * volume)
        worst = max(worst, abs(outflow - inflow - displaced) / inflow)
    verdict(worst <= 1e-6, f"gas out = gas in + displaced: relative error at most {worst:.1e} (wanted 1e-6)")
    open_volume = np.sum(bed.theta * volume)
    error = open_volume / (SECTION * np.ptp(bed.z)) - 1
    verdict(abs(error) <= 0.002, f"volume of the vessel on the grid: {100 * error:+.3f} % of the cylinder's (wanted 0.2 %)")
    verdict.note(f"largest continuity error of a cell {now[1:, 5].max():.1e} U/h; smallest void fraction {now[1:, 9].min():.3f}; "
                 f"moved by its bound at most {now[:, 8].max():.1e} m3 of {bed.solids:.1e} m3")


def momentum(bed, verdict, short):
    """Vertical momentum of particles and gas over the time of the means, the forces of floor and vessel on the grains included:
    d(P_s + P_f) = integral of [ dp A + rho sum U^2 A (in) - rho sum <f u> A (out) + forces of walls - buoyant weight ] dt.
    The force of the gas on the vessel (f_gas[19]) is what it loses to it.
    The volume flux of both phases together is the same in every section, hence P_f = const - rho_f/rho_p P_s."""
    average = bed.file["average"]
    step = bed.mean[:, 0]
    window = (step[1] - step[0]) * DEM_STEP
    inside = (step - 0.5 * (step[1] - step[0])) * DEM_STEP > average.attrs["from"]
    dp, floor, wall, rub = (bed.mean[inside, q] for q in (1, 2, 3, 4))
    P = dict(zip(bed.now[:, 0], bed.now[:, 1]))
    begin, end = step[inside][0] - (step[1] - step[0]), step[inside][-1]
    T = inside.sum() * window
    change = (P[end] - P[begin]) * (1 - bed.rho_f / RHO_P)
    fine = average["fine"]
    area = bed.theta[-1] * bed.cell
    out = fine["flux"][-1, ..., 2] * fine["u"][-1, ..., 2] + fine["u_variance"][-1, ..., 2]
    inflow_momentum, outflow_momentum = bed.rho_f * bed.inflow**2 / SECTION, bed.rho_f * np.sum(out * area)
    forces = {"pressure": dp.mean() * SECTION, "in": inflow_momentum, "out": -outflow_momentum, "floor": floor.mean(),
              "wall on grains": -wall.mean(), "wall on gas": -rub.mean(), "weight": -bed.weight}
    error = change / (bed.weight * T) - sum(forces.values()) / bed.weight
    verdict.note(f"per buoyant weight ({bed.weight:.4e} N, {bed.weight / SECTION:.1f} Pa), over {T:.2f} s: " +
                 ", ".join(f"{k} {v / bed.weight:+.4f}" for k, v in forces.items()) + f", change {change / (bed.weight * T):+.4f}")
    bound = 3e-3 if short else 1e-3
    verdict(abs(error) <= bound, f"momentum of gas and particles: the balance is open by {100 * error:+.3f} % of weight times time (wanted {100 * bound:.1f} %)")
    groups = [g.mean() for g in np.array_split(dp, min(8, len(dp)))]
    scatter = np.std(groups, ddof=1) / np.sqrt(len(groups)) * SECTION / bed.weight
    share = dp.mean() * SECTION / bed.weight
    verdict.if_long(short, abs(share - 1) <= max(0.03, 3 * scatter), f"mean pressure drop {dp.mean():.2f} Pa carries {100 * share:.2f} +- {100 * scatter:.2f} % "
                    "of the buoyant weight (wanted 100 +- 3 %)")


def fluidisation(bed, verdict, short):
    """Pressure drops of the packed bed at two velocities give Ergun's two terms, and these the velocity that carries the weight."""
    drops = []
    for i in range(2):
        steps = bed.mean[:, 0]
        held = (steps > (i + 0.6) * LEVEL_STEPS) & (steps <= (i + 1) * LEVEL_STEPS)
        drops.append(bed.mean[held, 1].mean())
    U = np.array(LEVELS)
    a, b = np.linalg.solve(np.stack([U, U**2], axis=1), drops)
    load = bed.weight / SECTION
    U_mf = (-a + np.sqrt(a * a + 4 * b * load)) / (2 * b) if b > 0 else load / a
    archimedes = D_P**3 * bed.rho_f * (RHO_P - bed.rho_f) * G / bed.mu**2
    wen_yu = (np.sqrt(33.7**2 + 0.0408 * archimedes) - 33.7) * bed.mu / (bed.rho_f * D_P)
    verdict.if_long(short, abs(U_mf / wen_yu - 1) <= 0.3, f"minimum fluidisation {U_mf:.3f} m/s, from the packed bed at {U[0]} and {U[1]} m/s ({drops[0]:.1f}, {drops[1]:.1f} "
            f"Pa); Wen & Yu (1966) {wen_yu:.3f} m/s (wanted: within their scatter of 30 %)")


def symmetry(bed, verdict, short):
    """Nothing in the vessel tells one side from another: means in the four quarters, and the bed's centre."""
    average = bed.file["average/particle_grid"]
    x, y, z = plot_fields.nodes(bed.file, "particle_grid")
    theta = plot_fields.open_share(bed.file, "particle_grid")
    solids = (1 - average["eps"][:]) * theta * np.diff(z)[:, None, None]
    X, Y = plot_fields.centres(x) - X0, plot_fields.centres(y) - Y0
    half = len(X) // 2
    quarters = np.array([solids[:, :half, :half].sum(), solids[:, :half, -half:].sum(), solids[:, -half:, :half].sum(), solids[:, -half:, -half:].sum()])
    off = 4 * quarters / quarters.sum() - 1
    verdict.if_long(short, np.abs(off).max() <= 0.06, "mean solids in the four quarters, less a fourth: " + ", ".join(f"{100 * q:+.1f}" for q in off) + " % (wanted 6 %)")
    turned = solids[:, ::-1].transpose(0, 2, 1)
    column, other = solids.sum(axis=0), turned.sum(axis=0)
    verdict.note(f"columns of solids less the same turned by 90 degrees: {100 * np.sqrt(np.mean((column - other)**2)) / column.max():.1f} % of the largest (root mean square)")
    mass = bed.n * np.pi / 6 * D_P**3 * RHO_P
    inside = bed.now[:, 0] * DEM_STEP > bed.file["average"].attrs["from"]
    cx, cy = bed.now[inside, 10].mean() / mass - X0, bed.now[inside, 11].mean() / mass - Y0
    verdict.if_long(short, np.hypot(cx, cy) <= 0.02 * 2 * RADIUS, f"the bed's centre is {1e3 * cx:+.2f}, {1e3 * cy:+.2f} mm off the axis (wanted 2 % of the diameter)")


def in_the_vessel(bed, verdict):
    """No grain's centre behind the wall, and no solids in closed cells."""
    last = plot_fields.frames(bed.file)[-1]
    p = bed.file["particles"][last]["position"][:]
    r = np.hypot(p[:, 0] - X0, p[:, 1] - Y0).max()
    verdict(r <= RADIUS - 0.45 * D_P, f"the outermost grain's centre is {1e3 * r:.3f} mm from the axis (wanted: at most {1e3 * (RADIUS - 0.45 * D_P):.3f})")
    eps = bed.file["fluid"][last]["eps"][:]
    solids = np.sum((1 - eps) * bed.theta * np.diff(bed.z)[:, None, None] * bed.cell)
    verdict(abs(solids / bed.solids - 1) <= 1e-12, f"solids in the open parts of cells: {abs(solids / bed.solids - 1):.1e} off the grains' volume (wanted 1e-12)")


def three_d(bed):
    """The grains of the last frame in three dimensions, coloured by their vertical velocity, in the vessel's outline."""
    plt = plot_fields.plt
    last = plot_fields.frames(bed.file)[-1]
    p, v = 1e3 * bed.file["particles"][last]["position"][:], bed.file["particles"][last]["velocity"][:, 2]
    figure = plt.figure(figsize=(5, 5.5))
    ax = figure.add_subplot(projection="3d", computed_zorder=False)
    front = np.argsort(p[:, 1] - p[:, 0])[::-1]
    fastest = np.percentile(np.abs(v), 99)
    balls = ax.scatter(*p[front].T, c=v[front], cmap="coolwarm", vmin=-fastest, vmax=fastest, s=9, linewidths=0.15, edgecolors="0.3", depthshade=False)
    a = np.linspace(0, 2 * np.pi, 73)
    for height in (0, np.ptp(bed.z) * 1e3):
        ax.plot(1e3 * (X0 + RADIUS * np.cos(a)), 1e3 * (Y0 + RADIUS * np.sin(a)), height, color=plot_fields.SOLID, linewidth=1)
    for q in a[::6]:
        ax.plot([1e3 * (X0 + RADIUS * np.cos(q))] * 2, [1e3 * (Y0 + RADIUS * np.sin(q))] * 2, [0, np.ptp(bed.z) * 1e3], color=plot_fields.SOLID, linewidth=0.4)
    ax.set_box_aspect((np.ptp(bed.x), np.ptp(bed.y), np.ptp(bed.z)))
    ax.set_xlabel("x / mm"), ax.set_ylabel("y / mm"), ax.set_zlabel("z / mm")
    figure.colorbar(balls, ax=ax, shrink=0.6, pad=0.1, label="vertical velocity / (m/s)")
    return figure


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


def draw(bed, folder):
    top = min(1.3 * bed.now[:, 3].max(), bed.z[-1])
    names = plot_fields.frames(bed.file)
    frames = np.linspace(len(names) // 3, len(names) - 1, 3).astype(int)
    pictures = {"mean_void_fraction": plot_fields.mean_void_fraction(bed.file, depth=Y0, top=top), "section": section(bed, 15e-3),
                "snapshots": plot_fields.snapshots(bed.file, frames, top=top), "profiles": plot_fields.profiles(bed.file, [5e-3, 15e-3, 25e-3]),
                "pressure": plot_fields.pressure_profile(bed.file), "grains": three_d(bed)}
    print("pictures:")
    for name, figure in pictures.items():
        path = os.path.join(folder, name + ".png")
        figure.savefig(path, dpi=110, bbox_inches="tight")
        print("  " + os.path.relpath(path))


def main():
    words = [w for w in sys.argv[1:] if w != "--short"]
    short = "--short" in sys.argv
    if len(words) != 1:
        sys.exit(__doc__)
    bed, verdict = Bed(words[0]), Verdict()
    if "weight" not in bed.file["average"].attrs or bed.now[-1, 0] * DEM_STEP <= bed.file["average"].attrs["from"]:
        sys.exit("the run ended before its means began: -var tend must be larger than -var tavg")
    verdict.note(f"{bed.n:.0f} grains, {bed.inflow / SECTION:.3f} m/s, {bed.now[-1, 0] * DEM_STEP:.2f} s, means from {bed.file['average'].attrs['from']:.2f} s")
    conservation(bed, verdict)
    in_the_vessel(bed, verdict)
    momentum(bed, verdict, short)
    fluidisation(bed, verdict, short)
    symmetry(bed, verdict, short)
    draw(bed, words[0])
    sys.exit(1 if verdict.failed else 0)


if __name__ == "__main__":
    main()
