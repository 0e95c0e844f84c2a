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
measure.py, beside it, if the generic measure (see generic_measure in sweep_tools/errors.py) is not what is wanted
    measure(folder, choices) -> {name: number or array}; name_err is the standard error of name. With reference "exact"
                these are the errors. Else the error of name is |value - reference| / |reference| (arrays: root mean
                squares; a name in `absolute = [...]` of study.toml is not divided).
    prepare(folder, choices)        optional: writes files that the script needs
    conclude(rows)                  optional: text that is added to recommendation.txt
It may import what lies in cases/studies and tests/system (harness.py reads dumps and thermo tables).
"""
import argparse
import fnmatch
import os
import re
import signal
import subprocess
import sys

from installed import INSTALLED
from sweep_tools.errors import rows_of
from sweep_tools.keywords import CASES, Wrong, key_of, number
from sweep_tools.picture import draw
from sweep_tools.runs import execute, free_cores, version
from sweep_tools.studies import Study, load_study, load_toml
from sweep_tools.tables import compare_short, recommendation, write_table


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
            known = load_toml(os.path.join(CASES, "studies", "methods.toml"))
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
    environment = {**os.environ, "TWOGRID": given} if given else None
    found = subprocess.run(["sh", "-c", 'cases=$1; . "$cases"/program.sh; find_program && echo "$program"', "sh", CASES], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                           text=True, env=environment)
    if found.returncode:
        raise Wrong(f"{found.stderr.strip()}; --executable PATH does, too")
    return found.stdout.strip()


def results_folder(study, out):
    """--out; else the study's own folder, or ./out/studies/NAME for a study of an installation, which all users share."""
    if out or not INSTALLED or not os.path.realpath(study.folder).startswith(os.path.realpath(CASES) + os.sep):
        return out or study.folder
    return os.path.join("out", "studies", os.path.basename(os.path.abspath(study.folder)))


def parse():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0], epilog="More: the text at the top of this file.")
    parser.add_argument("target", help="a study's folder, or a case script")
    parser.add_argument("--choice", action="append", default=[], metavar="KEY=V,V", help="what to vary (script only)")
    parser.add_argument("--fixed", action="append", default=[], metavar="KEY=V", help="what to set in all runs (script only)")
    parser.add_argument("--value", action="append", default=[], metavar="NAME=V", help="for {expressions}, such as d=1e-3")
    parser.add_argument("--reference", metavar="R", help="finest, or KEY=VALUE,...: the run the others are compared with")
    parser.add_argument("--executable", help="default: $TWOGRID, the installed program, or build/twogrid")
    parser.add_argument("--ranks", type=int)
    parser.add_argument("--timeout", type=float, default=3600, help="s a run (script only)")
    parser.add_argument("-j", type=int, default=0, metavar="N", help="cores to use; default: those that are free")
    parser.add_argument("--out", help="folder of table, picture and text; default: the study's (./out/studies/NAME if installed), or sweep/ beside the script")
    parser.add_argument("--short", action="store_true", help="the few runs of [short], compared with table.csv; writes nothing else")
    parser.add_argument("--count", action="store_true", help="say how many runs there are, and make none")
    parser.add_argument("--index", type=int, metavar="I", help="make run number I only (1, 2, ...), for job arrays; no table is written")
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
    jobs = study.runs + ([study.reference] if study.reference else [])
    if options.count:
        print(len(jobs))
        return 0
    executable = find_executable(options.executable)
    results = results_folder(study, options.out)
    os.makedirs(results, exist_ok=True)
    if options.short:
        patterns = study.short.get("runs") or []
        study.runs = [r for r in study.runs if any(fnmatch.fnmatchcase(r.name, p) for p in patterns)]
        if not study.runs:
            raise Wrong("study.toml: [short] runs = [...] matches no run")
        jobs = study.runs + ([study.reference] if study.reference else [])
    if options.index is not None:
        if not 1 <= options.index <= len(jobs):
            raise Wrong(f"--index {options.index}: 1 to {len(jobs)} are there")
        jobs = jobs[options.index - 1:options.index]
    if study.reference and not study.module and not re.search(r"\baverage\b|^\s*include\b", study.script, re.M):
        raise Wrong("the script has no means to compare: it wants 'fix_modify ID output ... average from T', or the study a measure.py")
    print(f"{study.title}", flush=True)
    execute(jobs, executable, os.path.join(results, "out"), options.j or free_cores(), options.again,
            lambda line: print(line, flush=True))
    if options.index is not None:
        return 0 if jobs[0].record["code"] == 0 else 1
    rows = rows_of(study)
    if options.short:
        lines, good = compare_short(study, rows, os.path.join(study.folder, "table.csv"))
        print("\n".join(lines))
        return 0 if good else 1
    reference = ", ".join(f"{k} {v}" for k, v in study.reference.table.items() if v != "") if study.reference else ""
    head = [study.title, *([f"compared with the run of {reference}"] if reference else []), f"executable {version(executable)}; cpu_s: user and system time of the run less that of an empty script"]
    write_table(os.path.join(results, "table.csv"), rows, head)
    said = recommendation(study.title, rows, study.error, study.keys, reference)
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
