#!/usr/bin/python3
"""Ranks' parts of the box that follow the particles: a low bed in a high box, cut in height. LIGGGHTS' own parts leave the upper ranks without
particles; with the borders moved every rank has its share, and the motion is the same as in parts that stay, but for round-off.

Without this test particles could be lost at a border that moves, or read the fluid of where their rank was before; contacts could lose their
springs on the way to another rank; borders could move to and fro for ever, or not at all where they need several steps to arrive.
Usage: balance.py EXECUTABLE RANKS...
"""
import re

import numpy as np

from harness import Checks, Run, arguments, blown_beads, data_file, head_with_particles, walls

L, D, H = 0.0312, 0.00495, 0.072
STEPS = 400
CUTS = {2: ["1 1 2"], 4: ["1 1 4", "2 1 2"], 8: ["1 1 8"]}
METHODS = {
    "centroid, B": "deposit centroid prolong constant read cell formulation B",
    "trilinear, A, flux held": "deposit trilinear prolong linear read trilinear formulation A hold on",
    "exact": "deposit exact prolong linear read fine/trilinear formulation B",
}


def particles():
    random = np.random.default_rng(5)
    x = [((i + 0.5) * 0.8e-3, (j + 0.5) * 0.8e-3 + 2e-5, (k + 0.5) * 0.76e-3) for k in range(18) for j in range(6) for i in range(39)]
    return np.array(x) + random.uniform(-2e-6, 2e-6, (len(x), 3)), random.uniform(-0.25, 0.25, (len(x), 3))


def run(executable, cut, methods, balance, count):
    x, v = particles()
    script = head_with_particles(1.25e-5, processors=cut, boundary="f f f", gamman=2e-4, gammat=1e-4, skin=0.3e-3) + walls(
        xplane=(0, L), yplane=(0, D), zplane=(0,)) + blown_beads((26, 48), STEPS, methods)
    done = Run(executable, script, count, ["-fluid_pressure_rtol", "1e-13", "-balance", balance],
               files={"particles.data": data_file(f"0 {L} 0 {D} 0 {H}", [tuple(p) for p in x], 0.75e-3, 2500, v)})
    fullest = max(float(m) / float(a) for a, m in re.findall(r"^Nlocal:\s+([\d.eE+-]+) ave\s+([\d.eE+-]+) max", done.output, re.M)[-1:])
    table = done.thermo()
    return (np.loadtxt(done.file(f"end.{STEPS}"), skiprows=9)[:, 1:], fullest, max(table["gas[6]"]), max(table["gas[7]"]), done.output)


def main():
    executable, ranks = arguments()
    c = Checks("borders between ranks follow the particles")
    for name, methods in METHODS.items():
        one, *_ = run(executable, "1 1 1", methods, "off", 1)
        speed = np.abs(one[:, 3:]).max()
        first = name == "centroid, B"
        for n in ranks if first else [r for r in ranks if r <= 4]:
            for cut in CUTS[n] if first else CUTS[n][:1]:
                state, fullest, volume, momentum, text = run(executable, cut, methods, "on", n)
                c.note(f"{name}, {cut}: fullest rank {fullest:.2f} of the mean")
                c.true("it was said once", text.count("parts of the box follow") == 1)
                c.below("fullest rank over the mean", fullest, 1.2)
                c.below("velocities against one rank", np.abs(state - one)[:, 3:].max() / speed, 1e-8)
                if first and n <= 4:
                    fixed, before, *_ = run(executable, cut, methods, "off", n)
                    c.true(f"equal parts are uneven here, fullest rank {before:.2f}", before > 1.5)
                    c.below("velocities of equal parts against one rank", np.abs(fixed - one)[:, 3:].max() / speed, 1e-8)
                c.below("solid volume", volume, 1e-12)
                c.below("action and reaction", momentum, 1e-12)
    c.end()


if __name__ == "__main__":
    main()
