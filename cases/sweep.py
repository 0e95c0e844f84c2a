#!/usr/bin/python3
"""Speed against error: runs a case script with every combination of choices, measures what each costs and how wrong it is.

    sweep.py STUDY                       a folder with study.toml (see below)
    sweep.py CASE_SCRIPT --choice deposit=centroid,trilinear --choice every=5,10 --reference finest

Choices are keywords of fix twogrid (fine, ratio, every, ...) and of its fix_modify (deposit, prolong, read, drag, cfl,
'eps bound', ...), which are written into the script; `timestep`; `kn` (N/m, of property/global); `ranks`; `method`, a
name of studies/methods.toml or one of twogrid's own; or variables of the script (-var). Several words make one value: ratio="4 4 4".

Written into the study's folder (--out for another): table.csv, error_cost.png with the Pareto front,
recommendation.txt. Finished runs are kept in FOLDER/out/runs under a hash of script, files, choices and executable, so
that an interrupted sweep goes on where it was; what was half done is run anew.

study.toml
    script = "in.name"              beside it, or the path of any script from it
    title = "one line"
    ranks = 1                       options = ["-fluid_pressure_rtol", "1e-9"]      timeout = 600
    error = ["force"]               what is plotted and judged; errors as fractions of 1; the first one is the main one
    methods = ["two-grid, exact"]   or "all"; of methods.toml, or of a file methods_file = "..."
    [fixed]     choices of all runs that are not varied
    [values]    names for expressions in braces: d = 1e-3 lets a choice say "kernel {2*d}"; variables are such names too
    [product]   every = [5, 10]     every combination of these, with each method
    [[variant]] name = "..."        a run more, with the choices given here
    [reference] choices of the run that the others are compared with; or reference = "finest" (in each choice the finest
                value); or reference = "exact" (measure.py knows the right answer)
    [short]     runs = ["two-grid, exact*"]    names (with * and ?) of the runs that --short makes
    [short.agree] force = [1e-3, 0.05]         how far they may be from table.csv: absolute, and of the value
measure.py, beside it, if the generic measure (see generic_measure) is not what is wanted
    measure(folder, choices) -> {name: number or array}; name_err is the standard error of name. With reference "exact"
                these are the errors. Else the error of name is |value - reference| / |reference| (arrays: root mean
                squares; a name in `absolute = [...]` of study.toml is not divided).
    prepare(folder, choices)        optional: writes files that the script needs
    conclude(rows)                  optional: text that is added to recommendation.txt
It may import what lies in cases/studies and tests/system (harness.py reads dumps and thermo tables).
"""
import argparse
import csv
import ctypes
import fnmatch
import hashlib
import importlib.util
import itertools
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib

HERE = os.path.dirname(os.path.abspath(__file__))
README = os.path.join(HERE, "..", "README.md")
OTHER_KEYS = {"timestep", "kn", "ranks", "method"}
NOT_CHOICES = {"boundary", "output", "model"}   # of fix_modify: they belong to the scene
STUDY_KEYS = {"script", "title", "ranks", "options", "timeout", "error", "methods", "methods_file", "fixed", "values", "product",
              "variant", "reference", "short", "absolute"}
SMALLER_IS_FINER = {"ratio", "every", "timestep", "dt", "cfl", "tolerance"}
LEVELS = (0.01, 0.03, 0.10)
LEAST_CPU = 0.05   # s: what is left of a run's CPU when its start-up is taken off is no surer than this


class Wrong(Exception):
    """What the user has to change, in one sentence."""


# ---- keywords --------------------------------------------------------------------------------------------------------

def tables_of(page):
    """First words of the rows of each table of `twogrid -keywords`, or of the README, which holds the same tables (a test
    compares them): keywords of fix, of fix_modify, names of methods."""
    found, name = {}, None
    for line in page.split("\n"):
        begins = re.match(r"`(fix|fix_modify) ID .*keyword values|\| (method) \|", line)
        if begins:
            name = begins.group(1) or begins.group(2)
            found[name] = []
        row = re.match(r"\| `([^`]*)` \|", line)
        if row and name:
            found[name].append(row.group(1))
        elif line and line[0] not in "|`":
            name = None
    return found


def keywords():
    try:
        with open(README) as f:
            tables = tables_of(f.read())
    except OSError as e:
        raise SystemExit(f"sweep.py: {README} cannot be read ({e.strerror}); its tables hold the keywords")
    return set(tables["fix"]), set(tables["fix_modify"]) - NOT_CHOICES, tables["method"]


FIX_KEYS, MODIFY_KEYS, METHODS = keywords()


# ---- the study -------------------------------------------------------------------------------------------------------

def text(value):
    """A choice's value as it stands in a script."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, (list, tuple)):
        return " ".join(text(v) for v in value)
    return str(value)


def number(value):
    try:
        return float(value) if not re.fullmatch(r"[+-]?\d+", str(value)) else int(value)
    except ValueError:
        return value


def key_of(name):
    """Choices may be written with _ for a blank (TOML's bare keys)."""
    blank = name.replace("_", " ")
    return blank if blank in MODIFY_KEYS else name


def load_toml(path):
    try:
        with open(path, "rb") as f:
            return tomllib.load(f)
    except OSError as e:
        raise Wrong(f"{path} cannot be read ({e.strerror})")
    except tomllib.TOMLDecodeError as e:
        raise Wrong(f"{path} is no valid TOML: {e}")


def load_study(path):
    """study.toml, or a script with the choices of the command line, as one dict with all keys set."""
    study = load_toml(os.path.join(path, "study.toml"))
    for key in study:
        if key not in STUDY_KEYS:
            raise Wrong(f"study.toml: '{key}' is no key of it; there are {', '.join(sorted(STUDY_KEYS))}")
    if "script" not in study:
        raise Wrong("study.toml: script = \"in.name\" is missing")
    study["folder"] = path
    study["script"] = os.path.join(path, study["script"])
    return study


def logical_lines(script):
    """Commands of a script, lines joined where they end with &; each a list of its physical lines."""
    out, open_line = [], False
    for line in script.split("\n"):
        if open_line:
            out[-1].append(line)
        else:
            out.append([line])
        open_line = line.rstrip().endswith("&")
    return out


def words_of(lines):
    joined = " ".join(l.split("#")[0].rstrip().rstrip("&") for l in lines)
    return joined.split()


def script_variables(script):
    return {w[1] for w in map(words_of, logical_lines(script)) if len(w) > 2 and w[0] == "variable"}


def rewrite(script, choices, path):
    """The script with the choices written in; a Wrong if there is no place for one."""
    lines = logical_lines(script)
    fix = [i for i, l in enumerate(lines) if (w := words_of(l)) and len(w) > 3 and w[0] == "fix" and w[3] == "twogrid"]
    modify = {k: v for k, v in sorted(choices.items(), key=lambda c: c[0] != "method") if k in MODIFY_KEYS}
    if len(fix) != 1 and any(k in MODIFY_KEYS or k in FIX_KEYS for k in choices):
        raise Wrong(f"{path} has {len(fix)} lines 'fix ID group twogrid', one is wanted for choices of it")
    inserted = {}
    if fix:
        words = words_of(lines[fix[0]])
        for key in FIX_KEYS & set(choices):
            value = choices[key].split()
            if key in words[4:]:
                at = words.index(key, 4)
                end = next((i for i in range(at + 1, len(words)) if words[i] in FIX_KEYS), len(words))
                words[at + 1:end] = value
            else:
                words += [key] + value
        if FIX_KEYS & set(choices):
            lines[fix[0]] = [" ".join(words)]
        if modify:
            run = next((i for i in range(fix[0] + 1, len(lines)) if words_of(lines[i])[:1] in (["run"], ["rerun"])), None)
            if run is None:
                raise Wrong(f"{path} has no 'run' after its fix twogrid")
            inserted[run] = [f"fix_modify {words[1]} {k} {v}" for k, v in modify.items()]
    for key, test in (("timestep", lambda w: w[:1] == ["timestep"]),
                      ("kn", lambda w: w[:1] == ["fix"] and w[3:5] == ["property/global", "kn"])):
        if key not in choices:
            continue
        found = [i for i, l in enumerate(lines) if test(words_of(l))]
        if not found:
            raise Wrong(f"{path} has no line that sets {key}")
        for i in found:
            w = words_of(lines[i])
            if key == "timestep":
                w[1] = choices[key]
            else:
                first = 7 if w[5] == "peratomtypepair" else 6
                w[first:] = [choices[key]] * (len(w) - first)
            lines[i] = [" ".join(w)]
    return "\n".join("\n".join(inserted.get(i, []) + l) for i, l in enumerate(lines))


class Study:
    """The runs that a study asks for."""

    def __init__(self, study):
        self.folder = study["folder"]
        self.title = study.get("title", os.path.basename(os.path.abspath(self.folder)))
        self.path = study["script"]
        try:
            with open(self.path) as f:
                self.script = f.read()
        except OSError as e:
            raise Wrong(f"the script {self.path} cannot be read ({e.strerror})")
        self.variables = script_variables(self.script)
        self.options = [str(o) for o in study.get("options", [])]
        self.timeout = study.get("timeout", 600)
        self.values = dict(study.get("values", {}))
        self.fixed = {key_of(k): v for k, v in study.get("fixed", {}).items()}
        self.fixed.setdefault("ranks", study.get("ranks", 1))
        self.absolute = set(study.get("absolute", []))
        self.short = study.get("short", {})
        error = study.get("error")
        self.error = [error] if isinstance(error, str) else error
        self.methods_path = os.path.join(self.folder, study["methods_file"]) if "methods_file" in study else os.path.join(
            HERE, "studies", "methods.toml")
        self.methods = load_toml(self.methods_path)
        product = {key_of(k): v for k, v in study.get("product", {}).items()}
        if "methods" in study:
            product = {"method": list(self.methods) if study["methods"] == "all" else study["methods"], **product}
        for key, values in product.items():
            if not isinstance(values, list) or not values:
                raise Wrong(f"choice {key}: {values!r} was given, a list of values is wanted")
        self.keys = list(product)
        asked = []
        if product:
            asked += [(None, dict(zip(product, combination))) for combination in itertools.product(*product.values())]
        for v in study.get("variant", []):
            if "name" not in v:
                raise Wrong("a [[variant]] of study.toml has no name")
            asked.append((v["name"], {key_of(k): w for k, w in v.items() if k != "name"}))
            self.keys += [k for k in asked[-1][1] if k not in self.keys]
        if not asked:
            raise Wrong("there is nothing to run: give --choice KEY=VALUE,VALUE, or methods, [product] or [[variant]] in study.toml")
        self.module = None
        if os.path.exists(os.path.join(self.folder, "measure.py")):
            spec = importlib.util.spec_from_file_location("measure", os.path.join(self.folder, "measure.py"))
            self.module = importlib.util.module_from_spec(spec)
            for shared in (os.path.join(HERE, "..", "tests", "system"), os.path.join(HERE, "studies"), self.folder):
                sys.path.insert(0, os.path.abspath(shared))
            spec.loader.exec_module(self.module)
        self.runs = [self.run(name, choices) for name, choices in asked]
        names = [r.name for r in self.runs]
        for n in names:
            if names.count(n) > 1:
                raise Wrong(f"two runs have the name '{n}'")
        self.reference = None
        reference = study.get("reference", "exact" if self.module else None)
        if reference is None:
            raise Wrong("no reference: give --reference finest, or the choices of one run (--reference every=1,fine='40 40 80')")
        if isinstance(reference, dict):
            self.reference = self.run("reference", {key_of(k): v for k, v in reference.items()})
        elif reference == "finest":
            self.reference = self.run("reference", {k: self.finest(k, v) for k, v in product.items()})
        elif reference != "exact":
            raise Wrong(f"reference: '{reference}' was given, finest, exact or the choices of a run are wanted")
        elif self.module is None:
            raise Wrong("reference: exact needs a measure.py that knows the right answer")

    def finest(self, key, values):
        """Of a keyword whose direction is known the finest value, else the last one."""
        size = lambda v: math.prod(float(w) for w in text(v).split())
        try:
            if key in SMALLER_IS_FINER:
                return min(values, key=size)
            if key == "fine":
                return max(values, key=size)
        except ValueError:
            pass
        return values[-1]

    def run(self, name, chosen):
        if name is None:
            name = ", ".join(text(v) if k == "method" else f"{k}={text(v)}" for k, v in chosen.items())
        choices = dict(self.fixed)
        for key, value in chosen.items():
            choices[key] = value
        method = choices.get("method")
        if method in self.methods:
            del choices["method"]
            choices.update({key_of(k): v for k, v in self.methods[method].items()})
        elif method is not None and method.split()[0] not in METHODS:
            raise Wrong(f"method '{method}' is not in {self.methods_path}, where there are {'; '.join(self.methods)}; nor one of "
                        f"twogrid's, {', '.join(METHODS)}")
        known = FIX_KEYS | MODIFY_KEYS | OTHER_KEYS
        for key in choices:
            if key not in known and key not in self.variables and key not in self.values:
                raise Wrong(f"choice '{key}' is no keyword of fix twogrid, nor timestep, kn, ranks or method, nor a variable of "
                            f"{self.path} ({', '.join(sorted(self.variables)) or 'it has none'})")
        names = {**self.values, **{k: number(v) for k, v in choices.items() if k not in known}}
        names.update({k: getattr(math, k) for k in ("pi", "sqrt", "floor", "ceil")}, round=round, int=int, min=min, max=max)

        def fill(match):
            try:
                return text(eval(match.group(1), {"__builtins__": {}}, names))
            except Exception as e:
                raise Wrong(f"run '{name}': {{{match.group(1)}}} has no value ({e}); names are {', '.join(self.values) or 'none'}")

        # values first, then what is written from them
        for key in list(names):
            if isinstance(names[key], str) and "{" in names[key]:
                names[key] = number(re.sub(r"\{([^{}]*)\}", fill, names[key]))
        choices = {k: re.sub(r"\{([^{}]*)\}", fill, text(v)) for k, v in choices.items()}
        plain = {k: v for k, v in names.items() if not callable(v) and k != "pi"}
        return Job(self, name, chosen, choices, plain)


class Job:
    """One run: its script, its files, its command line and its folder's name."""

    def __init__(self, study, name, chosen, choices, names):
        self.study, self.name, self.chosen, self.choices = study, name, chosen, choices
        self.ranks = int(choices.get("ranks", 1))
        self.variables = {k: v for k, v in choices.items() if k in study.variables}
        self.script = rewrite(study.script, {k: v for k, v in choices.items() if k not in study.variables}, study.path)
        #: what measure.py sees: values, variables and choices, numbers where they are numbers
        self.all = {**names, **{k: number(v) for k, v in choices.items()}, "method": chosen.get("method", name), "name": name}
        self.table = {k: text(v) for k, v in chosen.items()}

    def files(self):
        """Files beside the script that it names."""
        base = os.path.dirname(os.path.abspath(self.study.path))
        words = {w for l in logical_lines(self.script) for w in words_of(l)}
        return sorted(w for w in words if not os.path.isabs(w) and w not in (".", "..") and os.path.isfile(os.path.join(base, w)))

    def prepare(self, folder):
        """Fills an empty folder; returns the hash of what will run."""
        h = hashlib.sha256()
        base = os.path.dirname(os.path.abspath(self.study.path))
        for w in self.files():
            os.makedirs(os.path.dirname(os.path.join(folder, w)) or ".", exist_ok=True)
            shutil.copy(os.path.join(base, w), os.path.join(folder, w))
        with open(os.path.join(folder, "in.run"), "w") as f:
            f.write(self.script)
        if self.study.module and hasattr(self.study.module, "prepare"):
            self.study.module.prepare(folder, self.all)
        for root, folders, names in sorted(os.walk(folder)):
            folders.sort()
            for n in sorted(names):
                h.update(n.encode())
                with open(os.path.join(root, n), "rb") as f:
                    h.update(f.read())
        h.update(json.dumps([sorted(self.variables.items()), self.ranks, self.study.options]).encode())
        return h

    def command(self, executable):
        words = [os.path.join(HERE, "mpirun.sh"), str(self.ranks), executable, "-in", "in.run", "-log", "log.liggghts"]
        for k, v in self.variables.items():
            words += ["-var", k] + v.split()
        return words + self.study.options


# ---- running ---------------------------------------------------------------------------------------------------------

LIBC = ctypes.CDLL(None)


def end_with_parent():
    """In a child: have the kernel end it should this program be killed (PR_SET_PDEATHSIG), so that no run is left over."""
    LIBC.prctl(1, signal.SIGTERM)


class Child:
    """A process whose CPU time is told by the kernel when it ends, with that of its own children."""

    def __init__(self, command, folder):
        with open(os.path.join(folder, "output.txt"), "w") as out:
            self.process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT,
                                            start_new_session=True, preexec_fn=end_with_parent)
        self.begin, self.late = time.time(), False

    def ended(self):
        """None, or (exit code, CPU s, wall s)."""
        pid, status, use = os.wait4(self.process.pid, os.WNOHANG)
        if pid == 0:
            return None
        self.process.returncode = os.waitstatus_to_exitcode(status)
        return self.process.returncode, use.ru_utime + use.ru_stime, time.time() - self.begin

    def kill(self):
        """mpirun first by a plain signal, so that it ends its ranks."""
        for s in (signal.SIGTERM, signal.SIGKILL):
            try:
                os.killpg(self.process.pid, s)
            except ProcessLookupError:
                return
            for _ in range(50):
                time.sleep(0.05)
                if self.process.returncode is not None or self.ended() is not None:
                    return


def version(executable):
    with open(executable, "rb") as f:
        return hashlib.sha256(f.read()).hexdigest()[:12]


def free_cores():
    cores = len(os.sched_getaffinity(0))
    return max(1, cores - round(os.getloadavg()[0]))


def reason_of(folder):
    """Why a run ended badly: its own sentence."""
    try:
        with open(os.path.join(folder, "output.txt"), errors="replace") as f:
            lines = f.read().split("\n")
    except OSError:
        return "no output"
    found = [l for l in lines if l.startswith("ERROR")]
    return (found or [l for l in lines if l.strip()] or ["no output"])[0 if found else -1].strip()[:200]


def startup_cost(executable, scratch, cache, ranks):
    """CPU of a run that does nothing: taken off every run, so that short ones can be compared."""
    if str(ranks) not in cache:
        folder = os.path.join(scratch, "empty")
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, "in.run"), "w") as f:
            f.write("units si\n")
        costs = []
        for _ in range(3):
            child = Child([os.path.join(HERE, "mpirun.sh"), str(ranks), executable, "-in", "in.run", "-log", "none"], folder)
            while (end := child.ended()) is None:
                time.sleep(0.02)
            costs.append(end[1])
        cache[str(ranks)] = sorted(costs)[1]
    return cache[str(ranks)]


def execute(jobs, executable, out, cores, again=False, say=print):
    """Runs what has not been run; gives each job its folder and record. A record says code, cpu, wall, late."""
    runs = os.path.join(out, "runs")
    os.makedirs(runs, exist_ok=True)
    program = version(executable)
    startup_file = os.path.join(out, f"startup_{program}.json")
    startup = json.load(open(startup_file)) if os.path.exists(startup_file) else {}
    waiting = []
    for job in jobs:
        new = os.path.join(runs, f".new_{os.getpid()}")
        shutil.rmtree(new, ignore_errors=True)
        os.makedirs(new)
        h = job.prepare(new)
        h.update(program.encode())
        job.folder = os.path.join(runs, h.hexdigest()[:16])
        record = os.path.join(job.folder, "done.json")
        if os.path.exists(record) and (not again or json.load(open(record))["code"] == 0):
            shutil.rmtree(new)
        elif any(w.folder == job.folder for w in waiting):
            shutil.rmtree(new)
        else:
            shutil.rmtree(job.folder, ignore_errors=True)
            os.rename(new, job.folder)
            waiting.append(job)
    for ranks in sorted({j.ranks for j in waiting}):
        startup_cost(executable, out, startup, ranks)
    with open(startup_file, "w") as f:
        json.dump(startup, f)
    total, done, spent, running = len(waiting), 0, 0.0, []
    say(f"{len(jobs)} runs, {total} of them to do (others finished before, or are alike); on {cores} core{'s' * (cores > 1)}")
    begin = time.time()
    try:
        while waiting or running:
            busy = sum(min(j.ranks, cores) for j, _ in running)
            while waiting and (not running or busy + waiting[0].ranks <= cores):
                job = waiting.pop(0)
                running.append((job, Child(job.command(executable), job.folder)))
                busy += job.ranks
            time.sleep(0.02)
            for job, child in list(running):
                end = child.ended()
                if end is None and not child.late and time.time() - child.begin > job.study.timeout:
                    child.kill()
                    end, child.late = (-1, float("nan"), time.time() - child.begin), True
                if end is None:
                    continue
                running.remove((job, child))
                code, cpu, wall = end
                record = dict(name=job.name, code=code, late=child.late, wall=wall, cpu=cpu - startup[str(job.ranks)] if code == 0 else cpu,
                              choices=job.choices)
                with open(os.path.join(job.folder, "done.part"), "w") as f:
                    json.dump(record, f)
                os.rename(os.path.join(job.folder, "done.part"), os.path.join(job.folder, "done.json"))
                done += 1
                left = (time.time() - begin) / done * (total - done)
                state = f"cpu {record['cpu']:.2f} s, wall {wall:.2f} s" if code == 0 else (
                    f"stopped after {wall:.0f} s: timeout" if child.late else f"failed: {reason_of(job.folder)}")
                say(f"[{done}/{total}] {job.name}: {state}; {left / 60:.1f} min left")
    except BaseException:
        for _, child in running:
            child.kill()
        raise
    for job in jobs:
        job.record = json.load(open(os.path.join(job.folder, "done.json")))


# ---- measuring -------------------------------------------------------------------------------------------------------

def onto(nodes, common, field):
    """Means of a cell-wise constant field [nz][ny][nx] over the cells of a common grid, exact overlaps."""
    import numpy as np
    for axis, (a, b) in enumerate(zip(nodes, common)):
        low = np.maximum(a[None, :-1], b[:-1, None])
        high = np.minimum(a[None, 1:], b[1:, None])
        weight = np.clip(high - low, 0, None) / np.diff(b)[:, None]
        at = 2 - axis
        field = np.moveaxis(np.tensordot(weight, np.moveaxis(field, at, 0), 1), 0, at)
    return field


def read_means(folder):
    """What the generic measure takes from the one output file with means: nodes, fields, batches of fields."""
    import glob
    import h5py
    import numpy as np
    for path in sorted(glob.glob(os.path.join(folder, "**", "*.h5"), recursive=True)):
        with h5py.File(path) as f:
            if "average/particle_grid" not in f:
                continue
            a = f["average/particle_grid"]
            nodes = [f["particle_grid"][c][:] for c in "xyz"]
            w = a["batch/weight"][:]
            full = w > 0.5 * w.max()
            batch = {k: a["batch/" + k][:][full] for k in ("eps", "p", "gas_velocity", "solids_flux")}
            batch["gas_flux"] = batch["eps"][..., None] * batch["gas_velocity"]
            return nodes, {k: a[k][:] for k in ("eps", "p", "solids_flux", "gas_flux")}, batch
    raise Wrong(f"the run in {folder} wrote no means: the generic measure needs 'fix_modify ID output ... average from T' "
                "in the script, or write a measure.py")


def generic_measure(folder, reference, common):
    """Errors of the time means against the reference run, on a common grid of the coarsest particle cells of the two or more
    runs: void fraction (rms difference over the rms of the solids fraction), flux of solids and of gas (over the rms of
    theirs), pressure drop from the lowest to the highest layer. name_err: standard error of the difference, from batches.
    """
    import numpy as np
    out = {}
    (n1, f1, b1), (n0, f0, b0) = read_means(folder), read_means(reference)
    rms = lambda q: float(np.sqrt(np.mean(np.square(q))))
    squared = lambda b: np.var(b, axis=0, ddof=1) / len(b) if len(b) > 1 else np.full(b.shape[1:], np.nan)

    def components(nodes, field, batch):
        each = [(..., c) for c in range(3)] if field.ndim == 4 else [...]
        return ([onto(nodes, common, field[c]) for c in each],
                [np.array([onto(nodes, common, b[c]) for b in batch]) for c in each])

    for name in ("eps", "solids_flux", "gas_flux"):
        v1, s1 = components(n1, f1[name], b1[name])
        v0, s0 = components(n0, f0[name], b0[name])
        scale = rms(1 - v0[0]) if name == "eps" else math.sqrt(sum(rms(v)**2 for v in v0))
        difference = math.sqrt(sum(rms(p - q)**2 for p, q in zip(v1, v0)))
        noise = math.sqrt(sum(float(np.mean(squared(p) + squared(q))) for p, q in zip(s1, s0)))
        out[name] = difference / scale if scale > 0 else float("nan")
        out[name + "_err"] = noise / scale if scale > 0 else float("nan")
    drop = lambda p: p[..., 0, :, :].mean((-1, -2)) - p[..., -1, :, :].mean((-1, -2))
    p1, p0 = drop(f1["p"]), drop(f0["p"])
    out["pressure_drop"] = abs(p1 / p0 - 1)
    error = lambda b: float(np.sqrt(squared(drop(b["p"]))))
    out["pressure_drop_err"] = math.hypot(error(b1), error(b0)) / abs(p0)
    return out


def measured(study, job, code):
    """measure.py's numbers, kept beside the run."""
    path = os.path.join(job.folder, "measured.json")
    mark = hashlib.sha256((code + json.dumps(job.all, sort_keys=True, default=str)).encode()).hexdigest()
    if os.path.exists(path):
        kept = json.load(open(path))
        if kept["mark"] == mark:
            return kept["numbers"]
    found = study.module.measure(job.folder, job.all)
    numbers = {k: v.tolist() if hasattr(v, "tolist") else v for k, v in found.items()}
    with open(path, "w") as f:
        json.dump(dict(mark=mark, numbers=numbers), f)
    return numbers


def against(value, reference, absolute):
    """Error of a number or an array against the reference's."""
    import numpy as np
    value, reference = np.asarray(value, float), np.asarray(reference, float)
    if value.shape != reference.shape:
        return float("nan")
    scale = 1.0 if absolute else float(np.sqrt(np.mean(reference**2)))
    return float(np.sqrt(np.mean((value - reference)**2))) / scale if scale > 0 else float("nan")


def rows_of(study):
    """One dict a run: name, choices, cost, numbers and errors."""
    import numpy as np
    runs = study.runs + ([study.reference] if study.reference else [])
    if study.reference and study.reference.record["code"] != 0:
        raise Wrong(f"the reference run failed: {reason_of(study.reference.folder)}")
    rows, numbers = [], {}
    good = [j for j in runs if j.record["code"] == 0]
    if study.module:
        code = "".join(open(os.path.join(study.folder, f)).read() for f in sorted(os.listdir(study.folder)) if f.endswith(".py"))
        for job in good:
            numbers[job.name] = measured(study, job, code)
        if study.reference:
            right = numbers[study.reference.name]
            for job in good:
                n = numbers[job.name]
                numbers[job.name] = {}
                for k, v in n.items():
                    if k.endswith("_err") and k[:-4] in n:
                        continue
                    if np.ndim(v) == 0:
                        numbers[job.name]["value_" + k] = v
                    numbers[job.name][k] = against(v, right[k], k in study.absolute)
                    if k + "_err" in n:
                        total = np.hypot(np.asarray(n[k + "_err"], float), np.asarray(right[k + "_err"], float))
                        numbers[job.name][k + "_err"] = against(total + np.asarray(right[k]), right[k], k in study.absolute)
    else:
        steps = [max(np.diff(read_means(j.folder)[0][a]).max() for j in good) for a in range(3)]
        nodes = read_means(study.reference.folder)[0]
        common = [np.linspace(n[0], n[-1], max(1, int((n[-1] - n[0]) / h + 1e-6)) + 1) for n, h in zip(nodes, steps)]
        for job in good:
            numbers[job.name] = generic_measure(job.folder, study.reference.folder, common)
    for job in study.runs:
        if study.reference and job.folder == study.reference.folder:
            continue
        r = job.record
        state = "ok" if r["code"] == 0 else "timeout" if r["late"] else "failed: " + reason_of(job.folder)
        rows.append({"name": job.name, **{k: job.table.get(k, "") for k in study.keys}, "state": state,
                     "cpu_s": max(LEAST_CPU, r["cpu"]), "wall_s": r["wall"], **numbers.get(job.name, {})})
    if not rows:
        raise Wrong("every run is the reference run itself: there is nothing to compare")
    if study.error is None:
        study.error = [k for k in (numbers[good[0].name] if good else {}) if not k.endswith("_err") and not k.startswith("value_")]
    for e in study.error:
        if good and e not in numbers[good[0].name]:
            raise Wrong(f"error '{e}' is not among what was measured: {', '.join(numbers[good[0].name])}")
    return rows


# ---- reporting -------------------------------------------------------------------------------------------------------

def write_table(path, rows, head):
    names = list(dict.fromkeys(k for r in rows for k in r))
    with open(path, "w", newline="") as f:
        f.write("".join(f"# {h}\n" for h in head))
        w = csv.DictWriter(f, names, lineterminator="\n")
        w.writeheader()
        for r in rows:
            w.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in r.items()})


def read_table(path):
    with open(path) as f:
        rows = list(csv.DictReader(line for line in f if not line.startswith("#")))
    return [{k: float(v) if k not in ("name", "method", "state") and re.fullmatch(r"[-+0-9.eE]+|nan|inf", v or "x") else v
             for k, v in r.items()} for r in rows]


def usable(rows, error):
    return [r for r in rows if r["state"] == "ok" and isinstance(r.get(error), float) and math.isfinite(r[error])]


def noise_of(row, error):
    """Standard error of a row's error, 0 if none was given."""
    value = row.get(error + "_err")
    return value if isinstance(value, float) and math.isfinite(value) else 0.0


def front_of(rows, error):
    """Runs that no other beats in both, cheapest first."""
    best, out = math.inf, []
    for r in sorted(usable(rows, error), key=lambda r: (r["cpu_s"], r[error])):
        if r[error] < best:
            best = r[error]
            out.append(r)
    return out


def beaten(r, rows, error):
    """Another run is clearly cheaper and clearly more accurate, or no dearer and half again as accurate; beyond the noise."""
    for q in rows:
        noise = math.hypot(noise_of(q, error), noise_of(r, error))
        cheaper, no_dearer = q["cpu_s"] < 0.9 * r["cpu_s"] - LEAST_CPU, q["cpu_s"] < 1.1 * r["cpu_s"] + 0.5 * LEAST_CPU
        if cheaper and q[error] < 0.9 * r[error] - noise or no_dearer and q[error] < r[error] / 1.5 - noise:
            return True
    return False


def recommendation(study_title, rows, errors, keys):
    out = [study_title, ""]
    for error in errors:
        good = usable(rows, error)
        out.append(f"Error: {error}; a run counts when its error and its standard error together are below")
        for level in LEVELS:
            enough = [r for r in good if r[error] + noise_of(r, error) <= level]
            if enough:
                r = min(enough, key=lambda r: (r["cpu_s"], r[error]))
                noise = f" +- {100 * noise_of(r, error):.2g} %" if noise_of(r, error) else ""
                out.append(f"  {100 * level:3.0f} %: {r['name']} ({100 * r[error]:.2g} %{noise}; {r['cpu_s']:.2g} s of CPU)")
            elif good:
                r = min(good, key=lambda r: r[error])
                out.append(f"  {100 * level:3.0f} %: none; the nearest is {r['name']} ({100 * r[error]:.2g} %, {r['cpu_s']:.2g} s)")
        never = []
        for key in keys:
            values = list(dict.fromkeys(r[key] for r in good if r.get(key) not in (None, "")))
            for v in values if len(values) > 1 else []:
                if all(beaten(r, good, error) for r in good if r.get(key) == v):
                    never.append(f"{'' if key == 'method' else key + ' '}{v}")
        out.append("  never pays (another run is no dearer and more accurate): " + ("; ".join(never) or "nothing"))
        out.append("")
    failed = [r for r in rows if r["state"] != "ok"]
    out += [f"Did not run: {r['name']}: {r['state']}" for r in failed]
    return "\n".join(out).rstrip() + "\n"


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


def compare_short(study, rows, table):
    """Rows of a short sweep against those of table.csv: list of sentences, and whether all agree."""
    agree = study.short.get("agree", {})
    if not agree:
        raise Wrong("study.toml: [short.agree] is missing, so that --short has nothing to compare")
    if not os.path.exists(table):
        raise Wrong(f"{table} is not there: run the whole study first")
    kept = {r["name"]: r for r in read_table(table)}
    out, good = [], True
    for r in rows:
        if r["name"] not in kept:
            out.append(f"FAIL {r['name']}: not in {table}")
            good = False
            continue
        for key, (absolute, relative) in agree.items():
            was, now = kept[r["name"]].get(key), r.get(key)
            if not isinstance(was, float) or not isinstance(now, float):
                out.append(f"FAIL {r['name']}: {key} is {now}, table.csv has {was}")
                good = False
                continue
            bound = absolute + relative * abs(was)
            fine = abs(now - was) <= bound
            good = good and fine
            out.append(f"{'ok  ' if fine else 'FAIL'} {r['name']}: {key} {now:.4g}, table.csv {was:.4g} (wanted within {bound:.2g})")
    return out, good


# ---- the command line ------------------------------------------------------------------------------------------------

def split_choice(words):
    """KEY=VALUE,VALUE -> key, values."""
    key, sign, values = words.partition("=")
    if not sign or not key or not values:
        raise Wrong(f"--choice '{words}': KEY=VALUE,VALUE is wanted, such as deposit=centroid,trilinear")
    return key_of(key.strip()), [number(v.strip()) for v in values.split(",")]


def study_from_script(options):
    study = dict(script=options.target, folder=options.out or os.path.join(os.path.dirname(os.path.abspath(options.target)), "sweep"))
    product = {}
    for c in options.choice:
        key, values = split_choice(c)
        if key == "method":  # their names hold commas
            known = load_toml(os.path.join(HERE, "studies", "methods.toml"))
            listed = c.partition("=")[2]
            values = list(known) if listed == "all" else [m for m in listed.split(";")]
        product[key] = values
    study["product"] = product
    study["fixed"] = {k: v[0] for k, v in map(split_choice, options.fixed)}
    study["values"] = {k: v[0] for k, v in map(split_choice, options.value)}
    study["timeout"] = options.timeout
    if options.ranks:
        study["ranks"] = options.ranks
    if options.reference and options.reference != "finest":
        parts = re.findall(r"([^=,]+)=([^=]*?)(?=,[^=,]+=|$)", options.reference)
        if not parts:
            raise Wrong(f"--reference '{options.reference}': finest, or KEY=VALUE,KEY=VALUE is wanted")
        study["reference"] = {key_of(k.strip()): number(v.strip()) for k, v in parts}
    elif options.reference:
        study["reference"] = "finest"
    os.makedirs(study["folder"], exist_ok=True)
    return study


def find_executable(given):
    for path in [given] if given else [os.environ.get("TWOGRID"), os.path.join(HERE, "..", "build", "twogrid")]:
        if path and os.access(path, os.X_OK) and os.path.isfile(path):
            return os.path.abspath(path)
    raise Wrong(f"the executable {given or 'build/twogrid'} is not there: build it (cases/build.sh) or give --executable PATH")


def parse():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0], epilog="More: the text at the top of this file.")
    parser.add_argument("target", help="a study's folder, or a case script")
    parser.add_argument("--choice", action="append", default=[], metavar="KEY=V,V", help="what to vary (script only)")
    parser.add_argument("--fixed", action="append", default=[], metavar="KEY=V", help="what to set in all runs (script only)")
    parser.add_argument("--value", action="append", default=[], metavar="NAME=V", help="for {expressions}, such as d=1e-3")
    parser.add_argument("--reference", metavar="R", help="finest, or KEY=VALUE,...: the run the others are compared with")
    parser.add_argument("--executable", help="default: $TWOGRID, or build/twogrid")
    parser.add_argument("--ranks", type=int)
    parser.add_argument("--timeout", type=float, default=3600, help="s a run (script only)")
    parser.add_argument("-j", type=int, default=0, metavar="N", help="cores to use; default: those that are free")
    parser.add_argument("--out", help="folder of table, picture and text; default: the study's, or sweep/ beside the script")
    parser.add_argument("--short", action="store_true", help="the few runs of [short], compared with table.csv; writes nothing else")
    parser.add_argument("--again", action="store_true", help="run failed ones once more")
    return parser.parse_args()


def main():
    options = parse()
    if os.path.isdir(options.target):
        if options.choice or options.fixed or options.reference or options.ranks:
            raise Wrong("--choice, --fixed, --reference and --ranks are for a case script; a study says them in study.toml")
        study = Study(load_study(options.target))
    elif os.path.isfile(options.target):
        study = Study(study_from_script(options))
    else:
        raise Wrong(f"{options.target} is neither a study's folder nor a script")
    executable = find_executable(options.executable)
    results = options.out or study.folder
    os.makedirs(results, exist_ok=True)
    if options.short:
        patterns = study.short.get("runs") or []
        study.runs = [r for r in study.runs if any(fnmatch.fnmatchcase(r.name, p) for p in patterns)]
        if not study.runs:
            raise Wrong("study.toml: [short] runs = [...] matches no run")
    jobs = study.runs + ([study.reference] if study.reference else [])
    print(f"{study.title}", flush=True)
    execute(jobs, executable, os.path.join(results, "out"), options.j or free_cores(), options.again,
            lambda line: print(line, flush=True))
    rows = rows_of(study)
    if options.short:
        lines, good = compare_short(study, rows, os.path.join(study.folder, "table.csv"))
        print("\n".join(lines))
        return 0 if good else 1
    head = [study.title, f"executable {version(executable)}; cpu_s: user and system time of the run less that of an empty script"]
    write_table(os.path.join(results, "table.csv"), rows, head)
    said = recommendation(study.title, rows, study.error, study.keys)
    if study.module and hasattr(study.module, "conclude"):
        said += "\n" + study.module.conclude(rows).rstrip() + "\n"
    with open(os.path.join(results, "recommendation.txt"), "w") as f:
        f.write(said)
    draw(os.path.join(results, "error_cost.png"), study.title, rows, study.error, study.keys)
    print("\n" + said + f"\nwritten: table.csv, recommendation.txt, error_cost.png in {results}")
    return 0


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        sys.exit(main())
    except Wrong as e:
        sys.exit(f"sweep.py: {e}")
    except KeyboardInterrupt:
        sys.exit("interrupted; the same command goes on where it was")
