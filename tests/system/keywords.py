#!/usr/bin/python3
"""twogrid -keywords, the keyword page's tables, cases/sweep.py and the record in the output file say the same of the keywords.

Without this test a keyword that was added, renamed or given another default would leave a page that is wrong and a sweep
that doesn't know it; the record of a file could lack a setting, or hold the default of one that the script has changed.
"""
import os
import subprocess
import sys

import h5py

from harness import MPIRUN, Checks, Run, arguments, head

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")

SCRIPT = head("0 0.008 0 0.004 0 0.008", 1e-5, boundary="p f f") + """
fix motion all nve/sphere
region fill block 0 0.008 0 0.004 0 0.004
lattice sc 0.002 origin 0.5 0.5 0.5
create_atoms 1 region fill
set group all diameter 0.001 density 1000
variable U equal 0.1+0*step
fix gas all twogrid fine 8 4 8 ratio 2 2 2 stretch z 1.01 density 1.2 viscosity 1.8e-5 every auto
fix_modify gas method paper read kernel 2e-3 formulation A eps bound clip 0.123456789012345 cfl 0.3 model gap friction off
fix_modify gas boundary zlo inlet 0 0 v_U boundary zlo patch jet rect 0 0.002 0 0.002 inlet 0 0 0.5 boundary zhi pressure 0
fix_modify gas output every 10 file bed.h5
run 0
"""
# Not given in the script, or filled in from the box: the values that hold.
SETTINGS = {
    "fine": "8 4 8", "ratio": "2 2 2", "stretch": "z 1.01", "density": "1.2", "viscosity": "1.8e-05", "every": "auto",
    "domain": "0 0.008 0 0.004 0 0.008", "method": "paper", "deposit": "centroid", "prolong": "constant", "read": "kernel 0.002",
    "formulation": "A", "eps bound": "clip 0.123456789012345", "cfl": "0.3", "drag": "ergun/wenyu", "hold": "auto", "one-way": "no",
    "boundary": "xlo periodic; xhi periodic; ylo slip; yhi slip; zlo inlet 0 0 v_U; zlo patch jet rect 0 0.002 0 0.002 inlet 0 0 0.5; "
                "zhi pressure 0",
    "initial u": "0 0 0", "flow_rate": "none", "accuracy": "off", "convection": "vanleer", "gap friction": "off",
    "output": "every 10 file bed.h5 particles yes overwrite no legs one"}
OLD_NAMES = ("program", "version", "commit", "date", "command_line", "ranks", "bricks", "fine", "ratio", "every", "density", "viscosity",
             "drag", "formulation")  # attributes of /record that files have had before


def main():
    executable, ranks = arguments()
    c = Checks("keywords: table, page, sweep, record")
    done = subprocess.run([*MPIRUN, "-np", "2", executable, "-keywords"], stdout=subprocess.PIPE, text=True, timeout=60)
    page = done.stdout.strip().split("\n")
    c.true(f"two ranks print the page once and end with 0: {len(page)} lines", done.returncode == 0 and page.count(page[0]) == 1)
    with open(os.path.join(ROOT, "liggghts_fixes", "script", "README.md")) as f:
        readme = f.read().split("\n")
    rows = [line for line in page if line.startswith("|")]
    missing = [r for r in rows if r not in readme]
    c.true(f"all {len(rows)} lines of its tables stand on the page" + "".join(f"\n     not there: {r}" for r in missing), not missing)

    sys.path.insert(0, os.path.join(ROOT, "cases"))
    from sweep_tools import keywords as tool
    with open(os.path.join(ROOT, "liggghts_fixes", "script", "README.md")) as f:
        tables, told = tool.tables_of(f.read()), tool.tables_of(done.stdout)
    for name in ("fix", "fix_modify", "method"):
        c.true(f"program and page have the same {len(told[name])} rows of {name}, in order, no more", tables[name] == told[name])
    c.true("sweep.py knows them", tool.FIX_KEYS == set(told["fix"]) and tool.METHODS == told["method"] and
           tool.MODIFY_KEYS == set(told["fix_modify"]) - {"boundary", "output", "model"})

    for n in ranks:
        run = Run(executable, SCRIPT, n)
        with h5py.File(run.file("bed.h5")) as f:
            record, settings = dict(f["record"].attrs), {k: v.decode() for k, v in f["record/settings"].attrs.items()}
        wrong = [f"{k} {settings.get(k)}" for k, v in SETTINGS.items() if settings.get(k) != v]
        c.true(f"{n} ranks: settings in the record" + "".join(f"\n     wrong: {w}" for w in wrong), not wrong)
        c.true(f"{n} ranks: all keywords are in it", set(settings) == set(told["fix"] + told["fix_modify"]) - {"model"})
        c.true(f"{n} ranks: the record has the names of before", all(k in record for k in OLD_NAMES))
    c.end()


if __name__ == "__main__":
    main()
