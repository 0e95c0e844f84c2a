#!/usr/bin/python3
"""Verdict on a run of in.liquid_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run with two velocities and few grains,
whose expansion is told without a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import picture_3d  # noqa: E402
import plot_fields  # noqa: E402
import suspension  # noqa: E402
from verdict import NO_PICTURES, Bed, Verdict, batch_error, command_line, ledgers, momentum, save, save_compared, usual_pictures  # noqa: E402

D_P, RHO_P = 3.087e-3, 3586.0    # as in.liquid_bed has it
OF_LAW = 0.02                    # void fraction
OF_RICHARDSON_ZAKI = 0.10        # of the void fraction


class Ladder(Bed):
    """The run, and of each velocity but the first, which only stirs the bed, what the second half of its time has: pressure drop and its error, share
    of the weight on the floor, bed height by the grains' mean height, void fraction by it and its error, void fraction of the middle."""

    def __init__(self, folder, step):
        super().__init__(folder, D_P, RHO_P, step)
        U = self.now[:, 10]
        # The row of the first step has the first velocity; the one that ends a level still has that level's.
        ends = [*np.nonzero(np.abs(np.diff(U)) > 1e-9)[0], len(U) - 1]
        begins = [0, *ends[:-1]]
        self.U, self.levels = U[ends[1:]], []
        period = self.now[1, 0] - self.now[0, 0]
        self.stay = (ends[-1] - begins[-1]) * period
        times = {n: int(self.file["fluid"][n]["step"][()]) for n in self.frames}
        for last in ends[1:]:
            late = (self.now[last, 0] - 0.5 * self.stay, self.now[last, 0])
            rows = (self.mean[:, 0] > late[0]) & (self.mean[:, 0] <= late[1])
            middle = (self.mean[:, 0] > late[0] - 0.25 * self.stay) & (self.mean[:, 0] <= late[0])
            heights = 2 * self.mean[rows, 3]
            height = heights.mean()
            solid = self.solids / (self.section * height)
            shown = [n for n in self.frames if late[0] < times[n] <= late[1]]
            self.levels.append(dict(dp=self.mean[rows, 1].mean() * self.section / self.weight, dp_error=batch_error(self.mean[rows, 1], 4) * self.section / self.weight,
                                    floor=self.mean[rows, 2].mean() / self.weight, height=height, before=2 * self.mean[middle, 3].mean(), eps=1 - solid, error=solid * batch_error(heights, 4) / height,
                                    middle=np.mean([self.slab(n, 0.2 * height, 0.7 * height) for n in shown]), frames=shown))

    def slab(self, frame, low, high):
        grains = self.file["particles"][frame]
        return suspension.void_between(low, high, grains["position"][:, 2], grains["radius"][:], self.section)


def expansion(bed, verdict, short):
    """Void fraction of the bed's middle at each velocity: by the law of a uniform suspension, and by Richardson & Zaki."""
    fluid = (D_P, RHO_P, bed.rho_f, bed.mu)
    name = bed.file["record/settings"].attrs["drag"]
    law = drag_check.LAWS.get(name.decode() if isinstance(name, bytes) else str(name))
    U_t = suspension.terminal_velocity(*fluid)
    Re, archimedes = U_t * D_P * bed.rho_f / bed.mu, D_P**3 * bed.rho_f * (RHO_P - bed.rho_f) * suspension.G / bed.mu**2
    n, other = suspension.richardson_zaki(Re), suspension.khan_richardson(archimedes)
    verdict.note(f"a lone sphere falls at {U_t:.4f} m/s, Re {Re:.0f}; n {n:.2f} by Richardson & Zaki (1954), {other:.2f} by Khan & Richardson (1989)")
    verdict.note("U, m/s   bed height  void fraction, its middle    by the law  Richardson-Zaki  pressure/weight, floor/weight")
    eps = np.array([v["eps"] for v in bed.levels])
    zaki = (bed.U / U_t)**(1 / n)
    by_law = np.array([suspension.void_by_law(law, U, *fluid) if law else np.nan for U in bed.U])
    for i, v in enumerate(bed.levels):
        verdict.note(f"{bed.U[i]:6.3f}   {1e3 * v['height']:6.1f} mm   {eps[i]:.4f} +- {v['error']:.4f}  {v['middle']:.3f}    {by_law[i]:.4f}      {zaki[i]:.4f}           {v['dp']:.4f} +- {v['dp_error']:.4f}  {v['floor']:.4f}")
    # Water leaves faster here than there, and takes more momentum with it than it brought: by up to 15 % where bed and water are stirred most.
    beyond = []
    for U, v in zip(bed.U, bed.levels):
        off, momentum_in = v["dp"] + v["floor"] - 1, bed.rho_f * U**2 * bed.section / bed.weight
        beyond += [off - 0.15 * momentum_in - 4 * v["dp_error"], -off - 4 * v["dp_error"]]
    worst = np.max(beyond)  # not a number where one isn't
    verdict.between(-np.inf, worst, 0.005, f"water and floor carry the buoyant weight at every velocity, and 15 % of the inflow's momentum at most: beyond four standard errors off by {100 * max(worst, 0):.2f} % (wanted 0.5 %)", short)
    if law:
        off = np.abs(eps - by_law).max()
        verdict.at_most(OF_LAW, off, f"void fraction by the bed's height, against that of a uniform suspension by the same law: {off:.4f} off at most (wanted {OF_LAW:g})", short)
    off = np.abs(eps / zaki - 1).max()
    verdict.at_most(OF_RICHARDSON_ZAKI, off, f"and against Richardson & Zaki: {100 * off:.1f} % off at most (wanted {100 * OF_RICHARDSON_ZAKI:.0f} %)", short)
    if len(eps) > 1:
        verdict.between(0, -np.diff(eps).max(), np.inf, "each velocity expands the bed less than the one before", short)
    if len(eps) > 2:
        fit = lambda e: np.polyfit(np.log(e), np.log(bed.U), 1)
        slope, at_one = fit(eps)
        verdict.note(f"line through ln U over ln eps: n {slope:.2f}, U at eps = 1 {np.exp(at_one) / U_t:.3f} U_t" + (f"; through the law's own points n {fit(by_law)[0]:.2f}, {np.exp(fit(by_law)[1]) / U_t:.3f} U_t" if law else ""))
    drift = max(abs(v["height"] / v["before"] - 1) for v in bed.levels)
    verdict.note(f"bed height in the second half of each level against the quarter before: {100 * drift:.1f} % at most")
    curve = np.linspace(0.42, 0.9, 49)
    references = [dict(label=f"Richardson & Zaki, n = {n:.2f}", x=U_t * curve**n, y=curve, line=True), dict(label=f"Khan & Richardson, n = {other:.2f}", x=U_t * curve**other, y=curve, line=True)]
    if law:
        references.append(dict(label="uniform suspension, the run's law", x=[suspension.by_law(law, e, *fluid) for e in curve], y=curve, line=True))
    save_compared(bed.folder, [dict(title="Expansion of the bed", x_label="superficial velocity / (m/s)", y_label="void fraction", x=bed.U, mean=eps, error=[v["error"] for v in bed.levels], references=references)])
    return curve, U_t, n, other, law, fluid


def draw(bed, known):
    plt = plot_fields.plt
    curve, U_t, n, other, law, fluid = known
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    zaki = U_t * curve**n
    axes[0].fill_betweenx(curve, U_t * (curve / (1 + OF_RICHARDSON_ZAKI))**n, U_t * (curve / (1 - OF_RICHARDSON_ZAKI))**n, color="tab:blue", alpha=0.12, label=f"Richardson & Zaki, {100 * OF_RICHARDSON_ZAKI:.0f} % of void fraction")
    axes[0].plot(zaki, curve, color="tab:blue", label=f"Richardson & Zaki, n = {n:.2f}")
    axes[0].plot(U_t * curve**other, curve, color="tab:blue", linestyle=":", label=f"Khan & Richardson, n = {other:.2f}")
    for name, style in (("wenyu", "-"), ("difelice", "-."), ("beetstra", "--"), ("ergun/wenyu", ":")):
        mine = drag_check.LAWS[name] is law
        axes[0].plot([suspension.by_law(drag_check.LAWS[name], e, *fluid) for e in curve], curve, style, color="tab:red" if mine else "0.6", linewidth=1.6 if mine else 1, label="uniform by " + name + (", the run's law" if mine else ""))
    axes[0].errorbar(bed.U, [v["eps"] for v in bed.levels], [2 * np.nan_to_num(v["error"]) for v in bed.levels], fmt="ko", markersize=4, label="computed")
    axes[0].set_xlabel("superficial velocity / (m/s)"), axes[0].set_ylabel("void fraction"), axes[0].set_xlim(0, 0.42), axes[0].legend(fontsize=7, loc="lower right")
    colours = plt.cm.viridis(np.linspace(0, 0.9, len(bed.levels)))
    for U, v, c in zip(bed.U, bed.levels, colours):
        edges = np.arange(0, 1.25 * v["height"], 3 * D_P)
        profile = np.mean([[bed.slab(f, a, b) for a, b in zip(edges, edges[1:])] for f in v["frames"]], axis=0)
        axes[1].plot(profile, 1e3 * plot_fields.centres(edges), color=c, label=f"{U:.2f} m/s")
    axes[1].set_xlabel("void fraction"), axes[1].set_ylabel("z / mm"), axes[1].legend(fontsize=7)
    return figure


def main():
    folder, short = command_line(__doc__)
    now = np.loadtxt(os.path.join(folder, "now.txt"), ndmin=2)
    bed, verdict = Ladder(folder, (now[-1, 4] - now[0, 4]) / (now[-1, 0] - now[0, 0])), Verdict()
    verdict.note(f"{bed.n:.0f} grains, {len(bed.U)} velocities from {bed.U[0]:g} to {bed.U[-1]:g} m/s after one that stirs, each for {bed.stay * bed.step:.2f} s")
    ledgers(bed, verdict, "water")
    drag_check.check(bed.file, verdict)
    momentum(bed, verdict, {"floor on grains": bed.mean[:, 2]}, 5e-3 if short else 1e-3)
    known = expansion(bed, verdict, short)
    if not NO_PICTURES:
        save({**usual_pictures(bed, [f * bed.levels[-1]["height"] for f in (0.2, 0.5, 0.8)]), "liquid_bed": draw(bed, known)}, bed.folder)
    picture_3d.draw(os.path.join(bed.folder, "bed.h5"), os.path.join(bed.folder, "grains.png"), frame=len(bed.frames) // 2, cut="none")
    verdict.end()


if __name__ == "__main__":
    main()
