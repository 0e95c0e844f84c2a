#!/usr/bin/python3
"""Verdict on a run of in.sedimentation, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (one_SHARE.h5, bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of a narrower column; fronts are told without a verdict.
"""
import glob
import os
import sys

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import picture_3d  # noqa: E402
import plot_fields  # noqa: E402
import suspension  # noqa: E402
from verdict import NO_PICTURES, Bed, Verdict, command_line, ledgers, save, save_compared, usual_pictures  # noqa: E402

D, RHO_P = 1.0e-3, 2500.0        # as in.sedimentation has it
OF_LAW, OF_RICHARDSON_ZAKI = 0.15, 0.15
ABOVE = 6e-3                     # m, of clear liquid at the beginning


class Column:
    """A settling suspension: time, heights and radii of the grains of each frame."""

    def __init__(self, path):
        self.file = h5py.File(path, "r")
        names = plot_fields.frames(self.file)
        self.t = np.array([self.file["fluid"][n]["time"][()] for n in names])
        self.z, self.r = zip(*((self.file["particles"][n]["position"][:, 2], self.file["particles"][n]["radius"][:]) for n in names))
        x, y, z = plot_fields.nodes(self.file)
        self.section, self.h0 = np.ptp(x) * np.ptp(y), z[-1] - ABOVE
        record = self.file["record"].attrs
        self.rho_f, self.mu = float(record["density"]), float(record["viscosity"])
        name = self.file["record/settings"].attrs["drag"]
        self.law = drag_check.LAWS.get(name.decode() if isinstance(name, bytes) else str(name))

    def share(self, kind):
        """Of the suspension's volume that spheres of radii `kind` (low, high) take at the beginning."""
        r = self.r[0][(self.r[0] > kind[0]) & (self.r[0] < kind[1])]
        return np.sum(4 / 3 * np.pi * r**3) / (self.section * self.h0)

    def front(self, kind):
        """Height of the front over time. What stands above the column's middle has the share of the beginning up to the front, as long as neither front nor
        sediment has come there."""
        heights = []
        for z, r in zip(self.z, self.r):
            of = (r > kind[0]) & (r < kind[1])
            volume = np.sum(4 / 3 * np.pi * r[of]**3) - suspension.volume_below(0.5 * self.h0, z[of], r[of])
            heights.append(0.5 * self.h0 + volume / (self.share(kind) * self.section))
        return np.array(heights)

    def speed(self, heights, low=0.6):
        """Of a front, from what is 0.1 s after the beginning on until it has fallen to `low` of the height; and its standard error, from four pieces."""
        fall = (self.t >= 0.1) & (heights >= low * self.h0)
        t, h = self.t[fall], heights[fall]
        if len(t) < 5:
            return np.nan, np.nan
        ends = np.linspace(0, len(t) - 1, 5).round().astype(int)
        pieces = -np.diff(h[ends]) / np.diff(t[ends])
        return (h[0] - h[-1]) / (t[-1] - t[0]), pieces.std(ddof=1) / 2


def lone(d, c):
    """Fall of a lone sphere and Richardson & Zaki's n."""
    U = suspension.terminal_velocity(d, RHO_P, c.rho_f, c.mu)
    return U, suspension.richardson_zaki(U * d * c.rho_f / c.mu)


def one_size(folder, verdict, short):
    """Fronts of suspensions of one size against the law of a uniform one and against Richardson & Zaki."""
    rows, columns = [], []
    for path in sorted(glob.glob(os.path.join(folder, "one_*.h5"))):
        c = Column(path)
        share = c.share((0, 1))
        U_t, n = lone(D, c)
        heights = c.front((0, 1))
        v, error = c.speed(heights)
        by_law = float(suspension.by_law(c.law, 1 - share, D, RHO_P, c.rho_f, c.mu)) if c.law else np.nan
        zaki = U_t * (1 - share)**n
        rows.append((share, v, error, by_law, zaki))
        columns.append((c, heights))
        verdict.note(f"{100 * share:.1f} % of spheres of 1 mm: the front falls at {1e3 * v:.2f} +- {1e3 * error:.2f} mm/s; by the law {1e3 * by_law:.2f} ({100 * (v / by_law - 1):+.1f} %), Richardson & Zaki {1e3 * zaki:.2f} ({100 * (v / zaki - 1):+.1f} %)")
    rows = np.array(rows)
    verdict.note(f"a lone sphere falls at {1e3 * U_t:.2f} mm/s, Re {U_t * D * c.rho_f / c.mu:.2f}, n {n:.2f}" +
                 (f"; line through ln v over ln eps: n {np.polyfit(np.log(1 - rows[:, 0]), np.log(rows[:, 1]), 1)[0]:.2f}" if len(rows) > 1 else ""))
    if c.law:
        off = np.abs(rows[:, 1] / rows[:, 3] - 1).max()
        verdict.at_most(OF_LAW, off, f"fronts against a uniform suspension by the run's law: {100 * off:.1f} % off at most (wanted {100 * OF_LAW:.0f} %)", short)
    off = np.abs(rows[:, 1] / rows[:, 4] - 1).max()
    verdict.at_most(OF_RICHARDSON_ZAKI, off, f"fronts against Richardson & Zaki: {100 * off:.1f} % off at most (wanted {100 * OF_RICHARDSON_ZAKI:.0f} %)", short)
    if len(rows) > 1:
        verdict.between(0, -np.diff(rows[:, 1]).max(), np.inf, "the more spheres, the slower the front", short)
    return rows, columns, U_t, n


def two_fronts(shares, slips):
    """Velocities (m/s, down) of large and small ones in the mixture, of the small ones above it, and their share there. slips: functions of the void
    fraction that give the slip of each size, the same whatever else there is: buoyancy of the mixture and drag of its like at that void fraction."""
    eps = 1 - sum(shares)
    u = sum(s * f(eps) for s, f in zip(shares, slips))
    large, small = slips[0](eps) - u, slips[1](eps) - u
    # Small ones that the front of the large ones leaves behind: what comes through it goes on at their own pace.
    low, high = 1e-4, 0.6
    for _ in range(60):
        share = 0.5 * (low + high)
        v = (1 - share) * slips[1](1 - share)
        low, high = (share, high) if share * (large - v) < shares[1] * (large - small) else (low, share)
    return large, small, v, share


def two_sizes(c, verdict, short):
    d = np.unique(np.round(2 * c.r[0], 9))[::-1]
    middle = d.mean() / 2
    kinds = ((middle, 1), (0, middle))
    shares = [c.share(k) for k in kinds]
    theories = []
    for name in ("the law", "Richardson & Zaki"):
        slips = []
        for size in d:
            U_t, n = lone(size, c)
            slips.append((lambda eps, size=size: float(suspension.by_law(c.law, eps, size, RHO_P, c.rho_f, c.mu)) / eps) if name == "the law" else (lambda eps, U_t=U_t, n=n: U_t * eps**(n - 1)))
        if c.law or name != "the law":
            theories.append((name, two_fronts(shares, slips)))
    heights = c.front(kinds[0])
    large, error = c.speed(heights)
    # Heights below which certain parts of the small ones stand fall with these, here above the front of the large ones.
    parts = np.array([0.90, 0.93, 0.96])
    small_at = np.array([np.quantile(z[r < middle], parts) for z, r in zip(c.z, c.r)])
    clear = np.array([np.quantile(z[r > middle], 0.98) for z, r in zip(c.z, c.r)])
    above = (clear < small_at[:, 0]) & (small_at[:, 0] > 0.5 * c.h0) & (c.t > 0.2)
    small = -np.polyfit(c.t[above], small_at[above].mean(axis=1), 1)[0] if above.sum() > 3 else np.nan
    verdict.note(f"two sizes, {1e3 * d[0]:.2f} and {1e3 * d[1]:.2f} mm, {100 * shares[0]:.1f} % and {100 * shares[1]:.1f} %: front of the large ones {1e3 * large:.2f} +- {1e3 * error:.2f} mm/s, of the small ones above it {1e3 * small:.2f} mm/s")
    for name, (a, b, v, share) in theories:
        bound = OF_LAW if name == "the law" else OF_RICHARDSON_ZAKI
        verdict.within(f"by {name} {1e3 * a:.2f} ({100 * (large / a - 1):+.1f} %) and {1e3 * v:.2f} mm/s ({100 * (small / v - 1):+.1f} %; {100 * share:.1f} % of them there): wanted {100 * bound:.0f} %",
                       ("large", -bound, large / a - 1, bound), ("small", -bound, small / v - 1, bound), short=short)
    z, r = c.z[-1], c.r[-1]
    order = np.argsort(z)
    volume = np.cumsum(r[order]**3) / np.sum(r**3)
    part = lambda low, high: np.sum(r[order][(volume > low) & (volume <= high) & (r[order] > middle)]**3) / np.sum(r[order][(volume > low) & (volume <= high)]**3)
    # The sediment grows at the speed w by what settles on it, in the shares in which it comes; when the large ones have come down, small ones cover it.
    low, high = np.quantile(z, [0.25, 0.65])
    eps = suspension.void_between(low, high, z, r, c.section)
    large_v, small_v = theories[0][1][:2]
    w = (shares[0] * large_v + shares[1] * small_v) / (1 - eps - sum(shares))
    wanted = shares[0] * (large_v + w) / (shares[0] * (large_v + w) + shares[1] * (small_v + w))
    bottom, top = part(0, 0.5), part(0.9, 1)
    verdict.within(f"sediment: {100 * bottom:.1f} % of the volume in its lower half is of large ones, by the fluxes of both onto it {100 * wanted:.1f} % (wanted: 5 % of the whole), {100 * top:.1f} % in its highest tenth (wanted: less than 5 %)",
                   ("lower half less wanted", -0.05, bottom - wanted, 0.05), ("highest tenth", 0, top, 0.05), short=short)
    verdict.note(f"void fraction of the sediment's middle {eps:.3f}")
    return d, kinds, heights, small_at.mean(axis=1), theories


def draw(rows, columns, U_t, n, c, known):
    plt = plot_fields.plt
    d, kinds, heights, small_at, theories = known
    figure, axes = plt.subplots(1, 3, figsize=(11.5, 3.6), layout="constrained")
    eps = np.linspace(0.6, 1, 41)
    axes[0].fill_between(eps, (1 - OF_RICHARDSON_ZAKI) * 1e3 * U_t * eps**n, (1 + OF_RICHARDSON_ZAKI) * 1e3 * U_t * eps**n, color="tab:blue", alpha=0.12, label=f"{100 * OF_RICHARDSON_ZAKI:.0f} % of it")
    axes[0].plot(eps, 1e3 * U_t * eps**n, color="tab:blue", label=f"Richardson & Zaki, n = {n:.2f}")
    if c.law:
        axes[0].plot(eps[:-1], [1e3 * suspension.by_law(c.law, e, D, RHO_P, c.rho_f, c.mu) for e in eps[:-1]], color="tab:red", label="uniform, the run's law")
    axes[0].errorbar(1 - rows[:, 0], 1e3 * rows[:, 1], 2e3 * rows[:, 2], fmt="ko", markersize=4, label="computed")
    axes[0].set_xlabel("void fraction of the suspension"), axes[0].set_ylabel("speed of the front / (mm/s)"), axes[0].legend(fontsize=7), axes[0].set_title("one size")
    for (column, h), share, v, colour in zip(columns, rows[:, 0], rows[:, 4], ("tab:blue", "tab:orange", "tab:green", "tab:purple")):
        shown = h > 0.55 * column.h0
        axes[1].plot(column.t[shown], 1e3 * h[shown], "o", markersize=3, color=colour, label=f"{100 * share:.0f} % of the volume")
        axes[1].plot(column.t[shown], 1e3 * (column.h0 - v * column.t[shown]), color=colour, linewidth=0.9)
    axes[1].set_xlabel("time / s"), axes[1].set_ylabel("front / mm"), axes[1].set_title("one size; lines: Richardson & Zaki"), axes[1].legend(fontsize=7)
    z, r = c.z[-1], c.r[-1]
    edges = np.arange(0, z.max() + D, D)
    for kind, size, colour in zip(kinds, d, ("tab:red", "tab:blue")):
        of = (r > kind[0]) & (r < kind[1])
        axes[2].plot([1 - suspension.void_between(a, b, z[of], r[of], c.section) for a, b in zip(edges, edges[1:])], 1e3 * plot_fields.centres(edges), color=colour, label=f"{1e3 * size:.1f} mm")
    axes[2].set_xlabel("share of the volume"), axes[2].set_ylabel("z / mm"), axes[2].set_title(f"two sizes after {c.t[-1]:.1f} s"), axes[2].legend(fontsize=7)
    return figure


def main():
    folder, short = command_line(__doc__)
    now = np.loadtxt(os.path.join(folder, "now.txt"), ndmin=2)
    bed, verdict = Bed(folder, D, RHO_P, (now[-1, 4] - now[0, 4]) / (now[-1, 0] - now[0, 0])), Verdict()
    verdict.note(f"two sizes: {bed.n:.0f} grains, {bed.length:.2f} s")
    ledgers(bed, verdict, "liquid")
    drag_check.check(bed.file, verdict)
    rows, columns, U_t, n = one_size(folder, verdict, short)
    c = Column(os.path.join(folder, "bed.h5"))
    known = two_sizes(c, verdict, short)
    save_compared(folder, [dict(title="Front of a settling suspension", x_label="void fraction", y_label="speed of the front / (mm/s)", x=1 - rows[:, 0], mean=1e3 * rows[:, 1], error=1e3 * rows[:, 2], references=[
        dict(label=f"Richardson & Zaki, n = {n:.2f}", x=np.linspace(0.65, 0.95, 31), y=1e3 * U_t * np.linspace(0.65, 0.95, 31)**n, line=True)])])
    if not NO_PICTURES:
        save({**usual_pictures(bed, [0.1 * c.h0, 0.3 * c.h0, 0.5 * c.h0]), "sedimentation": draw(rows, columns, U_t, n, c, known)}, folder)
    picture_3d.draw(os.path.join(folder, "bed.h5"), os.path.join(folder, "grains.png"), frame=len(c.t) // 3, cut="none")
    verdict.end()


if __name__ == "__main__":
    main()
