#!/usr/bin/python3
"""-skin best: where the script's skin is 0.08 diameters, neighbour lists and motion are those of a script with the better skin: the same bits on one
rank, and the same but for round-off on several. Beads that bounce in a gas.

Not those of the script's own skin: LIGGGHTS 3.8 keeps the tangential spring of a contact that opens until the next list, so that a contact which
closes again before starts with it. With neigh_modify contact_distance_factor 1.01 it doesn't, and the skin has no effect but round-off.

Without this test a list could miss pairs that come into contact (a skin that LIGGGHTS takes over only in part: ghosts, the trigger for new lists, the
region a rank's particles may lie in), and the option could do nothing.
Usage: skin.py EXECUTABLE RANKS...
"""
import re

import numpy as np

from harness import Checks, Run, arguments, blown_beads, data_file, head_with_particles, walls

L, D, H = 0.0312, 0.00495, 0.036
STEPS, SIZE, SKIN = 600, 0.75e-3, 0.06e-3


def run(executable, count, options, skin=SKIN, neighbours="delay 0"):
    random = np.random.default_rng(5)
    x = np.array([((i + 0.5) * 0.8e-3, (j + 0.5) * 0.8e-3 + 2e-5, (k + 0.5) * 0.8e-3) for k in range(18) for j in range(6) for i in range(39)])
    v = random.uniform(-0.4, 0.4, x.shape)
    script = head_with_particles(1.25e-5, processors=f"{count} 1 1", boundary="f f f", gamman=2e-4, gammat=1e-4, skin=skin).replace(
        "neigh_modify delay 0", f"neigh_modify {neighbours}") + walls(xplane=(0, L), yplane=(0, D), zplane=(0,)) + blown_beads((26, 24), STEPS)
    done = Run(executable, script, count, ["-fluid_pressure_rtol", "1e-13", *options],
               files={"particles.data": data_file(f"0 {L} 0 {D} 0 {H}", [tuple(p) for p in x], SIZE, 2500, v)})
    builds = sum(int(n) for n in re.findall(r"^Neighbor list builds = (\d+)", done.output, re.M))
    dangerous = sum(int(n) for n in re.findall(r"^Dangerous builds = (\d+)", done.output, re.M))
    return np.loadtxt(done.file(f"end.{STEPS}"), skiprows=9)[:, 1:], builds, dangerous, done.output


def main():
    executable, ranks = arguments()
    c = Checks("-skin best")
    plain, many, *_ = run(executable, 1, [])
    wanted, wanted_lists, *_ = run(executable, 1, [], skin=0.475 * SIZE)
    speed = np.abs(wanted[:, 3:]).max()
    for n in ranks:
        state, few, dangerous, text = run(executable, n, ["-skin", "best"])
        c.note(f"{n} ranks: {few} new lists in place of {many}")
        c.true("the scene report says so", "0.475 diameters (the script's is 6e-05 m)" in text)
        c.true("about as many new lists as with that skin in the script, a fraction of the script's own",
               abs(few - wanted_lists) <= (n > 1) and few < 0.4 * many)
        c.true("none came late", dangerous == 0)
        if n == 1:
            c.true("the same bits as with that skin in the script", np.array_equal(state, wanted))
        c.below("velocities against one rank with that skin", np.abs(state - wanted)[:, 3:].max() / speed, 1e-8)
    c.true("the script's own skin: other springs", np.abs(plain - wanted)[:, 3:].max() > 1e-4 * speed)
    factor = "delay 0 contact_distance_factor 1.01"
    reset, *_ = run(executable, 1, ["-skin", "best"], neighbours=factor)
    reset_plain, *_ = run(executable, 1, [], neighbours=factor)
    c.below("velocities against the script's skin, springs that are zeroed", np.abs(reset - reset_plain)[:, 3:].max() / speed, 1e-8)
    kept, as_many, *_ = run(executable, 1, ["-skin", "script"])
    c.true("-skin script: the same bits", as_many == many and np.array_equal(kept, plain))
    good, lists, _, text = run(executable, 1, ["-skin", "best"], skin=0.4 * SIZE)
    same, same_lists, *_ = run(executable, 1, [], skin=0.4 * SIZE)
    c.true("a good skin stays: the same bits", lists == same_lists and np.array_equal(good, same) and "neighbour skin" not in text)
    c.end()


if __name__ == "__main__":
    main()
