#!/usr/bin/python3
"""Verdict on a run of in.flat_spouted_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run of some tenths of a second; what needs a long
mean is told without a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import flat_beds  # noqa: E402
from verdict import G  # noqa: E402

D_P, RHO_P = 3.0e-3, 2505.0      # as in.flat_spouted_bed has it
DEPTH, SLOT = 20.0e-3, 5.0e-3
LOW = (0.5, 0.9)                 # m/s, held before


def jet(bed, verdict, short):
    """How far the void over the slot reaches, against jets' lengths."""
    reach, H0, U = flat_beds.void_over_the_slot(bed), flat_beds.height_at_rest(bed), bed.inlet.max()
    d0 = np.sqrt(4 / np.pi * SLOT * DEPTH)  # circle of the slot's area
    froude = U**2 / (G * d0)
    keairns = 6.5 * d0 * np.sqrt(bed.rho_f / (RHO_P - bed.rho_f) * froude)
    merry = 5.2 * d0 * (bed.rho_f * d0 / (RHO_P * D_P))**0.3 * (1.3 * froude**0.2 - 1)
    low, high = 0.6 * min(merry, keairns), 1.4 * max(merry, keairns)
    verdict.between(low, H0 if reach is None else reach, high, "the void over the slot reaches " + ("through the whole bed" if reach is None else f"{1e3 * reach:.0f} mm") + f"; jets of that slot reach {1e3 * merry:.0f} mm by Merry (1975), {1e3 * keairns:.0f} mm by Yang & Keairns (1978), the bed's height at rest is {1e3 * H0:.0f} mm "
                    "(wanted: between the lower less 40 % and the higher plus 40 %; through the bed counts as its height)", short)


def main():
    bed, verdict, short = flat_beds.begin(__doc__, D_P, RHO_P)
    flat_beds.carries_weight(bed, verdict, short)
    flat_beds.fluidises_as_wen_yu(bed, verdict, short, LOW, 13)
    flat_beds.spout(bed, verdict, short)
    jet(bed, verdict, short)
    flat_beds.rhythm(bed, verdict)
    flat_beds.end(bed, verdict, short, [30e-3, 60e-3, 100e-3], 0.4)


if __name__ == "__main__":
    main()
