#!/usr/bin/python3
"""Runs that know when start-up is over and when their means are sure enough (output average from auto until X): they end at a coupling, the
same one when they go on from a checkpoint, with every bit; the script goes on behind them. --long: the errors they claim hold.

What would pass falsely without it: a run that ends a step later or earlier after each restart, means that begin within start-up or begin anew at a
restart, a later run of the script that ends at once; and an error that is claimed and isn't so.

    until.py EXECUTABLE RANKS... [--long]      --long: twenty beds of cases/first_bed, each filled by another seed, against long runs of others
"""
import os
import re
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np

from harness import Checks, Run, arguments, long_form, narrow_bed, poured
from same_script import checkpoints, gas, gone_on, text_of

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
BED = narrow_bed() + poured(300) + """
reset_timestep 0
fix gas all twogrid fine 18 1 20 ratio 3 1 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 1.3 boundary zhi pressure 0
fix_modify gas boundary zlo patch jet rect 0.0096 0.0120 0 0.0048 inlet 0 0 5.0
fix_modify gas output every 2000 file bed.h5 fields eps average from {plan}
thermo_style custom step atoms f_gas[1] f_gas[4]
thermo_modify format float %.17g
thermo 1000
dump d all custom 2000 all.dump id x y z vx vy vz
dump_modify d sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g"
{more}
run {steps}
run 250
"""


def bed(plan, steps=100000, more=""):
    return BED.format(plan=plan, steps=steps, more=more)


def end_of(run):
    """The step at which the run said that it would end."""
    said = re.search(r"as sure as 'until' wants: the run ends at step (\d+)", run)
    return int(said.group(1)) if said else -1


def means(path, name="bed.h5"):
    with h5py.File(os.path.join(path, name)) as f:
        a, g = dict(f["average"].attrs), f["average/particle_grid"]
        return a, g["eps"][...], g["gas_flux"][...], np.maximum(1 - g["eps"][...], 0)


def short(c, executable, ranks):
    for n in ranks:
        a = Run(executable, bed("auto until 0.1", more="fix_modify gas checkpoint every 10000 keep 99"), n, ("-var", "kind", "1"), timeout=100)
        end, log = end_of(a.output), text_of(a.path, "log.liggghts")
        begun = re.search(r"start-up lasted (\S+) s, means are taken from (\S+) s on", log)
        c.true(f"{n} ranks: {begun.group(0) if begun else 'start-up is never over'}; end planned for step {end}", bool(begun) and 0 < end < 100000)
        steps = [int(line.split()[0]) for line in log.splitlines() if re.match(r" *\d+ +300 ", line)]
        c.true(f"that run's last step is {end}, a coupling; the script goes on to {max(steps)}", end % 10 == 0 and end in steps and max(steps) == end + 250)
        attributes, *_ = means(a.path)
        c.true(f"errors of the means in the file: {attributes['standard_error_eps']:.3f}, {attributes['standard_error_flux']:.3f}; from {attributes['from']:.4g} s, wanted {begun.group(2)}",
               max(attributes["standard_error_eps"], attributes["standard_error_flux"]) < 0.11 and abs(attributes["from"] - float(begun.group(2))) < 1e-3)
        names = checkpoints(a.path)
        for name in (names[1], names[-1]) if n == ranks[0] else names[-1:]:
            folder, path, b = gone_on(executable, n, a, name)
            c.true(f"from {name}: code {b.returncode}, the end at step {end_of(b.stdout)} or before the checkpoint", b.returncode == 0 and end_of(b.stdout) in (end, -1))
            c.true("particles, every bit", text_of(path, "all.dump") == text_of(a.path, "all.dump"))
            one, two = gas(a.path), gas(path)
            differ = sorted(k for k in {*one, *two} if k not in one or k not in two or not np.array_equal(one[k], two[k], equal_nan=True))
            c.true(f"fluid and means, every bit of {len(one)} datasets{': but ' + ', '.join(differ) if differ else ''}", not differ)
            folder.cleanup()
    a = Run(executable, bed("0.02 until 0.002", steps=3000), ranks[0])
    said = re.search(r"means over .*", a.output).group(0)
    c.true(f"not sure enough within the run: {said}", end_of(a.output) == -1 and "'until' wants" in said)
    for plan, wanted in (("soon", "or auto"), ("auto until 2", "standard error"), ("0.1 until nan", "standard error"), ("until 0.1", "or auto")):
        a = Run(executable, bed(plan, steps=10), expect_success=False)
        sentence = next((line for line in a.output.splitlines() if "ERROR" in line), "none")
        c.true(f"from {plan}: {sentence[:150]}", a.code == 1 and wanted in sentence)


def first_bed(executable, seed, plan, steps):
    with open(os.path.join(TOP, "cases", "first_bed", "in.first_bed")) as f:
        text = f.read()
    text, found = re.subn(r"(variable +seed +index) \d+", rf"\1 {seed}", text)
    assert found == 1, "cases/first_bed/in.first_bed has no variable seed"
    text = text.replace("average from ${tavg}", "average from " + plan).replace("fields u p eps", "fields eps")
    text = re.sub(r"output every \d+", "output every 1000000", re.sub(r"\nrun +\$\{steps\}", f"\nrun {steps}", text))
    run = Run(executable, text, timeout=3000)
    return run, means(run.path, "first_bed.h5")


def mirrored(eps, flux):
    """Of the same scene, whose jet stands in the middle."""
    return eps[:, :, ::-1], flux[:, :, ::-1] * (-1, 1, 1)


def distance(a, b, w):
    """Root mean squares, over the means of b: of void fraction and flux."""
    return [np.sqrt(np.sum(w * (a[0] - b[0])**2) / np.sum(w * b[0]**2)), np.sqrt(np.sum(w[..., None] * (a[1] - b[1])**2) / np.sum(w[..., None] * b[1]**2))]


def nearest(a, b, w):
    """a, or its mirror image. The jet leans to one side for as long as any of these runs lasts: means are of one of two states."""
    return min((a, mirrored(*a)), key=lambda x: distance(x, b, w)[1])


def long(c, executable):
    """Errors claimed, against the mean of long runs."""
    seeds = [s for s in range(20000003, 20000803, 2) if all(s % q for q in range(3, 4480, 2))][:23]
    within = 0.03
    with ThreadPoolExecutor(2) as pool:
        whole = list(pool.map(lambda s: first_bed(executable, s, "1.0", 600000)[1], seeds[:3]))
        w = whole[0][3]
        near = [nearest(r[1:3], whole[0][1:3], w) for r in whole]
        mean = tuple(np.mean([r[q] for r in near], axis=0) for q in (0, 1))
        for seed, (a, *_), r in zip(seeds, whole, near):
            c.note(f"long run, seed {seed}: {a['weight']:.3g} s, standard errors {a['standard_error_eps']:.4f}, {a['standard_error_flux']:.4f}; from the mean of the three {distance(r, mean, w)[0]:.4f}, {distance(r, mean, w)[1]:.4f}")
        good, one = 0, 0
        for seed, (run, (a, eps, flux, _)) in zip(seeds[3:], pool.map(lambda s: first_bed(executable, s, f"auto until {within}", 600000), seeds[3:])):
            off = distance(nearest((eps, flux), mean, w), mean, w)
            good, one = good + (end_of(run.output) > 0 and max(off) <= 2 * within), one + (max(off) <= within)
            c.note(f"seed {seed}: from {a['from']:.2f} s over {a['weight']:.2f} s, claimed {a['standard_error_eps']:.4f}, {a['standard_error_flux']:.4f}, off by {off[0]:.4f}, {off[1]:.4f}")
    c.true(f"off by at most two standard errors in {good} of 20 runs (wanted 18), by one in {one}", good >= 18)


def main():
    executable, ranks = arguments()
    c = Checks("runs that end when their means are sure enough")
    if long_form():
        long(c, executable)
    else:
        short(c, executable, ranks)
    c.end()


if __name__ == "__main__":
    main()
