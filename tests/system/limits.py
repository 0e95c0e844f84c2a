#!/usr/bin/python3
"""Limits of a run are told, with their remedy: what the eps bound moves or cannot place, couplings of too many fluid steps, inlets that
are not numbers, grids that don't fit into memory, options that nothing asks for; names of files and a fluid at rest beside them.

    limits.py EXECUTABLE RANKS...

What would pass falsely without it: an obstacle of overlapping spheres whose volume the eps bound has moved all over the channel, or a
bed with more solids than the bound allows anywhere, simulated to the end without a word; a coupling that needs a million fluid steps and looks like one that hangs, or
hears no signal; a remedy that has nothing to do with the variable that is nan; a machine that swaps, or kills the run, before a word
is said; a memory estimate that no run bears out; a misspelt option that changes nothing; XDMF that no reader takes.
"""
import math
import os
import resource
import signal
import subprocess
import tempfile
import time
import xml.etree.ElementTree

import numpy as np

from harness import MPIRUN, Checks, Run, arguments, data_file, head_with_particles

GAS = """
fix gas all twogrid fine 8 4 8 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 5
fix_modify gas boundary zlo inlet 0 0 0.5 boundary zhi pressure 0 {modify}
fix_modify gas output off
thermo_style custom step atoms f_gas[6] f_gas[7] f_gas[8] f_gas[9]
thermo 5
"""
BOX, SIZE = "0 0.008 0 0.004 0 0.008", (0.008, 0.004, 0.008)


def run(executable, x, d, modify, steps=20, ranks=1):
    text = head_with_particles(1e-6, boundary="f f f", kn=1e-6, kt=1e-6) + GAS.format(modify=modify) + f"run {steps}\n"
    return Run(executable, text, ranks, files={"particles.data": data_file(BOX, x, d, 2500)})


def warnings(run, part):
    return [line for line in run.output.splitlines() if line.startswith("WARNING: fix gas twogrid:") and part in line]


def bound_moves(c, executable, ranks):
    """A rod of spheres that overlap, held, across a channel; once more with the same spheres apart."""
    d = 1e-3
    for gap, wanted in ((0.25e-3, 1), (1.0e-3, 0)):
        a = np.arange(-8, 9) * gap
        i, k = np.meshgrid(a, a, indexing="ij")
        near = (np.hypot(i, k) <= 0.55e-3).ravel()
        y = np.arange(0.5e-3, 3.6e-3, gap)
        x = np.array([(0.004 + p, q, 0.004 + r) for p, r in zip(i.ravel()[near], k.ravel()[near]) for q in y])
        for n in ranks:
            r = run(executable, x, d, "deposit trilinear", ranks=n)
            solids = len(x) * math.pi / 6 * d**3
            moved = r.thermo()["f_gas[8]" if "f_gas[8]" in r.thermo() else "gas[8]"][-1] / solids
            said = warnings(r, "eps bound move 0.3' moves")
            c.true(f"spheres of {d} m each {gap} m, {n} rank(s): {moved:.2%} of the solids moved, told {len(said)} time(s)",
                   len(said) == wanted and (moved > 0.01) == bool(wanted) and all("ratio" in s for s in said))


def bound_cannot_be_kept(c, executable):
    """Solids for a void fraction of 0.55 everywhere, and a bound of 0.7."""
    pitch, d = 1e-3, 1e-3 * (6 * 0.45 / math.pi)**(1 / 3)
    x = np.array([((i + .5) * pitch, (j + .5) * pitch, (k + .5) * pitch) for i in range(8) for j in range(4) for k in range(8)])
    for bound, wanted in ((0.7, 1), (0.5, 0)):
        said = warnings(run(executable, x, d, f"deposit trilinear eps bound move {bound}"), "cannot be kept")
        c.true(f"bound {bound} where the mean is 0.55: told {len(said)} time(s)", len(said) == wanted)
        if said:
            # V (1 - 0.55) there are, V (1 - 0.7) may be: a third of the solids has no place
            c.true(f"the volume unplaced: {said[0].split('kept: ')[1].split(' of')[0]} (wanted 33.33 %)", "33.33 %" in said[0])


ONE = np.array([[0.004, 0.002, 0.004]])


def refused(c, executable, what, words, modify="", before="", then="", ranks=1, fine="fine 8 4 8 ratio 2 2 2", options=()):
    """One sphere in a channel; the run ends with one sentence that holds all words."""
    begin = time.time()
    text = head_with_particles(1e-6, boundary="f f f") + before + GAS.format(modify=modify).replace(
        "fine 8 4 8 ratio 2 2 2", fine) + "run 20\n" + then
    r = Run(executable, text, ranks, options, files={"particles.data": data_file(BOX, ONE, 1e-3, 2500)}, expect_success=False, timeout=60)
    errors = [line for line in r.output.splitlines() if line.startswith("ERROR")]
    c.true(f"{what}: {(errors or ['no sentence'])[0]}",
           r.code != 0 and len(errors) == 1 and all(w in errors[0] for w in words) and time.time() - begin < 10)


def too_many_fluid_steps(c, executable, ranks):
    """The interval over the longest fluid step: 5e-6 s U / (h cfl) for an inlet of U, cells of h."""
    steps = ["fluid steps", "at most 10000", "every"]
    patch = "boundary zlo patch jet rect 0.002 0.006 0 0.004 inlet 0 0 "
    refused(c, executable, "a jet of 9e5 m/s", steps + ["inlet", "176"], patch + "9e5", ranks=ranks[-1])
    refused(c, executable, "the same by a variable that jumps in the second run", steps, patch + "v_U",
            "variable U equal 1+9e5*(step>30)\n", "run 20\n", ranks[-1])
    refused(c, executable, "cfl 1e-9", steps + ["cfl"], "cfl 1e-9")
    refused(c, executable, "dt 1e-12 s", steps + ["'dt'"], "dt 1e-12")
    refused(c, executable, "a DEM step of 100 s from the second run on", steps, then="timestep 100\nrun 20\n")
    refused(c, executable, "viscosity that limits the step", steps + ["implicit auto"],
            "implicit off convection none", then="timestep 100\nrun 20\n")


def not_a_number(c, executable, ranks):
    where = ["v_U", "nan", "finite"]
    jet = "boundary zlo patch jet rect 0.002 0.006 0 0.004 inlet 0 0 v_U"
    refused(c, executable, "nan from the start", where + ["boundary zlo patch jet"], jet, "variable U equal exp(1000)-exp(1000)\n")
    refused(c, executable, "inf", ["boundary zlo patch jet", "v_U", "inf"], jet, "variable U equal exp(1000)\n")
    late = "variable U equal 1+0*(step<13)+exp(1000*(step>12))-exp(1000*(step>12))\n"
    refused(c, executable, "nan at step 15", where + ["boundary zlo patch jet", "step 15"], jet, late, ranks=ranks[-1])
    refused(c, executable, "nan of a moving wall", where + ["boundary xlo"], "boundary xlo noslip 0 0 v_U", late)


def signal_within_a_coupling(c, executable, ranks):
    """9600 fluid steps a coupling, some minutes: much longer than the 10 to 18 s that mpirun takes to hand on a signal, so that it can't fall between two. It comes after 4 s and is heard."""
    text = head_with_particles(1e-6, boundary="f f f") + GAS.format(modify="dt 5.2e-10").replace("fine 8 4 8 ratio 2 2 2", "fine 64 32 64 ratio 4 4 4") + "run 20\n"
    with tempfile.TemporaryDirectory(prefix="twogrid_test_") as folder:
        with open(os.path.join(folder, "in.test"), "w") as f:
            f.write(text)
        with open(os.path.join(folder, "particles.data"), "w") as f:
            f.write(data_file(BOX, ONE, 1e-3, 2500))
        # mpirun leaves its ranks 1 s by default, too short for a signal during start-up; with 10 s it sleeps up to 20 s itself after the ranks have ended.
        p = subprocess.Popen(MPIRUN + ["--mca", "odls_base_sigkill_timeout", "10", "-np", str(ranks[-1]), os.path.abspath(executable), "-in", "in.test"], cwd=folder,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        time.sleep(4)
        running, begin = p.poll() is None, time.time()
        p.send_signal(signal.SIGTERM)
        try:
            output = p.communicate(timeout=30)[0]
        except subprocess.TimeoutExpired:
            p.kill()
            output = p.communicate()[0]
        took = time.time() - begin
    said = [line for line in output.splitlines() if "ended by signal 15 within a coupling" in line]
    c.true(f"SIGTERM within a coupling: {took:.1f} s later {(said or ['no sentence'])[0]}",
           running and len(said) == 1 and p.returncode != 0 and took < 25)


def grids_too_large(c, executable, ranks):
    for fine in ("fine 100000 1 100000 ratio 100000 1 100000", "fine 3000 3000 3000", "fine 2000000000 2000000000 2000000000",
                 "fine 1250 1250 1250"):  # the last can be numbered, and needs half a terabyte
        cells = np.prod([float(w) for w in fine.split()[1:4]])
        refused(c, executable, fine, ["fine: found", f"{cells:.4g}"], fine=fine, ranks=ranks[-1])
    refused(c, executable, "bricks whose product overflows to 1", ["-fluid_bricks"], options=["-fluid_bricks", "641,6700417,1"])


def memory_that_was_estimated(c, executable):
    """Two grids; the difference of what they take, by the system, against the difference of what was said."""
    took, said = [], []
    for n in (48, 112):
        text = head_with_particles(1e-6, boundary="f f f") + GAS.format(modify="").replace("fine 8 4 8", f"fine {n} {n} {n}") + "run 5\n"
        r = Run(executable, text, files={"particles.data": data_file(BOX, ONE, 1e-3, 2500)})
        took.append(1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
        words = r.output.split("fine cells need about ")[1].split()
        said.append(float(words[0]) * {"MB": 1e6, "GB": 1e9}[words[1]])
    took, said = took[1] - took[0], said[1] - said[0]
    c.below(f"memory: said {said / 1e6:.0f} MB more for the larger grid, took {took / 1e6:.0f} MB: difference / taken",
            abs(said / took - 1), 0.25)


def words_that_nothing_reads(c, executable, ranks):
    """Misspelt options, and in the same run the name of a file that XML has to quote."""
    name = "bed & <1>s.h5"
    text = head_with_particles(1e-6, boundary="f f f") + GAS.format(modify="").replace(
        "output off", f"output every 5 file '{name}'") + "run 10\nrun 10\n"
    wrong = ["-fluid_pressure_rtoll", "-fluid_presure_rtol", "-ksp_rtoll"]
    right = ["-fluid_pressure_rtol", "-fluid_pressure_ksp_norm_type"]
    options = [w for o, v in zip(wrong + right, ("1e-9", "1e-9", "1e-9", "1e-9", "natural")) for w in (o, v)]
    r = Run(executable, text, ranks[-1], options, files={"particles.data": data_file(BOX, ONE, 1e-3, 2500)})
    for option in wrong:
        c.true(f"{option}: told {len(warnings(r, option + ' '))} time(s)", len(warnings(r, option + " ")) == 1)
    for option in right:
        c.true(f"{option}: told {len(warnings(r, option + ' '))} time(s)", not warnings(r, option + " "))
    xml_name = r.file(name.replace(".h5", ".xdmf"))
    items = [i.text.split(":")[0] for i in xml.etree.ElementTree.parse(xml_name).iter("DataItem")]
    c.true(f"{len(items)} data items of the XDMF file name {name}", len(items) > 10 and set(items) == {name} and os.path.exists(r.file(name)))


def fluid_at_rest(c, executable):
    """A held sphere, nothing blows. Continuity over a velocity that is rounding alone is no figure."""
    text = head_with_particles(1e-5, boundary="f f f") + GAS.format(modify="").replace("inlet 0 0 0.5", "slip").replace(
        "f_gas[9]", "f_gas[9] f_gas[5]") + "run 200\n"
    t = Run(executable, text, files={"particles.data": data_file(BOX, ONE, 1.2e-3, 1000)}).thermo()
    c.below("continuity error of a fluid at rest", np.max(np.abs(t["f_gas[5]" if "f_gas[5]" in t else "gas[5]"])), 0)


def main():
    executable, ranks = arguments()
    c = Checks("limits that are told")
    bound_moves(c, executable, ranks)
    bound_cannot_be_kept(c, executable)
    too_many_fluid_steps(c, executable, ranks)
    not_a_number(c, executable, ranks)
    signal_within_a_coupling(c, executable, ranks)
    grids_too_large(c, executable, ranks)
    words_that_nothing_reads(c, executable, ranks)
    fluid_at_rest(c, executable)
    memory_that_was_estimated(c, executable)
    c.end()


if __name__ == "__main__":
    main()
