"""What the system tests share: running a LIGGGHTS script through twogrid and reading what it wrote.

A test is a script of its own:  TEST.py EXECUTABLE [RANKS ...].  It prints the measured figures and the wanted bounds and
ends with exit code 0 only if every check held.
"""
import os
import re
import subprocess
import sys
import tempfile

import numpy as np

MPIRUN = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1",
          "--mca", "btl", "self,vader"]

# Granular particles without contacts worth mentioning; fill in box, particles and fix.
HEAD = """
units si
atom_style granular
atom_modify map array
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
    """Collects checks; prints each with its figure."""

    def __init__(self, title):
        self.failed = 0
        print(f"== {title}", flush=True)

    def below(self, what, value, bound):
        good = bool(np.isfinite(value)) and value <= bound
        self.failed += not good
        print(f"{'ok  ' if good else 'FAIL'} {what}: {value:.3e} (wanted at most {bound:.3g})", flush=True)
        return good

    def true(self, what, condition):
        self.failed += not condition
        print(f"{'ok  ' if condition else 'FAIL'} {what}", flush=True)
        return condition

    def note(self, text):
        print(f"     {text}", flush=True)

    def end(self):
        sys.exit(1 if self.failed else 0)


class Run:
    """A finished run: its log, thermo table, dumps and output file in a scratch folder of its own."""

    def __init__(self, executable, script, ranks=1, options=(), timeout=100, expect_success=True, files=None):
        self.folder = tempfile.TemporaryDirectory(prefix="twogrid_test_")
        self.path = self.folder.name
        for name, text in (files or {}).items():
            with open(os.path.join(self.path, name), "w") as f:
                f.write(text)
        with open(os.path.join(self.path, "in.test"), "w") as f:
            f.write(script)
        command = MPIRUN + ["-np", str(ranks), os.path.abspath(executable), "-in", "in.test", *options]
        done = subprocess.run(command, cwd=self.path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=timeout)
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


def read_thermo(path):
    """All thermo lines of all runs in a log as a dict of columns; headers must not change between runs."""
    names, rows = None, []
    with open(path) as f:
        for line in f:
            words = line.split()
            if words and words[0] == "Step":
                names = words
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


def arguments():
    executable = sys.argv[1]
    ranks = [int(a) for a in sys.argv[2:]] or [1]
    return executable, ranks
