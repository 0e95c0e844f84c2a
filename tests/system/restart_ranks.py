#!/usr/bin/python3
"""A run of 2 ranks goes on on 1, 4 and 8 with its own script. At the restart the fluid and what the coupling knows of every cell are those of the
checkpoint to the last bit, all particles are there as they were, and what was inserted and lost goes on being counted; what is conserved stays so.
Later the runs part, as runs on other ranks do: their means must agree within their statistical error.

Without this test a part of a field could be lost or shifted where ranks are cut elsewhere, sums of ranks be counted twice or dropped, and a bed
that goes on on other ranks be another one, with numbers that look as good.
Usage: restart_ranks.py EXECUTABLE [--long]: with means of a bubbling bed over 0.3 s, which takes some minutes.
Long form 2026-11-28, 311a92c, 2 cores: seven figures on 1, 4 and 8 ranks within 0.6 combined standard errors of those on 2 (pressure drop 79.6 +- 4.6 and
79.4 to 79.6 Pa, kinetic energy 1.49 +- 0.17 and 1.49 to 1.54 uJ, eps above the jet 0.720 +- 0.028 and 0.716 to 0.720).
"""
import os
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

from harness import Checks, Run, arguments, data_file, head, head_with_particles, launch, poured, read_thermo, walls

BOX = "0 0.0216 0 0.0048 0 0.036"
WALLS = walls(xplane=(0, 0.0216), yplane=(0, 0.0048), zplane=(0,))
SPHERE = 2500 * 4 / 3 * np.pi * 0.0006**3
OTHERS = (1, 4, 8)


def script(fill, run, more, insertion="", background=0.4):
    return head(BOX, 1.5e-5, boundary="f f f", skin=0.4e-3, gamman=2e-3, gammat=1e-3) + WALLS + poured(450) + f"""\
run {fill}
reset_timestep 0
{insertion}fix gas all twogrid fine 18 1 20 ratio 3 1 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 {background} boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
fix_modify gas boundary zlo patch jet rect 0.0096 0.0120 0 0.0048 inlet 0 0 5.0
fix_modify gas output every {run} file bed.h5 fields u p eps average from {1.5e-5 * run!r}
fix_modify gas checkpoint every {run} keep 9
variable mass equal mass(all)
variable height equal xcm(all,z)
thermo_style custom step atoms ke v_mass v_height f_gas[1] f_gas[4] f_gas[6] f_gas[7] f_gas[14] f_gas[15]
thermo_modify format float %.17g lost ignore norm no
thermo 10
dump d all custom {run} all.*.dump id x y z vx vy vz omegax omegay omegaz
dump_modify d sort id format "%d{9 * ' %.17g'}"
run {run}
run 0
fix_modify gas checkpoint write at_once.h5
run {more}
"""


def gone_on(executable, ranks, run):
    """In a folder as it is left by a kill after the first checkpoint."""
    folder = tempfile.TemporaryDirectory(prefix="twogrid_test_")
    path = os.path.join(folder.name, "run")
    shutil.copytree(run.path, path)
    names = sorted(os.listdir(os.path.join(path, "in.test.checkpoints")))
    for name in names[1:]:
        shutil.rmtree(os.path.join(path, "in.test.checkpoints", name))
    os.unlink(os.path.join(path, "at_once.h5"))
    done = subprocess.run([*launch(ranks), os.path.abspath(executable), "-in", "in.test", "-restart", "auto"], cwd=path, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace", timeout=3000)
    if done.returncode != 0:
        print(done.stdout[-3000:])
        sys.exit(f"FAIL: the run ended with code {done.returncode} on {ranks} ranks")
    return folder, path


def states(path):
    """All arrays and numbers of fluid and coupling, and of the averages; other numbers differ between ranks or are sums of them."""
    out = {}
    with h5py.File(path) as f:
        for group in ("fluid", "coupling", "averages"):
            f[group].visititems(lambda n, d, g=group: out.__setitem__(f"{g}/{n}", d[...]) if isinstance(d, h5py.Dataset) else None)
    return out


def compare(c, ranks, before, path, run):
    one, two = states(before.file("at_once.h5")), states(os.path.join(path, "at_once.h5"))
    arrays = [k for k in one if one[k].ndim > 1]
    differ = [k for k in arrays if k not in two or not np.array_equal(one[k].view(np.int64), two[k].view(np.int64))]
    c.true(f"on {ranks} ranks: every bit of {len(arrays)} fields of fluid, coupling and means{': but ' + ', '.join(differ) if differ else ''}",
           not differ and {k for k in two if two[k].ndim > 1} == set(arrays) and len(arrays) > 30)
    numbers = [k for k in one if one[k].ndim <= 1]
    differ = [k for k in numbers if k not in two or (abs(one[k].sum() - two[k].sum()) > 1e-13 * abs(one[k].sum()) if k.endswith("_of_rank") else
                                                     one[k].min() != two[k].min() or one[k].max() != two[k].max())]
    c.true(f"and of {len(numbers)} numbers{': but ' + ', '.join(differ) if differ else ''}", not differ and len(numbers) > 20)
    x, y = (open(os.path.join(p, f"all.{run}.dump")).read() for p in (before.path, path))
    c.true("particles at the checkpoint's step, every bit", x == y and x.count("\n") > 300)


def conservation(c, ranks, path, run):
    t = read_thermo(os.path.join(path, "log.liggghts"))
    c.below("volume of solids, and action and reaction", max(t["gas[6]"].max(), t["gas[7]"].max()), 1e-12)
    now = t["v_mass"] / 2500 if "v_mass" in t else t["mass"] / 2500
    coupled = t["Step"] % 10 == 0
    balance = (now - t["gas[14]"] + t["gas[15]"])[coupled]
    c.below(f"volume now ({now[-1] / SPHERE * 2500:.0f} particles) less inserted ({t['gas[14]'][-1]:.3g}) plus lost ({t['gas[15]'][-1]:.3g} m3), change",
            np.ptp(balance) / balance[0], 1e-12)
    return t, balance[-1]


def still(c, executable):
    """Particles that never move, as many on either rank: their deposit is not made anew at a coupling, but is the checkpoint's."""
    x = [((i + 0.5) * 1.2e-3, (j + 0.5) * 1.2e-3, (k + 0.5) * 1.2e-3) for k in range(20) for j in range(4) for i in range(12)]
    box = "0 0.0144 0 0.0048 0 0.024"
    rest = f"""
fix hold all freeze
fix gas all twogrid fine 12 4 20 ratio 3 2 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas boundary zlo inlet 0 0 0.4 boundary zhi pressure 0
fix_modify gas output off
thermo_style custom step atoms f_gas[4] f_gas[6] f_gas[9]
thermo_modify format float %.17g
thermo 10
"""
    text = head_with_particles(1e-5, boundary="p p f", processors="2 1 1", skin=0.4e-3) + rest
    a = Run(executable, text + "run 200\nwrite_restart half\nfix_modify gas checkpoint write half.h5\nrun 40\n", 2, files={"particles.data": data_file(box, x, 1e-3, 2500)})
    s = a.thermo()
    for n in OTHERS:
        text = head(box, 1e-5, boundary="p p f", skin=0.4e-3)
        text = text[:text.index("region box")] + f"read_restart {a.file('half')}\n" + text[text.index("neighbor"):] + rest
        t = Run(executable, text + f"fix_modify gas checkpoint read {a.file('half.h5')}\nrun 40\n", n).thermo()
        c.below(f"particles that lie still, {n} ranks: volume of solids", t["gas[6]"].max(), 1e-12)
        c.below("least void fraction, and pressure drop, relative difference", max(abs(t["gas[9]"][-1] / s["gas[9]"][-1] - 1), abs(t["gas[4]"][-1] / s["gas[4]"][-1] - 1)), 1e-6)


def batches(values, n):
    parts = [p.mean() for p in np.array_split(values, n)]
    return np.mean(parts), np.std(parts, ddof=1) / np.sqrt(n)


def figures(path, run):
    """Mean and standard error of each, over what follows the checkpoint's step."""
    with h5py.File(os.path.join(path, "bed.h5")) as f:
        g = f["average/particle_grid"]
        w, eps, flux = g["batch/weight"][...], g["batch/eps"][...], g["batch/gas_flux"][...] if "batch/gas_flux" in g else None
    full = w > 0.5 * w.max()
    out = {}
    for name, cell in (("eps in the jet", (0, 0, 3)), ("eps above the jet", (1, 0, 3)), ("eps beside the jet", (1, 0, 1)), ("eps at the bed's top", (2, 0, 5))):
        x = eps[(full, *cell)]
        out[name] = x.mean(), x.std(ddof=1) / np.sqrt(len(x))
    return out


def thermo_figures(t, run):
    late = (t["Step"] > run) & (t["Step"] % 10 == 0)
    z = next(k for k in t if "height" in k)
    return {"pressure drop": batches(t["gas[4]"][late], 12), "height of the particles' centre": batches(t[z][late], 12), "kinetic energy": batches(t["KinEng"][late], 12)}


def all_thermo(folder):
    """Of both runs after the checkpoint: the log holds them one after the other."""
    return read_thermo(os.path.join(folder, "log.liggghts"))


def main():
    executable, _ = arguments()
    long = "--long" in sys.argv
    c = Checks("from 2 ranks on 1, 4 and 8")
    pour = ("region top block 0.002 0.0196 0.0007 0.0041 0.024 0.033 units box\n"
            "fix pour all insert/rate/region seed 32452867 distributiontemplate mix nparticles 400 particlerate 20000 insert_every 60 overlapcheck yes "
            "vel constant 0 0 -0.5 region top ntry_mc 10000\n")
    run, more = 100, 60
    a = Run(executable, script(100, run, more, pour), 2)
    conservation(c, 2, a.path, run)
    for n in OTHERS:
        folder, path = gone_on(executable, n, a)
        compare(c, n, a, path, run)
        conservation(c, n, path, run)
        folder.cleanup()
    still(c, executable)
    if long:
        run, more = 6000, 20000
        a = Run(executable, script(4000, run, more, background=0.95), 2, timeout=3000)  # above minimum fluidisation, 0.75 m/s: it bubbles
        means = {2: {**thermo_figures(all_thermo(a.path), run), **figures(a.path, run)}}
        for n in OTHERS:
            folder, path = gone_on(executable, n, a)
            means[n] = {**thermo_figures(all_thermo(path), run), **figures(path, run)}
            folder.cleanup()
        parted = min(abs(means[n]["kinetic energy"][0] / means[2]["kinetic energy"][0] - 1) for n in OTHERS)
        c.true(f"the bed moves and the runs part: kinetic energy {means[2]['kinetic energy'][0]:.2g} J, means of it at least {parted:.1g} from each other", means[2]["kinetic energy"][0] > 1e-7 and parted > 1e-6)
        for name, (mean, error) in means[2].items():
            for n in OTHERS:
                other, its = means[n][name]
                c.below(f"{name}: {mean:.6g} +- {error:.2g} on 2 ranks, {other:.6g} +- {its:.2g} on {n}; difference in combined standard errors",
                        abs(mean - other) / np.hypot(error, its), 4)
    c.end()


if __name__ == "__main__":
    main()
