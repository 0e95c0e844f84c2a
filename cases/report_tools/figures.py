"""Figures of a run, each narrow enough for a phone: set-up and grids, mean fields, profiles with their error, comparisons, pressure and its spectrum."""
import itertools
import re
import textwrap

import numpy as np

import plot_fields
from plot_fields import MM, batches, centres, mean_and_error, nodes, open_share, plane, plt, view

WIDE = 4.0  # inches, 400 pixels of the page
SIDES = {"inlet": ("#1b7837", "inlet"), "pressure": ("#d95f02", "outlet (pressure)"), "noslip": ("#000000", "wall, no slip"), "slip": ("#999999", "wall, slip"),
         "periodic": ("#7570b3", "periodic")}


@plot_fields.matplotlib.ticker.FuncFormatter
def plain(value, _):
    """A tick's number as it is: matplotlib's own factor at the axis' end (1e-6) lies over labels and legends."""
    return re.sub(r"e([-+])0?", r"e\1", f"{value:g}").replace("-", "\u2212")


def ticks(axis, length, ends=()):
    """As many as an axis of this length (inches) has room for; the ends alone, if they are given, on a short one."""
    if length < 0.44 and len(ends):
        axis.set_ticks(np.round(ends, 1))
    else:
        axis.set_major_locator(plot_fields.matplotlib.ticker.MaxNLocator(int(np.clip(length / 0.22, 1, 5)), steps=[1, 2, 5, 10]))
    axis.set_major_formatter(plain)


def legend_above(ax, columns):
    """Long names are broken, one below the other."""
    handles, labels = ax.get_legend_handles_labels()
    if max(map(len, labels)) > 50 / columns - 5:
        columns, labels = 1, [textwrap.fill(label, 46) for label in labels]
    ax.legend(handles, labels, loc="lower left", bbox_to_anchor=(0, 1.01), borderaxespad=0, ncols=columns, fontsize=8, handlelength=1.4, columnspacing=1.0)


def fluid(file):
    """What to call it, by its density."""
    return "liquid" if float(file["record"].attrs.get("density", 0)) > 100 else "gas"


def deep(file):
    """Depth (m) of the cut that is drawn: the middle where a mean over the depth would mix what differs; None: the mean."""
    _, along = view(file)
    e = nodes(file)[along]
    thick = len(e) > 2 and (np.ptp(e) > 0.5 * np.ptp(nodes(file)[view(file)[0]]) or open_share(file) is not None)
    return 0.5 * (e[0] + e[-1]) if thick else None


def where(file):
    depth = deep(file)
    return "mean over the depth" if depth is None else f"cut at {'xy'[view(file)[1]]} = {MM * depth:.1f} mm"


# ---- set-up -------------------------------------------------------------------------------------------------------------

def conditions(text):
    """Boundary keyword of the record: {side: kind}, [(side, name, shape with numbers, kind)]."""
    sides, patches = {}, []
    for part in text.split(";"):
        words = part.split()
        if len(words) < 2:
            continue
        kind = next((w for w in words[1:] if w in SIDES), None)
        if words[1] != "patch":
            sides[words[0]] = kind
        elif len(words) > 3:
            patches.append((words[0], words[2], words[3], [float(w) for w in words[4:8] if re.fullmatch(r"[-+0-9.eE]+", w)], kind))
    return sides, patches


def patch_extent(shape, numbers, across):
    """From and to (m), along the direction drawn, of a patch on floor or top."""
    if shape == "rect" and len(numbers) >= 4:
        return numbers[2 * across], numbers[2 * across + 1]
    if shape == "circle" and len(numbers) >= 3:
        return numbers[across] - numbers[2], numbers[across] + numbers[2]
    return None


def discs(ax, file, frame, across, along, keep_in=None):
    """Outlines of the grains, true to size; how many a layer of two diameters at mid-depth holds, if the bed is deep."""
    if frame not in file.get("particles", ()) or not len(file["particles"][frame]["position"]):
        return False
    p = file["particles"][frame]
    x, r = p["position"][:], p["radius"][:]
    keep = np.ones(len(x), bool)
    if np.ptp(nodes(file)[along]) > 16 * r.mean():
        keep &= np.abs(x[:, along] - 0.5 * (nodes(file)[along][0] + nodes(file)[along][-1])) < 2 * r.mean()
    if keep_in:
        keep &= (x[:, across] > keep_in[0] - r) & (x[:, across] < keep_in[1] + r) & (x[:, 2] > keep_in[2] - r) & (x[:, 2] < keep_in[3] + r)
    d = 2 * MM * r[keep]
    ax.add_collection(plot_fields.EllipseCollection(d, d, np.zeros(len(d)), units="xy", offsets=MM * x[keep][:, [across, 2]], transOffset=ax.transData, facecolors="#e8c99b",
                                                    edgecolors="#9a7b4f" if keep_in else "none", linewidths=0.4, rasterized=True))
    return True


def setup(file, frame, boundary):
    """The domain with its sides, patches, bodies, particle cells and grains; a part of it with both grids."""
    across, along = view(file)
    fine, coarse = nodes(file), nodes(file, "particle_grid")
    a, z = MM * fine[across], MM * fine[2]
    tall = np.ptp(z) > 1.1 * np.ptp(a)
    height = min(5.2, 1.5 * np.ptp(z) / np.ptp(a) + 1.0) if tall else 2.2 + 3.2 * np.ptp(z) / np.ptp(a)
    figure, axes = plt.subplots(*((1, 2) if tall else (2, 1)), figsize=(WIDE, max(height, 3.2)), layout="constrained")
    sides, patches = conditions(boundary)
    theta, depth = open_share(file), 0.5 * (fine[along][0] + fine[along][-1])
    patch_middle = next((0.5 * sum(e) for s, n, shape, numbers, k in patches if s == "zlo" for e in [patch_extent(shape, numbers, across)] if e), 0.5 * (fine[across][0] + fine[across][-1]))
    # Some four particle cells a side, from the floor's first open cell on.
    step = np.median(np.diff(coarse[across])), np.median(np.diff(coarse[2]))
    half = min(2.2 * step[0], 0.5 * np.ptp(fine[across]))
    middle = np.clip(patch_middle, fine[across][0] + half, fine[across][-1] - half)
    bottom = fine[2][0]
    if frame in file.get("particles", ()) and len(file["particles"][frame]["position"]):
        bottom = max(bottom, float(np.percentile(file["particles"][frame]["position"][:, 2], 1)) - step[1])
    window = middle - half, middle + half, bottom - 0.12 * step[1], min(bottom + 2 * half, fine[2][-1])
    seen = {}
    for i, ax in enumerate(axes):
        if theta is not None:
            solid = np.ma.masked_where(plane(theta, fine, along, depth).filled(0) > 0.5 if np.ma.isMaskedArray(plane(theta, fine, along, depth)) else plane(theta, fine, along, depth) > 0.5,
                                       np.ones((len(z) - 1, len(a) - 1)))
            ax.pcolormesh(a, z, solid, cmap=plot_fields.matplotlib.colors.ListedColormap([plot_fields.SOLID]), rasterized=True)
        discs(ax, file, frame, across, along, window if i else None)
        if i:
            ax.vlines(a, z[0], z[-1], color="#555555", linewidth=0.4)
            ax.hlines(z, a[0], a[-1], color="#555555", linewidth=0.4)
        ax.vlines(MM * coarse[across], z[0], z[-1], color="#2166ac", linewidth=1.1 if i else 0.35)
        ax.hlines(MM * coarse[2], a[0], a[-1], color="#2166ac", linewidth=1.1 if i else 0.35)
        name = "xy"[across]
        for side, xs, ys in ((name + "lo", (a[0], a[0]), (z[0], z[-1])), (name + "hi", (a[-1], a[-1]), (z[0], z[-1])), ("zlo", (a[0], a[-1]), (z[0], z[0])), ("zhi", (a[0], a[-1]), (z[-1], z[-1]))):
            if sides.get(side):
                colour, label = SIDES[sides[side]]
                seen[label] = ax.plot(xs, ys, color=colour, linewidth=3.5, solid_capstyle="butt", clip_on=False, zorder=4)[0]
        for side, _, shape, numbers, kind in patches:
            extent = patch_extent(shape, numbers, across) if side in ("zlo", "zhi") else None
            if extent and kind:
                level = z[0] if side == "zlo" else z[-1]
                seen[f"patch: {SIDES[kind][1]}"] = ax.plot(MM * np.array(extent), (level, level), color={"inlet": "#d01c8b"}.get(kind, SIDES[kind][0]), linewidth=6, solid_capstyle="butt",
                                                         clip_on=False, zorder=5)[0]
        ax.set_aspect("equal")
        ax.set_xlabel(name + " / mm")
        ax.locator_params(nbins=5)
        if not tall:
            ticks(ax.yaxis, 2.9 * (np.ptp(z) / np.ptp(a) if not i else (window[3] - window[2]) / (window[1] - window[0])), () if i else (z[0], z[-1]))
        if not i and np.ptp(z) > 6 * np.ptp(a):
            ax.set_xticks([a[0], a[-1]])
        if i:
            ax.set_xlim(MM * window[0], MM * window[1]), ax.set_ylim(MM * window[2], MM * window[3])
            for artist in ax.get_lines():
                artist.set_clip_on(True)
    axes[0].set_ylabel("z / mm")
    axes[0].set_title("particle cells"), axes[1].set_title("a part: both grids")
    return figure, [(line.get_color(), label) for label, line in seen.items()]


# ---- means --------------------------------------------------------------------------------------------------------------

def bed_top(file):
    """Height (m) above which 5 % of the solids lie on average; None in a domain without."""
    edges = nodes(file, "particle_grid")
    solids = file["average/particle_grid/solids_fraction"][:]
    theta = open_share(file, "particle_grid")
    layers = np.sum(solids * (1 if theta is None else theta) * np.outer(np.diff(edges[1]), np.diff(edges[0])), axis=(1, 2)) * np.diff(edges[2])
    if layers.sum() <= 0:
        return None
    below = np.concatenate([[0], np.cumsum(layers)]) / layers.sum()
    return float(np.interp(0.95, below, edges[2]))


def beyond(values, options):
    """Which ends of a colour bar stand for more than their value: of those that are drawn."""
    little = 0.005 * (options["vmax"] - options["vmin"])
    return {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[int(np.min(values) < options["vmin"] - little), int(np.max(values) > options["vmax"] + little)]


def maps(file, which, titles):
    """Two or three maps beside each other (above each other where the bed is wide), each with its own colours."""
    across, along = view(file)
    depth = deep(file)
    top = bed_top(file)
    z = nodes(file)[2]
    top = z[-1] if top is None else min(z[-1], z[0] + 1.6 * (top - z[0]))
    tall = (top - z[0]) > 1.1 * np.ptp(nodes(file)[across])
    flat = (top - z[0]) < 0.35 * np.ptp(nodes(file)[across])  # colours below: beside it there would be no room for them
    ratio = (top - z[0]) / np.ptp(nodes(file)[across])
    figure, axes = plt.subplots(*((1, len(which)) if tall else (len(which), 1)), figsize=(WIDE, np.clip(3.4 / len(which) * ratio + 1.3, 2.8, 6.0) if tall else len(which) * (2.9 * ratio + (1.35 if flat else 0.75))),
                                sharey="all" if tall else "none", layout="constrained", squeeze=False)
    for ax, title, (values, grid, label, options) in zip(axes.ravel(), titles, which):
        edges = nodes(file, grid)
        shown = plane(values, edges, along, depth, open_share(file, grid))
        if options.get("vmin") == "even":
            inside = edges[2][:-1] < top
            most = float(np.percentile(np.abs(np.ma.filled(shown[inside], 0)), 99.5)) or 1.0
            options = dict(options, vmin=-most, vmax=most)
        elif "vmin" not in options:
            inside = np.ma.compressed(np.ma.asarray(shown[edges[2][:-1] < top]))
            options = dict(options, vmin=float(np.percentile(inside, 0.5)), vmax=float(np.percentile(inside, 99.5)))
        if options["vmax"] <= options["vmin"]:
            options["vmax"] = options["vmin"] + 1e-12
        picture = plot_fields.map_on(ax, edges, across, shown, **options)
        ax.set_ylim(MM * z[0], MM * top)
        ax.set_title(title)
        ax.locator_params(nbins=5)
        ticks(ax.yaxis, 5 if tall else 2.7 * ratio, (MM * z[0], MM * top))
        if ratio > 6:
            ax.set_xticks([MM * edges[across][0], MM * edges[across][-1]])
        below = tall or flat
        bar = figure.colorbar(picture, ax=ax, location="bottom" if below else "right", label=label.replace("\n", " ") if flat else label, pad=0.02, shrink=0.86, aspect=40 if flat else 20,
                              extend=beyond(shown[edges[2][:-1] < top], options))
        ticks(bar.ax.xaxis if below else bar.ax.yaxis, (0.7 if len(which) > 1 else 2) if tall else 1 if flat else 2.3 * ratio)
        bar.ax.tick_params(labelsize=8)
    for ax in axes[:, 0]:
        ax.set_ylabel("z / mm")
    return figure


def void_fractions(file):
    return maps(file, [(file["average/" + at + "/eps"][:], grid, "void fraction", dict(vmin=0.4, vmax=1.0)) for at, grid in (("fine", "grid"), ("particle_grid", "particle_grid"))], ["fluid's grid", "particle grid"])


def velocities(file):
    signed = dict(cmap="coolwarm", vmin="even")
    shown = [(file["average/fine/u"][..., 2], "grid", f"{fluid(file)}, vertical\nvelocity / (m/s)", signed)]
    if bed_top(file) is not None:
        shown.append((file["average/particle_grid/solids_flux"][..., 2], "particle_grid", "solids, vertical\nflux / (m/s)", signed))
    return maps(file, shown, [fluid(file), "solids"])


def pressure_map(file):
    return maps(file, [(file["average/fine/p"][:], "grid", "pressure / Pa", {}), (np.sqrt(np.maximum(file["average/fine/p_variance"][:], 0)), "grid", "standard\ndeviation / Pa", {})], ["pressure", "its fluctuation"])


def profiles(file):
    """Means across the bed at three heights, with bands of two standard errors: a figure for each quantity."""
    across, along = view(file)
    edges = nodes(file, "particle_grid")
    x = centres(edges[across]) * MM
    weight, batch = batches(file)
    theta = open_share(file, "particle_grid")
    top, bottom = bed_top(file), edges[2][0]
    top = edges[2][-1] if top is None else top
    levels = sorted({int(np.clip(np.searchsorted(edges[2], bottom + f * (top - bottom), side="right") - 1, 0, len(edges[2]) - 2)) for f in (0.25, 0.5, 0.75)})
    wide = lambda v: np.ma.stack([plane(b, edges, along, theta=theta) for b in v])
    drawn = []
    for label, values in (("void fraction", wide(batch("eps"))), (f"{fluid(file)}, vertical velocity / (m/s)", wide(batch("gas_velocity")[..., 2])),
                          ("solids, vertical flux / (m/s)", wide(batch("solids_flux")[..., 2])))[:3 if bed_top(file) is not None else 2]:
        figure, ax = plt.subplots(figsize=(WIDE, 2.9), layout="constrained")
        for k, colour, marker in zip(levels, ("#332288", "#117733", "#cc6677"), "os^"):
            mean, error = mean_and_error(values[:, k], weight)
            ax.plot(x, mean, color=colour, marker=marker, markersize=3.5, linewidth=1.2, label=f"z = {centres(edges[2])[k] * MM:.1f} mm")
            ax.fill_between(x, mean - 2 * error, mean + 2 * error, color=colour, alpha=0.2, linewidth=0)
        ax.set_xlabel("xy"[across] + " / mm"), ax.set_ylabel(label)
        ax.set_xlim(edges[across][0] * MM, edges[across][-1] * MM)
        ax.yaxis.set_major_formatter(plain)
        ax.grid(alpha=0.25)
        ax.margins(y=0.12)
        legend_above(ax, 3)
        drawn.append((label, figure))
    return drawn, float(weight.sum()), len(weight)


# ---- against a reference --------------------------------------------------------------------------------------------------

def comparison(curve):
    """A curve of compared.json with its band of two standard errors, and its references."""
    figure, ax = plt.subplots(figsize=(WIDE, 3.1), layout="constrained")
    x, mean = np.array(curve["x"], float), np.array(curve["mean"], float)
    error = np.array(curve["error"], float) if curve.get("error") is not None else None
    ax.plot(x, mean, color="#332288", marker="o", markersize=3, linewidth=1.4, label="twogrid")
    if error is not None:
        ax.fill_between(x, mean - 2 * error, mean + 2 * error, color="#332288", alpha=0.2, linewidth=0)
    styles = (dict(color="k", marker="o", mfc="none", linestyle=""), dict(color="#cc6677", marker="s", mfc="none", linestyle="--"), dict(color="#117733", marker="^", mfc="none", linestyle="-."))
    for reference, style in zip(curve.get("references", []), itertools.cycle(styles)):
        ax.plot(reference["x"], reference["y"], markersize=4.5, label=reference["label"], **({**style, "linestyle": "-", "marker": ""} if reference.get("line") else style))
        if reference.get("tolerance") is not None:
            y = np.array(reference["y"], float)
            ax.fill_between(reference["x"], y - reference["tolerance"], y + reference["tolerance"], color=style["color"], alpha=0.12, linewidth=0)
    ax.set_xlabel(curve["x_label"]), ax.set_ylabel(curve["y_label"])
    ax.grid(alpha=0.25)
    legend_above(ax, 2)
    return figure


# ---- in time --------------------------------------------------------------------------------------------------------------

def pressure_limits(values):
    """From and to: without the first jump and spikes."""
    low, high = np.percentile(values[len(values) // 50:], [0.5, 99.5])
    return low - 0.15 * (high - low) - 1e-12, high + 0.15 * (high - low) + 1e-12


def pressure_series(time, values, begin, used, in_seconds):
    """used: the rows that the mean is of."""
    figure, ax = plt.subplots(figsize=(WIDE, 2.7), layout="constrained")
    ax.plot(time, values, color="#332288", linewidth=0.8)
    if begin is not None and begin > time[0]:
        ax.axvspan(time[0], begin, color="0.9", linewidth=0)
    if used.any():
        ax.axhline(values[used].mean(), color="#cc6677", linewidth=1, label=f"mean {values[used].mean():.4g} Pa")
        legend_above(ax, 1)
    ax.set_ylim(*pressure_limits(values))
    ax.yaxis.set_major_formatter(plain)
    ax.set_xlim(time[0], time[-1])
    ax.set_xlabel("time / s" if in_seconds else "DEM step"), ax.set_ylabel("pressure drop / Pa")
    ax.grid(alpha=0.25)
    return figure


def spectrum(values, period):
    """Power of an evenly spaced series by segments that overlap by half (Welch 1967): frequencies (Hz), Pa2/Hz."""
    n = len(values)
    length = n if n < 512 else n // 4
    window = np.hanning(length)
    parts = [values[i:i + length] for i in range(0, n - length + 1, max(length // 2, 1))]
    power = np.mean([np.abs(np.fft.rfft((p - p.mean()) * window))**2 for p in parts], axis=0) * 2 * period / np.sum(window**2)
    return np.fft.rfftfreq(length, period)[1:], power[1:], len(parts)


def spectrum_figure(f, power, peak):
    figure, ax = plt.subplots(figsize=(WIDE, 2.7), layout="constrained")
    ax.loglog(f, power, color="#332288", linewidth=0.9)
    ax.xaxis.set_major_formatter(plot_fields.matplotlib.ticker.FuncFormatter(lambda v, _: f"{v:g}"))
    if f[-1] < 30 * f[0]:
        ax.xaxis.set_minor_formatter(plot_fields.matplotlib.ticker.FuncFormatter(lambda v, _: f"{v:g}" if f"{v:e}"[0] in "25" else ""))
    ax.axvline(peak, color="#cc6677", linewidth=1, label=f"strongest: {peak:.3g} Hz")
    ax.set_ylim(max(power.max() * 1e-8, power[power > 0].min() if (power > 0).any() else 1e-30), power.max() * 3)
    ax.set_xlabel("frequency / Hz"), ax.set_ylabel("power / (Pa$^2$/Hz)")
    ax.grid(alpha=0.25)
    legend_above(ax, 1)
    return figure
