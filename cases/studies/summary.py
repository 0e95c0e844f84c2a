#!/usr/bin/python3
"""What all studies together say, from their table.csv: results.md and error_cost.png beside this file."""
import os
import sys

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


def cell(rows, error, level):
    """The cheapest run that reaches a level, or the best there is."""
    good = tables.usable(rows, error)
    enough = [r for r in good if r[error] + tables.noise_of(r, error) <= level]
    if enough:
        r = min(enough, key=lambda r: (r["cpu_s"], r[error]))
        return f"{r['name']} ({r['cpu_s']:.2g} s)"
    if not good:
        return "-"
    r = min(good, key=lambda r: r[error])
    return f"none; {r['name']}: {100 * r[error]:.2g} %"


def main():
    found = list(studies())
    lines = ["# Results", "", "Written by `summary.py` from the studies' tables. The cheapest run whose error and standard error together",
             "are below 1, 3 and 10 %, with its CPU time (without start-up); or the best one.", "",
             "| study | error of | 1 % | 3 % | 10 % |", "|---|---|---|---|---|"]
    for name, study, rows in found:
        for error in errors_of(study, rows):
            cells = " | ".join(cell(rows, error, level) for level in tables.LEVELS)
            lines.append(f"| [{name}]({name}/README.md) | {error.replace('_', ' ')} | {cells} |")
    with open(os.path.join(HERE, "results.md"), "w") as f:
        f.write("\n".join(lines) + "\n")
    order = list(load_toml(os.path.join(HERE, "methods.toml")))
    columns = min(3, len(found))
    rows_of_panels = -(-len(found) // columns)
    fig, axes = plt.subplots(rows_of_panels, columns, figsize=(4.6 * columns, 3.7 * rows_of_panels), squeeze=False)
    for ax in axes.flat[len(found):]:
        ax.axis("off")
    legend = {}
    for ax, (name, study, rows) in zip(axes.flat, found):
        keys = keys_of(study, rows)
        methods = keys[:1] == ["method"]
        picture.panel(ax, rows, errors_of(study, rows)[0], keys, order if methods else ())
        ax.set_title(name.replace("_", " "))
        if methods:
            legend.update(zip(*reversed(ax.get_legend_handles_labels())))
        else:
            ax.legend(fontsize=6, frameon=False)
    fig.tight_layout()
    known = [m for m in order if m in legend]
    fig.legend([legend[m] for m in known], known, loc="upper center", bbox_to_anchor=(0.5, 0.0), ncol=4, fontsize=9, frameon=False)
    fig.savefig(os.path.join(HERE, "error_cost.png"), dpi=90, bbox_inches="tight")
    print(f"written: results.md, error_cost.png in {HERE} ({len(found)} studies)")


if __name__ == "__main__":
    main()
