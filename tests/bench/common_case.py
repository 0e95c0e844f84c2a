#!/usr/bin/python3
"""What a whole coupled run costs, against LIGGGHTS' own particles alone: the common case that other codes were measured on.

    common_case.py EXECUTABLE [--fine NX NY NZ RX RY RZ] [--ranks N] [--to T] [--quick]

Box 44 x 10 x 150 mm, 15 x 3 x 50 fine cells (by default), 9240 spheres of 1.2 mm and 1000 kg/m3, air at 0.9 m/s superficial, pressure
outlet, no-slip walls; kn = kt = 100 N/m, e = 0.97, mu = 0.1; Ergun/Wen-Yu; DEM step 1e-5 s, coupled every 1e-4 s. A bed settled under
gravity from a random pack is blown up from t = 0; the first 0.2 s are dropped.

All in CPU seconds (user and system, all ranks), so that other load on the machine hardly counts:
  coupled    run to T less run to 0.2 s, from the same restart file
  stock      LIGGGHTS' own kernel and no gas, 500 steps from each of eight states of the coupled run, less start-up
  settled    the same from the settled bed
Printed: CPU s a simulated s, us a particle-step, ratios to stock; shares of time of the coupled run; mean and standard
deviation of the pressure drop.
"""
import argparse
import os
import re
import resource
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "system"))
from harness import read_thermo  # noqa: E402

MPIRUN = os.path.join(HERE, "..", "..", "cases", "mpirun.sh")
N, DT, EVERY, SKIP = 9240, 1e-5, 10, 0.2
WEIGHT = N * 1000 * np.pi / 6 * 1.2e-3**3 * (1 - 1.2 / 1000) * 9.81 / (44e-3 * 10e-3)  # Pa, buoyant

PARTICLES = """
units si
atom_style granular
boundary f f f
newton off
communicate single vel yes
processors {ranks} 1 1
{create}
neighbor 0.4e-3 bin
neigh_modify delay 0
soft_particles yes
fix kn all property/global kn peratomtypepair 1 100
fix kt all property/global kt peratomtypepair 1 100
fix gn all property/global gamman peratomtypepair 1 288.3
fix gt all property/global gammat peratomtypepair 1 144.15
fix mu all property/global coefficientFriction peratomtypepair 1 0.1
pair_style gran model hooke/stiffness tangential history
pair_coeff * *
timestep 1e-5
fix integrate all nve/sphere
fix gravity all gravity 9.81 vector 0 0 -1
fix left all wall/gran model hooke/stiffness tangential history primitive type 1 xplane 0
fix right all wall/gran model hooke/stiffness tangential history primitive type 1 xplane 0.044
fix front all wall/gran model hooke/stiffness tangential history primitive type 1 yplane 0
fix back all wall/gran model hooke/stiffness tangential history primitive type 1 yplane 0.010
fix bottom all wall/gran model hooke/stiffness tangential history primitive type 1 zplane 0
thermo_style custom step atoms ke cpu
thermo_modify lost error norm no
thermo 1000
"""
BOX = "region box block 0 0.044 0 0.010 0 0.150 units box\ncreate_box 1 box"
POUR = """
region fill block 0 0.044 0 0.010 0 0.066 units box
fix sphere all particletemplate/sphere 15485863 atom_type 1 density constant 1000 radius constant 0.6e-3
fix mix all particledistribution/discrete 32452843 1 sphere 1.0
fix fill all insert/pack seed 49979687 distributiontemplate mix vel constant 0 0 -0.4 insert_every once &
    overlapcheck yes all_in yes maxattempt 1000 particles_in_region 9240 region fill
run 1
unfix fill
run 40000
write_restart settled
"""
GAS = """
fix gas all twogrid fine {nx} {ny} {nz} ratio {rx} {ry} {rz} density 1.2 viscosity 1.8e-5 every 10
fix_modify gas drag ergun/wenyu formulation B deposit trilinear prolong constant read cell
fix_modify gas boundary zlo inlet 0 0 0.9 boundary zhi pressure 0
fix_modify gas boundary xlo noslip boundary xhi noslip boundary ylo noslip boundary yhi noslip
thermo_style custom step f_gas[1] f_gas[2] f_gas[3] f_gas[4] f_gas[6] f_gas[7] f_gas[10] cpu
thermo_modify lost error norm no
thermo 10
"""


class Bench:
    def __init__(self, executable, folder, ranks):
        self.executable, self.folder, self.ranks = os.path.abspath(executable), folder, ranks

    def run(self, name, script, options=(), ranks=None, prefix=()):
        """CPU seconds, and what was printed. prefix: what starts the program on every rank, such as valgrind."""
        with open(os.path.join(self.folder, "in." + name), "w") as f:
            f.write(script)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([MPIRUN, str(ranks or self.ranks), *prefix, self.executable, "-in", "in." + name, "-log", "log." + name, *options],
                              cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode:
            sys.exit(f"run {name} failed:\n{done.stdout[-3000:]}")
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout

    def head(self, create, ranks=None):
        return PARTICLES.format(create=create, ranks=ranks or self.ranks)

    def settle(self):
        if not os.path.exists(os.path.join(self.folder, "settled")):
            self.run("settle", self.head(BOX, 1) + POUR, ranks=1)

    def coupled(self, name, grid, stops):
        """From the settled bed through the given times (s), with a restart file at each; CPU seconds and output."""
        script = self.head("read_restart settled") + GAS.format(**dict(zip(("nx", "ny", "nz", "rx", "ry", "rz"), grid)))
        for i, (t, before) in enumerate(zip(stops, [0, *stops])):
            script += f"run {round((t - before) / DT)}\nwrite_restart {name}.{i}\n"
        return self.run(name, script)

    def particles_alone(self, state, steps, options):
        """CPU seconds of so many steps from a restart file, without gas and without start-up."""
        script = self.head(f"read_restart {state}")
        whole, _ = self.run("alone", script + f"run {steps}\n", options)
        start, _ = self.run("alone", script + "run 0\n", options)
        return whole - start


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("executable")
    parser.add_argument("--fine", type=int, nargs=6, default=[15, 3, 50, 1, 1, 1], metavar="N", help="fine cells and ratio")
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--to", type=float, default=1.0)
    parser.add_argument("--folder", help="where the runs are kept; a settled bed that is there is used again")
    parser.add_argument("--quick", action="store_true", help="two states, 0.3 s: shows that it works")
    a = parser.parse_args()
    end, states, steps = (0.3, 2, 200) if a.quick else (a.to, 8, 500)
    stops = [SKIP + (end - SKIP) * (i + 1) / states for i in range(states)]
    stock = ["-particles", "stock"]

    with tempfile.TemporaryDirectory() as scratch:
        folder = a.folder or scratch
        os.makedirs(folder, exist_ok=True)
        b = Bench(a.executable, folder, a.ranks)
        b.settle()
        long, text = b.coupled("gas", a.fine, stops)
        short, _ = b.coupled("start", a.fine, [SKIP])
        coupled = (long - short) / (end - SKIP)
        per_state = [b.particles_alone(f"gas.{i}", steps, stock) / (steps * DT) for i in range(states)]
        ours = [b.particles_alone(f"gas.{i}", steps, []) / (steps * DT) for i in range(states)]
        settled = b.particles_alone("settled", 2 * steps, stock) / (2 * steps * DT)
        settled_ours = b.particles_alone("settled", 2 * steps, []) / (2 * steps * DT)
        alone, alone_error = np.mean(per_state), np.std(per_state, ddof=1) / len(per_state)**0.5
        t = read_thermo(os.path.join(folder, "log.gas"))
        late = t["gas[1]"] > SKIP
        dp = t["gas[4]"][late]
        cells = int(np.prod(a.fine[:3]))
        print(f"{cells} fine cells, ratio {' '.join(map(str, a.fine[3:]))}, {a.ranks} ranks, {SKIP} to {end:g} s; CPU seconds a simulated second (us a particle-step)")
        show = lambda what, x, note="": print(f"  {what:48s} {x:8.1f}  ({x * DT / N * 1e6:.4f})  {note}")
        show("LIGGGHTS alone, bubbling states", alone, f"+- {alone_error:.1f} between states")
        show("particles alone as twogrid runs them, bubbling", np.mean(ours), f"{np.mean(ours) / alone:.3f} of LIGGGHTS")
        show("LIGGGHTS alone, settled bed", settled)
        show("particles alone as twogrid runs them, settled", settled_ours, f"{settled_ours / settled:.3f} of LIGGGHTS")
        show("coupled run", coupled, f"{coupled / alone:.3f} of LIGGGHTS bubbling, {coupled / settled:.3f} of LIGGGHTS settled")
        print(f"  pressure drop {dp.mean():.1f} Pa (weight {WEIGHT:.1f}), standard deviation {dp.std():.1f} Pa; pressure iterations "
              f"{t['gas[10]'][late].mean():.1f}")
        for line in re.findall(r"^twogrid: .*(?:%|share).*$", text, re.M)[-8:]:
            print("  " + line)


if __name__ == "__main__":
    main()
