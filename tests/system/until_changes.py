#!/usr/bin/python3
"""Means of a script whose runs have different conditions of the flow (output average from auto until X, fix_modify between runs, variables that a loop
changes), flows that don't scatter at all, and what the report, status.json and 'output off' say of it.

What would pass falsely without it: means that mix two inlet velocities, and a second run that ends at once because the first one's means were sure;
a restart that begins them anew, or doesn't; a steady flow that never ends.

    until_changes.py EXECUTABLE RANKS...
"""
import json
import os
import re

import h5py
import numpy as np

from harness import Checks, Run, arguments, narrow_bed, poured
from same_script import checkpoints, gas, gone_on, text_of
from until import end_of

SCENE = narrow_bed() + poured(150) + """
run 3999
fix gas all twogrid fine 9 1 12 ratio 3 1 2 density 1.2 viscosity 1.8e-5 every 20
fix_modify gas boundary zlo inlet 0 0 {inlet} boundary zhi pressure 0
fix_modify gas output every 20000 file bed.h5 fields eps average from {plan}
thermo_style custom step atoms f_gas[1]
thermo_modify format float %.17g
thermo 100000
{runs}
"""
LOOP = """
fix_modify gas checkpoint every 17000 keep 99
dump d all custom 20000 all.dump id x y z
dump_modify d sort id format "%d %.17g %.17g %.17g"
variable i loop 3
label again
variable U equal 0.6-0.1*$i
run 600000
next i
jump SELF again
"""


def scene(plan, runs, inlet="v_U"):
    return ("variable U equal 0.5\n" if inlet == "v_U" else "") + SCENE.format(plan=plan, runs=runs, inlet=inlet)


def ends(output):
    return [int(s) for s in re.findall(r"the run ends at step (\d+)", output)]


def begun_anew(output):
    return re.findall(r"twogrid: (boundary zlo, velocity in z is \S+ and was \S+ when the run before ended): start-up and means begin anew", output)


def mean_flux(path):
    """Of the gas, upwards, over the domain; from when on, and over what time."""
    with h5py.File(os.path.join(path, "bed.h5")) as f:
        a = f["average"].attrs
        return float(np.mean(f["average/fine/flux"][..., 2])), float(a["from"]), float(a["weight"])


def loop(c, executable, ranks):
    a = Run(executable, scene("auto until 0.05", LOOP), ranks, ("-var", "kind", "1"))
    found, anew = ends(a.output), begun_anew(a.output)
    c.true(f"{ranks} ranks: three velocities, three ends of runs by their means: {found}; begun anew: {anew}",
           len(found) == 3 and len(anew) == 2 and "is 0.4 and was 0.5" in anew[0] and "is 0.3 and was 0.4" in anew[1])
    c.true(f"steps of the later two runs: {np.diff(found)}; wanted: a start-up each", all(np.diff(found) > 10000))
    flux, begun, weight = mean_flux(a.path)
    c.true(f"mean flux {flux:.4f} m/s, from {begun:.3f} s over {weight:.3f} s: the last run's 0.3", abs(flux - 0.3) < 0.003)
    status = json.loads(text_of(a.path, "status.json"))["run"]
    c.true(f"status.json: {status}", status["last_step"] == found[-1] and status["steps_to_go"] == 0)
    output = re.search(r"^  output +(.*)$", text_of(a.path, "log.liggghts"), re.M).group(1)
    c.true(f"the report: output {output}", "average from auto until 0.05" in output and "every 20000 file bed.h5" in output)
    names = checkpoints(a.path)
    step = {n: int(re.search(r"\d+$", n).group(0)) for n in names}
    # In the second run, before and after what begins anew; and the last one.
    for name in [n for n in names if found[0] < step[n] < found[1]][:1] + names[-1:] + [n for n in names if step[n] < found[0]][-1:]:
        folder, path, b = gone_on(executable, ranks, a, name)
        c.true(f"from {name}: code {b.returncode}, ends {ends(b.stdout)}, begun anew {len(begun_anew(b.stdout))}",
               b.returncode == 0 and ends(b.stdout) == [f for f in found if f in ends(b.stdout)] and (name != names[-1] or not begun_anew(b.stdout)))
        c.true("particles, every bit", text_of(path, "all.dump") == text_of(a.path, "all.dump"))
        one, two = gas(a.path), gas(path)
        c.true(f"fluid and means, every bit of {len(one)} datasets", set(one) == set(two) and all(np.array_equal(one[k], two[k], equal_nan=True) for k in one))
        folder.cleanup()


def kept(c, executable):
    """What a checkpoint between two runs must hold: with an entry left out (state_file.h) the change is not seen."""
    def again(a, name, leave_out=""):
        os.environ["TWOGRID_CHECKPOINT_LEAVE_OUT"] = leave_out
        folder, path, b = gone_on(executable, 1, a, name)
        del os.environ["TWOGRID_CHECKPOINT_LEAVE_OUT"]
        with h5py.File(os.path.join(path, "bed.h5")) as f:
            there = "average" in f
        result = len(begun_anew(b.stdout)), "as 'output average from' says" in b.stdout, mean_flux(path) if there else None
        folder.cleanup()
        return result

    runs = "fix_modify gas checkpoint every 4000 keep 99\nrun 8000\nfix_modify gas boundary zlo inlet 0 0 0.3{}\nrun 8000"
    a = Run(executable, scene("0.01", runs.format(" output average from 0.02"), "0.5"), options=("-var", "kind", "1"))
    names = {n.split("_")[-1]: n for n in checkpoints(a.path)}
    whole = mean_flux(a.path)
    c.true(f"'average from 0.02' before the second run, which begins at 0.12 s: {whole}", abs(whole[1] - 0.12) < 1e-6 and abs(whole[2] - 0.12) < 1e-3)
    c.true("from the first run's end: the same", again(a, names["12000"]) == (0, True, whole))
    c.true("from within the second run: the same", again(a, names["16000"]) == (0, False, whole))
    c.true("without means_anew: another", again(a, names["16000"], "conditions/means_anew")[2] != whole)
    a = Run(executable, scene("auto", runs.format(""), "0.5"), options=("-var", "kind", "1"))
    c.true("another velocity, from the first run's end: seen", again(a, names["12000"])[0] == len(begun_anew(a.output)) == 1)
    c.true("without known: not seen", again(a, names["12000"], "conditions/known")[0] == 0)


def same_conditions(c, executable):
    """Whatever makes a run's parts, a variable that goes on through them, and the same velocity said otherwise."""
    runs = """
run 2000 every 500 "print 'a part'"
variable U equal 0.3+ramp(0,0.1)
run 3000 upto
variable U equal 0.4-ramp(0,0.1)
run 2000
variable U equal 0.3*(1+0*step)
run 2000 pre no
fix_modify gas boundary zlo inlet 0 0 0.3
run 2000
fix_modify gas boundary zlo inlet 0 0 0.31
run 20
"""
    a = Run(executable, scene("auto until 0.05", runs.replace("3000 upto", "9000 upto")).replace("U equal 0.5", "U equal 0.3"))
    c.true(f"begun anew only where the velocity leaps: {begun_anew(a.output)}", len(begun_anew(a.output)) == 1 and "is 0.31 and was 0.3 " in begun_anew(a.output)[0])


def from_a_time(c, executable):
    runs = "run 20000\nfix_modify gas boundary zlo inlet 0 0 0.3\nrun 20000\n"
    a = Run(executable, scene("0.1", runs, "0.5"))
    warned = [line for line in a.output.splitlines() if "span both" in line]
    flux, begun, _ = mean_flux(a.path)
    c.true(f"means from a time: {flux:.3f} m/s from {begun} s on, as asked; {warned}",
           len(warned) == 1 and "WARNING" in warned[0] and "average from" in warned[0] and 0.35 < flux < 0.45 and begun == 0.1)
    a = Run(executable, scene("0.1", runs.replace("0.3\n", "0.3 output average from auto until 0.05\n").replace("run 20000\n", "run 20000\n", 1).replace("\nrun 20000\n", "\nrun 400000\n"), "0.5"))
    flux, begun, _ = mean_flux(a.path)
    c.true(f"'average from auto until' before the second run: {flux:.4f} m/s from {begun:.3f} s on, ends {ends(a.output)}",
           abs(flux - 0.3) < 0.003 and begun > 0.3 and len(ends(a.output)) == 1 and "span both" not in a.output)


def steady(c, executable):
    """Grains that are held: nothing scatters but by round-off. And a box in which nothing flows."""
    held = scene("auto until 0.05", "run 150000", "0.5").replace("fix gas all", "unfix motion\nvelocity all set 0 0 0\nfix hold all freeze\nfix gas all")
    a = Run(executable, held)
    said = re.search(r"means over .*", a.output)
    c.true(f"held grains: ends at step {end_of(a.output)}; {said and said.group(0)}", 0 < end_of(a.output) < 150000 and "correlation" not in said.group(0))
    a = Run(executable, held.replace("0 0 0.5", "0 0 0"))
    c.true(f"no flow through the domain, held grains: ends at step {end_of(a.output)}", 0 < end_of(a.output) < 150000)
    a = Run(executable, held.replace("run 150000", "run 15000"))
    said = re.search(r"start-up is not over.*", a.output).group(0)
    c.true(f"too short: {said}", re.search(r"has passed the domain's longest side \S+ of 5 times, which takes some", said))


def lines_of_output(c, executable):
    a = Run(executable, scene("auto until 0.1", "fix_modify gas output every 40 file other.h5 average from 0.1\nrun 40", "0.5"))
    warned = [line for line in a.output.splitlines() if "has dropped" in line]
    c.true(f"a second line: {warned}", len(warned) == 1 and "WARNING" in warned[0] and "bed.h5" in warned[0] and "until 0.1" in warned[0])
    a = Run(executable, scene("auto until 0.1", "fix_modify gas output off\nrun 40", "0.5"))
    c.true(f"off before the first run: no file among {sorted(os.listdir(a.path))}", not os.path.exists(a.file("bed.h5")))
    a = Run(executable, scene("auto until 0.1", "fix_modify gas output off\nrun 40\nfix_modify gas output every 20\nrun 40", "0.5"), expect_success=False)
    c.true("frames after the first run without a file: refused", a.code == 1 and "before the first run" in a.output)
    a = Run(executable, scene("0.01", "run 20000\nfix_modify gas checkpoint every 40 output off\nrun 80\nfix_modify gas output every 40\nrun 80", "0.5"), options=("-var", "kind", "1"))
    for name in checkpoints(a.path):
        folder, path, b = gone_on(executable, 1, a, name)
        one, two = gas(a.path), gas(path)
        c.true(f"off and on again, from {name}: code {b.returncode}, {len(two)} datasets of {len(one)}", b.returncode == 0 and set(one) == set(two))
        folder.cleanup()


def main():
    executable, ranks = arguments()
    c = Checks("means of runs with other conditions")
    for n in ranks:
        loop(c, executable, n)
    kept(c, executable)
    same_conditions(c, executable)
    from_a_time(c, executable)
    steady(c, executable)
    lines_of_output(c, executable)
    c.end()


if __name__ == "__main__":
    main()
