#!/usr/bin/python3
"""A model that is off costs nothing: instructions (valgrind's callgrind) of a plain scene, with all optional models compiled in but
off, against builds that leave out each of them (cfd/compiled.h).

    off_costs_nothing.py BUILD_FOLDER [MODEL ...]     BUILD_FOLDER: scratch for the builds; default: every model, and all

Prints the table and ends with 0 if no model costs more than 0.1 % while off. Some 15 minutes on one core.
"""
import os
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))
from harness import data_file, head_with_particles, walls  # noqa: E402

MODELS = ["hold", "held", "accuracy", "formulation_a", "polydisperse", "gap_friction", "flow_rate"]
SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
L, H, D = 0.012, 0.024, 1e-3


def scene(steps):
    """A bed of 1000 grains through which gas blows: one size, one velocity, formulation B."""
    x = [(a, b, z) for z in (0.52e-3 + 1.02e-3 * k for k in range(10)) for b in (1e-3 + 1.1e-3 * k for k in range(10)) for a in (1e-3 + 1.1e-3 * k for k in range(10))]
    return data_file(f"0 {L} 0 {L} 0 {H}", x, D, 2500), head_with_particles(1e-5, boundary="f f f", gamman=0.01, gammat=0.005) + walls(
        xplane=(0, L), yplane=(0, L), zplane=(0,)) + f"""
fix weight all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 6 6 12 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas deposit trilinear prolong linear read trilinear
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


def build(folder, without):
    path = os.path.join(folder, "without_" + "_".join(without) if without else "with_all")
    subprocess.run(["cmake", "-S", SOURCE, "-B", path, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DTWOGRID_WITHOUT=" + ";".join(without)],
                   check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", path, "twogrid"], check=True, stdout=subprocess.DEVNULL)
    return os.path.join(path, "twogrid")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    folder, chosen = os.path.abspath(sys.argv[1]), sys.argv[2:] or MODELS
    count = lambda e: instructions(e, 300) - instructions(e, 100)  # what set-up costs falls out
    plain = count(build(folder, []))
    print(f"all models compiled in, off: {plain / 200 / 1000:.0f} instructions a particle and DEM step", flush=True)
    failed = False
    for without in ([MODELS] if len(chosen) > 1 else []) + [[m] for m in chosen]:
        lean = count(build(folder, without))
        more = 100 * (plain / lean - 1)
        failed |= more > 0.1
        name = without[0] if len(without) == 1 else "all of them"
        print(f"{'ok  ' if more <= 0.1 else 'FAIL'} {name}: costs {more:+.4f} % while off (wanted at most 0.1 %)", flush=True)
    sys.exit(failed)


if __name__ == "__main__":
    main()
