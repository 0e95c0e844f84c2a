"""A study: what study.toml, or the command line, asks for, and the runs that follow from it."""
import hashlib
import importlib.util
import itertools
import json
import math
import os
import re
import shutil
import sys
import tomllib

from .keywords import CASES, FIX_KEYS, METHODS, MODIFY_KEYS, OTHER_KEYS, Wrong, key_of, number, text
from .scripts import logical_lines, rewrite, script_variables, words_of

STUDY_KEYS = {"script", "title", "ranks", "options", "timeout", "error", "methods", "methods_file", "fixed", "values", "product",
              "variant", "reference", "short", "absolute"}
SMALLER_IS_FINER = {"ratio", "every", "timestep", "dt", "cfl", "tolerance"}


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
            CASES, "studies", "methods.toml")
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
            for shared in (os.path.join(CASES, "..", "tests", "system"), os.path.join(CASES, "studies"), self.folder):
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
        words = [os.path.join(CASES, "mpirun.sh"), str(self.ranks), executable, "-in", "in.run", "-log", "log.liggghts"]
        for k, v in self.variables.items():
            words += ["-var", k] + v.split()
        return words + self.study.options
