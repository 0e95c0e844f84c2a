#!/usr/bin/python3
"""What all studies together say, from their table.csv: results.md and error_cost.png beside this file; with --each the studies' own error_cost.png, too."""
import os
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
from sweep_tools import picture, tables
from sweep_tools.studies import load_toml


def studies():
    """(name, study.toml, rows) of every study that has a table."""
    for name in sorted(os.listdir(HERE)):
        folder = os.path.join(HERE, name)
        if all(os.path.exists(os.path.join(folder, f)) for f in ("study.toml", "table.csv")):
            yield name, load_toml(os.path.join(folder, "study.toml")), tables.read_table(os.path.join(folder, "table.csv"))


def errors_of(study, rows):
    given = study.get("error")
    if given:
        return [given] if isinstance(given, str) else given
    names = [k for k, v in rows[0].items() if isinstance(v, float) and k not in ("cpu_s", "wall_s")]
    return [k for k in names if k + "_err" in names]


def keys_of(study, rows):
    keys = (["method"] if "methods" in study else []) + list(study.get("product", {}))
    for v in study.get("variant", []):
        keys += [k for k in v if k != "name" and k not in keys]
    return [k for k in keys if k in rows[0]]


def cheapest(good, error, level):
    """The cheapest run whose error and standard error together reach a level; - if none does."""
    enough = [r for r in good if r[error] + tables.noise_of(r, error) <= level]
    r = min(enough, key=lambda r: (r["cpu_s"], r[error]), default=None)
    return f"{r['name']} ({r['cpu_s']:.2g} s)" if r else "-"


def most_accurate(good, error):
    """The run with the smallest error and standard error together, and what they are."""
    r = min(good, key=lambda r: r[error] + tables.noise_of(r, error), default=None)
    if r is None:
        return "-"
    noise = tables.noise_of(r, error)
    return f"{r['name']}: {100 * r[error]:.2g} %" + (f" +- {100 * noise:.2g}" + (", noise" if r[error] < 2 * noise else "") if noise else "") + f" ({r['cpu_s']:.2g} s)"


def table(found):
    lines = ["# Results", "", "Written by `summary.py` from the studies' tables. For each study and each of its errors: the cheapest run whose error and standard error together",
             "are within 10, 3 and 1 %, with its CPU time (without start-up; 0.05 s stands for less, too), - where no run is; and the most accurate run with its error +- its standard error",
             "(*noise*: the error is below two of them, so that it may be anything below).", "",
             "| study: what was run | error of | within 10 % | within 3 % | within 1 % | most accurate |", "|---|---|---|---|---|---|"]
    for name, study, rows in found:
        for n, error in enumerate(errors_of(study, rows)):
            good = tables.usable(rows, error)
            cells = " | ".join(cheapest(good, error, level) for level in sorted(tables.LEVELS, reverse=True))
            what = f"[{name}]({name}/README.md): {study['title']}" if n == 0 else f"[{name}]({name}/README.md)"
            lines.append(f"| {what} | {error.replace('_', ' ')} | {cells} | {most_accurate(good, error)} |")
    return "\n".join(lines) + "\n"


def main():
    found = list(studies())
    with open(os.path.join(HERE, "results.md"), "w") as f:
        f.write(table(found))
    order = list(load_toml(os.path.join(HERE, "methods.toml")))
    columns = min(3, len(found))
    rows_of_panels = -(-len(found) // columns)
    fig, axes = plt.subplots(rows_of_panels, columns, figsize=(4.7 * columns, 4.6 * rows_of_panels), squeeze=False)
    for ax in axes.flat[len(found):]:
        ax.axis("off")
    legend = {}
    for ax, (name, study, rows) in zip(axes.flat, found):
        keys = keys_of(study, rows)
        methods = keys[:1] == ["method"]
        colours, shapes = picture.panel(ax, rows, errors_of(study, rows)[0], keys, order if methods else ())
        title = "\n".join(textwrap.wrap(study["title"].split(" (")[0], 58)[:2])
        ax.set_title(name.replace("_", " "), fontsize=11, fontweight="bold", loc="left", pad=25)
        ax.text(0, 1.02, title, transform=ax.transAxes, fontsize=7.5, color="0.3", va="bottom")
        if methods:
            legend.update(colours)
        picture.below(ax, shapes if methods else {**colours, **shapes})
    fig.suptitle("Error against CPU time of all studies", fontsize=15, y=0.998)
    fig.text(0.5, 0.986, picture.HOW + "\n" + picture.NOISE + " Colours of methods: at the bottom; shapes, and colours of other choices: under each panel.", ha="center", va="top", fontsize=9.5)
    fig.tight_layout(rect=(0, 0.03, 1, 0.965), h_pad=1.4)
    known = [m for m in order if m in legend]
    fig.legend([legend[m] for m in known], known, loc="lower center", bbox_to_anchor=(0.5, 0.0), ncol=6, fontsize=10, frameon=False)
    fig.savefig(os.path.join(HERE, "error_cost.png"), dpi=90)
    if "--each" in sys.argv:
        for name, study, rows in found:
            picture.draw(os.path.join(HERE, name, "error_cost.png"), study["title"], rows, errors_of(study, rows), keys_of(study, rows))
    print(f"written: results.md, error_cost.png in {HERE} ({len(found)} studies)")


if __name__ == "__main__":
    main()
