#!/usr/bin/python3
"""Verdict on a run of in.two_sizes, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (SCENE.h5, SCENE_now.txt, SCENE_mean.txt)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of some tenths of a second; who is where is told without
a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import picture_3d  # noqa: E402
import plot_fields  # noqa: E402
from verdict import G, NO_PICTURES, Bed, Verdict, command_line, correlated_mean, ledgers, momentum, save, save_compared, usual_pictures  # noqa: E402

SMALL, RHO_SMALL = 1.5e-3, 2526.0  # as in.two_sizes has it
SCENES = ("mixing", "light_B", "light_A", "bed")


class Mixture(Bed):
    """A scene; its large ones are told by their radius."""

    def __init__(self, folder, scene, rho_large):
        now = np.loadtxt(os.path.join(folder, scene + "_now.txt"), ndmin=2)
        super().__init__(folder, SMALL, RHO_SMALL, (now[-1, 4] - now[0, 4]) / (now[-1, 0] - now[0, 0]), scene)
        r = self.grains("radius")
        self.large = r > 0.51 * SMALL
        volume = 4 / 3 * np.pi * r**3
        self.solids = volume.sum()
        self.weight = G * np.sum(volume * (np.where(self.large, rho_large, RHO_SMALL) - self.rho_f))
        self.part = volume[~self.large].sum() / self.solids  # of the volume that the small ones take
        self.t, self.zL, self.zS = self.now[:, 0] * self.step, self.now[:, 10], self.now[:, 11]
        # 0 where the mean heights of both are the same, 1 where all small ones lie above all large ones (Goldschmidt et al. 2003).
        full = (2 - self.part) / (1 - self.part)
        self.index = (self.zS / self.zL - 1) / (full - 1)


def lacey(bed):
    """Time and Lacey's index of each frame (P. M. C. Lacey, J. Appl. Chem. 4 (1954) 257-268), by volumes in pieces of 9 x 12 x 9 mm with 20 grains at least:
    1 where the share of large ones scatters as in a random mixture, 0 where each piece has one kind."""
    edges = [np.linspace(e[0], e[-1], 1 + max(1, round(np.ptp(e) / size))) for e, size in ((bed.x, 9e-3), (bed.y, 12e-3), (bed.z, 9e-3))]
    times, values = [], []
    for name in bed.frames:
        at, r = bed.file["particles"][name]["position"][:], bed.file["particles"][name]["radius"][:]
        large, v = r > 0.51 * SMALL, 4 / 3 * np.pi * r**3
        full = np.histogramdd(at, edges)[0] >= 20
        whole, big = np.histogramdd(at, edges, weights=v)[0][full], np.histogramdd(at[large], edges, weights=v[large])[0][full]
        p = v[large].sum() / v.sum()
        # A random piece: each grain in it or not by itself.
        random = p * (1 - p) * (p * v[~large].mean() + (1 - p) * v[large].mean()) * full.sum() / whole.sum()
        found = np.sum(whole * (big / whole - p)**2) / whole.sum()
        times.append(bed.file["fluid"][name]["time"][()]), values.append((p * (1 - p) - found) / (p * (1 - p) - random))
    return np.array(times), np.array(values)


def fluidisation(d, rho_f, mu):
    """Wen & Yu (1966), m/s."""
    archimedes = d**3 * rho_f * (RHO_SMALL - rho_f) * G / mu**2
    return (np.sqrt(33.7**2 + 0.0408 * archimedes) - 33.7) * mu / (rho_f * d)


def glass(beds, verdict, short):
    """The slow bed segregates, the fast one stays mixed."""
    slow, fast = beds["bed"], beds["mixing"]
    d = [2 * slow.grains("radius")[of].mean() for of in (slow.large, ~slow.large)]
    at = [fluidisation(x, slow.rho_f, slow.mu) for x in d]
    U = [b.inflow / b.section for b in (slow, fast)]
    verdict.note(f"minimum fluidisation by Wen & Yu (1966): {at[1]:.2f} m/s of the small ones, {at[0]:.2f} of the large; gas {U[0]:.2f} and {U[1]:.2f} m/s")
    late = slow.t > 0.8 * slow.length
    end = slow.index[late].mean()
    half = slow.index[(slow.t > 0.4 * slow.length) & (slow.t < 0.5 * slow.length)].mean()
    verdict.within(f"{U[0]:.2f} m/s segregates: index {slow.index[1]:.3f} at the beginning, {half:.3f} in the middle, {end:.3f} in the last fifth of {slow.length:.1f} s (wanted: 0.3, and no way back)",
                   ("end", 0.3, end, np.inf), ("end less middle", -0.05, end - half, np.inf), short=short)
    r, z = slow.grains("radius"), slow.grains("position")[:, 2]
    order = np.argsort(z)
    volume = np.cumsum(r[order]**3) / np.sum(r**3)
    share = lambda low, high: np.sum((r**3 * slow.large)[order][(volume > low) & (volume <= high)]) / np.sum((r**3)[order][(volume > low) & (volume <= high)])
    verdict.note(f"in the lowest fifth of the solids {100 * share(0, 0.2):.0f} % of the volume is of large ones, in the highest {100 * share(0.8, 1):.0f} %; of all {100 * (1 - slow.part):.0f} %")
    mixing = [(name, *lacey(b)) for name, b in (("slow", slow), ("fast", fast))]
    means = [values[times > (0.8 if name == "slow" else 0.5) * times[-1]].mean() for name, times, values in mixing]
    verdict.between(0.85, means[1], np.inf, f"{U[1]:.2f} m/s keeps it mixed: Lacey's index {mixing[1][2][0]:.3f} at the beginning, {means[1]:.3f} in the second half of {fast.length:.1f} s (wanted: 0.85)", short)
    verdict.between(0.2, means[1] - means[0], np.inf, f"and {U[0]:.2f} m/s doesn't: {mixing[0][2][0]:.3f} and {means[0]:.3f} in the last fifth (wanted: 0.2 less)", short)
    verdict.note(f"heights' index of the fast bed in its second half {fast.index[fast.t > 0.5 * fast.length].mean():.3f}: it throws small ones higher")
    return mixing


def light(beds, verdict, short):
    """They are lighter than the bed that they displace: they float, in both forms."""
    for scene in ("light_B", "light_A"):
        b = beds[scene]
        solid = 1 - b.file["average/particle_grid/eps"][1, ...].mean()
        rho = b.rho_large
        late = b.t > 0.7 * b.length
        ratio, error, _ = correlated_mean(b.zL[late] / b.zS[late])
        up = b.t[np.nonzero(b.zL > b.zS)[0]]
        verdict.between(1.3, ratio, np.inf, f"formulation {scene[-1]}: {b.large.sum()} spheres of {rho:.0f} kg/m3, from the floor of a bed of {solid * RHO_SMALL:.0f} kg/m3, " +
                        (f"pass its middle after {up[0]:.2f} s" if len(up) else "do not pass its middle") + f" and are then at {ratio:.2f} +- {error:.2f} of its mean height (wanted: more than 1.3; 2 is the surface)", short)


def draw(beds, mixing):
    plt = plot_fields.plt
    figure, axes = plt.subplots(1, 3, figsize=(11.5, 3.6), layout="constrained")
    for (name, times, values), scene, colour in zip(mixing, ("bed", "mixing"), ("tab:red", "tab:blue")):
        b = beds[scene]
        axes[0].plot(b.t, b.index, color=colour, linewidth=0.9, label=f"{b.inflow / b.section:.2f} m/s, by heights")
        axes[0].plot(times, 1 - values, color=colour, linestyle=":", label=f"{b.inflow / b.section:.2f} m/s, 1 - Lacey's")
    axes[0].axhline(1, color="0.6", linewidth=0.8), axes[0].axhline(0, color="0.6", linewidth=0.8)
    axes[0].set_xlabel("time / s"), axes[0].set_ylabel("index of segregation"), axes[0].set_title("glass of 1.5 and 2.5 mm"), axes[0].legend(fontsize=7)
    b = beds["bed"]
    r, z = b.grains("radius"), b.grains("position")[:, 2]
    edges = np.arange(0, z.max() + 3e-3, 3e-3)
    for of, label, colour in ((b.large, "2.5 mm", "tab:red"), (~b.large, "1.5 mm", "tab:blue")):
        volume, _ = np.histogram(z[of], edges, weights=4 / 3 * np.pi * r[of]**3)
        axes[1].plot(volume / (b.section * 3e-3), 1e3 * plot_fields.centres(edges), color=colour, label=label)
    axes[1].set_xlabel("share of the volume"), axes[1].set_ylabel("z / mm"), axes[1].set_title(f"{b.inflow / b.section:.2f} m/s after {b.length:.1f} s"), axes[1].legend()
    for scene, colour in (("light_B", "tab:blue"), ("light_A", "tab:orange")):
        b = beds[scene]
        axes[2].plot(b.t, 1e3 * b.zL, color=colour, label=f"large and light, {scene[-1]}")
        axes[2].plot(b.t, 1e3 * b.zS, color=colour, linestyle=":", label=f"small, {scene[-1]}")
    axes[2].set_xlabel("time / s"), axes[2].set_ylabel("mean height / mm"), axes[2].set_title("light spheres of 4.5 mm in glass of 1.5 mm"), axes[2].legend(fontsize=7)
    return figure


def main():
    folder, short = command_line(__doc__)
    verdict, beds = Verdict(), {}
    for scene in SCENES:
        rho = 300.0 if scene.startswith("light") else RHO_SMALL
        beds[scene] = Mixture(folder, scene, rho)
        beds[scene].rho_large = rho
    for scene in ("bed", "light_B"):
        b = beds[scene]
        verdict.note(f"{scene}: {b.large.sum()} large and {(~b.large).sum()} small, {b.inflow / b.section:.2f} m/s, {b.length:.2f} s, means from {b.begin:.2f} s")
        ledgers(b, verdict)
        momentum(b, verdict, {"floor on grains": b.mean[:, 2], "lid on grains": b.mean[:, 3]}, 5e-3 if short else 1e-3)
    drag_check.check(beds["bed"].file, verdict)
    mixing = glass(beds, verdict, short)
    light(beds, verdict, short)
    slow = beds["bed"]
    save_compared(folder, [dict(title="Segregation of the slow bed", x_label="time / s", y_label="index", x=slow.t, mean=slow.index, error=None, references=[])])
    if not NO_PICTURES:
        save({**usual_pictures(slow, [10e-3, 20e-3, 30e-3], top=80e-3), "two_sizes": draw(beds, mixing)}, folder)
    picture_3d.draw(os.path.join(folder, "bed.h5"), os.path.join(folder, "grains.png"), cut="none")
    verdict.end()


if __name__ == "__main__":
    main()
