#!/usr/bin/python3
"""What is off costs nothing: instructions (valgrind's callgrind) of a plain scene in which every optional model is off, of two
programs: one of before a model came in, or built without its file, and one with it.

    off_costs_nothing.py WITH WITHOUT     two executables

Prints both counts and ends with 0 if the first costs at most 0.5 % more than the second. About a minute.
"""
import os
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))
from harness import data_file, head_with_particles, walls  # noqa: E402

MOST = 0.5  # %
L, H, D = 0.012, 0.024, 1e-3


def scene(steps):
    """A bed of 1000 grains through which gas blows: one size, one velocity, formulation B."""
    x = [(a, b, z) for z in (0.52e-3 + 1.02e-3 * k for k in range(10)) for b in (1e-3 + 1.1e-3 * k for k in range(10)) for a in (1e-3 + 1.1e-3 * k for k in range(10))]
    return data_file(f"0 {L} 0 {L} 0 {H}", x, D, 2500), head_with_particles(1e-5, boundary="f f f", gamman=0.01, gammat=0.005) + walls(
        xplane=(0, L), yplane=(0, L), zplane=(0,)) + f"""
fix weight all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 6 6 12 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas deposit trilinear prolong constant read cell
fix_modify gas boundary zlo inlet 0 0 0.5 boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
thermo 1000
run {steps}
"""


def instructions(executable, steps):
    data, text = scene(steps)
    with tempfile.TemporaryDirectory() as folder:
        for name, content in (("particles.data", data), ("in.test", text)):
            with open(os.path.join(folder, name), "w") as f:
                f.write(content)
        done = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", executable, "-in", "in.test"], cwd=folder,
                              env={**os.environ, "OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"},
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    found = re.search(r"Collected : (\d+)", done.stdout)
    if done.returncode or not found:
        sys.exit("callgrind run failed:\n" + done.stdout[-2000:])
    return int(found.group(1))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    counts = []
    for executable in map(os.path.abspath, sys.argv[1:]):
        counts.append(instructions(executable, 300) - instructions(executable, 100))  # what set-up costs falls out
        print(f"{executable}: {counts[-1] / 200 / 1000:.1f} instructions a particle and DEM step", flush=True)
    more = 100 * (counts[0] / counts[1] - 1)
    print(f"{'ok  ' if more <= MOST else 'FAIL'} the first costs {more:+.3f} % (wanted at most {MOST} %)")
    sys.exit(more > MOST)


if __name__ == "__main__":
    main()
