#!/usr/bin/python3
"""Draws a column of a study's table.csv against another, one line a group.

    plot_table.py TABLE X Y[,Y...] GROUP[,GROUP...] OUT.png [XLABEL [YLABEL [power ...]]]

Axes are logarithmic; a power draws a grey line of that slope.
"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def number(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return None


def main():
    table, x, ys, groups, out, *rest = sys.argv[1:]
    with open(table) as f:
        rows = list(csv.DictReader(line for line in f if not line.startswith("#")))
    ys, groups = ys.split(","), groups.split(",")
    fig, axes = plt.subplots(1, len(ys), figsize=(5.6 * len(ys), 4.4), squeeze=False)
    for ax, y in zip(axes[0], ys):
        lines, points = {}, []
        for r in rows:
            a, b = number(r.get(x)), number(r.get(y))
            if a and b:
                name = ", ".join(r[g] if g in ("method", "name") else f"{g} {r[g]}" for g in groups if r.get(g))
                lines.setdefault(name, []).append((a, b))
                points.append((a, b))
        for i, (name, p) in enumerate(lines.items()):
            p.sort()
            ax.plot(*zip(*p), "osD^v<>pX*"[i % 10] + "-", ms=4, lw=1, color=f"C{i % 10}", label=name)
        low, high = min(p[0] for p in points), max(p[0] for p in points)
        middle = sorted(p[1] for p in points)[len(points) // 2]
        for power in map(float, rest[2:]):
            ax.plot([low, high], [middle * (q / (low * high)**0.5)**power for q in (low, high)], color="0.7", lw=1, zorder=0)
        ax.set(xscale="log", yscale="log", xlabel=rest[0] if rest else x,
               ylabel=(rest[1] if len(rest) > 1 else "error of") + (f" {y.replace('_', ' ')}" if len(ys) > 1 or len(rest) < 2 else ""))
        ax.grid(True, which="both", lw=0.3, alpha=0.5)
    axes[0][-1].legend(fontsize=7, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    fig.tight_layout()
    fig.savefig(out, dpi=100, bbox_inches="tight")


if __name__ == "__main__":
    main()
