"""Error against CPU time, drawn so that it can be read without the text: what is compared, which is better, what is noise."""
import textwrap

from .errors import LEAST_CPU
from .tables import front_of, noise_of, usable

SHAPES = "osD^v<>pX*"
COLOURS = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#000000", "#ee8866", "#999933", "#882255"]
HOW = "Lower is more accurate, further left is cheaper; the grey line joins what no other run beats in both, noise left out."
NOISE = "Pale with an arrow: the error is below its statistical error (two standard errors), drawn there; it may be anything below."


def plain_ticks(axis, low, high):
    """Labels 1, 2, 5, 10, ... of a logarithmic axis, few enough not to touch."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter
    import math
    decades = math.log10(high / low)
    steps = (1, 2, 5) if decades < 1.8 else (1, 3) if decades < 3 else (1,)
    every = 1 if decades < 6 else 2
    ticks = [m * 10.0**e for e in range(math.floor(math.log10(low)) - 1, math.ceil(math.log10(high)) + 1) if every == 1 or e % every == 0 for m in steps]
    ticks = [t for t in ticks if low <= t <= high]
    if len(ticks) < 2:  # a narrow range
        ticks = [float(f"{low * (high / low)**f:.2g}") for f in (0.1, 0.5, 0.9)]
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_minor_locator(FixedLocator([]))
    axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}" if 1e-3 <= v < 1e4 else f"{v:.0e}".replace("e+0", "e").replace("e-0", "e-")))
    axis.set_minor_formatter(NullFormatter())


def panel(ax, rows, error, keys, order=()):
    """Error against CPU with the Pareto front: colour by the first choice (or its place in `order`), shape by the second. Returns the handles and labels of
    colours and of shapes."""
    from matplotlib.lines import Line2D
    colour, marker = (list(keys) + [None, None])[:2]
    group_of = lambda r: r.get(colour) or r["name"]
    groups = list(dict.fromkeys([*order, *map(group_of, rows)]))
    shapes = list(dict.fromkeys(r.get(marker, "") for r in rows))
    good = usable(rows, error)
    bottom = 1e-4
    shown = {}  # what is drawn of a run: percent, whether it is only a bound
    for r in good:
        value, noise = 100 * r[error], 200 * noise_of(r, error)
        shown[r["name"]] = (max(noise, bottom), True) if noise > value else (max(value, bottom), False)
    colours = {}
    for r in good:
        i, s = groups.index(group_of(r)), shapes.index(r.get(marker, ""))
        y, bound = shown[r["name"]]
        c, hollow = COLOURS[i % 10], i >= 10
        if bound:
            ax.annotate("", (r["cpu_s"], y / 1.35), (r["cpu_s"], y), arrowprops=dict(arrowstyle="->", color=c, alpha=0.55, lw=0.9), zorder=2)
        elif noise_of(r, error):
            noise = 200 * noise_of(r, error)
            ax.plot(2 * [r["cpu_s"]], [max(y - noise, y / 3), y + noise], color=c, lw=0.8, alpha=0.6, zorder=2)
        ax.plot(r["cpu_s"], y, SHAPES[s % 10], ms=5.5, color=c, mfc="none" if hollow else c, alpha=0.4 if bound else 0.95, zorder=3)
        value = r.get(colour)
        value = int(value) if isinstance(value, float) and value == int(value) else value
        label = group_of(r) if colour in (None, "method") or not r.get(colour) else f"{colour} {value}"
        colours.setdefault(label, Line2D([], [], color=c, ls="", marker="o", ms=5.5, mfc="none" if hollow else c))
    front = front_of([r for r in good if not shown[r["name"]][1]], error)
    ax.step([r["cpu_s"] for r in front], [shown[r["name"]][0] for r in front], where="post", color="0.65", lw=1.2, zorder=1)
    if good:
        ax.set_xscale("log"), ax.set_yscale("log")
        y, x = [v for v, _ in shown.values()], [r["cpu_s"] for r in good]
        low, high = min(y) / 1.8, max(y) * 1.8
        left, right = min(x) / 1.25, max(x) * 1.25
        ax.set_ylim(low, high), ax.set_xlim(left, right)
        plain_ticks(ax.yaxis, low, high), plain_ticks(ax.xaxis, left, right)
        if min(x) <= LEAST_CPU * 1.001:
            ax.axvspan(left, LEAST_CPU * 1.08, color="0.94", lw=0, zorder=0)
    else:
        ax.text(0.5, 0.5, "no run has this error", ha="center", transform=ax.transAxes)
    ax.set_xlabel("CPU time / s" + (f" (grey: {LEAST_CPU:g} or less)" if good and min(r["cpu_s"] for r in good) <= LEAST_CPU * 1.001 else ""))
    ax.set_ylabel(f"error of {error.replace('_', ' ')} / %")
    ax.grid(True, lw=0.4, alpha=0.5)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    kinds = [(Line2D([], [], color="0.3", ls="", marker=SHAPES[i % 10], ms=5), f"{marker} {int(s) if s == int(s) else s}" if isinstance(s, float) else f"{marker} {s}") for i, s in enumerate(shapes) if s != ""]
    return colours, dict((label, h) for h, label in kinds) if marker and len(shapes) > 1 else {}


def below(ax, handles, columns=3, size=7.5):
    """A legend under the axes."""
    if handles:
        ax.legend(handles.values(), handles.keys(), loc="upper center", bbox_to_anchor=(0.5, -0.17), ncol=columns, fontsize=size, frameon=False, handletextpad=0.2, columnspacing=0.9)


def draw(path, title, rows, errors, keys):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(1, len(errors), figsize=(5.4 * len(errors), 4.6), squeeze=False)
    colours, shapes = {}, {}
    for ax, error in zip(axes[0], errors):
        c, s = panel(ax, rows, error, keys)
        colours.update(c), shapes.update(s)
    fig.suptitle("\n".join(textwrap.wrap(title, 62 * len(errors))), fontsize=10)
    fig.tight_layout(rect=(0, 0.03 + 0.03 * (2 if len(errors) == 1 else 1), 1, 1))
    fig.text(0.01, 0.01, "\n".join(textwrap.wrap(HOW + " " + NOISE, 95 * len(errors))), fontsize=7.5, color="0.3", va="bottom")
    fig.legend([*colours.values(), *shapes.values()], [*colours, *shapes], loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8, frameon=False)
    fig.savefig(path, dpi=100, bbox_inches="tight")
    plt.close(fig)
