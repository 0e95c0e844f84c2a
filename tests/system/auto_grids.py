#!/usr/bin/python3
"""`fine auto ratio auto every auto`: what is promised of the grids is there in scenes of many kinds, without warnings of the program's own about
them; the same on any number of ranks; kept where a run goes on from a checkpoint, whatever the particles are by then; a run with the same numbers
given has the same bits; what can't be chosen ends in a sentence.

Without this test a jet could have three cells or, drawn by a region between two lines that are looked at, one of twice its area, grains of 4 mm cells of 5, a run that goes on begin on other grids than it ended on, and a jet of
0.1 mm in a box of a metre take all of a machine's memory.
Usage: auto_grids.py EXECUTABLE RANKS...
"""
import os
import re
import shutil
import subprocess
import tempfile

import h5py
import numpy as np

from harness import MPIRUN, Checks, Run, arguments, head, poured, walls

AUTO = "fine auto ratio auto every auto"
SLOT = "0 0.0216 0 0.0048 0 0.036"
SLOT_WALLS = walls(xplane=(0, 0.0216), yplane=(0, 0.0048), zplane=(0,))
JET = """fix_modify gas boundary zlo inlet 0 0 0.4 boundary zhi pressure 0
fix_modify gas boundary zlo patch jet rect 0.0096 0.0120 0 0.0048 inlet 0 0 5.0
"""
OURS = ("void fraction is rough", "takes whole fine faces", "narrowest opening", "fluid crosses", "holds few particle cells", "parts")


def gas(words=AUTO):
    return f"fix gas all twogrid {words} density 1.2 viscosity 1.8e-5\n"


def grains(sizes, box, layers=3, every=1):
    """A loose lattice of the largest size, whose points take the sizes in turn."""
    pitch = 1.01 * max(sizes)
    text = f"lattice sc {pitch!r} origin 0.5 0.5 0.5\nregion grains block {box} units box\ncreate_atoms 1 region grains\n"
    text += f"set group all diameter {sizes[0]!r} density 2500\n"
    for i, d in enumerate(sizes[1:], 1):
        text += f"region r{i} block {box} units box\ngroup g{i} id {i}:100000:{len(sizes) * every}\nset group g{i} diameter {d!r}\n"
    return text


def grids(run):
    """fine, ratio, every as the scene report has them."""
    three = r"(\d+) x (\d+) x (\d+)"
    fine = re.search(r"fine grid +" + three, run.output)
    ratio = re.search(r"particle grid +" + three + r" cells of " + three, run.output)
    every = re.search(r"coupling interval +(\d+) steps", run.output)
    return tuple(map(int, fine.groups())), tuple(map(int, ratio.groups()[3:])), int(every.group(1))


def scene(box, boundary, sizes, more, words=AUTO, fill=None, before=""):
    low = box.split()
    room = fill or " ".join(low)
    return head(box, 1e-5, boundary=boundary, skin=0.3 * min(sizes)) + before + grains(sizes, room) + \
        "fix motion all nve/sphere\nfix weight all gravity 9.81 vector 0 0 -1\n" + gas(words) + more + "run 0\n"


def kinds(c, executable):
    """Box (m), boundary, sizes of grains, lines; then what must hold: patches (direction, width), and widths that want 8 or 4 cells."""
    blow = "fix_modify gas boundary zlo inlet 0 0 0.5 boundary zhi pressure 0\n"
    for name, box, boundary, sizes, more, before, jets, widths in (  # of the pipe: a column inside it
            ("slot", (0.04, 0.005, 0.1), "f f f", [1e-3], blow + "fix_modify gas boundary zlo patch j rect 0.0187 0.0201 0 0.005 inlet 0 0 5\n", "", [(0, 1.4e-3)], []),
            ("periodic box", (0.02, 0.02, 0.02), "p p p", [1e-3], "fix_modify gas flow_rate z 0.3\n", "", [], []),
            ("jet at an odd place", (0.04, 0.03, 0.08), "f f f", [1e-3], blow + "fix_modify gas boundary zlo patch j rect 0.01234 0.01571 0.0077 0.0111 inlet 0 0 5\n", "", [(0, 3.37e-3), (1, 3.4e-3)], []),
            ("jets on two sides", (0.03, 0.006, 0.06), "f f f", [1e-3], "fix_modify gas boundary zlo patch a rect 0.004 0.0065 0 0.006 inlet 0 0 5 boundary xlo patch b rect 0 0.006 0.031 0.0335 inlet 4 0 0 boundary zhi pressure 0\n", "", [(0, 2.5e-3), (2, 2.5e-3)], []),
            ("circles", (0.03, 0.03, 0.06), "f f f", [1e-3], blow + "fix_modify gas boundary zlo patch a circle 0.0101 0.015 0.002 inlet 0 0 5 boundary zlo patch b circle 0.021 0.0127 0.0026 inlet 0 0 5\n", "", [(0, 4e-3), (1, 4e-3)], []),
            ("a region", (0.03, 0.03, 0.06), "f f f", [1e-3], blow + "fix_modify gas boundary zlo patch a region nozzle inlet 0 0 5\n", "region nozzle block 0.013 0.0172 0.012 0.018 INF INF units box\n", [(0, 4.2e-3), (1, 6e-3)], []),
            ("sizes 1:3", (0.04, 0.03, 0.2), "f f f", [3e-3, 1e-3, 1e-3, 1e-3], blow, "", [], []),
            ("a round pipe", (0.04, 0.02, 0.06), "f f f", [1e-3], blow + "fix_modify gas solid pipe region outside\n",
             "region outside cylinder z 0.02 0.01 0.008 INF INF side out units box\n", [], [(0, 0.016, 8), (1, 0.016, 8)]),
            ("a thin tube", (0.02, 0.004, 0.03), "f f f", [1e-3], blow + "fix_modify gas solid rod region rod\n", "region rod cylinder y 0.01 0.0151 0.0004 INF INF units box\n", [], [(0, 0.0008, 8), (2, 0.0008, 8)])):
        text = " ".join(f"0 {x!r}" for x in box)
        fill = "0.015 0.025 0.005 0.015 0 0.04" if name == "a round pipe" else None
        r = Run(executable, scene(text, boundary, sizes, more, before=before, fill=fill or f"0 {box[0]!r} 0 {box[1]!r} 0 {0.6 * box[2]!r}"), launcher=None)
        fine, ratio, every = grids(r)
        told = [w for w in OURS if any("WARNING" in line and w in line for line in r.output.splitlines())]
        across = [width * fine[d] / box[d] for d, width in jets]
        cells = [box[d] / (fine[d] // ratio[d]) for d in range(3) if fine[d] > 1]
        enough = all(a > 4 - 1e-9 for a in across) and all(w * fine[d] / box[d] > n - 1e-6 for d, w, n in widths)
        c.true(f"{name}: {' x '.join(map(str, fine))}, ratio {' x '.join(map(str, ratio))}, every {every}; particle cells of {min(cells) / max(sizes):.2f} of the largest; "
               f"{', '.join(f'{a:.1f}' for a in across) or 'no'} across jets; told: {told or 'nothing'}",
               enough and min(cells) > 2 * max(sizes) * (1 - 1e-9) and not told and "grids                 chosen (auto)" in r.output)


def regions(c, executable):
    """Patches by region: small ones wherever they lie, of the area drawn; what differs from it is warned of, also with given cells."""
    box, low = "0 0.6 0 0.004 0 0.4", "fix_modify gas boundary zlo inlet 0 0 0 boundary zhi pressure 0\n"
    fill = "0.2 0.22 0 0.004 0 0.02"
    for x in (0.3010, 0.3001):
        jet = f"region j block {x!r} {x + 0.0012!r} INF INF INF INF units box\n"
        r = Run(executable, scene(box, "f f f", [1e-3], low + "fix_modify gas boundary zlo patch j region j inlet 0 0 10\n", before=jet, fill=fill), launcher=None)
        fine = grids(r)[0]
        area = re.search(r"patch j .* ([\d.e-]+) m2 of fine faces \(drawn: ([\d.e-]+) m2\)", r.output)
        taken, drawn = map(float, area.groups()) if area else (0, 0)
        c.true(f"a slit of 1.2 mm at {x} of 0.6 m: {fine[0]} cells, {taken:g} m2 of {drawn:g}", 0.0012 * fine[0] / 0.6 > 4 - 1e-9 and abs(drawn / 4.8e-6 - 1) < 0.01 and abs(taken / 4.8e-6 - 1) < 0.02)
    r = Run(executable, scene("0 0.02 0 0.004 0 0.04", "f f f", [1e-3], low + "fix_modify gas boundary zlo patch j region j inlet 0 0 10\n", "fine 7 1 20 every 10",
                              before="region j block 0.009 0.0102 INF INF INF INF units box\n"), launcher=None)
    c.true("given cells: +138 % of a region's area is warned of", "WARNING: patch j of zlo takes whole fine faces" in r.output and "+138.1 %" in r.output)
    r = Run(executable, scene("0 0.02 0 0.004 0 0.04", "f f f", [1e-3], low + "fix_modify gas boundary zlo patch j region j inlet 0 0 10\n",
                              before="region j block 0.009 0.0102 INF INF 0.001 0.002 units box\n"), expect_success=False, launcher=None)
    line = next((x for x in r.output.splitlines() if "fix gas twogrid" in x), "no sentence")
    c.true(f"a region that isn't on the side: {line}", r.code != 0 and "patch j region" in line and "no point was found" in line)


def no_bed(c, executable):
    """One grain in a vessel: it is no bed."""
    text = head("0 0.02 0 0.02 0 0.08", 1e-5, boundary="f f f", skin=3e-4) + "create_atoms 1 single 0.01 0.01 0.04\nset group all diameter 0.001 density 2500\n" \
        "fix motion all nve/sphere\nfix weight all gravity 9.81 vector 0 0 -1\n" + gas() + "fix_modify gas boundary zlo inlet 0 0 0.5 boundary zhi pressure 0\nrun 0\n"
    r = Run(executable, text, launcher=None)
    fine = grids(r)[0]
    c.true(f"one grain: {fine}, no word of a bed", fine[2] <= 0.08 / 0.0025 + 1e-9 and "bed of" not in r.output and "bed's end" not in r.output)


BED = head(SLOT, 1.5e-5, boundary="f f f", skin=0.4e-3, gamman=2e-3, gammat=1e-3) + SLOT_WALLS + poured(450) + "run 2000\nreset_timestep 0\n"
GOES = "fix_modify gas output every 300 file bed.h5 fields u p eps\nthermo_style custom step ke f_gas[1] f_gas[4]\nthermo_modify format float %.17g norm no\nthermo 100\n"


def same(c, executable, ranks):
    """On all ranks; and given."""
    seen = {}
    for n in ranks:
        r = Run(executable, BED + gas() + JET + GOES + "run 300\n", n)
        seen[n] = grids(r)
        if n == 1:
            one = r
    c.true(f"the same on {', '.join(map(str, ranks))} ranks: {seen[1]}", len(set(seen.values())) == 1)
    fine, ratio, every = seen[1]
    words = f"fine {' '.join(map(str, fine))} ratio {' '.join(map(str, ratio))} every {every}"
    given = Run(executable, BED + gas(words) + JET + GOES + "run 300\n")
    with h5py.File(one.file("bed.h5")) as a, h5py.File(given.file("bed.h5")) as b:
        names = []
        a["frames" if "frames" in a else "/"].visititems(lambda n, d: names.append(d.name) if isinstance(d, h5py.Dataset) else None)
        unlike = [n for n in names if not np.array_equal(a[n][()], b[n][()]) and "record" not in n]
        record = tuple(a["record"].attrs["fine"]), tuple(a["record"].attrs["ratio"])
    c.true(f"{words}: given, the same bits in {len(names)} fields{unlike or ''}", len(names) > 3 and not unlike and np.array_equal(one.thermo()["KinEng"], given.thermo()["KinEng"]))
    c.true(f"the file's record has the numbers: {record}", record == (fine, ratio))
    c.true("given grids are not called chosen", "chosen (auto)" not in given.output)


def interval(c, executable):
    """0.4 of a cell at the velocity that inlets reach in the run; a later run that blows faster."""
    def of(r):
        h = min(float(x) for x in re.findall(r"grid [xyz] +\d+ fine cells of ([\d.e-]+) m", r.output))
        return h, [int(e) for e in re.findall(r"coupling interval +(\d+) steps|every (\d+) \(auto\) in place", r.output) for e in e if e]
    ramp = "variable U equal ramp(0.2,2.0)\nvariable W equal 2*v_U\n"
    more = JET.replace("inlet 0 0 5.0", "inlet 0 0 v_W") + "fix_modify gas output off\nrun 50\nvariable W equal 10\nrun 20\nvariable W equal 1\nrun 20\n"
    r = Run(executable, BED + ramp + gas() + more, launcher=None)
    h, every = of(r)
    wanted = [int(0.4 * h / u / 1.5e-5 * (1 + 1e-9)) for u in (4, 10)]
    c.true(f"a ramp to 4 m/s, then 10, then 1: every {every}, wanted {wanted}", every == wanted and "the largest that inlets reach in this run" in r.output
           and "follows a variable" not in r.output)
    r = Run(executable, BED + "compute k all ke\nvariable W equal 5+0*c_k\n" + gas() + JET.replace("inlet 0 0 5.0", "inlet 0 0 v_W") + "fix_modify gas output off\nrun 5\n", launcher=None)
    c.true("a variable that hangs on the grains: its value of now, and that is said", "an inlet's variable, as it is now" in r.output and "every auto) hold for its value now" in r.output)


def goes_on(c, executable):
    """Between two runs a grain of three times the size comes: chosen anew, the particle cells would be as large as two of it."""
    later = "create_atoms 1 single 0.006 0.0024 0.028\ngroup big id > 450\nset group big diameter 0.0036 density 1000\n"
    text = BED + gas() + JET + GOES + "fix_modify gas checkpoint every 300 keep 9\nrun 300\n" + later + "run 600\n"
    first = Run(executable, text)
    with tempfile.TemporaryDirectory(prefix="twogrid_test_") as folder:
        path = os.path.join(folder, "run")
        shutil.copytree(first.path, path)
        kept = sorted(os.listdir(os.path.join(path, "in.test.checkpoints")))
        for name in kept[2:]:
            shutil.rmtree(os.path.join(path, "in.test.checkpoints", name))
        done = subprocess.run([*MPIRUN, "-np", "1", os.path.abspath(executable), "-in", "in.test", "-restart", "auto"], cwd=path, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, errors="replace", timeout=100)
        first.output, log = first.output, done.stdout
        there = done.returncode == 0 and "as the checkpoint has them" in log
        second = type("Log", (), {"output": log})
        c.true(f"from {kept[1]} of {len(kept)} on with the grids of the beginning: {grids(second) if there else log[-2000:]}", there and grids(second) == grids(first))
        unlike = []
        with h5py.File(first.file("bed.h5")) as f, h5py.File(os.path.join(path, "bed.h5")) as g:
            names = []
            f.visititems(lambda n, d: names.append(n) if isinstance(d, h5py.Dataset) and "record" not in n else None)
            unlike = [n for n in names if n not in g or not np.array_equal(f[n][()], g[n][()])]
        c.true(f"and with all bits of its {len(names)} fields{unlike[:3] or ''}", len(names) > 6 and not unlike)
        fresh = Run(executable, BED + later + gas() + JET + "run 0\n")
        c.true(f"chosen anew they would be others: {grids(fresh)}", grids(fresh)[:2] != grids(first)[:2])


def larger_later(c, executable):
    """A template, and its insertion, that come after the first run: the grids stay, and that is said."""
    later = "fix ball all particletemplate/sphere 86028121 atom_type 1 density constant 1000 radius constant 0.003\n" \
        "fix mix all particledistribution/discrete 49979687 1 ball 1.0\nregion up block 0.001 0.0206 0 0.0048 0.02 0.035 units box\n" \
        "fix more all insert/rate/region seed 86028157 distributiontemplate mix nparticles 5 particlerate 1000 insert_every 200 overlapcheck yes all_in no region up\n"
    r = Run(executable, BED + gas() + JET + "run 10\n" + later + "run 10\n", launcher=None)
    told = [x for x in r.output.splitlines() if "WARNING" in x and "chosen (auto)" in x]
    c.true(f"grains of 6 mm after the first run: {told[0][:160] if told else 'no warning'}", len(told) == 1 and "0.006 m" in told[0])


def refused(c, executable):
    for what, box, sizes, words, more, wanted in (
            ("a jet of 0.1 mm in a box of 1 m", "0 1 0 1 0 1", [0.05], AUTO, "fix_modify gas boundary zlo patch j rect 0.5 0.5001 0.5 0.5001 inlet 0 0 5 boundary zhi pressure 0\n", ("patch j of zlo", "40000 in x", "give numbers")),
            ("stretch", "0 0.1 0 0.1 0 0.1", [0.005], AUTO + " stretch z 1.1", "", ("stretch", "in z")),
            ("a prime number of cells", "0 0.1 0 0.1 0 0.1", [0.005], "fine 20 20 61 ratio auto every auto", "", ("61", "ratio")),
            ("a prime number of cells that grow", "0 0.1 0 0.1 0 0.1", [0.005], "fine 20 20 61 ratio auto every auto stretch z 1.05", "", ("61", "fine 57 in z", "a number for ratio in z", "a smaller 'stretch'")),
            ("a ratio that makes cells of a grain", "0 0.1 0 0.1 0 0.1", [0.005], "fine auto ratio 2 2 2 every auto", "fix_modify gas boundary zlo patch j rect 0.05 0.058 0 0.1 inlet 0 0 5 boundary zhi pressure 0\n", ("ratio", "patch j of zlo", "or auto")),
            ("one grid", "0 0.1 0 0.1 0 0.1", [0.005], AUTO, "fix_modify gas method single boundary zlo patch j rect 0.05 0.058 0 0.1 inlet 0 0 5 boundary zhi pressure 0\n", ("method single", "numbers")),
            ("no grains, no templates", "0 0.1 0 0.1 0 0.1", None, AUTO, "", ("no particles nor templates", "numbers of cells"))):
        text = scene(box, "f f f", sizes or [0.005], more, words, fill="0 0.1 0 0.1 0 0.1")
        if sizes is None:
            text = f"units si\natom_style granular\nnewton off\ncommunicate single vel yes\nboundary f f f\nregion box block {box} units box\ncreate_box 1 box\n" \
                   "fix kn all property/global youngsModulus peratomtype 1e7\n" + gas(words) + "timestep 1e-5\nneighbor 0.001 bin\nrun 0\n"
        r = Run(executable, text, expect_success=False, launcher=None)
        line = next((x for x in r.output.splitlines() if "fix gas twogrid" in x), "no sentence")
        c.true(f"{what}: {line}", r.code != 0 and all(w in line for w in wanted))


def main():
    executable, ranks = arguments()
    c = Checks("grids from the scene")
    kinds(c, executable)
    regions(c, executable)
    no_bed(c, executable)
    same(c, executable, ranks)
    interval(c, executable)
    goes_on(c, executable)
    larger_later(c, executable)
    refused(c, executable)
    c.end()


if __name__ == "__main__":
    main()
