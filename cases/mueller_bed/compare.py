#!/usr/bin/python3
"""Profiles of a run of in.mueller_bed against the measured ones, with a verdict, a table and a picture.

    compare.py FOLDER [--reference FOLDER] [--prefix u0.9_] [--from T] [--to T] [--no-verdict]

FOLDER: what the run wrote (bed.h5, mean.txt). --reference: a folder of measured profiles named PREFIXvoid_fraction_zZmm.csv and
PREFIXparticle_vz_zZmm.csv (x in mm, value); with none for the run's velocity, the run's own profiles are printed.
--from, --to: part of the run's time to use (s). Prints the root mean square difference of every profile, with the
standard error of the run's means from 8 batches, and the drag against its law; draws FOLDER/profiles.png, writes FOLDER/profiles.csv; ends with 0 if
every wanted figure was met.

Both are folded about their middle: the measured ones at 21.2 mm, the run at 22 mm. Each measured point is compared, by
linear interpolation, at its own distance from the middle. The run's values are means over the depth, a slab of 3 mm of
height, and columns 44/24 mm wide: void fraction from the volume of spheres in there, velocity as the volume's mean.
"""
import argparse
import glob
import os
import re
import sys

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import leg_tables  # noqa: E402
from verdict import Verdict, save_compared  # noqa: E402

WIDTH, DEPTH, D_P = 44.0e-3, 10.0e-3, 1.2e-3     # as in.mueller_bed has them
MEASURED_MIDDLE = 21.2e-3                        # of the measured profiles
SLAB, COLUMNS, BATCHES = 3.0e-3, 24, 8
# Wanted: the best of two other codes on each profile (void fraction; m/s), at 0.9 m/s.
WANTED = {("void_fraction", 16.4): 0.021, ("void_fraction", 31.2): 0.091,
          ("particle_vz", 15.0): 0.021, ("particle_vz", 25.0): 0.024, ("particle_vz", 35.0): 0.063}
HEIGHTS = {"void_fraction": [16.4, 31.2], "particle_vz": [15.0, 25.0, 35.0]}


def points_in_sphere(n=200):
    """Points spread evenly through the unit ball (shells of equal volume, golden angle); [n][3]."""
    k = np.arange(n) + 0.5
    golden = np.pi * (1 + 5**0.5)
    z = 1 - 2 * k / n
    angle = golden * k
    shell = ((np.arange(n) * 0.5545497) % 1.0) ** (1 / 3)  # multiples of a generic irrational: radii independent of z
    s = np.sqrt(1 - z**2)
    return shell[:, None] * np.stack([s * np.cos(angle), s * np.sin(angle), z], axis=1)


class Slab:
    """Sums over frames in one slab of height, by batch and column: volume of solids and volume times v_z."""

    def __init__(self, height, batches):
        self.lo, self.hi = height - SLAB / 2, height + SLAB / 2
        self.volume = np.zeros((batches, COLUMNS))
        self.moment = np.zeros((batches, COLUMNS))
        self.frames = np.zeros(batches)
        self.points = points_in_sphere() * D_P / 2

    def add(self, batch, x, vz):
        near = (x[:, 2] > self.lo - D_P / 2) & (x[:, 2] < self.hi + D_P / 2)
        z = x[near, 2][:, None] + self.points[None, :, 2]
        column = np.floor((x[near, 0][:, None] + self.points[None, :, 0]) * (COLUMNS / WIDTH)).astype(int)
        inside = (z > self.lo) & (z < self.hi)
        each = np.pi / 6 * D_P**3 / len(self.points)
        v = np.broadcast_to(vz[near][:, None], z.shape)[inside]
        column = np.clip(column[inside], 0, COLUMNS - 1)
        self.volume[batch] += each * np.bincount(column, minlength=COLUMNS)
        self.moment[batch] += each * np.bincount(column, weights=v, minlength=COLUMNS)
        self.frames[batch] += 1

    def profile(self, quantity, batches):
        """Folded about the middle: values at the centres of COLUMNS/2 columns, from the middle outwards."""
        fold = lambda a: 0.5 * (a + a[::-1])[COLUMNS // 2:]
        volume = fold(self.volume[batches].sum(axis=0))
        if quantity == "particle_vz":
            return fold(self.moment[batches].sum(axis=0)) / np.maximum(volume, 1e-30)
        return 1 - volume / (self.frames[batches].sum() * SLAB * DEPTH * WIDTH / COLUMNS)


def measured_profiles(folder, prefix):
    found = {}
    for path in sorted(glob.glob(os.path.join(folder, prefix + "*_z*mm.csv"))):
        match = re.fullmatch(re.escape(prefix) + r"(\w+)_z([\d.]+)mm\.csv", os.path.basename(path))
        if not match:
            continue
        rows = [line.split(",") for line in open(path) if line[0] in "-0123456789"]
        found[match.group(1), float(match.group(2))] = np.array(rows, dtype=float)
    return found


def read_frames(folder, wanted, begin, end):
    bed = h5py.File(os.path.join(folder, "bed.h5"), "r")
    names = sorted(bed["particles"])
    times = np.array([float(bed["fluid"][n]["time"][()]) for n in names])
    if begin is None:
        begin = float(bed["average"].attrs["from"]) if "average" in bed else 0.0
    use = [(n, t) for n, t in zip(names, times) if begin <= t <= (end or np.inf)]
    if len(use) < BATCHES:
        sys.exit(f"compare.py: {len(use)} frames from {begin:g} s on, at least {BATCHES} are wanted: let the run go on "
                 "(-var tend) or start earlier (--from)")
    slabs = {key: Slab(1e-3 * key[1], BATCHES) for key in wanted}
    for i, (name, _) in enumerate(use):
        frame = bed["particles"][name]
        x, v = frame["position"][:], frame["velocity"][:]
        for slab in slabs.values():
            slab.add(i * BATCHES // len(use), x, v[:, 2])
    return slabs, use[0][1], use[-1][1], len(use)


def rms_difference(centres, profile, distance, values):
    return np.sqrt(np.mean((np.interp(distance, centres, profile) - values)**2))


def draw(path, rows, title):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(1, len(rows), figsize=(3.4 * len(rows), 3.4), constrained_layout=True, squeeze=False)
    for axis, row in zip(axes[0], rows):
        axis.errorbar(1e3 * row["centres"], row["profile"], yerr=row["error"], fmt="-", color="C0", capsize=2, label="twogrid")
        if row["measured"] is not None:
            axis.plot(1e3 * row["distance"], row["measured"], "o", color="k", ms=4, mfc="none", label="measured")
        axis.set_xlabel("distance from the middle, mm")
        axis.set_title(("void fraction" if row["key"][0] == "void_fraction" else "particle $v_z$, m/s") +
                       f" at {row['key'][1]:g} mm", fontsize=10)
        axis.grid(alpha=0.3)
    axes[0][0].legend(fontsize=8)
    figure.suptitle(title, fontsize=9)
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    here = os.path.dirname(os.path.abspath(__file__))
    parser.add_argument("folder")
    parser.add_argument("--reference", default=os.path.join(here, "reference"))
    parser.add_argument("--prefix", default=None)
    parser.add_argument("--from", dest="begin", type=float)
    parser.add_argument("--to", dest="end", type=float)
    parser.add_argument("--no-verdict", action="store_true", help="of the profiles print the figures only")
    a = parser.parse_args()

    with h5py.File(os.path.join(a.folder, "bed.h5"), "r") as bed:
        last = sorted(bed["fluid"])[-1]
        match = re.search(r"-var U ([\d.]+)", str(bed["record"].attrs["command_line"])) if "record" in bed else None
        U = float(match.group(1)) if match else 0.9
        del last
    prefix = a.prefix or f"u{U:g}_"
    measured = measured_profiles(a.reference, prefix)
    wanted = sorted(measured) or [(q, z) for q in sorted(HEIGHTS) for z in HEIGHTS[q]]
    slabs, begin, end, frames = read_frames(a.folder, wanted, a.begin, a.end)
    centres = (np.arange(COLUMNS // 2) + 0.5) * WIDTH / COLUMNS
    mean = leg_tables.table(os.path.join(a.folder, "mean.txt"))
    mean = mean[(mean[:, 1] >= begin) & (mean[:, 1] <= end)]
    groups = [g.mean() for g in np.array_split(mean[:, 2], BATCHES)]
    print(f"superficial velocity {U:g} m/s; {frames} frames from {begin:.2f} to {end:.2f} s, slab {1e3 * SLAB:g} mm, {COLUMNS} "
          f"columns; pressure drop {mean[:, 2].mean():.1f} +- {np.std(groups, ddof=1) / BATCHES**0.5:.1f} Pa, top of the grains "
          f"{1e3 * mean[:, 3].mean():.1f} mm on average")
    rows, failed, lines = [], 0, ["quantity,height_mm,distance_mm,twogrid,standard_error"]
    for key in wanted:
        slab, everything = slabs[key], np.arange(BATCHES)
        profile = slab.profile(key[0], everything)
        each = np.array([slab.profile(key[0], [b]) for b in everything])
        error = each.std(axis=0, ddof=1) / np.sqrt(BATCHES)
        row = dict(key=key, centres=centres, profile=profile, error=error, measured=None)
        text = f"{key[0]} at {key[1]:g} mm"
        if key in measured:
            distance = np.abs(1e-3 * measured[key][:, 0] - MEASURED_MIDDLE)
            values = measured[key][:, 1]
            row.update(distance=distance, measured=values)
            rms = rms_difference(centres, profile, distance, values)
            # how much the rms itself would change with another batch left out
            without = [rms_difference(centres, slab.profile(key[0], np.delete(everything, b)), distance, values) for b in everything]
            jackknife = np.sqrt((BATCHES - 1) / BATCHES * np.sum((np.array(without) - np.mean(without))**2))
            # points left and right of the middle differ from each other: what no symmetric profile can do better than
            order = np.argsort(distance)
            smooth = np.poly1d(np.polyfit(distance[order], values[order], 5))
            floor = np.sqrt(np.mean((smooth(distance) - values)**2))
            bias = np.mean(np.interp(distance, centres, profile) - values)
            limit = WANTED.get(key) if abs(U - 0.9) < 1e-9 else None
            good = limit is None or rms < limit
            failed += not good
            word = "    " if limit is None or a.no_verdict else "PASS" if good else "FAIL"
            print(f"{word}  {text}: rms difference {rms:.4f} +- {jackknife:.4f}" +
                  (f" (wanted below {limit:g})" if limit else "") +
                  f"; mean difference {bias:+.4f}, standard error of the means {np.sqrt(np.mean(error**2)):.4f}, scatter of the "
                  f"measured points about a smooth even curve {floor:.4f}")
        else:
            print(f"      {text}: no measured profile; standard error of the means {np.sqrt(np.mean(error**2)):.4f}")
        rows.append(row)
        lines += [f"{key[0]},{key[1]:g},{1e3 * c:.3f},{p:.5f},{e:.5f}" for c, p, e in zip(centres, profile, error)]
    with h5py.File(os.path.join(a.folder, "bed.h5"), "r") as bed:
        verdict = Verdict()
        drag_check.check(bed, verdict)
    with open(os.path.join(a.folder, "profiles.csv"), "w") as f:
        f.write("\n".join(lines) + "\n")
    words = {"void_fraction": "void fraction", "particle_vz": "vertical velocity of grains / (m/s)"}
    save_compared(a.folder, [dict(title=f"{words[r['key'][0]].split(' / ')[0].capitalize()} {r['key'][1]:g} mm above the floor, folded about the middle", x_label="distance from the middle / mm",
                                  y_label=words[r["key"][0]], x=1e3 * r["centres"], mean=r["profile"], error=r["error"], references=[] if r["measured"] is None else
                                  [dict(label="measured (Mueller et al. 2009)", x=1e3 * r["distance"], y=r["measured"])]) for r in rows])
    draw(os.path.join(a.folder, "profiles.png"), rows, f"{U:g} m/s, means from {begin:.1f} to {end:.1f} s; bars: one standard error")
    print("picture: " + os.path.join(a.folder, "profiles.png"))
    sys.exit(1 if verdict.failed or (failed and not a.no_verdict) else 0)


if __name__ == "__main__":
    main()
