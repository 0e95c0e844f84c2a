#!/usr/bin/python3
"""Verdict on a run of in.first_bed, and its pictures.

    compare.py FOLDER [--short]     FOLDER: what the run wrote (first_bed.h5, pressure.txt, status.json)

Prints PASS or FAIL for every check, draws FOLDER/*.png, ends with 0 if all passed. --short: of a run of some hundredths of a second.
"""
import json
import os
import sys

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import drag_check  # noqa: E402
import leg_tables  # noqa: E402
import plot_fields  # noqa: E402
from verdict import G, NO_PICTURES, Verdict, batch_error, command_line, same_grains, save  # noqa: E402

# As in.first_bed has it.
D_P, RHO_P, DEM_STEP = 1.2e-3, 1000.0, 1.5e-5


def grains(file, status, verdict):
    """None is lost, and none is outside of the box."""
    first, last = (file["particles"][n]["position"][:] for n in (plot_fields.frames(file)[0], plot_fields.frames(file)[-1]))
    verdict(len(first) == len(last) == status["particles"] and status["particles_lost"] == 0, f"grains: {len(first)} at the beginning, {len(last)} at the end")
    edges = plot_fields.nodes(file)
    out = max(max((e[0] - last[:, k]).max(), (last[:, k] - e[-1]).max()) for k, e in enumerate(edges)) + D_P / 2
    verdict.between(-np.inf, out / D_P, 0.1, f"deepest overlap of a grain with a wall: {1e3 * max(out, 0):.3f} mm (wanted: at most {0.1e3 * D_P:.2f}, soft contacts)")
    return len(last)


def ledger(status, verdict):
    book = status["ledger"]
    verdict.at_most(1e-13, book["solids_volume_error"], f"solid volume deposited: relative error {book['solids_volume_error']:.1e} (wanted 1e-13)")
    verdict.at_most(1e-12, book["momentum_error"], f"action and reaction: relative error {book['momentum_error']:.1e} (wanted 1e-12)")


def pressure(folder, file, n, short, verdict):
    """The gas carries no more than the bed, and much of it: floor and rubbing walls carry the rest."""
    rho_f = float(file["record"].attrs["density"])
    x, y, _ = plot_fields.nodes(file)
    weight = n * np.pi / 6 * D_P**3 * (RHO_P - rho_f) * G / (np.ptp(x) * np.ptp(y))
    table = leg_tables.table(os.path.join(folder, "pressure.txt"))
    time = (table[:, 0] - table[0, 0]) * DEM_STEP
    dp = table[time >= float(file["average"].attrs["from"]), 1]
    verdict.between(0.5, dp.mean() / weight, 1.1, f"mean pressure drop {dp.mean():.1f} +- {batch_error(dp):.1f} Pa, of a weight over the area of {weight:.1f} Pa (wanted: 0.5 to 1.1 of it)", short)


def main():
    folder, short = command_line(__doc__)
    file, verdict = h5py.File(os.path.join(folder, "first_bed.h5"), "r"), Verdict()
    with open(os.path.join(folder, "status.json")) as f:
        status = json.load(f)
    same_grains(folder, file, D_P, RHO_P)
    n = grains(file, status, verdict)
    ledger(status, verdict)
    pressure(folder, file, n, short, verdict)
    drag_check.check(file, verdict)
    frames = len(plot_fields.frames(file))
    if not NO_PICTURES:
        save({"mean_void_fraction": plot_fields.mean_void_fraction(file), "profiles": plot_fields.profiles(file, [10e-3, 20e-3, 30e-3]), "pressure": plot_fields.pressure_profile(file),
              "snapshots": plot_fields.snapshots(file, sorted({frames // 3, 2 * frames // 3, frames - 1}))}, folder)
    verdict.end()


if __name__ == "__main__":
    main()
