#!/usr/bin/python3
"""One HTML page of a run, with all its pictures in it:   cases/report.py FOLDER [--out FILE.html]

FOLDER is where a run of twogrid has written; a log alone will do, and a run that is still going on: what is missing is said, with what gives it.
The page needs no network and no script, and reads on a phone. FILE: FOLDER/report.html without --out.
"""
import argparse
import os
import sys
import traceback

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from report_tools import page, sections  # noqa: E402
from report_tools.run_folder import RunFolder  # noqa: E402

SECTIONS = (("head", "", sections.head), ("verdict", "Verdict", sections.verdict), ("movie", "Grains and fluid", sections.film), ("setup", "Set-up and grids", sections.setup),
            ("compared", "Comparison", sections.compared), ("fields", "Mean fields", sections.fields), ("profiles", "Profiles", sections.profiles),
            ("pressure", "Pressure", sections.pressure), ("ledger", "Ledger", sections.ledger), ("cost", "Cost", sections.cost),
            ("not-modelled", "What was not modelled", sections.not_modelled), ("scene", "Scene report", sections.scene), ("origin", "What made this", sections.origin))


def report(run):
    """The page, and what could not be drawn."""
    parts, failed = [], []
    for name, heading, section in SECTIONS:
        try:
            text = section(run)
        except Exception as error:  # a damaged file must not take the rest of the page with it
            failed.append(f"{heading or name}: {type(error).__name__}: {error}")
            if os.environ.get("TWOGRID_REPORT_TRACE"):
                traceback.print_exc()
            text = f'<p class="failed">This could not be drawn: {page.escape(failed[-1])}</p>'
        parts.append((name, heading, text))
    return page.whole(f"{run.title()}: report", parts), failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--out")
    o = parser.parse_args()
    if not os.path.isdir(o.folder):
        sys.exit(f"report: {o.folder} is no folder; wanted: one that a run of twogrid has written into")
    run = RunFolder(o.folder)
    if not run.log_name and not run.output:
        sys.exit(f"report: neither a log nor an output file of twogrid in {run.folder}" + "".join(f"; {p}" for p in run.problems))
    text, failed = report(run)
    path = os.path.abspath(o.out or os.path.join(run.folder, "report.html"))
    try:
        with open(path, "w", encoding="utf-8") as f:
            f.write(text)
    except OSError as error:
        sys.exit(f"report: {path} can't be written ({error.strerror}); --out FILE.html puts the page elsewhere")
    for line in failed:
        print(f"report: could not be drawn: {line}", file=sys.stderr)
    print(f"report: {path}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
