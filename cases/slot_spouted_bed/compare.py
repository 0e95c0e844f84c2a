#!/usr/bin/python3
"""Verdict on a run of in.slot_spouted_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run of some tenths of a second; what needs a long
mean is told without a verdict.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import flat_beds  # noqa: E402
import plot_fields  # noqa: E402
from verdict import G  # noqa: E402

D_P, RHO_P = 2.5e-3, 2500.0      # as in.slot_spouted_bed has it
WIDTH, SLOT = 280.0e-3, 24.0e-3


def spouts_as_mathur_gishler(bed, verdict, short):
    """Above minimum spouting the void over the slot reaches through the bed. Mathur & Gishler (1955), with the circles of the areas of bed and slot."""
    H0, depth = flat_beds.height_at_rest(bed), np.ptp(bed.y)
    D, Di = np.sqrt(4 / np.pi * WIDTH * depth), np.sqrt(4 / np.pi * SLOT * depth)
    U_ms = D_P / D * (Di / D)**(1 / 3) * np.sqrt(2 * G * H0 * (RHO_P - bed.rho_f) / bed.rho_f)
    U, reach = bed.inflow / bed.section, flat_beds.void_over_the_slot(bed)
    through = reach is None or reach > H0
    verdict(through or U < 1.3 * U_ms, f"gas over the section {U:.3f} m/s is {U / U_ms:.2f} of minimum spouting by Mathur & Gishler (1955), {U_ms:.3f} m/s; the void over the slot reaches " +
            ("through the bed" if reach is None else f"{1e3 * reach:.0f} mm") + f", the bed at rest {1e3 * H0:.0f} mm (wanted: through the bed from 1.3 on)", short,
            [("reach over the height at rest", 1.0 if U > 1.3 * U_ms else 0.0, 9.0 if reach is None else reach / H0, np.inf)])


def pressure(bed, verdict, short):
    """Balance of momentum; the pressure drop from floor and slot, and its peak before the jet breaks through."""
    dp, share, scatter = flat_beds.balance(bed, verdict, short)
    p = bed.file["average/fine/p"][:]
    slot = np.abs(plot_fields.centres(bed.x) - WIDTH / 2) < SLOT / 2
    verdict.note(f"mean pressure drop from the floor {dp.mean():.0f} Pa, {share:.3f} +- {scatter:.3f} of the buoyant weight; from the cells over the slot {p[0][:, slot].mean() - p[-1].mean():.0f} Pa")
    k = int(np.argmax(bed.mean[:, 1]))
    verdict.note(f"largest pressure drop {bed.mean[k, 1] * bed.section / bed.weight:.2f} of the weight, at {bed.mean[k, 0] * bed.step:.2f} s, with {np.interp(bed.mean[k, 0], bed.now[:, 0], bed.now[:, 12]):.1f} m/s in the slot")


def main():
    bed, verdict, short = flat_beds.begin(__doc__, D_P, RHO_P)
    pressure(bed, verdict, short)
    flat_beds.spout(bed, verdict, short)
    spouts_as_mathur_gishler(bed, verdict, short)
    flat_beds.rhythm(bed, verdict)
    flat_beds.end(bed, verdict, short, [50e-3, 100e-3, 150e-3], 0.6)


if __name__ == "__main__":
    main()
