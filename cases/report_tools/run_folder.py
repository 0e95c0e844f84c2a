"""What a run has left in its folder: log, status.json, output file, tables of fix ave/time, the comparison's verdict. Any of it may lack."""
import functools
import glob
import json
import os
import re

import h5py
import numpy as np

import leg_tables
from . import run_log


def text_of(path):
    try:
        with open(path, errors="replace") as f:
            return f.read()
    except OSError:
        return ""


def is_log(path):
    return "LIGGGHTS (Version" in text_of(path)[:2000]


class RunFolder:
    def __init__(self, folder):
        self.folder = os.path.abspath(folder)
        self.problems = []  # what is there and can't be read, or isn't of one run
        self.output_name, self.output = self.open_output()
        self.log_name = self.find_log()
        self.legs = self.find_legs()
        self.log = "\n".join(self.legs)
        self.goes_on = "twogrid: goes on from the checkpoint" in self.log
        self.status = self.find_status()
        self.same_run()
        self.without_fluid = bool(self.log) and not re.search(r"^(twogrid: the scene of fix|twogrid: goes on from|fix\s+\S+\s+\S+\s+twogrid\b)", self.log, re.M)
        self.verdict = text_of(self.path("verdict.txt"))
        self.compared = self.read_json("compared.json") or []
        self.scenes = run_log.scenes(self.log)
        self.scene = self.scenes[-1] if self.scenes else None
        self.frames = sorted(self.output["fluid"]) if self.output and "fluid" in self.output else []
        self.fix = self.scene["fix"] if self.scene else "gas"

    # ---- files ----------------------------------------------------------------------------------------------------------

    def path(self, name):
        return os.path.join(self.folder, name)

    def names(self, pattern):
        return [os.path.basename(p) for p in glob.glob(os.path.join(glob.escape(self.folder), pattern))]

    def find_log(self):
        """The log that the output file's run wrote; without, log.liggghts, else the newest file that begins as LIGGGHTS' logs do."""
        candidates = {"log.liggghts", *self.names("log.*"), *self.names("*.log")}
        logs = [n for n in candidates if os.path.isfile(self.path(n)) and is_log(self.path(n)) and not re.search(r"\.\d+$", n)]
        named = self.argument("-log", "-l") or "log.liggghts"
        if self.output:
            for name in (named, os.path.basename(named)):
                if os.path.isfile(self.path(name)) and is_log(self.path(name)):
                    return name
        found = max(logs, key=lambda n: (n == "log.liggghts", os.path.getmtime(self.path(n))), default=None)
        if self.output and found:
            self.problems.append(f"The log of the run that wrote {self.output_name}, {named}, is not here: scene, ledger and cost are those of {found}, perhaps of another run.")
        return found

    def find_legs(self):
        """Texts of the logs of all legs, the newest last: each that goes on from a checkpoint has put the one before aside, as NAME.1, NAME.2, ..."""
        texts = [text_of(self.path(self.log_name))] if self.log_name else []
        older = sorted((int(n.rsplit(".", 1)[1]) for n in self.names(glob.escape(self.log_name) + ".*") if re.search(r"\.\d+$", n)), reverse=True) if self.log_name else []
        for number in older:
            if "twogrid: goes on from the checkpoint" not in texts[0]:
                break
            texts.insert(0, text_of(self.path(f"{self.log_name}.{number}")))
        return texts

    def find_status(self):
        """What lies beside the log, named after it as twogrid does; without a log any."""
        if not self.log_name:
            return self.read_json("status.json") or next((s for s in map(self.read_json, sorted(self.names("*.status.json"))) if s), {})
        folder, name = os.path.split(self.log_name)
        stem = re.sub(r"(?<=.)\.log$", "", re.sub(r"^log\.(?=.)", "", name))
        return self.read_json(os.path.join(folder, "status.json" if name == "log.liggghts" else stem + ".status.json")) or {}

    def same_run(self):
        """Says so where the output file was not made while the program ran that the log's status file tells of."""
        made = str(self.leg("date"))
        began, ended = (str(self.status.get(k) or "") for k in ("started", "date"))
        if made and began and (made < began or (self.status.get("state") != "running" and made > ended)):
            self.problems.append(f"{self.output_name} was made or gone on with at {made}, but the program that wrote {self.log_name or 'status.json'} ran from {began} to {ended}: "
                                 "pictures and means are of one run, scene, ledger and cost of another.")

    def read_json(self, name):
        try:
            return json.loads(text_of(self.path(name)))
        except ValueError:
            return None

    def open_output(self):
        """The output file that is newest of those with frames or means."""
        best = (None, None)
        for name in sorted(self.names("*.h5"), key=lambda n: os.path.getmtime(self.path(n))):
            try:
                file = h5py.File(self.path(name), "r")
                if "record" in file and "grid" in file:
                    best = (name, file)
            except OSError as error:
                self.problems.append(f"{name} can't be read: {str(error).split('(')[0].strip() or error}")
        return best

    # ---- the script -------------------------------------------------------------------------------------------------------

    def record(self, key, default=""):
        value = self.output["record"].attrs.get(key, default) if self.output else default
        return value.decode() if isinstance(value, bytes) else value

    def setting(self, key, default=""):
        if not self.output or "settings" not in self.output["record"]:
            return default
        value = self.output["record/settings"].attrs.get(key, default)
        return value.decode() if isinstance(value, bytes) else str(value)

    def leg(self, key):
        """What the newest leg of the output's run has put on record."""
        legs = sorted((int(n[4:]) for n in self.output["record"] if re.fullmatch(r"leg_\d+", n)), reverse=True) if self.output else []
        value = next((self.output[f"record/leg_{n}"].attrs[key] for n in legs if key in self.output[f"record/leg_{n}"].attrs), self.record(key))
        return value.decode() if isinstance(value, bytes) else value

    def argument(self, *switches):
        """What follows a switch of the newest leg's command line, which has no quotes: up to the next switch."""
        match = re.search(rf"\s(?:{'|'.join(switches)})\s+(.+?)(?=\s+-[A-Za-z]|\s*$)", str(self.leg("command_line")))
        return match.group(1) if match else None

    def title(self):
        return os.path.basename(self.argument("-in", "-i") or self.folder)

    def gravity(self):
        """Of the scene report, m/s2; None without."""
        words = next((v for k, v in self.scene["pairs"] if k == "gravity"), "").split()[:3] if self.scene else []
        return np.array(words, dtype=float) if len(words) == 3 and all(re.fullmatch(r"[-+.\deE]+", w) for w in words) else None

    # ---- time -------------------------------------------------------------------------------------------------------------

    @functools.cached_property
    def clock(self):
        """(DEM step, fluid's time in s) in the order of steps: of the frames, else by the log."""
        frames = [self.output["fluid"][n] for n in self.frames] if self.frames else []
        pairs = dict((float(f["step"][()]), float(f["time"][()])) for f in frames if "step" in f and "time" in f)
        if len(pairs) > 1:
            return np.array(sorted(pairs.items()))
        told = np.array(run_log.clock(self.log)).reshape(-1, 2)
        for step, time in pairs.items() if len(told) else ():
            told[:, 1] += time - np.interp(step, *told.T)
        return told

    def time_of(self, step):
        """Fluid time of DEM steps (s), straight between those that are known, and on as in the first and last stretch; None where none are."""
        at = self.clock
        if not len(at):
            return None
        step = np.asarray(step, dtype=float)
        i = np.clip(np.searchsorted(at[:, 0], step) - 1, 0, len(at) - 2)
        (s0, t0), (s1, t1) = at[i].T, at[i + 1].T
        return t0 + (step - s0) * (t1 - t0) / (s1 - s0)

    def means_begin(self):
        """Fluid time from which the means are (s); None without."""
        value = self.output["average"].attrs.get("from") if self.output and "average" in self.output else None
        return None if value is None or not np.isfinite(value) else float(value)

    def averaged(self, step):
        """Rows at these steps that lie in the time of the means, as cases/verdict.py counts: a row stands for the half of its interval before it. All where there are no means."""
        time = self.time_of(step - 0.5 * (step[1] - step[0]))
        begin = self.means_begin()
        return np.ones(len(step), bool) if begin is None or time is None else time > begin

    # ---- tables -----------------------------------------------------------------------------------------------------------

    def tables(self):
        """Tables of fix ave/time in the folder: name, names of the columns, rows."""
        for name in sorted(self.names("*.txt")):
            head = text_of(self.path(name))[:4000].split("\n")
            if not head[0].startswith("# Time-averaged data") or len(head) < 2:
                continue
            try:
                rows = leg_tables.table(self.path(name))
            except (ValueError, OSError):
                continue
            columns = head[1].lstrip("# ").split()
            if rows.ndim == 2 and rows.shape[0] and rows.shape[1] == len(columns):
                yield name, columns, rows

    def thermo(self):
        """LIGGGHTS' table of the last runs with one header: column: values."""
        names, rows = None, []
        for line in self.log.split("\n"):
            words = line.split()
            if words[:1] == ["Step"]:
                names, rows = words, rows if words == names else []
            elif names and len(words) == len(names) and words[0].isdigit():
                try:
                    row = [float(w) for w in words]
                except ValueError:
                    continue
                while rows and rows[-1][0] >= row[0]:  # told again by the next run, or by a leg that has begun before
                    rows.pop()
                rows.append(row)
        return dict(zip(names, np.array(rows).T)) if rows else {}

    def series(self, i):
        """f_ID[i] over the steps, from the table that has most rows of it (of those that the log names, if any), else from LIGGGHTS' table: where from, steps, values; None."""
        best = max(((name, rows[:, 0], rows[:, columns.index(f"f_{self.fix}[{i}]")]) for name, columns, rows in self.tables() if f"f_{self.fix}[{i}]" in columns),
                   key=lambda t: (t[0] in self.log, len(t[1])), default=None)
        if best:
            return best
        thermo = self.thermo()
        for column in (f"{self.fix}[{i}]", f"f_{self.fix}[{i}]"):
            if column in thermo:
                return "LIGGGHTS' table in the log", thermo["Step"], thermo[column]
        return None

    def costs(self):
        """Shares of CPU time of each part, over all runs that the log tells of, and those runs' seconds."""
        parts, total = {}, 0.0
        for duration, shares in re.findall(r"^twogrid: run of (.+?); shares of CPU time: (.+)$", self.log, re.M):
            s = run_log.seconds(duration)
            total += s
            for part, share in re.findall(r"([A-Za-z ]+?) ([\d.]+) %", shares):
                parts[part.strip()] = parts.get(part.strip(), 0.0) + s * float(share)
        return {k: v / total for k, v in parts.items()} if total else {}, total

