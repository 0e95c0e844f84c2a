#!/usr/bin/python3
"""Verdict on a run of in.goldschmidt_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run of some tenths of a second; what needs a long
mean is told without a verdict.
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import flat_beds  # noqa: E402

D_P, RHO_P = 2.5e-3, 2526.0      # as in.goldschmidt_bed has it
LOW = (0.5, 0.9)                 # m/s, held before


def main():
    bed, verdict, short = flat_beds.begin(__doc__, D_P, RHO_P)
    flat_beds.carries_weight(bed, verdict, short)
    flat_beds.fluidises_as_wen_yu(bed, verdict, short, LOW, 12)
    flat_beds.bubbling(bed, verdict, short)
    flat_beds.end(bed, verdict, short, [50e-3, 100e-3, 150e-3], 0.35)


if __name__ == "__main__":
    main()
