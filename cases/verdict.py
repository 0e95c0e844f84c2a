"""What the cases' compare.py share: lines of a verdict, what a run of a bed has written, the ledgers, the balance of momentum, minimum
fluidisation, statistics of series that are correlated in time, pictures.

A bed's script writes bed.h5 with faces and means, and two tables at the same steps: now.txt (step, vertical momentum of the grains, number of
grains, top of the grains, f_ID[1], f_ID[5] to f_ID[9], more) and mean.txt (step, f_ID[4], vertical forces).
"""
import json
import os
import re
import sys

import h5py
import numpy as np

import leg_tables
import plot_fields

G = 9.81
NO_PICTURES = "TWOGRID_NO_PICTURES" in os.environ  # verdicts only


class Verdict:
    """Prints a line for each check; failed counts those that are not met. What was found and what was wanted of each goes to the file that
    $TWOGRID_CHECKS names: false_alarms.py reads it. A check that a short run is too short for (short=True) is told without a verdict."""

    def __init__(self):
        self.failed, self.checks = 0, []

    def __call__(self, good, text, short=False, figures=()):
        """figures: what it hangs on, a tuple each: name, least, what was found, most."""
        if short:
            self.note(text)
            return
        good = bool(good)
        self.failed += not good
        self.checks.append({"text": text, "good": good, "figures": [(name, float(least), float(found), float(most)) for name, least, found, most in figures]})
        print(f"{'PASS' if good else 'FAIL'}  {text}", flush=True)

    def within(self, text, *figures, short=False):
        """Every figure, a tuple (name, least, what was found, most), lies within its bounds; one that isn't a number doesn't."""
        self(all(least <= found <= most for _, least, found, most in figures), text, short, figures)

    def between(self, least, found, most, text, short=False):
        self.within(text, ("", least, found, most), short=short)

    def at_most(self, most, found, text, short=False):
        """Of an error, which is 0 at best."""
        self.between(0, found, most, text, short)

    def note(self, text):
        print(f"      {text}", flush=True)

    def end(self):
        if "TWOGRID_CHECKS" in os.environ:
            with open(os.environ["TWOGRID_CHECKS"], "w") as f:
                json.dump(self.checks, f)
        sys.exit(1 if self.failed else 0)


def command_line(usage):
    """The folder that compare.py is called with, and whether with --short. From here on what the folder lacks is told in a sentence."""
    words = [w for w in sys.argv[1:] if w != "--short"]
    if len(words) != 1:
        sys.exit(usage)
    folder = words[0]

    def tell(kind, error, trace):
        if issubclass(kind, (FileNotFoundError, KeyError)):
            what = error.args[0] if kind is KeyError else next(iter(re.findall(r"[\w.]+\.(?:h5|txt|json|csv)", str(error))), error)
            print(f"FAIL  the run in {os.path.abspath(folder)} lacks what is compared, {what}: it is one of another case, or ended before it wrote that")
        else:
            sys.__excepthook__(kind, error, trace)

    sys.excepthook = tell
    return folder, "--short" in sys.argv


def same_grains(folder, file, d, rho):
    """Ends with a sentence if the grains of a run are not those that its compare.py has: no grain of diameter d (m); another density than rho, as
    the scene report in the log has it for grains of one size."""
    last = plot_fields.frames(file)[-1]
    found = 2 * file["particles"][last]["radius"][:] if last in file.get("particles", {}) else np.array([])
    if len(found) and np.abs(found / d - 1).min() > 1e-3:
        sys.exit(f"FAIL  compare.py has grains of {1e3 * d:.4g} mm, the run's have {1e3 * found.min():.4g}" + (f" to {1e3 * found.max():.4g}" if np.ptp(found) > 1e-3 * d else "") +
                 " mm: change it at the top of compare.py, too")
    try:
        with open(os.path.join(folder, "log.liggghts"), errors="replace") as f:
            densities = [float(m) for m in re.findall(r"^  particles  .*, diameter [\d.e-]+ m, density ([\d.e+]+) kg/m3", f.read(), re.M)]
    except OSError:
        return
    if densities and min(abs(density / rho - 1) for density in densities) > 1e-3:
        sys.exit(f"FAIL  compare.py has grains of {rho:.5g} kg/m3, the run's have {densities[-1]:.5g}: change it at the top of compare.py, too")


class Bed:
    """The output of a run, with what several checks need. d, rho: of the grains; step: the DEM step (s); scene: of several in a run, whose files are
    SCENE.h5, SCENE_now.txt, SCENE_mean.txt."""

    def __init__(self, folder, d, rho, step, scene=""):
        self.folder, self.d, self.rho_p, self.step = folder, d, rho, step
        self.file = h5py.File(os.path.join(folder, (scene or "bed") + ".h5"), "r")
        tables = scene + "_" if scene else ""
        self.now = leg_tables.table(os.path.join(folder, tables + "now.txt"))
        self.mean = leg_tables.table(os.path.join(folder, tables + "mean.txt"))
        means = self.file["average"].attrs if "average" in self.file else {}
        self.begin = float(means.get("from", np.inf))
        if "weight" not in means or self.now[-1, 0] * step <= self.begin:
            sys.exit("FAIL  the run ended before its means began: -var tend must be larger than -var tavg")
        same_grains(folder, self.file, d, rho)
        self.x, self.y, self.z = plot_fields.nodes(self.file)
        self.cell = np.outer(np.diff(self.y), np.diff(self.x))
        self.volume = np.diff(self.z)[:, None, None] * self.cell
        theta = plot_fields.open_share(self.file)
        self.theta = np.ones(self.volume.shape) if theta is None else theta
        self.rho_f = float(self.file["record"].attrs["density"])
        self.mu = float(self.file["record"].attrs["viscosity"])
        self.frames = plot_fields.frames(self.file)
        self.last = self.frames[-1]
        self.inlet = self.file["fluid"][self.last]["faces/flux_z"][0]  # m/s, of whole faces
        self.inflow = np.sum(self.inlet * self.cell)                   # m3/s
        self.section = np.sum(self.theta[0] * self.cell)               # m2, of the floor
        self.n = self.now[0, 2]
        self.solids = self.n * np.pi / 6 * d**3
        self.weight = self.solids * (rho - self.rho_f) * G             # buoyant, N
        self.length = self.now[-1, 0] * step                           # s

    def averaged(self, table):
        """The rows of a table that lie in the time of the means."""
        period = table[1, 0] - table[0, 0]
        return (table[:, 0] - 0.5 * period) * self.step > self.begin

    def grains(self, name):
        """Particles' field of the last frame."""
        return self.file["particles"][self.last][name][:]


# ---- statistics ------------------------------------------------------------------------------------------------------

def batch_error(series, count=8):
    """Standard error of a series' mean from that of at most `count` batches."""
    means = [b.mean() for b in np.array_split(series, min(count, len(series)))]
    return np.std(means, ddof=1) / np.sqrt(len(means))


def jackknife(f, weight):
    """f(weights of batches) and its standard error, from leaving out one batch after the other. f may give an array, also with what is no number."""
    whole, b = np.asarray(f(weight)), len(weight)
    without = np.array([f(np.where(np.arange(b) == i, 0.0, weight)) for i in range(b)])
    with np.errstate(invalid="ignore"):  # infinities
        return whole, np.sqrt((b - 1) / b * ((without - without.mean(axis=0)) ** 2).sum(axis=0))


def correlated_mean(series):
    """Mean of a series, its standard error and the number of independent values that it stands for: by the integrated time of
    correlation, summed up to five times itself (Sokal 1997)."""
    series = np.asarray(series, dtype=float)
    n, off = len(series), series - series.mean()
    variance = np.mean(off**2)
    if variance == 0:
        return series[0], 0.0, float(n)
    time = 1.0
    for lag in range(1, n):
        time += 2 * np.sum(off[lag:] * off[:-lag]) / n / variance
        if lag >= 5 * time:
            break
    independent = n / max(time, 1.0)
    return series.mean(), np.sqrt(variance / max(independent - 1, 1e-9)), independent


def by_chance(series, alarms):
    """How far a series' mean may lie from 0 by chance: what is exceeded once in 1/alarms runs. No more than six values count as independent, for
    a series that is short for its correlation seems to hold more than it does. Returns mean, standard error, independent values, bound."""
    mean, error, independent = correlated_mean(series)
    error = max(error, batch_error(series, 4))
    return mean, error, independent, student(max(min(independent, 6.0) - 1, 1.0), alarms) * error


def student(freedom, alarms):
    """How many standard errors a mean is exceeded by with the probability `alarms` (on both sides), from `freedom` + 1 values."""
    t = np.concatenate([np.linspace(0, 20, 20001), np.geomspace(20, 1e7, 20000)[1:]])
    density = (1 + t**2 / freedom) ** (-(freedom + 1) / 2)
    below = np.concatenate([[0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(t))])
    return np.interp(1 - alarms, below / below[-1], t)


# ---- checks that hold in any bed -------------------------------------------------------------------------------------

def ledgers(bed, verdict, fluid="gas"):
    """Grains, their volume, action and reaction, and the fluid's volume."""
    now, frames = bed.now, bed.file["fluid"]
    verdict(np.ptp(now[:, 2]) == 0, f"particles: {now[0, 2]:.0f} at the beginning, {now[-1, 2]:.0f} at the end")
    verdict.at_most(1e-13, now[:, 6].max(), f"solid volume deposited: relative error at most {now[:, 6].max():.1e} (wanted 1e-13)")
    verdict.at_most(1e-12, now[:, 7].max(), f"action and reaction: relative error at most {now[:, 7].max():.1e} (wanted 1e-12)")
    worst = 0
    for name in bed.frames:
        if frames[name]["time"][()] < bed.begin:
            continue
        flux, rate = frames[name]["faces/flux_z"], frames[name]["faces/deps_dt"][:]
        inflow, outflow, displaced = np.sum(flux[0] * bed.cell), np.sum(flux[-1] * bed.cell), -np.sum(rate * bed.volume)
        # Of what comes in; where nothing does, of what the grains displace.
        worst = np.maximum(worst, abs(outflow - inflow - displaced) / (inflow or 0.5 * np.sum(np.abs(rate) * bed.volume)))
    verdict.at_most(1e-6, worst, f"{fluid} out = {fluid} in + displaced: relative error at most {worst:.1e} (wanted 1e-6)")
    verdict.note(f"largest continuity error of a cell {now[1:, 5].max():.1e} U/h; smallest void fraction {now[1:, 9].min():.3f}; "
                 f"moved by its bound at most {now[:, 8].max():.1e} m3 of {bed.solids:.1e} m3")


def in_open_cells(bed, verdict):
    """All the grains' volume lies in what bodies leave open."""
    solids = np.sum((1 - bed.file["fluid"][bed.last]["eps"][:]) * bed.theta * bed.volume)
    off = abs(solids / bed.solids - 1)
    verdict.at_most(1e-12, off, f"solids in the open parts of cells: {off:.1e} off the grains' volume (wanted 1e-12)")


def momentum(bed, verdict, forces, bound=1e-3, of_gas=()):
    """Vertical momentum of grains and gas over the time of the means:
    d(P_s + P_f) = integral of [ dp A + rho sum U^2 A (in) - rho sum <f u> A (out) + forces - buoyant weight ] dt.
    forces: name: series over mean.txt of what acts upwards on grains and gas (N): of walls on grains, less the gas's forces on bodies (of_gas names
    these). f_ID[4] and the forces on bodies are means over the coupling interval before: their series lags by it, which is corrected for.
    Inlet and outlet are floor and top, equally wide. The volume flux of both phases together is the same in every section, hence
    P_f = const - rho_f/rho_p P_s. Returns the pressure drop's series and its mean share of the weight with the standard error."""
    step, inside = bed.mean[:, 0], bed.averaged(bed.mean)
    period = step[1] - step[0]
    first = int(np.argmax(inside))
    every = int(np.ravel(bed.file["record"].attrs["every"])[0])

    def mean(series, lag):
        """Over the window, of a series that lags by so many steps."""
        end, begin = series[inside][-1], series[max(first - 1, 0)]
        return series[inside].mean() + lag * (end - begin) / (inside.sum() * period)

    dp = bed.mean[inside, 1]
    P = dict(zip(bed.now[:, 0], bed.now[:, 1]))
    T = inside.sum() * period * bed.step
    change = (P[step[inside][-1]] - P[step[inside][0] - period]) * (1 - bed.rho_f / bed.rho_p) / (bed.weight * T)
    fine, top = bed.file["average/fine"], bed.theta[-1] * bed.cell
    out = fine["flux"][-1, ..., 2] * fine["u"][-1, ..., 2] + fine["u_variance"][-1, ..., 2]
    share = np.where(bed.theta[0] > 0, bed.theta[0], 1)
    parts = {"pressure": mean(bed.mean[:, 1], every) * bed.section, "in": bed.rho_f * np.sum(bed.inlet**2 / share * bed.cell), "out": -bed.rho_f * np.sum(out * top),
             **{name: mean(series, every if name in of_gas else 0) for name, series in forces.items()}, "weight": -bed.weight}
    error = change - sum(parts.values()) / bed.weight
    verdict.note(f"per buoyant weight ({bed.weight:.4e} N, {bed.weight / bed.section:.1f} Pa), over {T:.2f} s: " +
                 ", ".join(f"{k} {v / bed.weight:+.4f}" for k, v in parts.items()) + f", change {change:+.4f}")
    verdict.between(-bound, error, bound, f"momentum of gas and particles: the balance is open by {100 * error:+.3f} % of weight times time (wanted {100 * bound:.1f} %)")
    unit = bed.section / bed.weight
    return dp, dp.mean() * unit, batch_error(dp) * unit


def packed_fluidisation(bed, levels, steps, load):
    """Velocity at which a packed bed would lose as much pressure as `load` (Pa), by its pressure drops at two `levels` (m/s), each held for so
    many DEM steps from the beginning, as a U + b U^2; and Wen & Yu's (1966). Returns both and the two pressure drops."""
    at = bed.mean[:, 0]
    drops = [bed.mean[(at > (i + 0.6) * steps) & (at <= (i + 1) * steps), 1].mean() for i in range(2)]
    U = np.array(levels)
    a, b = np.linalg.solve(np.stack([U, U**2], axis=1), drops)
    U_mf = (-a + np.sqrt(a * a + 4 * b * load)) / (2 * b) if b > 0 else load / a
    archimedes = bed.d**3 * bed.rho_f * (bed.rho_p - bed.rho_f) * G / bed.mu**2
    return U_mf, (np.sqrt(33.7**2 + 0.0408 * archimedes) - 33.7) * bed.mu / (bed.rho_f * bed.d), drops


# ---- pictures ----------------------------------------------------------------------------------------------------------

def usual_pictures(bed, heights, top=None, depth=None):
    """Mean void fraction (over the depth, or at `depth`), three snapshots, profiles at heights, pressure; up to `top` (m)."""
    if NO_PICTURES:
        return {}
    which = np.linspace(len(bed.frames) // 3, len(bed.frames) - 1, 3).astype(int)
    return {"mean_void_fraction": plot_fields.mean_void_fraction(bed.file, depth=depth, top=top), "snapshots": plot_fields.snapshots(bed.file, which, top=top),
            "profiles": plot_fields.profiles(bed.file, heights), "pressure": plot_fields.pressure_profile(bed.file)}


def save_compared(folder, curves):
    """Curves for report.py as folder/compared.json: each a dict with title, x_label, y_label, x, mean, error (standard error, or None) and references,
    dicts with label, x, y, perhaps line=True and tolerance."""
    plain = lambda v: np.asarray(v, dtype=float).tolist() if isinstance(v, (list, tuple, np.ndarray)) else v
    dump = [{**{k: plain(v) for k, v in c.items() if k != "references"}, "references": [{k: plain(v) for k, v in r.items()} for r in c.get("references", [])]} for c in curves]
    with open(os.path.join(folder, "compared.json"), "w") as f:
        json.dump(dump, f)


def save(pictures, folder):
    """Figures by their name as folder/NAME.png."""
    if NO_PICTURES:
        return
    print("pictures:")
    for name, figure in pictures.items():
        path = os.path.join(folder, name + ".png")
        figure.savefig(path, dpi=110, bbox_inches="tight")
        print("  " + os.path.abspath(path))
