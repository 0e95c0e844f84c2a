#!/usr/bin/python3
"""Verdict on a run of in.netl_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run of some tenths of a second; what needs a long
mean is told without a verdict.
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import flat_beds  # noqa: E402

D_P, RHO_P = 3.256e-3, 1131.0    # as in.netl_bed has it
LOW = (0.4, 0.7)                 # m/s, held before
MEASURED = 1.05                  # m/s, minimum fluidisation


def main():
    bed, verdict, short = flat_beds.begin(__doc__, D_P, RHO_P)
    flat_beds.carries_weight(bed, verdict, short)
    U_mf = flat_beds.fluidises_as_wen_yu(bed, verdict, short, LOW, 12)
    verdict.between(0.8, U_mf / MEASURED, 1.2, f"minimum fluidisation by the packed bed {U_mf:.3f} m/s, measured {MEASURED} m/s (wanted: 20 %)", short)
    flat_beds.bubbling(bed, verdict, short)
    flat_beds.rhythm(bed, verdict)
    flat_beds.end(bed, verdict, short, [50e-3, 100e-3, 150e-3], 0.6)


if __name__ == "__main__":
    main()
