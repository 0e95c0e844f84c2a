"""What the system tests share: running a LIGGGHTS script through twogrid and reading what it wrote.

A test is a script of its own:  TEST.py EXECUTABLE [RANKS ...].  It prints the measured figures and the wanted bounds and
ends with exit code 0 only if every check held.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

MPIRUN = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1",
          "--mca", "btl", "self,vader"]
ENDS_AT_ONCE = [*MPIRUN, "--mca", "odls_base_sigkill_timeout", "0"]  # else mpirun sleeps a second after any rank's non-zero exit

# Granular particles without contacts worth mentioning; fill in box, particles and fix.
HEAD = """
units si
atom_style granular
newton off
communicate single vel yes
processors {processors}
boundary {boundary}
{create}
neighbor {skin} bin
neigh_modify delay 0
fix m1 all property/global youngsModulus peratomtype 1e7
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global kn peratomtypepair 1 {kn}
fix m4 all property/global kt peratomtypepair 1 {kt}
fix m5 all property/global gamman_abs peratomtypepair 1 {gamman}
fix m6 all property/global gammat_abs peratomtypepair 1 {gammat}
fix m7 all property/global coefficientFriction peratomtypepair 1 {mu}
pair_style gran model hooke/stiffness tangential history absolute_damping on
pair_coeff * *
timestep {dt}
"""
DEFAULTS = dict(processors="* * *", boundary="p p p", skin=0.5e-3, kn=100, kt=100, gamman=0, gammat=0, mu=0.1)


class Checks:
    """Collects checks; prints each with its figure. With STOP_AT_FIRST_FAILURE in the environment the first that fails
    ends the test."""

    def __init__(self, title):
        self.failed = 0
        print(f"== {title}", flush=True)

    def below(self, what, value, bound):
        good = bool(np.isfinite(value)) and value <= bound
        print(f"{'ok  ' if good else 'FAIL'} {what}: {value:.3e} (wanted at most {bound:.3g})", flush=True)
        return self.count(good)

    def true(self, what, condition):
        print(f"{'ok  ' if condition else 'FAIL'} {what}", flush=True)
        return self.count(condition)

    def count(self, good):
        self.failed += not good
        if not good and "STOP_AT_FIRST_FAILURE" in os.environ:
            sys.exit(1)
        return good

    def note(self, text):
        print(f"     {text}", flush=True)

    def end(self):
        sys.exit(1 if self.failed else 0)


def launch(ranks, launcher=MPIRUN):
    """How a command begins that starts the program on so many ranks: a lone one without mpirun, which takes longer than it."""
    return [*launcher, "-np", str(ranks)] if ranks > 1 else []


class Run:
    """A finished run: its log, thermo table, dumps and output file in a scratch folder of its own."""

    def __init__(self, executable, script, ranks=1, options=(), timeout=100, expect_success=True, files=None, launcher=MPIRUN, environment=None):
        self.folder = tempfile.TemporaryDirectory(prefix="twogrid_test_")
        self.path = self.folder.name
        for name, text in (files or {}).items():
            with open(os.path.join(self.path, name), "w") as f:
                f.write(text)
        with open(os.path.join(self.path, "in.test"), "w") as f:
            f.write(script)
        command = launch(ranks, launcher) + [os.path.abspath(executable), "-in", "in.test", *options]
        done = subprocess.run(command, cwd=self.path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                              timeout=timeout, env={**os.environ, **(environment or {})})
        self.output, self.code = done.stdout, done.returncode
        if expect_success and self.code != 0:
            print(self.output[-4000:])
            sys.exit(f"FAIL: the run ended with code {self.code} on {ranks} ranks")

    def file(self, name):
        return os.path.join(self.path, name)

    def thermo(self):
        return read_thermo(self.file("log.liggghts"))

    def dump(self, name):
        return read_dump(self.file(name))


def run_case(name, executable, ranks, out, *words):
    """cases/run NAME with this program in its short mode, results in the folder out, without its report; what it printed, with its code."""
    top = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
    done = subprocess.run([os.path.join(top, "cases", "run"), name, "--short", "--ranks", str(ranks), "--out", out, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, errors="replace", env={**os.environ, "TWOGRID": os.path.abspath(executable), "TWOGRID_NO_REPORT": "1"})
    print(done.stdout, flush=True)
    return done


def half_the_drag(c, name, out):
    """Compares a run of a case in its short mode again, as if its gas were twice as dense and viscous: all laws of drag then give exactly twice the
    force for the same motion, so that what the run has is half the drag. Its comparison must say so."""
    for file in [f for f in os.listdir(out) if f.endswith(".h5")]:
        with h5py.File(os.path.join(out, file), "r+") as f:
            for key in ("density", "viscosity"):
                f["record"].attrs[key] = 2 * f["record"].attrs[key]
    top = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
    done = subprocess.run([os.path.join(top, "cases", "run"), name, "--short", "--compare", "--out", out], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                          env={**os.environ, "TWOGRID_NO_REPORT": "1", "TWOGRID_NO_PICTURES": "1"})
    lines = [line for line in done.stdout.split("\n") if line.startswith("FAIL") and "drag" in line]
    c.true(f"half the drag: {'; '.join(lines) or done.stdout[-500:]}", done.returncode == 1 and len(lines) == 1 and re.search(r": 0\.[4-6]\d+ of what the law", lines[0]))


def short_mode(name, least, *pictures):
    """A whole test: the short mode of a case passes, with so many checks at least, draws, and says FAIL on half the drag."""
    short_modes((name, least, *pictures))


def short_modes(*cases):
    """That of several cases: name, least number of checks, pictures."""
    executable, ranks = arguments()
    c = Checks("short runs of " + ", ".join(case[0] for case in cases))
    for name, least, *pictures in cases:
        with tempfile.TemporaryDirectory() as out:
            done = run_case(name, executable, ranks[-1], out)
            c.true(f"{name}: run and comparison pass", done.returncode == 0 and done.stdout.count("PASS") >= least and "FAIL" not in done.stdout)
            pictures_are_there(c, out, *pictures)
            half_the_drag(c, name, out)
    c.end()


def pictures_are_there(c, out, *names):
    """Checks the pictures of a case. That in three dimensions is asked for only where what draws it is installed."""
    names = [n for n in names if n != "grains" or (shutil.which("xvfb-run") and os.path.isdir("/usr/lib/python3/dist-packages/vtkmodules"))]
    sizes = [os.path.getsize(p) if os.path.exists(p) else 0 for p in (os.path.join(out, n + ".png") for n in names)]
    c.true(f"pictures {', '.join(names)}", min(sizes) > 10000)


def read_thermo(path):
    """Thermo lines in a log as a dict of columns: of all runs, or of those after the header last changed."""
    names, rows = None, []
    with open(path) as f:
        for line in f:
            words = line.split()
            if words and words[0] == "Step":
                names, rows = words, rows if words == names else []
            elif names and len(words) == len(names) and re.fullmatch(r"\d+", words[0]):
                try:
                    rows.append([float(w) for w in words])
                except ValueError:
                    pass
    table = np.array(rows)
    return {n: table[:, i] for i, n in enumerate(names)}


def read_dump(path):
    """Frames of a custom dump: list of (step, dict of columns sorted by id)."""
    frames = []
    with open(path) as f:
        lines = f.read().split("\n")
    i = 0
    while i < len(lines):
        if lines[i].startswith("ITEM: TIMESTEP"):
            step, count = int(lines[i + 1]), int(lines[i + 3])
            names = lines[i + 8].split()[2:]
            rows = [[float(w) for w in r.split()] for r in lines[i + 9:i + 9 + count]]
            table = np.array(rows).reshape(count, len(names))
            if "id" in names:
                table = table[np.argsort(table[:, names.index("id")])]
            frames.append((step, {n: table[:, q] for q, n in enumerate(names)}))
            i += 9 + count
        else:
            i += 1
    return frames


def head(box, dt, **values):
    """The script's beginning: an empty box. box: 'xlo xhi ylo yhi zlo zhi'."""
    return HEAD.format(**{**DEFAULTS, **values, "create": f"region box block {box} units box\ncreate_box 1 box", "dt": repr(dt)})


def head_with_particles(dt, **values):
    """The script's beginning: box and particles from the file particles.data."""
    return HEAD.format(**{**DEFAULTS, **values, "create": "read_data particles.data", "dt": repr(dt)})


def data_file(box, x, d, rho, v=None):
    """Text of particles.data: positions x (n,3), diameters, density, velocities (n,3) or none."""
    x = np.atleast_2d(x)
    d = np.broadcast_to(d, len(x))
    edges = [float(w) for w in box.split()]
    lines = ["particles", "", f"{len(x)} atoms", "1 atom types", ""]
    lines += [f"{edges[2 * a]!r} {edges[2 * a + 1]!r} {'xyz'[a]}lo {'xyz'[a]}hi" for a in range(3)]
    lines += ["", "Atoms", ""]
    lines += [f"{i + 1} 1 {float(d[i])!r} {float(rho)!r} " + " ".join(repr(float(q)) for q in x[i]) for i in range(len(x))]
    if v is not None:
        lines += ["", "Velocities", ""]
        lines += [f"{i + 1} " + " ".join(repr(float(q)) for q in v[i]) + " 0 0 0" for i in range(len(x))]
    return "\n".join(lines) + "\n"


WALL = "fix {id} all wall/gran model hooke/stiffness tangential history primitive type 1 {plane} {at!r} absolute_damping on\n"


def walls(**planes):
    """Primitive walls, e.g. walls(xplane=(0, 0.02), zplane=(0,))."""
    return "".join(WALL.format(id=f"wall_{p}{i}", plane=p, at=float(a)) for p, at in planes.items() for i, a in enumerate(at))


def narrow_bed():
    """The script's beginning: a box of 21.6 x 4.8 x 36 mm with floor and sides, open above, for spheres of 1.2 mm."""
    return head("0 0.0216 0 0.0048 0 0.036", 1.5e-5, boundary="f f f", skin=0.4e-3, gamman=0.01, gammat=0.005) + walls(xplane=(0, 0.0216), yplane=(0, 0.0048), zplane=(0,))


def poured(count, block="0.0007 0.0209 0.0007 0.0041 0.0007 0.03", radius=0.0006, regions=""):
    """Lines of a script after walls: fixes weight and motion, and spheres at random places of a block (region pour). regions: lines of others."""
    return f"""
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
fix ball all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant {radius!r}
fix mix all particledistribution/discrete 32452843 1 ball 1.0
region pour block {block} units box
{regions}fix pour all insert/pack seed 49979687 distributiontemplate mix vel constant 0 0 -0.1 insert_every once overlapcheck yes all_in yes particles_in_region {count} region pour
run 1
unfix pour
"""


def blown_beads(cells, steps, methods=""):
    """Lines of a script after walls: gas from below through beads in a box of cells[0] x 1 x cells[1] fine cells; fixes weight, integrate and gas,
    two runs, and at the end the dump end.STEPS of positions and velocities, sorted by id."""
    return f"""
fix weight all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine {cells[0]} 1 {cells[1]} ratio 2 1 2 density 1.2 viscosity 1.8e-5 every 4
{"fix_modify gas " + methods if methods else ""}
fix_modify gas boundary zlo inlet 0 0 0.7 boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
fix_modify gas output off
thermo_style custom step atoms f_gas[6] f_gas[7]
thermo_modify lost error norm no
thermo 4
dump end all custom {steps} end.* id x y z vx vy vz
dump_modify end format "%d %.17g %.17g %.17g %.17g %.17g %.17g" sort id first no
run {steps // 2}
run {steps // 2}
"""


def arguments():
    executable = sys.argv[1]
    ranks = [int(a) for a in sys.argv[2:] if not a.startswith("--")] or [1]
    return executable, ranks


def long_form():
    """Whether the command line asks for the long form of a test."""
    return "--long" in sys.argv


def column(table, name):
    """A column of a thermo table; LIGGGHTS' versions write computes and fixes with or without their prefix."""
    return table[name] if name in table else table[name[2:]]


def settled(executable, box, x, d, rho, steps, dt, **values):
    """Positions after `steps` without fluid, under gravity, in a box of walls."""
    e = [float(w) for w in box.split()]
    script = head_with_particles(dt, boundary="f f f", **values) + walls(xplane=e[0:2], yplane=e[2:4], zplane=e[4:6]) + f"""
fix grav all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
dump d all custom {steps} settled.txt id x y z
dump_modify d format "%d %.17g %.17g %.17g"
thermo {steps}
run {steps}
"""
    last = Run(executable, script, files={"particles.data": data_file(box, x, d, rho)}).dump("settled.txt")[-1][1]
    return np.stack([last[a] for a in "xyz"], axis=1)


def step_of(frame):
    return int(np.array(frame.attrs["step"] if "step" in frame.attrs else frame["step"][()]).item())


def gas_balance(path, inflow):
    """Largest |out - in - displaced| of the gas between floor and top over the frames, over inflow (m3/s)."""
    worst = 0.0
    with h5py.File(path) as f:
        x, y, z = (np.diff(f["grid/" + a][()]) for a in "xyz")
        area = np.outer(y, x)
        for name in sorted(f["fluid"])[1:]:  # the first frame is the state before any fluid step
            flux, rate = f["fluid/" + name]["faces/flux_z"], f["fluid/" + name]["faces/deps_dt"]
            into, out = np.sum(flux[0] * area), np.sum(flux[-1] * area)
            worst = max(worst, abs(out - into + np.sum(rate * z[:, None, None] * area)) / inflow)
    return worst


class MixtureBalance:
    """Vertical momentum of particles and gas between floor and top, from outside the coupling: particle velocities and
    wall forces of LIGGGHTS, written gas velocities, the pressure drop of the fix's vector.

    step, mv, wall, dp, U: at every DEM step, momentum and wall force of the particles, pressure drop, superficial inflow.
    weight: buoyant. The fluid's part lies in the frames of path, in which windows begin and end."""

    def __init__(self, path, rho, every, dt, weight, step, mv, wall, dp, U):
        self.step, self.mv, self.dp, self.every, self.dt, self.weight = step, mv, dp, every, dt, weight
        at, gas, out = [], [], []
        with h5py.File(path) as f:
            x, y, z = (np.diff(f["grid/" + a][()]) for a in "xyz")
            area = np.outer(y, x)
            for name in sorted(f["fluid"]):
                frame = f["fluid/" + name]
                eps, w = frame["eps"][()], frame["faces/uz"][()]
                below = np.concatenate([np.ones_like(eps[:1]), 0.5 * (eps[1:] + eps[:-1]), eps[-1:]])
                # The inlet's faces are not solved for; of the outlet's, half a volume lies inside. z: equal cells.
                height = np.concatenate([[0.0], z[1:], [0.5 * z[-1]]])
                at.append(step_of(frame))
                gas.append(rho * np.sum(below * w * area * height[:, None, None]))
                out.append(rho * np.sum((below * w * w)[-1] * area))
        self.frames, self.area = np.array(at), area.sum()
        self.gas, out = np.interp(step, at, gas), np.interp(step, at, out)
        self.coupled = step % every == 0
        self.push = np.where(self.coupled, (dp * self.area + rho * U * U * self.area - out) * every * dt, 0.0)
        # Impulses of DEM step s reach the velocities by halves in steps s and s + 1.
        self.wall = np.concatenate([[0.0], 0.5 * (wall[1:] + wall[:-1]) * dt])

    def window(self, begin, end, band=0):
        """Means over the weight: pressure, walls, change of momentum, and what the balance is open by. Steps are moved to
        frames. band: mean over all windows that begin and end up to so many steps further inside; it takes out the noise of
        the gas's momentum at a single moment."""
        begins = self.frames[(self.frames >= begin) & (self.frames <= begin + band)]
        ends = self.frames[(self.frames >= end - band) & (self.frames <= end)]
        result = np.mean([[self._one(b, e) for e in ends] for b in begins], axis=(0, 1))
        return dict(zip(("dp", "wall", "change", "error"), (*result[:3], abs(result[3]))), begin=begins[0], end=ends[-1])

    def _one(self, begin, end):
        window = (self.step > begin) & (self.step <= end)
        whole = self.weight * (end - begin) * self.dt
        i, j = np.searchsorted(self.step, [begin, end])
        change = self.mv[j] - self.mv[i] + self.gas[j] - self.gas[i]
        gained = self.push[window].sum() + self.wall[window].sum() - whole
        return (self.dp[window & self.coupled].mean() * self.area / self.weight, self.wall[window].sum() / whole, change / whole,
                (gained - change) / whole)
