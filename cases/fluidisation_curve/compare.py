#!/usr/bin/python3
"""The packed bed's pressure drop on the falling branch against Ergun (1952) at the bed's own void fractions, and minimum fluidisation by it.

    compare.py FOLDER [--no-picture]     FOLDER: what in.fluidisation_curve wrote (curve.txt, bed.txt)

Prints PASS or FAIL for every check, draws FOLDER/fluidisation_curve.png, ends with 0 if all passed.
"""
import argparse
import os
import sys

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import leg_tables  # noqa: E402
from verdict import G, Verdict, save_compared  # noqa: E402

WIDTH, CELL = 6.0e-3, 1.8e-3  # as in.fluidisation_curve has them: width, height of the particle cells
TOLERANCE, LINE_TOLERANCE = 0.02, 0.05  # of points, and of the line through them


def read_beds(path):
    """All dumped frames: list of (step, positions, radii); and the density of the spheres (kg/m3)."""
    with open(path) as f:
        lines = f.read().split("\n")
    frames, at = [], 0
    while at + 9 < len(lines):
        step, count = int(lines[at + 1]), int(lines[at + 3])
        table = np.array([line.split()[:5] for line in lines[at + 9:at + 9 + count]], dtype=float)
        frames.append((step, table[:, :3], table[:, 3]))
        at += 9 + count
    return frames, np.sum(table[:, 4]) / np.sum(4 / 3 * np.pi * table[:, 3]**3)


def volume_below(z, centre, radius):
    """Volume of spheres below the height z (m3): caps by their height h, pi h^2 (3 r - h) / 3."""
    h = np.clip(z - (centre - radius), 0, 2 * radius)
    return np.sum(np.pi * h**2 * (3 * radius - h) / 3)


def void_fractions(x, radius):
    """Exact void fraction of slices as high as the particle cells, from the floor to above the surface; their height (m)."""
    height = CELL
    borders = np.arange(0, x[:, 2].max() + radius.max() + height, height)
    below = np.array([volume_below(z, x[:, 2], radius) for z in borders])
    return 1 - np.diff(below) / (WIDTH**2 * height), height


def ergun_factors(eps, d, fluid):
    """Ergun (1952): dp/L = linear U + quadratic U^2 of a packing at superficial velocity U; Pa s/m2 and Pa s2/m3. fluid: density, viscosity."""
    rho, mu = fluid
    return 150 * (1 - eps)**2 * mu / (eps**3 * d**2), 1.75 * (1 - eps) * rho / (eps**3 * d)


def velocity_at(dp, linear, quadratic):
    """Velocity U at which linear U + quadratic U^2 = dp."""
    return 2 * dp / (linear + np.sqrt(linear**2 + 4 * quadratic * dp))


def ergun_velocity(x, radius, weight, fluid):
    """Superficial velocity (m/s) at which Ergun's pressure drop over the bed's own void fractions is the weight."""
    eps, height = void_fractions(x, radius)
    linear, quadratic = ergun_factors(eps, 2 * radius.mean(), fluid)
    return velocity_at(weight, height * linear.sum(), height * quadratic.sum())


def against_ergun(step, U, dp, beds, fluid):
    """Superficial velocity over that at which Ergun's pressure drop is the one measured, point by point, with the bed as it was: it gets denser while the flow is turned
    down, by 5 % of that velocity. step: the middles of the points' times."""
    factors = []
    for at, x, radius in beds:
        eps, height = void_fractions(x, radius)
        factors.append((at, *(height * f.sum() for f in ergun_factors(eps, 2 * radius.mean(), fluid))))
    at, linear, quadratic = np.array(factors).T
    return U / velocity_at(dp, np.interp(step, at, linear), np.interp(step, at, quadratic))


def measure(folder):
    curve = leg_tables.table(os.path.join(folder, "curve.txt"))
    step, U, dp = curve[:, 0], curve[:, 2], curve[:, 3]
    floor = curve[:, 6] / WIDTH**2
    beds, rho_p = read_beds(os.path.join(folder, "bed.txt"))
    with h5py.File(os.path.join(folder, "bed.h5"), "r") as file:
        fluid = tuple(float(file["record"].attrs[k]) for k in ("density", "viscosity"))
    radius = beds[-1][2]
    lightened = (rho_p - fluid[0]) * G
    weight = np.sum(4 / 3 * np.pi * radius**3) * lightened / WIDTH**2
    falling = np.arange(len(U)) > np.argmax(U)
    # Fixed-bed line dp = a U + b U^2, from the part of the falling branch well below the weight.
    fixed = falling & (dp < 0.75 * weight) & (dp > 0.1 * weight)
    (a, b), *_ = np.linalg.lstsq(np.stack([U[fixed], U[fixed]**2], axis=1), dp[fixed], rcond=None)
    Umf = velocity_at(weight, a, b)
    ratio = against_ergun(step[fixed] - 0.5 * (step[1] - step[0]), U[fixed], dp[fixed], beds, fluid)
    at_rest = [(x, r) for s, x, r in beds if step[fixed].min() <= s <= step[fixed].max()]
    ergun = np.mean([ergun_velocity(x, r, weight, fluid) for x, r in at_rest])
    slices = [void_fractions(x, r) for x, r in at_rest]
    line = np.mean([[height * sum(f) for f in ergun_factors(e, 2 * radius.mean(), fluid)] for e, height in slices], axis=0)
    eps = np.mean(np.concatenate([void_fractions(x, r)[0][2:-3] for x, r in at_rest]))
    middle = velocity_at((1 - eps) * lightened, *ergun_factors(eps, 2 * radius.mean(), fluid))
    return dict(liquid=fluid[0] > 0.1 * rho_p, U=U, dp=dp, falling=falling, a=a, b=b, ratio=ratio, weight=weight, Umf=Umf, eps=eps, ergun=ergun, middle=middle,
                plateau=dp[falling & (U > 1.03 * Umf)], rests=floor[falling & (U > 1.03 * Umf)], line=line, particles=len(radius), beds=len(at_rest))


def draw(m, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, ax = plt.subplots(figsize=(7, 4.6))
    up = ~m["falling"]
    ax.plot(m["U"][up], m["dp"][up], "o", ms=4, mfc="none", color="tab:blue", label="rising")
    ax.plot(m["U"][m["falling"]], m["dp"][m["falling"]], "o", ms=4, color="tab:red", label="falling")
    U = np.linspace(0, m["U"].max(), 200)
    line = m["a"] * U + m["b"] * U**2
    ax.plot(U[line < 1.15 * m["weight"]], line[line < 1.15 * m["weight"]], "k-", lw=1, label="fixed bed, fitted")
    ax.axhline(m["weight"], color="k", ls="--", lw=1, label="buoyant weight / area")
    ax.axvline(m["Umf"], color="tab:red", lw=1, alpha=0.6)
    ax.axvline(m["ergun"], color="tab:green", lw=1.2, ls="-.", label="Ergun at the bed's void fractions")
    ax.set_xlabel("superficial velocity (m/s)")
    ax.set_ylabel("pressure drop (Pa)")
    ax.set_ylim(0, 1.25 * m["weight"])
    ax.set_xlim(0, None)
    ax.legend(loc="center left")
    ax.set_title(f"U_mf = {m['Umf']:.4f} m/s, Ergun {m['ergun']:.4f} m/s")
    fig.tight_layout()
    fig.savefig(path, dpi=130)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("--no-picture", action="store_true")
    options = parser.parse_args()
    m = measure(options.folder)
    verdict = Verdict()
    verdict.note(f"{m['particles']} particles; weight/area {m['weight']:.2f} Pa; void fraction of the middle "
          f"{m['eps']:.4f}, where Ergun alone would give {m['middle']:.4f} m/s ({m['beds']} beds at rest)")
    if len(m["plateau"]) > 1:
        mean, error = m["plateau"].mean(), m["plateau"].std(ddof=1) / np.sqrt(len(m["plateau"]))
        verdict.note(f"falling branch above minimum fluidisation: pressure drop {mean:.1f} +- {error:.1f} Pa, {100 * mean / m['weight']:.1f} % of the weight; the floor carries {100 * m['rests'].mean() / m['weight']:.1f} %")
    by_line = m["Umf"] / m["ergun"] - 1
    line = f"minimum fluidisation by the line through the falling branch {m['Umf']:.4f} m/s, Ergun over the void fractions of the beds meanwhile {m['ergun']:.4f} m/s: {100 * by_line:+.2f} %"
    error = m["ratio"].mean() - 1
    points = f"packed bed: velocity for the pressure drop of {len(m['ratio'])} points, each over Ergun's for the bed as it was: {100 * error:+.2f} %, scatter {100 * m['ratio'].std():.2f} %"
    if m["liquid"]:
        verdict.note(points)
        verdict.between(-LINE_TOLERANCE, by_line, LINE_TOLERANCE, line + f" (wanted within {100 * LINE_TOLERANCE:.0f} %)")
    else:
        verdict.note(line)
        verdict.between(-TOLERANCE, error, TOLERANCE, points + f" (wanted within {100 * TOLERANCE:.0f} %)")
    U = np.linspace(0, m["ergun"], 40)
    order = np.argsort(m["U"][m["falling"]])
    save_compared(options.folder, [dict(title="Pressure drop while the flow is turned down", x_label="superficial velocity / (m/s)", y_label="pressure drop / Pa",
                                        x=m["U"][m["falling"]][order], mean=m["dp"][m["falling"]][order], error=None, references=[
                                            dict(label="Ergun, the bed's void fractions", x=U, y=m["line"][0] * U + m["line"][1] * U**2, line=True),
                                            dict(label="weight / area", x=[m["ergun"], m["U"].max()], y=2 * [m["weight"]], line=True)])])
    if not options.no_picture:
        path = os.path.join(options.folder, "fluidisation_curve.png")
        draw(m, path)
        verdict.note(f"picture: {path}")
    verdict.end()


if __name__ == "__main__":
    main()
