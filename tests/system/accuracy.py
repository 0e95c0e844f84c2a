#!/usr/bin/python3
"""`every auto` with `accuracy X`: a block of grains sinks in a closed box of liquid, against the same run coupled at every DEM step
with a tolerance and Courant number far below what is needed.

Without this test, steps could be chosen that miss the wanted error, or that keep it at the cost of the finest run; and the
checks that compare with a finer step could leave traces in the run they check (continued from a state not restored in
full), which no result would show. Also: where an error doesn't fall with its step, the noise of centroid deposition, the
steps must not shrink without end, and the user must be told.
"""
import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles, walls

W, D, H, d = 0.016, 0.004, 0.032, 1e-3
STEPS = 6400


def script(gas, keywords):
    x = [(a, b, z) for z in 0.018 + 1.05 * d * np.arange(10) for b in d * (0.75 + 1.25 * np.arange(3)) for a in 0.0045 + 1.05 * d * np.arange(8)]
    return data_file(f"0 {W} 0 {D} 0 {H}", x, d, 2500), head_with_particles(1.5e-5, boundary="f f f", gamman=0.003, gammat=0.0015) + walls(
        xplane=(0, W), yplane=(0, D), zplane=(0, H)) + f"""
fix grav all gravity 9.81 vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 16 1 32 ratio 4 1 4 density 1000 viscosity 0.02 {gas}
fix_modify gas hold off {keywords}
compute vz all reduce ave vz
thermo {STEPS // 10}
thermo_style custom step atoms c_vz f_gas[1] f_gas[11] f_gas[12] f_gas[13]
thermo_modify format float %.17g
run {STEPS}
"""


SMOOTH = "deposit trilinear prolong linear read trilinear"


def run(executable, gas, keywords):
    data, text = script(gas, keywords)
    r = Run(executable, text, 1, files={"particles.data": data}, timeout=120)
    t = r.thermo()
    column = lambda i: t[f"f_gas[{i}]"] if f"f_gas[{i}]" in t else t[f"gas[{i}]"]
    v = t["c_vz"] if "c_vz" in t else t["vz"]
    said = [line for line in r.output.split("\n") if "accuracy of the steps" in line or "steps in time are" in line]
    return dict(v=v, every=column(13), said=said)


def main():
    executable, _ = arguments()
    c = Checks("accuracy of the steps in time")
    finest = run(executable, "every 1", SMOOTH + " cfl 0.1 tolerance 1e-8")["v"]
    size = np.sqrt(np.mean(finest**2))
    for wanted in (0.1, 0.03, 0.01):
        r = run(executable, "every auto", f"{SMOOTH} accuracy {wanted}")
        error = np.sqrt(np.mean((r["v"] - finest)**2)) / size
        c.note(r["said"][0])
        c.below(f"accuracy {wanted}: error of the block's velocity", error, wanted)
        c.true(f"accuracy {wanted}: coupled every {r['every'][-1]:.0f} DEM steps at last (wanted: more than 1)", r["every"][-1] > 1)

    plain = run(executable, "every 10", SMOOTH + " cfl 0.4 tolerance 1e-6")["v"]
    checked = run(executable, "every 10", SMOOTH + " accuracy 0.01 cfl 0.4 tolerance 1e-6")["v"]
    c.true("checks change no bit of the run they check", np.array_equal(plain, checked))

    noisy = run(executable, "every auto", "deposit centroid read cell accuracy 0.001")
    for line in noisy["said"]:
        c.note(line)
    c.true("an accuracy that is out of reach is said to be missed", any("less accurate than wanted" in line for line in noisy["said"]))
    c.end()


if __name__ == "__main__":
    main()
