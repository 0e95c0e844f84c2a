"""Error against CPU time, drawn."""
from .tables import front_of, noise_of, usable

SHAPES = "osD^v<>pX*"


def panel(ax, rows, error, keys, order=()):
    """Error against CPU with the Pareto front: colour by the first choice (or its place in `order`), shape by the second."""
    colour, marker = (list(keys) + [None, None])[:2]
    group_of = lambda r: r.get(colour) or r["name"]
    groups = list(dict.fromkeys([*order, *map(group_of, rows)]))
    shapes = list(dict.fromkeys(r.get(marker, "") for r in rows))
    good = usable(rows, error)
    percent = lambda r: max(100 * r[error], 1e-4)
    drawn = set()
    for r in good:
        i, s = groups.index(group_of(r)), shapes.index(r.get(marker, ""))
        label = group_of(r) if colour in (None, "method") or not r.get(colour) else f"{colour} {r[colour]}"
        ax.errorbar(r["cpu_s"], percent(r), yerr=100 * noise_of(r, error), fmt=SHAPES[s % 10], ms=5, color=f"C{i % 10}", lw=0.8,
                    mfc="none" if i >= 10 else None, label=None if label in drawn else label)
        drawn.add(label)
    front = front_of(rows, error)
    ax.step([r["cpu_s"] for r in front], [percent(r) for r in front], where="post", color="0.6", lw=1, zorder=0)
    if good:
        ax.set_xscale("log")
        ax.set_yscale("log")
        low, high = min(map(percent, good)), max(map(percent, good))
        ax.set_ylim(low / 1.5, high * 1.5)
    else:
        ax.set_title("no run has this error")
    ax.set_xlabel("CPU (s)")
    ax.set_ylabel(f"error of {error.replace('_', ' ')} (%)")
    ax.grid(True, which="both", lw=0.3, alpha=0.5)
    return [(SHAPES[i % 10], f"{marker} {s}") for i, s in enumerate(shapes) if s != ""] if marker and len(shapes) > 1 else []


def draw(path, title, rows, errors, keys):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(1, len(errors), figsize=(5.6 * len(errors), 4.6), squeeze=False)
    for ax, error in zip(axes[0], errors):
        shapes = panel(ax, rows, error, keys)
    handles, labels = axes[0][0].get_legend_handles_labels()
    handles += [plt.Line2D([], [], color="k", ls="", marker=m, ms=4) for m, _ in shapes]
    labels += [label for _, label in shapes]
    fig.suptitle(title, fontsize=10)
    fig.tight_layout()
    fig.legend(handles, labels, loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8, frameon=False)
    fig.savefig(path, dpi=100, bbox_inches="tight")
    plt.close(fig)
