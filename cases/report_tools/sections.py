"""The sections of a report: each takes the run and returns HTML. What the run lacks is said, with what would give it."""
import os
import re

import numpy as np

from . import figures, movie
from .page import bars, drawing, escape, image, missing, picture_file, pictures, table

WITHOUT_FLUID = "the log has no fix twogrid (particles alone, so far as it goes)."
LAST_LEG = ", of the last leg"
NO_OUTPUT = "No output file of twogrid (HDF5) in this folder: fix_modify ID output every N file NAME.h5 writes one."
NO_MEANS = "No means in the output: fix_modify ID output ... average from T makes them, once the run has passed T."
NO_FRAMES = "No frames in the output: fix_modify ID output every N makes them."


def count(n):
    return f"{n:,.0f}".replace(",", "\u202f")


def tilted(run):
    """A warning above pictures that take z as up where gravity points elsewhere."""
    g = run.gravity()
    if g is None or -g[2] >= 0.999 * np.linalg.norm(g):
        return ""
    return f'<p class="warning">Here z is taken as up, but gravity is {" ".join(f"{v:g}" for v in g)} m/s2: what is called height, vertical, up and down is along z, not along gravity.</p>'


def head(run):
    status = run.status
    state = status.get("state") or ("finished" if os.path.exists(run.path("finished")) else "state not known: no status.json")
    facts = []
    # LIGGGHTS' own count where no coupling has counted.
    grains = status["particles"] if status.get("particles") is not None else next((int(n) for n in reversed(re.findall(r"^Loop time of .* with (\d+) atoms", run.log, re.M))), None)
    if grains is not None:
        facts.append((count(grains), "grains"))
    if run.output:
        facts.append((count(np.prod(run.record("fine"))), "fluid cells"))
    if status.get("time") is not None:
        facts.append((f"{status['time']:.4g} s", "of fluid time"))
    if status.get("wall_seconds") is not None:
        facts.append((f"{status['wall_seconds'] / 60:.1f} min" if status["wall_seconds"] > 90 else f"{status['wall_seconds']:.2g} s", f"by the clock on {status.get('ranks', '?')} rank(s)" + (LAST_LEG if run.goes_on else "")))
    good, bad = run.verdict.count("PASS  "), run.verdict.count("FAIL  ")
    if good + bad:
        facts.append((f"{good} of {good + bad}", "checks passed"))
    sentence = f"{state}; {run.record('date') or status.get('started', 'date not known')}; " + (status.get("program") or (f"twogrid {run.record('version')} ({run.record('commit')})" if run.output else "version not known"))
    text = f"<h1>{escape(run.title())}</h1><p class=\"quiet\">{escape(run.folder)}<br>{escape(sentence)}</p>"
    if status.get("error"):
        text += f'<p class="failed">The run ended with an error: {escape(status["error"])}</p>'
    text += "".join(f'<p class="failed">{escape(p)}</p>' for p in run.problems)
    return text + ('<div class="facts">' + "".join(f"<div><b>{escape(b)}</b><span>{escape(s)}</span></div>" for b, s in facts) + "</div>" if facts else "")


def verdict(run):
    if not run.verdict.strip():
        return missing("No verdict: verdict.txt is what a case's compare.py says, and cases/run writes it (cases/run NAME --compare --out FOLDER for a run that is there).")
    rows, notes = [], []
    for line in run.verdict.split("\n"):
        if line.startswith(("PASS  ", "FAIL  ")):
            rows.append([(f"word {line[:4].lower()}", line[:4]), line[6:]])
        elif line.startswith("      ") and line.strip():
            notes.append(line.strip())
    text = table(["", "what was checked: what was found (what is wanted)"], rows) if rows else "<p>The comparison gave no verdicts.</p>"
    return text + ('<p class="quiet">Without a verdict:</p><ul class="quiet">' + "".join(f"<li>{escape(n)}</li>" for n in notes) + "</ul>" if notes else "")


def film(run):
    if not run.output:
        return missing(NO_OUTPUT)
    if not run.frames:
        return missing(NO_FRAMES)
    data, size, n, scales, where, deep, beside = movie.animate(run.output, run.frames)
    caption = (f"{n} of {len(run.frames)} frames. {'Left' if beside else 'Above'}: grains, true to size" + (", those behind the cut" if deep else "") +
               f". {'Right' if beside else 'Below'}: {figures.fluid(run.output)}, {where}. Colours: {movie.in_words(*scales)}.")
    from matplotlib import cm
    bars_of_colour = ""
    for scale in scales if scales[0] else scales[1:]:
        stops = ", ".join("rgb(%d %d %d)" % tuple(int(255 * c) for c in cm.get_cmap(scale.colours)(t)[:3]) for t in np.linspace(0, 1, 9))
        ends = "".join(f"<b>{escape(e)}</b>" for e in scale.ends())
        bars_of_colour += f'<div class="scale">{escape(scale.what)}<i style="background:linear-gradient(to right, {stops})"></i><span>{ends}</span></div>'
    return tilted(run) + image(data, "webp", "grains and fluid in motion", size[0] / 2, size[1] / 2, caption) + bars_of_colour


def setup(run):
    if not run.output:
        return missing(NO_OUTPUT + (" What the log says of the grids stands in the scene report below." if run.scene else ""))
    d = (2 * run.output["particles"][run.frames[0]]["radius"][:].mean() if run.frames and run.frames[0] in run.output.get("particles", ()) and
         len(run.output["particles"][run.frames[0]]["radius"]) else None)
    fine, ratio = run.record("fine"), run.record("ratio")
    rows = [["fluid's grid", " x ".join(map(str, fine)) + " cells"], ["particle cell", " x ".join(map(str, ratio)) + " fine cells" +
            (", " + " x ".join(f"{np.median(np.diff(run.output['particle_grid'][c][:])) / d:.1f}" for c in "xyz") + " diameters" if d else "")]]
    if d:
        rows.append(["mean diameter", f"{1e3 * d:.4g} mm"])
    drawn, legend = figures.setup(run.output, run.frames[0] if run.frames else None, run.setting("boundary"))
    picture = drawing(drawn, "set-up and grids", "Blue lines: particle cells; grey lines: fluid cells; grains of the first frame" + (" (a layer at mid-depth where the bed is deep)." if d else "."), legend)
    return pictures(picture, f"<div>{table([], rows)}</div>")


def differences(c, reference):
    """A curve's differences from a reference where both are, its standard errors there (None without), how many points have been left out, whose points they are.
    A line is looked up at the run's x, within the line's range; the run at the x of measured points, within the run's range: neither is known beyond."""
    x, y = np.array(c["x"], float), np.array(c["mean"], float)
    error = np.array(c["error"], float) if c.get("error") is not None else np.full(len(x), np.nan)
    to_x, to_y = np.array(reference["x"], float), np.array(reference["y"], float)
    order = np.argsort(to_x if reference.get("line") else x, kind="stable")
    if reference.get("line"):
        off, near = y - np.interp(x, to_x[order], to_y[order], np.nan, np.nan), error
    else:
        once = np.all(np.diff(x[order]) > 0)  # else the run has several values at one x
        inside = lambda v: np.interp(to_x, x[order], v[order], np.nan, np.nan) if once else np.full(len(to_x), np.nan)
        off, near = inside(y) - to_y, inside(error)
    known = np.isfinite(off)
    return off[known], near[known] if np.any(np.isfinite(near)) else None, int(np.sum(~known)), "the run's" if reference.get("line") else "its"


def curve(c):
    """A curve of compared.json, with how far it is from its references."""
    said = []
    unit = " " + c["y_label"].split(" / ")[1].strip("()") if " / " in c["y_label"] else ""
    for r in c.get("references", []):
        off, error, left_out, whose = differences(c, r)
        if len(off):
            text = f"{r['label']}: root mean square difference {np.sqrt(np.mean(off**2)):.3g}{unit}, mean {np.mean(off):+.3g}{unit}, at {len(off)} of {whose} points"
            text += f" ({left_out} left out: where only one of both is known)" if left_out else ""
            if error is not None:
                text += f"; {int(np.sum(np.abs(off) > 2 * error))} of {len(off)} further off than two standard errors of the run ({np.sqrt(np.nanmean(error**2)):.2g}{unit})"
        else:
            text = f"{r['label']}: no difference, for nowhere are both known"
        said.append(text)
    better = "Nearer is better" if any("root mean" in t for t in said) else ""
    band = "band: two standard errors" if c.get("error") is not None else ""
    told = (c["title"], "; ".join(said or ["no reference"]), "; ".join(w for w in (better, band) if w).capitalize())
    return drawing(figures.comparison(c), c["title"], ". ".join(t for t in told if t) + ".")


def own_pictures(run):
    """Those of the case's comparison that a report doesn't draw itself."""
    return [picture_file(run.path(n), n, n[:-4].replace("_", " ")) for n in sorted(run.names("*.png")) if n[:-4] not in ("mean_void_fraction", "snapshots", "profiles", "pressure")]


def compared(run):
    curves, shown = [curve(c) for c in run.compared], own_pictures(run)
    if not curves and not shown:
        return missing("No curves and pictures of a comparison: a case's compare.py draws them (cases/run NAME --compare --out FOLDER), curves by save_compared of cases/verdict.py.")
    return (pictures(*curves) if curves else "") + (("<h3>Its pictures</h3>" if curves else "") + pictures(*shown) if shown else "")


def fields(run):
    if not run.output:
        return missing(NO_OUTPUT)
    if "average" not in run.output or "fine" not in run.output["average"]:
        return missing(NO_MEANS)
    group = run.output["average"]
    span = f"Means over {float(group.attrs['weight']):.3g} s from {float(group.attrs['from']):.3g} s on; {figures.where(run.output)}."
    top = figures.bed_top(run.output)
    if top is not None:
        span += f" 95 % of the solids lie below z = {1e3 * top:.1f} mm."
    return tilted(run) + f"<p>{escape(span)}</p>" + pictures(drawing(figures.void_fractions(run.output), "mean void fraction", "Mean void fraction on both grids."),
                                              drawing(figures.velocities(run.output), "mean velocities", f"{figures.fluid(run.output).capitalize()}: interstitial velocity" + ("; solids: volume flux" if top is not None else "") + ". Red is up, blue is down."),
                                              drawing(figures.pressure_map(run.output), "mean pressure", "Dynamic pressure and how it fluctuates."))


def profiles(run):
    if not run.output:
        return missing(NO_OUTPUT)
    if "average" not in run.output or "batch" not in run.output.get("average/particle_grid", ()):
        return missing(NO_MEANS)
    drawn, weight, n = figures.profiles(run.output)
    return tilted(run) + (f"<p>At a fourth, a half and three fourths of the bed's height; means over {weight:.3g} s. Bands: two standard errors, from the scatter of {n} batches"
            f"{'' if n > 3 else ': too few to be trusted'}.</p>" + pictures(*(drawing(f, label, label.split(" / ")[0]) for label, f in drawn)))


def even_part(time):
    """The longest stretch of points at equal distances in time: its first point and the one behind it."""
    gaps = np.diff(time)
    changes = np.flatnonzero(np.abs(np.diff(gaps)) > 0.01 * np.minimum(gaps[1:], gaps[:-1])) + 1
    ends = [0, *changes, len(gaps)]
    first, last = max(zip(ends, ends[1:]), key=lambda e: e[1] - e[0])
    return first, last + 1


def pressure(run):
    series = run.series(4)
    if run.without_fluid:
        return missing(f"No pressure drop: {WITHOUT_FLUID}")
    if not series or len(series[1]) < 2:
        return missing(f"No series of the pressure drop: fix NAME all ave/time 1 50 50 f_{run.fix}[4] file FILE.txt writes one, thermo_style custom ... f_{run.fix}[4] a coarse one.")
    name, step, values = series
    time = run.time_of(step)
    begin, used = run.means_begin() if time is not None else None, run.averaged(step)
    grey = "" if used.all() else " Grey: before the means begin; the mean, and the spectrum if there is one, are of the rows after." if used.any() else " No row lies in the time of the means yet: no mean."
    low, high = figures.pressure_limits(values)
    off = np.sum((values < low) | (values > high))
    grey += f" {off} point(s) lie beyond the picture, which would have to go from {values.min():.3g} to {values.max():.3g} Pa." if off else ""
    drawn = [drawing(figures.pressure_series(time if time is not None else step, values, begin, used, time is not None), "pressure drop over time", f"From {name}, {len(step)} points.{grey}")]
    if time is None:
        return pictures(*drawn) + missing("No spectrum: the time of a DEM step isn't known; neither frames of the output nor the log tell it.")
    t, v = time[used], values[used]
    first, end = even_part(t) if len(t) > 1 else (0, len(t))
    part = "" if end - first == len(t) else f" of {len(t)}, the longest part at equal distances in time, {t[first]:.4g} to {t[end - 1]:.4g} s (elsewhere the time step or the table's interval is another, or rows lack),"
    t, v = t[first:end], v[first:end]
    if len(t) < 32 or np.ptp(v) == 0:
        return pictures(*drawn) + missing(f"No spectrum: {'all values are the same' if len(t) > 31 else f'it takes 32 points at equal distances in time, and there are {len(t)}'}{part.rstrip(',')}{' after the means begin' if not used.all() else ''}.")
    period = (t[-1] - t[0]) / (len(t) - 1)
    f, power, parts = figures.spectrum(v, period)
    peak = f[np.argmax(power)]
    few = " That is the longest period that it can tell: the series is too short." if peak <= 1.5 * f[0] else ""
    drawn.append(drawing(figures.spectrum_figure(f, power, peak), "spectrum of the pressure drop",
                         f"Spectrum from {len(t)} points{part} over {len(t) * period:.3g} s, {parts} part(s), resolution {f[0]:.2g} Hz.{few}"))
    return pictures(*drawn)


LEDGER = (("solids volume, relative error", "solids_volume_error", 6, "below 1e-12; a warning above 1e-9"), ("action and reaction, relative error", "momentum_error", 7, "below 1e-12; a warning above 1e-9"),
          ("continuity error of a cell (U/h)", "continuity_error", 5, "about the tolerance"), ("volume moved by the eps bound (m3)", None, 8, "little against the solids"),
          ("volume inserted (m3)", "volume_inserted", 14, "as the script inserts"), ("volume deleted or left (m3)", "volume_vanished", 15, "0, or as the script deletes"),
          ("volume grown (m3)", "volume_grown", 16, "0, or as the script lets grow"))


def ledger(run):
    book, rows = run.status.get("ledger") or {}, []
    for what, key, i, wanted in LEDGER:
        series = run.series(i)
        last = book.get(key)
        if last is None and series:
            last = series[2][-1]
        if last is None and not series:
            continue
        largest = f"{np.max(np.abs(series[2][min(1, len(series[2]) - 1):])):.2g}" if series else "-"
        rows.append([what, ("number", "-" if last is None else f"{last:.2g}"), ("number", largest), wanted])
    lost = run.status.get("particles_lost")
    if lost is not None:
        rows.append(["grains lost", ("number", str(lost)), "", "0"])
    if not rows:
        return missing(f"No ledger: status.json has it (none with -log none), and f_{run.fix}[5] to f_{run.fix}[8] in a table of fix ave/time or of thermo_style.")
    return table(["", "at the end", "largest", "good"], rows) + f'<p class="quiet">Largest: of those in tables of fix ave/time or in the log; - where f_{run.fix}[5] to [8], [14] to [16] are in none.</p>'


def cost(run):
    shares, total = run.costs()
    text = bars(shares) if shares else missing(f"No shares of CPU time by twogrid: {WITHOUT_FLUID}" if run.without_fluid else "No shares of CPU time in the log: the run has not come to its end, or its log is not here.")
    rows = []
    if total:
        told = sum("shares of CPU time:" in leg for leg in run.legs)
        rows.append(["runs with the fluid", f"{total:.3g} s" + (f", of {told} of {len(run.legs)} legs, as the shares" if len(run.legs) > 1 else LAST_LEG if run.goes_on else "")])
    rate = run.status.get("wall_seconds_per_simulated_second")
    if rate:
        rows.append(["a second of fluid time takes", f"{rate / 60:.3g} min" if rate > 90 else f"{rate:.3g} s"])
    if run.status.get("steps_per_second"):
        rows.append(["DEM steps a second", f"{run.status['steps_per_second']:.4g}"])
    memory = re.findall(r"^twogrid: (\S+) fine cells need about (.+?) of memory", run.log, re.M)
    if memory:
        rows.append(["memory of the fluid and the coupling", memory[-1][1]])
    return text + (table([], rows) if rows else "")


def not_modelled(run):
    if not run.scene:
        return missing("No scene report in the log of this run.")
    rows = [[k, v] for k, v in run.scene["pairs"] if k in ("modelled", "not modelled", "not computed")]
    warnings = run.scene["warnings"] + list(dict.fromkeys(re.findall(r"^WARNING: ((?:fix|Particle insertion:) .+)$", run.log, re.M)))
    return table([], rows) + "".join(f'<p class="warning">{escape(w)}</p>' for w in warnings) + ("" if warnings else "<p>No warnings.</p>")


def scene(run):
    if not run.log_name:
        return missing("No scene report: the log of a run of twogrid holds it, between its script and its first step.")
    if not run.scene:
        return missing(f"No scene report in {run.log_name}: " + (WITHOUT_FLUID if run.without_fluid else "the run has not come to fix twogrid's first step."))
    logs = "log" if len(run.legs) == 1 else f"logs of {len(run.legs)} legs"
    more = f"<p>The last of {len(run.scenes)} in the {logs}.</p>" if len(run.scenes) > 1 else ""
    return more + table([], [[k, v] for k, v in run.scene["pairs"] if k not in ("modelled", "not modelled", "not computed")])


def origin(run):
    rows = [["command", str(run.record("command_line"))]] if run.output else []
    rows += [[k, str(run.record(k))] for k in ("program", "version", "commit", "compiler", "LIGGGHTS", "PETSc", "MPI", "HDF5") if run.output and run.record(k) != ""]
    files = ", ".join(n for n in (run.log_name, run.output_name, "status.json" if run.status else None) if n)
    return (table([], rows) if rows else missing("What program, libraries and command made a run stands in the output file's /record.")) + f'<p class="quiet">Read from {escape(files)} by cases/report.py.</p>'
