#!/usr/bin/python3
"""A whole coupled run of 100 fluid steps on 1 against 2, 4 and 8 ranks: the fields agree to 1e-6, no particle is lost.

Without this test a halo filled late, a particle binned twice at a border, or a reaction lost there would pass, since
each run by itself looks right.
"""
import h5py
import numpy as np

from continuity import script
from harness import Checks, Run, arguments


def last(path):
    with h5py.File(path) as f:
        k = sorted(f["fluid"])[-1]
        return {n: f[f"fluid/{k}/{n}"][()] for n in ("u", "p", "eps")}, f["particles/" + sorted(f["particles"])[-1] + "/id"].shape[0]


def main():
    executable, ranks = arguments()
    c = Checks("whole run on several ranks")
    data, text = script(2)
    text = text.replace("output every 2 ", "output every 200 ").replace("run 24", "run 200").replace("thermo 2\n", "thermo 100\n")
    fields = {}
    for n in [1] + [r for r in ranks if r != 1]:
        r = Run(executable, text, n, ["-fluid_pressure_rtol", "1e-10"], files={"particles.data": data})
        fields[n] = last(r.file("bed.h5"))
    reference, count = fields[1]
    for n, (found, particles) in fields.items():
        if n == 1:
            continue
        c.true(f"{n} ranks: {particles} particles, {count} wanted", particles == count)
        for name in found:
            error = np.abs(found[name] - reference[name]).max() / np.abs(reference[name]).max()
            c.below(f"{n} ranks: {name} differs by", error, 1e-6)
    c.end()


if __name__ == "__main__":
    main()
