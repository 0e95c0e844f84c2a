#!/usr/bin/python3
"""Draws what a twogrid run left in its HDF5 file: mean void fraction, snapshots with particles, profiles with their errors.

    plot_fields.py bed.h5 --out pictures --heights 10 20 40 --frames 5 10 -1

Heights and all axes are in mm, z points up. A bed is looked at along its thinner horizontal direction. The functions may
be used one by one; each takes the open file (h5py) and returns the figure.
"""
import argparse
import os

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection

MM = 1000.0
SOLID = "#8a7f76"
plt.rcParams.update({"font.size": 9, "axes.titlesize": 9, "axes.spines.top": False, "axes.spines.right": False,
                     "legend.frameon": False, "figure.dpi": 100, "savefig.dpi": 200, "image.cmap": "viridis"})


# ---- reading -------------------------------------------------------------------------------------------------------

def nodes(file, grid="grid"):
    """Node coordinates x, y, z in m of `grid` or `particle_grid`."""
    return [file[grid][c][:] for c in "xyz"]


def centres(edges):
    return 0.5 * (edges[1:] + edges[:-1])


def open_share(file, grid="grid"):
    """[nz][ny][nx]: the part of each cell that bodies leave open; None where there are no bodies."""
    return file[grid]["theta"][:] if "theta" in file[grid] else None


def view(file):
    """(across, along): index of the horizontal direction drawn, and of the one looked along (the thinner)."""
    x, y, _ = nodes(file)
    return (0, 1) if np.ptp(x) >= np.ptp(y) else (1, 0)


def plane(values, edges, along, depth=None, theta=None):
    """[nz][ny][nx] -> [nz][across]: mean over the direction looked along, or the cells that hold `depth` (m). With theta, the
    open share of cells: over their open parts, and masked where all is solid."""
    axis = 2 - along
    width = np.diff(edges[along])
    if depth is None and theta is None:
        return np.average(values, axis=axis, weights=width)
    if depth is None:
        shape = [1, 1, 1]
        shape[axis] = len(width)
        weights = theta * width.reshape(shape)
        whole = weights.sum(axis=axis)
        return np.ma.masked_where(whole == 0, (values * weights).sum(axis=axis) / np.where(whole > 0, whole, 1))
    i = int(np.clip(np.searchsorted(edges[along], depth, side="right") - 1, 0, values.shape[axis] - 1))
    at = np.take(values, i, axis=axis)
    return at if theta is None else np.ma.masked_where(np.take(theta, i, axis=axis) == 0, at)


def frames(file):
    """Names of the frames, in order."""
    return sorted(file["fluid"])


def batches(file):
    """Full batches: (weights, function that gives the batch means of a quantity, one a row). The one being filled when
    the run ended is left out if it stands for less than half the time of the others."""
    group = file["average/particle_grid/batch"]
    weight = group["weight"][:]
    keep = weight >= 0.5 * weight.max()
    return weight[keep], lambda name: group[name][:][keep]


def mean_and_error(values, weight):
    """Mean over batches (first axis) and its standard error, from the scatter of the batches' means."""
    average = np.ma.average if np.ma.isMaskedArray(values) else np.average
    mean = average(values, axis=0, weights=weight)
    if len(weight) < 2:
        return mean, np.full_like(mean, np.nan)
    variance = average((values - mean) ** 2, axis=0, weights=weight)
    return mean, np.sqrt(variance / (len(weight) - 1))


# ---- drawing -------------------------------------------------------------------------------------------------------

def map_on(axes, edges, across, values, **options):
    """Cell values as they are, in mm, true to scale; solids of bodies (masked) in one colour."""
    axes.set_facecolor(SOLID)
    picture = axes.pcolormesh(edges[across] * MM, edges[2] * MM, values, rasterized=True, **options)
    axes.set_aspect("equal")
    axes.set_xlabel("xy"[across] + " / mm")
    return picture


def map_size(edges, across, panels, height=5.0):
    width = height * np.ptp(edges[across]) / np.ptp(edges[2])
    return panels * (width + 0.45) + 1.2, height + 0.8


def mean_void_fraction(file, depth=None, top=None):
    """Time-mean void fraction on both grids, averaged over the depth or at `depth` (m); `top` (m): highest z shown."""
    across, along = view(file)
    edges, coarse = nodes(file), nodes(file, "particle_grid")
    figure, axes = plt.subplots(1, 2, figsize=map_size(edges, across, 2), sharey=True, layout="constrained")
    for ax, title, at, e in ((axes[0], "fluid's grid", "fine", edges),
                             (axes[1], "particle grid", "particle_grid", coarse)):
        theta = open_share(file, "grid" if at == "fine" else "particle_grid")
        values = plane(file["average/" + at + "/eps"][:], e, along, depth, theta)
        picture = map_on(ax, e, across, values, vmin=0.4, vmax=1.0)
        ax.set_title(title)
    axes[0].set_ylabel("z / mm")
    if top:
        axes[0].set_ylim(edges[2][0] * MM, top * MM)
    figure.colorbar(picture, ax=axes, label="mean void fraction", shrink=0.8)
    return figure


def snapshots(file, which, top=None):
    """Particles, true to size and coloured by their vertical velocity, over the gas's vertical velocity at mid-depth."""
    across, along = view(file)
    edges = nodes(file)
    names = frames(file)
    names = [names[i] for i in which if -len(names) <= i < len(names)]
    depth = 0.5 * (edges[along][0] + edges[along][-1])
    theta = open_share(file)
    gas = [plane(file["fluid"][n]["u"][..., 2], edges, along, depth, theta) for n in names]
    solids = [file["particles"][n] if "particles" in file and n in file["particles"] else None for n in names]
    speeds = [np.abs(s["velocity"][:, 2]) for s in solids if s is not None and len(s["velocity"])]
    fastest_gas = max(max(np.abs(g).max() for g in gas), 1e-12)
    fastest = max((np.percentile(s, 99) for s in speeds), default=1.0) or 1.0
    figure, axes = plt.subplots(1, len(names), figsize=map_size(edges, across, len(names)), sharey=True, squeeze=False,
                                layout="constrained")
    balls = None
    for ax, name, g, s in zip(axes[0], names, gas, solids):
        picture = map_on(ax, edges, across, g, vmin=0, vmax=fastest_gas, cmap="Greys")
        ax.set_title(f"t = {file['fluid'][name]['time'][()]:.3f} s")
        if s is None or not len(s["position"]):
            continue
        x, d = s["position"][:] * MM, 2 * s["radius"][:] * MM
        front = np.argsort(-x[:, along])  # those nearer to the eye are drawn last
        balls = EllipseCollection(d[front], d[front], np.zeros(len(d)), units="xy", offsets=x[front][:, [across, 2]],
                                  transOffset=ax.transData, array=s["velocity"][:, 2][front], cmap="coolwarm",
                                  clim=(-fastest, fastest), linewidths=0, rasterized=True)
        ax.add_collection(balls)
    axes[0][0].set_ylabel("z / mm")
    if top:
        axes[0][0].set_ylim(edges[2][0] * MM, top * MM)
    figure.colorbar(picture, ax=axes, label="gas, vertical velocity / (m/s)", shrink=0.6, pad=0.01)
    if balls is not None:
        figure.colorbar(balls, ax=axes, label="particles, vertical velocity / (m/s)", shrink=0.6, pad=0.02)
    return figure


def profiles(file, heights):
    """Means across the bed at the given heights (m), with a band of two standard errors from the batches."""
    across, along = view(file)
    edges = nodes(file, "particle_grid")
    x = centres(edges[across]) * MM
    weight, batch = batches(file)
    theta = open_share(file, "particle_grid")
    wide = lambda v: np.ma.stack([plane(b, edges, along, theta=theta) for b in v])
    quantities = (("void fraction", wide(batch("eps"))),
                  ("gas, vertical velocity / (m/s)", wide(batch("gas_velocity")[..., 2])),
                  ("solids, vertical flux / (m/s)", wide(batch("solids_flux")[..., 2])))
    figure, axes = plt.subplots(1, 3, figsize=(10.5, 3.4), layout="constrained")
    colours = plt.cm.viridis(np.linspace(0, 0.85, len(heights)))
    for ax, (label, values) in zip(axes, quantities):
        for height, colour in zip(heights, colours):
            k = int(np.clip(np.searchsorted(edges[2], height, side="right") - 1, 0, len(edges[2]) - 2))
            mean, error = mean_and_error(values[:, k], weight)
            ax.plot(x, mean, color=colour, marker="o", markersize=3, linewidth=1.2,
                    label=f"z = {centres(edges[2])[k] * MM:.1f} mm")
            ax.fill_between(x, mean - 2 * error, mean + 2 * error, color=colour, alpha=0.2, linewidth=0)
        ax.set_xlabel("xy"[across] + " / mm")
        ax.set_ylabel(label)
        ax.set_xlim(edges[across][0] * MM, edges[across][-1] * MM)
    axes[0].legend()
    figure.suptitle(f"means over {weight.sum():.3g} s in {len(weight)} batches; bands: two standard errors", fontsize=9)
    return figure


def pressure_profile(file):
    """Mean pressure over height, over the whole section, with its band of two standard errors."""
    edges = nodes(file, "particle_grid")
    weight, batch = batches(file)
    area = np.outer(np.diff(edges[1]), np.diff(edges[0]))
    theta = open_share(file, "particle_grid")
    if theta is None:
        section = np.einsum("bkji,ji->bk", batch("p"), area) / area.sum()
    else:
        section = np.einsum("bkji,kji,ji->bk", batch("p"), theta, area) / np.maximum(np.einsum("kji,ji->k", theta, area), 1e-300)
    mean, error = mean_and_error(section, weight)
    z = centres(edges[2]) * MM
    figure, ax = plt.subplots(figsize=(3.6, 3.4), layout="constrained")
    ax.plot(mean, z, color="C0", linewidth=1.4)
    ax.fill_betweenx(z, mean - 2 * error, mean + 2 * error, color="C0", alpha=0.25, linewidth=0)
    ax.set_xlabel("mean pressure / Pa")
    ax.set_ylabel("z / mm")
    return figure


def body_forces(file):
    """Force of the gas on each body over time, one panel a body."""
    names = file["grid/bodies"].attrs["names"].decode().split()
    at = frames(file)
    time = [file["fluid"][n]["time"][()] for n in at]
    force = np.stack([file["fluid"][n]["bodies/force"][:] for n in at])
    figure, axes = plt.subplots(1, len(names), figsize=(1.2 + 3.4 * len(names), 3.0), squeeze=False, layout="constrained")
    for b, (ax, name) in enumerate(zip(axes[0], names)):
        for d in range(3):
            ax.plot(time, force[:, b, d], color=f"C{d}", linewidth=1.2, label="xyz"[d])
        ax.set_title(name)
        ax.set_xlabel("t / s")
    axes[0][0].set_ylabel("force of the gas / N")
    axes[0][0].legend()
    return figure


def wall_profiles(file, steps=30):
    """Over height: vertical friction and pressure on the bodies' surfaces, means by area; time means, or of the last frame."""
    walls = file["grid/walls"]
    values = file["average/walls"] if "average/walls" in file else file["walls"][sorted(file["walls"])[-1]]
    names = file["grid/bodies"].attrs["names"].decode().split()
    z, area, body = walls["centre"][:, 2], walls["area"][:], walls["body"][:]
    edges = np.linspace(z.min(), z.max() + 1e-9, min(steps, max(2, len(np.unique(z)))) + 1)
    figure, axes = plt.subplots(1, 2, figsize=(7.0, 3.4), sharey=True, layout="constrained")
    for b, name in enumerate(names):
        for ax, v in zip(axes, (values["friction"][:, 2], values["pressure"][:])):
            of = body == b
            whole = np.histogram(z[of], edges, weights=area[of])[0]
            some = whole > 0
            mean = np.histogram(z[of], edges, weights=(area * v)[of])[0][some] / whole[some]
            ax.plot(mean, centres(edges)[some] * MM, marker=".", linewidth=1.2, label=name)
    for ax in axes:
        ax.locator_params(axis="x", nbins=5)
    axes[0].set_xlabel("friction on the wall, upwards / Pa")
    axes[1].set_xlabel("pressure on the wall / Pa")
    axes[0].set_ylabel("z / mm")
    axes[0].legend()
    return figure


def surface(file, most=20000):
    """The bodies' surfaces in three dimensions: size of the friction, and pressure; time means, or of the last frame."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection
    walls = file["grid/walls"]
    values = file["average/walls"] if "average/walls" in file else file["walls"][sorted(file["walls"])[-1]]
    points, polygons = walls["points"][:] * MM, walls["polygons"][:]
    outlines, at = [], 0
    while at < len(polygons):
        outlines.append(points[polygons[at + 2:at + 2 + polygons[at + 1]]])
        at += 2 + polygons[at + 1]
    step = 1 + len(outlines) // most
    figure = plt.figure(figsize=(8.4, 4.0), layout="constrained")
    for place, (label, v) in enumerate((("friction / Pa", np.linalg.norm(values["friction"][:], axis=1)), ("pressure / Pa", values["pressure"][:]))):
        ax = figure.add_subplot(1, 2, place + 1, projection="3d")
        low, high = np.percentile(v, (1, 99))
        shown = Poly3DCollection(outlines[::step], array=v[::step], cmap="viridis", clim=(low, max(high, low + 1e-12 * (1 + abs(low)))))
        ax.add_collection3d(shown)
        lo, hi = points.min(axis=0), points.max(axis=0)
        ax.set(xlim=(lo[0], hi[0]), ylim=(lo[1], hi[1]), zlim=(lo[2], hi[2]), xlabel="x / mm", ylabel="y / mm", zlabel="z / mm")
        ax.set_box_aspect(np.maximum(hi - lo, 1e-3 * (hi - lo).max()))
        figure.colorbar(shown, ax=ax, label=label, shrink=0.7, pad=0.12)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file", help="HDF5 file of a run")
    parser.add_argument("--out", default=".", help="directory for the pictures")
    parser.add_argument("--heights", type=float, nargs="+", default=None, help="of the profiles, mm")
    parser.add_argument("--frames", type=int, nargs="+", default=None, help="frames to draw (negative: from the end)")
    parser.add_argument("--depth", type=float, default=None, help="mm; the mean over the depth if not given")
    parser.add_argument("--top", type=float, default=None, help="highest z shown in maps, mm")
    o = parser.parse_args()
    os.makedirs(o.out, exist_ok=True)
    top = o.top / MM if o.top else None

    def save(figure, name):
        path = os.path.join(o.out, name + ".png")
        figure.savefig(path)
        plt.close(figure)
        print(path)

    with h5py.File(o.file, "r") as file:
        if "average" in file:
            bottom, height = nodes(file)[2][0], np.ptp(nodes(file)[2])
            heights = [h / MM for h in o.heights] if o.heights else [bottom + f * height for f in (0.1, 0.2, 0.35)]
            save(mean_void_fraction(file, o.depth / MM if o.depth is not None else None, top), "mean_void_fraction")
            save(profiles(file, heights), "profiles")
            save(pressure_profile(file), "pressure")
        else:
            print("no means in this file: fix_modify ID output average from T makes them")
        if "fluid" in file and len(file["fluid"]):
            last = len(file["fluid"]) - 1
            which = o.frames if o.frames is not None else sorted({last // 3, 2 * last // 3, last})
            save(snapshots(file, which, top), "snapshots")
            if "grid/bodies" in file and last > 0:
                save(body_forces(file), "body_forces")
            if "grid/walls" in file:
                save(wall_profiles(file), "walls")
                save(surface(file), "surface")
        else:
            print("no frames in this file: fix_modify ID output every N makes them")


if __name__ == "__main__":
    main()
