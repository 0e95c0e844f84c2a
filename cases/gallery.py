#!/usr/bin/python3
"""One HTML page of all cases: what each is, grains and gas in motion, the curve against its reference, verdict, cost.

    cases/gallery.py [--run short|run|long] [--out FILE.html] [FOLDER ...]

FOLDER: cases of your own elsewhere. --run: runs every case first, in that mode, with all that cases/run does; without it the page shows of each case the last run
that came to its end, the longest mode first (run_long, run, job_..., run_short where cases/run puts them). FILE: cases/out/gallery.html without --out, ./out/gallery.html
if twogrid is installed. The page has its pictures in it; links to the reports lead to where they lie.
"""
import argparse
import os
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from installed import CASES, INSTALLED  # noqa: E402
from report_tools import movie, page, sections  # noqa: E402
from report_tools.run_folder import RunFolder  # noqa: E402


def facts(folder):
    """title, what, against, time and memory of a case.sh, and the folder of its results."""
    line = 'cases=$1 case=$2; . "$cases"/case_words.sh; printf "%s\\n" "$title" "$what" "$against" "$time_run" "$memory" "$(results_folder)"'
    return subprocess.run(["sh", "-c", line, "sh", CASES, os.path.abspath(folder)], stdout=subprocess.PIPE, text=True, check=True).stdout.split("\n")


def best_run(out):
    """Of the runs that came to their end: the longest mode, then the newest; jobs stand between the usual run and the short one. None: there is none.
    Runs with -var are others than the case."""
    rank = {"run_long": 3, "run": 2, "run_short": 0}
    runs = []
    for name in os.listdir(out) if os.path.isdir(out) else []:
        if name not in rank and not name.startswith("job_"):
            continue
        run = RunFolder(os.path.join(out, name))
        if run.status.get("state") == "finished" and run.verdict:
            runs.append((rank.get(name, 1), os.path.getmtime(run.path("verdict.txt")), run))
    return max(runs, key=lambda r: r[:2])[2] if runs else None


def card(case, base):
    title, what, against, time, memory, out = facts(case)[:6]
    text = f"<p>{page.escape(what[:1].upper() + what[1:])}. Compared with: {page.escape(against)}.</p>"
    run = best_run(out)
    if run is None:
        return title, text + page.missing(f"Not run here: cases/run {os.path.basename(case)}, some {time} of one core, {memory}.")
    status, good, bad = run.status, run.verdict.count("PASS  "), run.verdict.count("FAIL  ")
    text += page.table([], [["run", f"{os.path.basename(run.folder)}, {status.get('time', 0):.3g} s of fluid time, {status.get('date', '')[:10]}, {status.get('program', '')}"],
                            ["cost", f"{status.get('wall_seconds', 0):.0f} s by the clock on {status.get('ranks', '?')} rank(s)"],
                            [("word " + ("fail" if bad else "pass"), "FAIL" if bad else "PASS" if good else "-"), f"{good} of {good + bad} checks passed"]])
    text += "".join(f'<p class="warning">{page.escape(line)}</p>' for line in run.verdict.split("\n") if line.startswith("FAIL  "))
    shown = []
    if run.frames:
        data, size, n, legends, where, _, beside = movie.animate(run.output, run.frames, 20)
        shown.append(page.image(data, "webp", f"{title}: grains and fluid", size[0] / 2, size[1] / 2, f"{movie.in_words(*legends)}; {where}."))
    shown += [sections.curve(c) for c in run.compared] or sections.own_pictures(run)
    text += page.pictures(*shown)
    if os.path.exists(run.path("report.html")):
        text += f'<p><a href="{page.escape(os.path.relpath(run.path("report.html"), base))}">The whole report</a></p>'
    return title, text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*")
    parser.add_argument("--run", choices=("short", "run", "long"))
    parser.add_argument("--out", default=os.path.join("." if INSTALLED else CASES, "out", "gallery.html"))
    o = parser.parse_args()
    cases = sorted(os.path.join(CASES, n) for n in os.listdir(CASES) if os.path.exists(os.path.join(CASES, n, "case.sh"))) + [os.path.abspath(f) for f in o.folders]
    for case in cases:
        if not os.path.exists(os.path.join(case, "case.sh")):
            sys.exit(f"gallery: {case} is no case: it has no case.sh")
        if o.run:
            # A check that fails, or a mode that a case doesn't have, is no reason to leave out the others.
            subprocess.run([os.path.join(CASES, "run"), case, *([] if o.run == "run" else ["--" + o.run])], check=False)
    base = os.path.dirname(os.path.abspath(o.out))
    parts = [("top", "", "<h1>twogrid: the cases</h1><p>Each as it was last run here. How to run one: <code>cases/run NAME</code>; what each costs: <code>cases/list</code>.</p>")]
    for case in cases:
        title, text = card(case, base)
        parts.append((os.path.basename(case), title[:1].upper() + title[1:], text))
    os.makedirs(base, exist_ok=True)
    with open(o.out, "w", encoding="utf-8") as f:
        f.write(page.whole("twogrid: the cases", parts))
    print(f"gallery: {os.path.abspath(o.out)}")


if __name__ == "__main__":
    main()
