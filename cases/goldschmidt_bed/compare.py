#!/usr/bin/python3
"""Verdict on a run of in.goldschmidt_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run of some tenths of a second; what needs a long
mean is told without a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import flat_beds  # noqa: E402
import picture_3d  # noqa: E402
from verdict import NO_PICTURES, Bed, Verdict, command_line, ledgers, save, save_compared, usual_pictures  # noqa: E402

D_P, RHO_P = 2.5e-3, 2526.0      # as in.goldschmidt_bed has it
LOW = (0.5, 0.9)                 # m/s, held before


def main():
    folder, short = command_line(__doc__)
    now = np.loadtxt(os.path.join(folder, "now.txt"), ndmin=2)
    bed, verdict = Bed(folder, D_P, RHO_P, (now[-1, 4] - now[0, 4]) / (now[-1, 0] - now[0, 0])), Verdict()
    verdict.note(f"{bed.n:.0f} grains, {bed.inflow / bed.section:.3f} m/s, {bed.length:.2f} s, means from {bed.begin:.2f} s")
    ledgers(bed, verdict)
    drag_check.check(bed.file, verdict)
    flat_beds.carries_weight(bed, verdict, short)
    flat_beds.fluidises_as_wen_yu(bed, verdict, short, LOW, 12)
    flat_beds.bubbling(bed, verdict, short)
    flat_beds.left_and_right(bed, verdict, short, bed.solids * RHO_P)
    save_compared(folder, flat_beds.compared(bed))
    if not NO_PICTURES:
        save({**usual_pictures(bed, [50e-3, 100e-3, 150e-3], top=0.35), "curve": flat_beds.curve(bed)}, bed.folder)
    picture_3d.draw(os.path.join(bed.folder, "bed.h5"), os.path.join(bed.folder, "grains.png"), cut="none")
    verdict.end()


if __name__ == "__main__":
    main()
