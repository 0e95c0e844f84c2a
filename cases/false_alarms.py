#!/usr/bin/python3
"""How often a case's verdict would say FAIL by chance: the same case with many fillings, and how far each check stays from its bounds.

    cases/false_alarms.py CASE [--fillings 30] [--short|--long] [--ranks N] [--out FOLDER] [--compare] [--save] [-var NAME VALUE ...]

Runs by ./run what FOLDER (CASE/out/false_alarms...) hasn't got yet, one filling (-var seed, a prime) after the other, compares each, and prints a table, a row for each
figure that a check hangs on. --save writes the rows to false_alarms.csv beside this script, in place of older ones of that case and mode. --compare runs nothing.

    distance   mean distance to the nearer bound in standard deviations of the fillings; of errors, which are 0 at best, of their logarithms
    rate       upper limit (95 % sure, from so many fillings) of how often the bound is passed, if figures scatter like a normal distribution
    any        the same if they scatter in any way that has one peak (Vysochanskij and Petunin)
    largest    how near the nearest filling came, in standard deviations from the mean; 2.0 +- 0.4 of 30 normal ones: much more means that 'rate' is not to be trusted

30 fillings that all pass say by themselves only that less than one in ten fails. Exit code: 0 if every filling passed and no check's rate is above 1 in 1000.
"""
import csv
import json
import math
import os
import re
import statistics
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
WANTED = 1e-3
COLUMNS = "case mode check fillings failed least most mean scatter distance largest rate any program date".split()


def primes(first, count):
    """So many primes from `first` on, itself one: each about 10^4 on from the one before."""
    found, n = [], first
    while len(found) < count:
        while any(n % q == 0 for q in range(2, math.isqrt(n) + 1)):
            n += 1
        found.append(n)
        n += 10007
    return found


def tail(k):
    """Of the normal distribution, beyond k standard deviations."""
    return 0.5 * math.erfc(k / math.sqrt(2))


def surely(k, n):
    """Lower limit, 95 % sure, of a distance of k standard deviations that n values gave."""
    return k - 1.645 * math.sqrt(1 / n + k * k / (2 * (n - 1)))


def away(found, bound, log, sign):
    """Distances of the figures to a bound, positive inside."""
    if log:
        return [math.log10(b / f) for f, b in zip(found, bound)]
    return [sign * (b - f) for f, b in zip(found, bound)]


def row_of(text, name, figures, failed):
    """A row of the table from (least, found, most) of all fillings."""
    least, found, most = zip(*figures)
    n, middle = len(found), statistics.median
    row = {"check": short(text) + (f": {name}" if name else ""), "fillings": n, "failed": failed, "least": middle(least), "most": middle(most), "mean": statistics.fmean(found),
           "scatter": statistics.stdev(found) if n > 1 else math.nan}
    if not all(map(math.isfinite, found)):
        return {**row, "distance": math.nan, "largest": math.nan, "rate": 1.0, "any": 1.0}
    error = all(b == 0 for b in least) and all(math.isfinite(b) and b > 0 for b in most) and all(f >= 0 for f in found)
    if error and max(found) == 0:
        return {**row, "distance": math.inf, "largest": 0.0, "rate": 0.0, "any": 0.0}
    if error:
        smallest = min(f for f in found if f > 0)
        sides = [away([max(f, smallest) for f in found], most, True, 1)]
    else:
        sides = [away(found, b, False, sign) for b, sign in ((least, -1), (most, 1)) if all(map(math.isfinite, b))]
    rate = any_rate = 0.0
    nearest, largest = math.inf, 0.0
    for side in sides:
        mean, scatter = statistics.fmean(side), statistics.stdev(side) if n > 1 else math.nan
        if scatter == 0:
            k = math.inf if mean > 0 else -math.inf
        else:
            k = mean / scatter
        if k < nearest:
            nearest, largest = k, (mean - min(side)) / scatter if scatter > 0 else 0.0
        sure = surely(k, n) if math.isfinite(k) else k
        rate += tail(sure)
        any_rate += 4 / (9 * (1 + sure**2)) if sure > math.sqrt(5 / 3) else 1.0
    return {**row, "distance": nearest, "largest": largest, "rate": min(rate, 1.0), "any": min(any_rate, 1.0)}


def short(text):
    """What a check is, without its figures."""
    words = re.split(r"[:(]| (?=[-+]?\d)", text)[0].strip(" ,")
    return words if len(words) > 12 else re.sub(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", "#", text)[:60]


def gather(runs):
    """Rows of all checks of the fillings, in their order. Checks that one filling has and another hasn't are told apart by their text."""
    rows, seen = [], {}
    for checks in runs:
        count = {}
        for check in checks:
            key = re.sub(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", "#", re.split(r"[:(]", check["text"])[0])
            count[key] = count.get(key, 0) + 1
            seen.setdefault((key, count[key]), []).append(check)
    for checks in seen.values():
        failed = sum(not c["good"] for c in checks)
        figures = checks[0]["figures"]
        if not figures:
            rows.append({"check": short(checks[0]["text"]), "fillings": len(checks), "failed": failed})
        for i, (name, *_) in enumerate(figures):
            rows.append(row_of(checks[0]["text"], name, [c["figures"][i][1:] for c in checks if len(c["figures"]) > i], failed))
    return rows


def shown(value):
    if value is None or value == "":
        return ""
    if isinstance(value, (int, str)):
        return str(value)
    return "" if math.isnan(value) else "-" if math.isinf(value) else f"{value:.3g}"


def arguments():
    words, o = sys.argv[1:], {"mode": "", "fillings": 30, "ranks": None, "out": None, "compare": False, "save": False, "var": []}
    if not words or words[0].startswith("-"):
        sys.exit(__doc__)
    o["case"] = words.pop(0)
    while words:
        word = words.pop(0)
        if word in ("--short", "--long"):
            o["mode"] = word
        elif word in ("--compare", "--save"):
            o[word[2:]] = True
        elif word in ("--fillings", "--ranks", "--out") and words:
            o[word[2:]] = words.pop(0)
        elif word == "-var" and len(words) >= 2:
            o["var"] = [word, *words]
            words = []
        else:
            sys.exit(f"false_alarms.py: what is {word}?\n\n{__doc__}")
    o["fillings"] = int(o["fillings"])
    return o


def main():
    o = arguments()
    case = o["case"] if os.path.exists(os.path.join(o["case"], "case.sh")) else os.path.join(HERE, o["case"])
    script = os.path.join(case, "in." + os.path.basename(os.path.abspath(case)))
    if not os.path.exists(script):
        sys.exit(f"false_alarms.py: there is no case {o['case']}")
    with open(script) as f:
        default = re.search(r"^variable\s+seed\s+index\s+(\d+)", f.read(), re.M)
    if not default:
        sys.exit(f"false_alarms.py: {script} has no 'variable seed index PRIME' for its filling")
    out = os.path.abspath(o["out"] or os.path.join(case, "out", "false_alarms" + o["mode"].replace("--", "_") + "".join("_" + w.replace("/", "_") for w in o["var"] if w != "-var")))
    run, runs, ended = [os.path.join(HERE, "run"), case, *([o["mode"]] if o["mode"] else [])], [], True
    made = {"program": set(), "date": set()}
    for seed in primes(int(default.group(1)), o["fillings"]):
        folder = os.path.join(out, f"seed_{seed}")
        os.makedirs(folder, exist_ok=True)
        there = os.path.exists(os.path.join(folder, "finished"))
        if not there and o["compare"]:
            continue
        how = ["--compare", "--out", folder] if there else [*(["--ranks", o["ranks"]] if o["ranks"] else []), "--out", folder, *o["var"], "-var", "seed", str(seed)]
        checks = os.path.join(folder, "checks.json")
        if os.path.exists(checks):
            os.remove(checks)
        with open(os.path.join(out, f"seed_{seed}.txt"), "w") as text:
            subprocess.run(run + how, stdout=text, stderr=subprocess.STDOUT, env={**os.environ, "TWOGRID_CHECKS": checks, "TWOGRID_NO_REPORT": "1", "TWOGRID_NO_PICTURES": "1"})
        if not os.path.exists(checks):
            ended = False
            print(f"filling {seed} did not come to its comparison: {text.name}", flush=True)
            continue
        with open(checks) as f:
            runs.append(json.load(f))
        with open(os.path.join(folder, "status.json")) as f:
            status = json.load(f)
        made["program"].add(status["program"]), made["date"].add(status["date"][:10])
    if len(runs) < 3:
        sys.exit(f"{len(runs)} fillings in {out}: too few")
    rows = gather(runs)
    name, mode = os.path.basename(os.path.abspath(case)), " ".join([o["mode"].strip("-") or "default", *(w for w in o["var"] if w != "-var")])
    print(f"{name}, {mode}: {len(runs)} fillings\n")
    print(f"{'check':62} {'failed':>7} {'least':>9} {'mean':>9} {'most':>9} {'scatter':>9} {'distance':>9} {'largest':>8} {'rate':>9} {'any':>9}")
    for row in rows:
        print(f"{row['check'][:62]:62} {row['failed']:>3}/{row['fillings']:<3} " + " ".join(f"{shown(row.get(c)):>9}" for c in ("least", "mean", "most", "scatter", "distance")) +
              f" {shown(row.get('largest')):>8} {shown(row.get('rate')):>9} {shown(row.get('any')):>9}")
    rates, failed = [row.get("rate", 0) for row in rows], sum(any(not c["good"] for c in checks) for checks in runs)
    print(f"\n{failed} of {len(runs)} fillings fail; largest rate {max(rates):.2g} (wanted: {WANTED:g}), all together {sum(rates):.2g}")
    if o["save"]:
        path, old = os.path.join(HERE, "false_alarms.csv"), []
        if os.path.exists(path):
            with open(path) as f:
                old = [r for r in csv.DictReader(f) if (r["case"], r["mode"]) != (name, mode)]
        with open(path, "w", newline="") as f:
            table = csv.DictWriter(f, COLUMNS, restval="", lineterminator="\n")
            table.writeheader()
            table.writerows(sorted(old + [{"case": name, "mode": mode, **{k: shown(v) for k, v in row.items()}, **{k: " ".join(sorted(v)) for k, v in made.items()}} for row in rows], key=lambda r: (r["case"], r["mode"])))
        print(path)
    sys.exit(0 if ended and not failed and max(rates) < WANTED else 1)


if __name__ == "__main__":
    main()
