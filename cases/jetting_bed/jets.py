#!/usr/bin/python3
"""The paper's jets: one, two and three of them at two velocities, each on two grids and on either of them alone.

    jets.py [--short|--long] [--ranks N] [--out FOLDER] [--save] [--compare] [--only WORD]

Runs by ../run what FOLDER (out/jets) hasn't got yet, compares what is there, and leaves there jets.csv (lengths, merging, pressure drop, differences),
profiles.csv (void fraction and solids' velocity at four heights), jets.png (what a single grid loses) and jets_all.png (all beds on two grids).
--save copies these into this folder, whose tables keep the rows of runs that FOLDER hasn't got; --compare runs nothing, --only runs just those with WORD in their name. --short: thin beds for 0.08 s, one jet;
--long: 6 s each. README.md says what each number means.
"""
import argparse
import csv
import itertools
import os
import platform
import shutil
import subprocess
import sys

import h5py
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, ".."))
import leg_tables  # noqa: E402
import plot_fields  # noqa: E402
from compare import D_P, DEM_STEP, RHO_P, height_of_void  # noqa: E402
from verdict import G, batch_error, jackknife  # noqa: E402

KINDS = {"two": ("two grids", "-var grids two"), "coarse": ("single grid of the particle cells", "-var grids coarse"),
         "fine": ("single grid of the fluid's cells", "-var grids fine"),
         "two_jets": ("two grids, grains feel the fluid's cells", "-var grids two -var method jets"),
         "coarse_velocity": ("particle cells, the jet's velocity kept", "-var grids coarse -var keep velocity"),
         "fine_exact": ("fluid's cells, exact deposition", "-var grids fine -var method exact")}
COLOURS = {"two": "#1b6ca8", "coarse": "#d1603d", "fine": "#5f9e4b", "two_jets": "#7fb2e5", "coarse_velocity": "#e8a87c", "fine_exact": "#a3c585"}
HIGHER = {(3, 9.0, "fine"): "96e-3"}  # m, domains in place of 72 mm: where the start throws grains over the top, and the run ends
APART = 12e-3          # m, between the axes of neighbouring jets, as in.jetting_bed has it
CELL = (2.4e-3, 3e-3)  # m, particle cells: everything is compared on these
LAYERS = (1, 3, 5, 7)  # of particle cells, for profiles: 4.5, 10.5, 16.5 and 22.5 mm


def beds(short):
    """(jets, velocity, kind) of all runs."""
    if short:
        return [(1, 6.0, kind) for kind in KINDS]
    main = [(n, U, kind) for n in (1, 2, 3) for U in (6.0, 9.0) for kind in ("two", "coarse", "fine")]
    return main + [(1, U, kind) for U in (6.0, 9.0) for kind in ("two_jets", "coarse_velocity", "fine_exact")]


def folder_of(out, n, U, kind):
    return os.path.join(out, f"jets{n}_U{U:g}_{kind}")


# ---- one run -----------------------------------------------------------------------------------------------------------

class Jets:
    """Means of a run on cells of 2.4 x 3 mm, whatever its grids are."""

    def __init__(self, folder, n, U, kind):
        self.n, self.U, self.kind, self.folder = n, U, kind, folder
        with h5py.File(os.path.join(folder, "bed.h5"), "r") as file:
            self.weight, batch = plot_fields.batches(file)
            edges = plot_fields.nodes(file, "particle_grid")
            self.edges, self.x, self.z = edges, np.arange(0, edges[0][-1] + 1e-9, CELL[0]), np.arange(0, edges[2][-1] + 1e-9, CELL[1])
            nx, nz = len(self.x) - 1, len(self.z) - 1
            low = int(round(72e-3 / CELL[1]))  # compared up to here
            # Cells are equal, and nested in those of the comparison: means over them are plain means.
            onto = lambda v: v.mean(axis=2).reshape(len(v), nz, -1, nx, v.shape[3] // nx).mean(axis=(2, 4))[:, :low]
            self.eps, self.solids = onto(batch("eps")), onto(batch("solids_fraction"))
            self.flux, self.gas = onto(batch("solids_flux")[..., 2]), onto(batch("gas_flux")[..., 2])
            mean = file["average"]
            self.map_eps = mean["particle_grid/eps"][:].mean(axis=1)
            self.map_gas = mean["fine/flux"][..., 2].mean(axis=1)
            self.fine = plot_fields.nodes(file)
            self.z = self.z[:low + 1]
            self.begin, self.span, self.end = float(mean.attrs["from"]), float(mean.attrs["weight"]), float(mean.attrs["to"])
            self.correlation = float(mean.attrs.get("correlation_time", np.nan))
            record = file["record"].attrs
            self.commit, self.date, self.rho_f = record["commit"].decode(), record["date"].decode()[:10], float(record["density"])
        self.axes = [nx / 2 * CELL[0] + (i - (n - 1) / 2) * APART for i in range(n)]
        self.columns = [int(a / CELL[0]) for a in self.axes]
        now, means = (leg_tables.table(os.path.join(folder, t)) for t in ("now.txt", "mean.txt"))
        inside = means[:, 0] * DEM_STEP > self.begin
        self.drop = means[inside, 1]
        area = nx * CELL[0] * 4.95e-3
        self.load = now[0, 2] * np.pi / 6 * D_P**3 * (RHO_P - self.rho_f) * G / area
        self.moved = now[:, 8].max() / (now[0, 2] * np.pi / 6 * D_P**3)
        self.smallest = now[1:, 9].min()

    def mean(self, field, weight=None):
        return np.average(field, axis=0, weights=self.weight if weight is None else weight)

    def ridges(self, weight):
        """Of each jet, by height: the largest mean void fraction within half of the jets' distance from its axis, for jets bend. Its own half of the way to a neighbour."""
        eps, reach = self.mean(self.eps, weight), int(0.5 * APART / CELL[0])
        return [eps[:, max(c - reach, 0):c + reach + 1].max(axis=1) for c in self.columns]

    def lengths(self, weight):
        height = plot_fields.centres(self.z)
        each = [height_of_void(r, height) for r in self.ridges(weight)]
        return np.array(each + [np.mean(each)])

    def merging(self, weight):
        """Mean over neighbouring jets of the height at which the bridge of grains between them has half of its depth in the lowest layer: the void fraction in the
        middle between the axes, below the smaller of the two jets' ridges. The middle of the lowest layer, at most, where there is no bridge at all."""
        eps, height, ridges = self.mean(self.eps, weight), plot_fields.centres(self.z), self.ridges(weight)
        found = []
        for i, (a, b) in enumerate(zip(self.columns, self.columns[1:])):
            middle = eps[:, [(a + b) // 2, (a + b + 1) // 2]].mean(axis=1)
            bridge = np.minimum(ridges[i], ridges[i + 1]) - middle
            if bridge[0] <= 0:
                found.append(height[0])
                continue
            low = bridge < 0.5 * bridge[0]
            k = int(np.argmax(low))
            found.append(np.interp(-0.5 * bridge[0], -bridge[k - 1:k + 1], height[k - 1:k + 1]) if low.any() else np.inf)
        return np.mean(found)

    def mean_height(self, weight):
        solids = self.mean(self.solids, weight).sum(axis=1)
        return (solids * plot_fields.centres(self.z)).sum() / solids.sum()

    def velocity(self, weight):
        """Vertical, of the solids: flux over fraction; not where there are next to none."""
        solids = self.mean(self.solids, weight)
        return np.where(solids > 0.01, self.mean(self.flux, weight) / np.maximum(solids, 0.01), np.nan)

    def scalars(self):
        (*each, L), (*_, L_error) = jackknife(self.lengths, self.weight)
        H, H_error = jackknife(self.mean_height, self.weight)
        M, M_error = jackknife(self.merging, self.weight) if self.n > 1 else (np.nan, np.nan)
        top = self.gas[:, 1, self.columns].mean(axis=1)
        gas, gas_error = jackknife(lambda w: np.average(top, weights=w), self.weight)
        return {"length_mm": (1e3 * L, 1e3 * L_error), "merging_mm": (1e3 * M, 1e3 * M_error), "mean_height_mm": (1e3 * H, 1e3 * H_error),
                "gas_flux_on_axis_m_s": (gas, gas_error), "pressure_drop_share": (self.drop.mean() / self.load, batch_error(self.drop) / self.load)}


# ---- two runs ----------------------------------------------------------------------------------------------------------

def apart(a, b, field, bed=0.02):
    """Root mean square difference of a field's means over the cells with solids; what chance makes of it (from both runs' batches); and how often
    chance makes as much: batches of both runs, in pairs of neighbours, dealt anew to two runs."""
    count = 2 * (min(len(a.weight), len(b.weight)) // 2)
    pairs = lambda run, name: getattr(run, name)[:count].reshape(count // 2, 2, *run.eps.shape[1:]).mean(axis=1)
    inside = 0.5 * (a.mean(a.solids) + b.mean(b.solids)) > bed

    def field_of(fraction, flux):
        if field == "eps":
            return 1 - fraction.mean(axis=0)[inside]
        return flux.mean(axis=0)[inside] / np.maximum(fraction.mean(axis=0)[inside], 0.01)

    fraction = np.concatenate([1 - pairs(a, "eps"), 1 - pairs(b, "eps")]) if field == "eps" else np.concatenate([pairs(a, "solids"), pairs(b, "solids")])
    flux = np.concatenate([pairs(a, "flux"), pairs(b, "flux")])
    m = count // 2
    difference = lambda one: np.sqrt(np.mean((field_of(fraction[one], flux[one]) - field_of(fraction[~one], flux[~one])) ** 2))
    true = np.arange(2 * m) < m
    found = difference(true)
    dealt = list(itertools.combinations(range(2 * m), m))
    random = np.random.default_rng(1)
    if len(dealt) > 1000:
        dealt = [dealt[i] for i in random.choice(len(dealt), 1000, replace=False)]
    chance = []
    for one in dealt:
        mask = np.zeros(2 * m, bool)
        mask[list(one)] = True
        chance.append(difference(mask))
    return found, float(np.median(chance)), float(np.mean(np.array(chance) >= found * (1 - 1e-12)))


# ---- tables ------------------------------------------------------------------------------------------------------------

def machine():
    try:
        with open("/proc/cpuinfo") as f:
            return next(line.split(":")[1].strip() for line in f if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def number(value, digits=4):
    """inf: a jet that reaches through the bed, or a bridge between two that reaches up to its surface."""
    return "" if np.isnan(value) else f"{value:.{digits}g}"


def write_table(path, words, key, rows, older):
    """rows (dicts), and those of the table `older` of runs that are none of theirs. key: columns that name a run. Returns all."""
    name = lambda row: tuple(str(row[k]) for k in key)
    if older and os.path.exists(older):
        made = {name(row) for row in rows}
        with open(older) as f:
            rows = rows + [row for row in csv.DictReader(line for line in f if line[0] != "#") if name(row) not in made]
    rows = sorted(rows, key=name)
    with open(path, "w", newline="") as f:
        f.write(f"# {words}\n")
        table = csv.DictWriter(f, list(dict.fromkeys(c for row in rows for c in row)), restval="", lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    return rows


def write_tables(runs, out, words, older=None):
    """jets.csv and profiles.csv; the rows of the first. older: folder of tables whose other runs are kept."""
    two = {(r.n, r.U): r for r in runs if r.kind == "two"}
    rows, profiles = [], []
    for r in runs:
        row = {"jets": r.n, "U_m_s": f"{r.U:g}", "grids": r.kind, "means_s": number(r.span, 3), "batches": len(r.weight), "correlation_time_s": number(r.correlation, 2)}
        scalars = r.scalars()
        against = two.get((r.n, r.U))
        for name, (value, error) in scalars.items():
            row[name], row[name + "_error"] = number(value), number(error, 2)
        row.update(solids_moved_by_the_bound=number(r.moved, 2), smallest_void_fraction=number(r.smallest, 3), program=r.commit, date=r.date, machine=machine())
        if against is not None and against is not r:
            for name, (value, error) in against.scalars().items():
                mine, my_error = scalars[name]
                if np.isfinite(value) and np.isfinite(mine):
                    row[name + "_less_two"], row[name + "_less_two_error"] = number(mine - value, 3), number(np.hypot(error, my_error), 2)
            for name, field in (("void_fraction", "eps"), ("solids_velocity_m_s", "velocity")):
                found, chance, p = apart(r, against, field)
                row.update({name + "_apart": number(found, 3), name + "_apart_by_chance": number(chance, 3), name + "_probability": number(p, 2)})
        rows.append(row)
        eps, eps_error = jackknife(lambda w: r.mean(r.eps, w), r.weight)
        v, v_error = jackknife(r.velocity, r.weight)
        for k in LAYERS:
            for i, x in enumerate(plot_fields.centres(r.x)):
                profiles.append({"jets": r.n, "U_m_s": f"{r.U:g}", "grids": r.kind, "z_mm": f"{1e3 * (k + 0.5) * CELL[1]:g}", "x_mm": f"{1e3 * x:.1f}", "void_fraction": f"{eps[k, i]:.4f}",
                                 "void_fraction_error": f"{eps_error[k, i]:.4f}", "solids_velocity_m_s": number(v[k, i], 3), "solids_velocity_error_m_s": number(v_error[k, i], 2)})
    key = ["jets", "U_m_s", "grids"]
    table = lambda name, made: write_table(os.path.join(out, name), words, key, made, older and os.path.join(older, name))
    table("profiles.csv", profiles)
    return table("jets.csv", rows)


def tell(rows):
    """The table for people."""
    print(f"{'jets':>4} {'U':>3} {'grids':16} {'length / mm':>14} {'merging / mm':>14} {'gas on axis':>13} {'drop/weight':>15} {'eps apart (chance), p':>25} {'v_s apart (chance), p':>25}")
    pm = lambda row, name: "-" if not row.get(name) else "through" if row[name] == "inf" else f"{row[name]} +- {row[name + '_error'] or '?'}"
    for row in rows:
        far = [f"{row[q + '_apart']} ({row[q + '_apart_by_chance']}), {row[q + '_probability']}" if row.get(q + "_apart") else "-" for q in ("void_fraction", "solids_velocity_m_s")]
        print(f"{row['jets']:>4} {row['U_m_s']:>3} {row['grids']:16} {pm(row, 'length_mm'):>14} {pm(row, 'merging_mm'):>14} {pm(row, 'gas_flux_on_axis_m_s'):>13} "
              f"{pm(row, 'pressure_drop_share'):>15} {far[0]:>25} {far[1]:>25}")


# ---- pictures ----------------------------------------------------------------------------------------------------------

def map_of(ax, edges, values, run, **options):
    picture = plot_fields.map_on(ax, edges, 0, values, **options)
    for axis in run.axes:
        ax.annotate("", (1e3 * axis, 0), (1e3 * axis, -4), arrowprops=dict(arrowstyle="-|>", color="k", lw=1), annotation_clip=False)
    return picture


def what_is_lost(runs, n, U, path, top=36e-3):
    """jets.png: three columns of mean void fraction and of mean gas flux, and profiles of all three below."""
    import matplotlib.pyplot as plt
    chosen = [next((r for r in runs if (r.n, r.U, r.kind) == (n, U, kind)), None) for kind in ("two", "coarse", "fine")]
    if any(r is None for r in chosen):
        return False
    map_height = min(3.0, 3.0 * top / chosen[0].x[-1]) + 0.5  # inches, true to scale
    figure = plt.figure(figsize=(10.5, 5.8 + 2 * map_height), layout="constrained")
    panels = figure.subplots(4, 3, gridspec_kw={"height_ratios": [map_height, map_height, 2.6, 2.6]})
    for column, run in enumerate(chosen):
        void = map_of(panels[0][column], run.edges, run.map_eps, run, vmin=0.4, vmax=1)
        gas = map_of(panels[1][column], run.fine, run.map_gas, run, vmin=0, vmax=U, cmap="magma")
        panels[0][column].set_title(KINDS[run.kind][0])
        for ax in panels[:2, column]:
            ax.set_ylim(0, 1e3 * top)
            ax.set_xlabel("")
        panels[0][column].axhline(1e3 * run.lengths(run.weight)[-1], color="w", lw=1, ls="--")
    panels[0][0].set_ylabel("z / mm")
    panels[1][0].set_ylabel("z / mm")
    figure.colorbar(void, ax=panels[0, :], label="mean void fraction", shrink=0.9)
    figure.colorbar(gas, ax=panels[1, :], label="mean gas flux upwards / (m/s)", shrink=0.9)
    for column, k in enumerate(LAYERS[:3]):
        for run in chosen:
            x = 1e3 * plot_fields.centres(run.x)
            for ax, (mean, error) in ((panels[2][column], jackknife(lambda w: run.mean(run.eps, w)[k], run.weight)), (panels[3][column], jackknife(lambda w: run.velocity(w)[k], run.weight))):
                ax.plot(x, mean, color=COLOURS[run.kind], lw=1.3, marker=".", ms=4, label=KINDS[run.kind][0])
                ax.fill_between(x, mean - 2 * error, mean + 2 * error, color=COLOURS[run.kind], alpha=0.18, lw=0)
        panels[2][column].set_title(f"z = {1e3 * (k + 0.5) * CELL[1]:.1f} mm, means over cells of {1e3 * CELL[0]:g} x {1e3 * CELL[1]:g} mm")
        panels[3][column].set_xlabel("x / mm")
        panels[3][column].axhline(0, color="0.7", lw=0.8, zorder=0)
        for ax in panels[2:, column]:
            ax.set_xlim(0, 1e3 * run.x[-1])
    panels[2][0].set_ylabel("void fraction")
    panels[3][0].set_ylabel("solids' velocity upwards / (m/s)")
    for row, room in zip(panels[2:], (0.3, 0.0)):  # for the legend
        low, high = min(ax.get_ylim()[0] for ax in row), max(ax.get_ylim()[1] for ax in row)
        for ax in row:
            ax.set_ylim(low, high + room * (high - low))
    panels[2][0].legend(loc="upper left", fontsize=8)
    first = chosen[0]
    figure.suptitle(f"{n} jet{'s' if n > 1 else ''} of 1.6 mm at {U:g} m/s (arrows), means over {first.span:.2f} s; white: length of the jets; bands: two standard errors", fontsize=10)
    figure.savefig(path, dpi=90)
    plt.close(figure)
    return True


def all_beds(runs, path, top=42e-3):
    """jets_all.png: mean void fraction of every bed on two grids, the solids' mean flux as arrows."""
    import matplotlib.pyplot as plt
    chosen = sorted((r for r in runs if r.kind == "two"), key=lambda r: (r.U, r.n))
    if not chosen:
        return False
    velocities, most = sorted({r.U for r in chosen}), max(r.n for r in chosen)
    figure, panels = plt.subplots(len(velocities), most, figsize=(2.2 + 1.5 * most * (most + 1) / 2, 0.6 + 2.8 * len(velocities)), layout="constrained", sharey=True, squeeze=False,
                                  gridspec_kw={"width_ratios": range(1, most + 1)})
    for ax in panels.ravel():
        ax.set_visible(False)
    for run in chosen:
        ax = panels[velocities.index(run.U)][run.n - 1]
        ax.set_visible(True)
        picture = map_of(ax, run.edges, run.map_eps, run, vmin=0.4, vmax=1)
        ax.set_ylim(0, 1e3 * top)
        ax.set_title(f"{run.n} jet{'s' if run.n > 1 else ''}, {run.U:g} m/s")
        x, z = np.meshgrid(1e3 * plot_fields.centres(run.x), 1e3 * plot_fields.centres(run.z))
        with h5py.File(os.path.join(run.folder, "bed.h5"), "r") as file:
            flux = file["average/particle_grid/solids_flux"][:].mean(axis=1)
        ax.quiver(x, z, flux[..., 0], flux[..., 2], color="w", scale=0.9, scale_units="height", width=0.002 * 3 / run.n, pivot="mid")
        (*_, L), _ = jackknife(run.lengths, run.weight)
        ax.axhline(1e3 * L, color="w", lw=1, ls="--")
    for row in panels:
        row[0].set_ylabel("z / mm")
    figure.colorbar(picture, ax=panels, label="mean void fraction", shrink=0.7)
    figure.suptitle("Two grids: mean void fraction, flux of the solids (arrows), length of the jets (dashed)", fontsize=9)
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return True


# ---- all together ------------------------------------------------------------------------------------------------------

def run_missing(o, out, mode):
    """What isn't there yet, one after the other. A run that doesn't come to its end is told, and kept as it is."""
    ended = True
    for n, U, kind in beds(o.short):
        folder = folder_of(out, n, U, kind)
        if os.path.exists(os.path.join(folder, "finished")) or (o.only and o.only not in os.path.basename(folder)):
            continue
        words = ["-var", "jets", str(n), "-var", "U", f"{U:.1f}", *KINDS[kind][1].split()]
        if (n, U, kind) in HIGHER:
            words += ["-var", "H", HIGHER[n, U, kind]]
        command = [os.path.join(HERE, "..", "run"), "jetting_bed", *mode, *(["--ranks", str(o.ranks)] if o.ranks else []), "--out", folder, *words]
        print(" ".join(["cases/run"] + command[1:]), flush=True)
        with open(os.path.join(out, os.path.basename(folder) + ".txt"), "w") as text:
            subprocess.run(command, stdout=text, stderr=subprocess.STDOUT, env={**os.environ, "TWOGRID_NO_REPORT": "1"})
        if not os.path.exists(os.path.join(folder, "finished")):
            ended = False
            print(f"  did not come to its end: {text.name}", flush=True)
    return ended


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--long", action="store_true")
    parser.add_argument("--ranks", type=int)
    parser.add_argument("--out")
    parser.add_argument("--save", action="store_true")
    parser.add_argument("--compare", action="store_true")
    parser.add_argument("--only")
    o = parser.parse_args()
    mode = ["--short"] if o.short else ["--long"] if o.long else []
    out = os.path.abspath(o.out or os.path.join(HERE, "out", "jets" + "".join(mode).replace("--", "_")))
    os.makedirs(out, exist_ok=True)
    ended = o.compare or run_missing(o, out, mode)
    runs = [Jets(folder_of(out, n, U, kind), n, U, kind) for n, U, kind in sorted(beds(o.short)) if os.path.exists(os.path.join(folder_of(out, n, U, kind), "finished"))]
    if not runs:
        sys.exit(f"no finished run in {out}")
    rows = write_tables(runs, out, "cases/jetting_bed/jets.py" + "".join(" " + m for m in mode), HERE if o.save else None)
    tell(rows)
    made = ["jets.csv", "profiles.csv"]
    most = max((r.n, r.U) for r in runs if r.kind == "fine") if any(r.kind == "fine" for r in runs) else (0, 0)
    if what_is_lost(runs, *most, os.path.join(out, "jets.png")):
        made.append("jets.png")
    if all_beds(runs, os.path.join(out, "jets_all.png")):
        made.append("jets_all.png")
    for name in made:
        if o.save:
            shutil.copy(os.path.join(out, name), HERE)
        print(os.path.join(HERE if o.save else out, name))
    sys.exit(0 if ended else 1)


if __name__ == "__main__":
    main()
