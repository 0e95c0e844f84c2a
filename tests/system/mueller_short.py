#!/usr/bin/python3
"""The short mode of cases/mueller_bed: script, comparison and picture work, and the bubbling bed carries its weight.

Without this test the case could rot: a renamed keyword, a comparison that reads the wrong profile, a bed that loses grains.
Pressure against weight is a coarse check on so short a mean (some two periods of 0.2 s of the bed's sloshing: 8 %).
"""
import csv
import os
import re
import tempfile

import numpy as np

from harness import Checks, arguments, half_the_drag, pictures_are_there, read_thermo, run_case

WEIGHT = 9240 * 1000 * np.pi / 6 * 1.2e-3**3 * (1 - 1.2 / 1000) * 9.81 / (44e-3 * 10e-3)  # Pa, buoyant


def main():
    executable, _ = arguments()
    c = Checks("short run of the bed of Mueller et al.")
    with tempfile.TemporaryDirectory() as out:
        done = run_case("mueller_bed", executable, 1, out)
        c.true("run and comparison end well, with all five profiles, and the law's drag", done.returncode == 0 and done.stdout.count("rms difference") == 5 and "PASS  vertical drag" in done.stdout)
        pictures_are_there(c, out, "profiles")
        rows = list(csv.DictReader(open(os.path.join(out, "profiles.csv"))))
        eps = np.array([float(r["twogrid"]) for r in rows if r["quantity"] == "void_fraction"])
        c.true(f"void fractions between {eps.min():.2f} and {eps.max():.2f} (wanted: within 0.35 to 1, not all alike)", 0.35 < eps.min() < eps.max() - 0.05 < 1)
        vz = np.array([float(r["twogrid"]) for r in rows if r["quantity"] == "particle_vz" and float(r["height_mm"]) == 25])
        c.true(f"grains rise in the middle ({vz[0]:+.3f} m/s) and sink at the walls ({vz[-2]:+.3f})", vz[0] > 0 > vz[-2])
        mean = np.loadtxt(os.path.join(out, "mean.txt"))
        dp = mean[mean[:, 1] > 0.35, 2].mean()
        c.below(f"pressure drop {dp:.1f} Pa against the weight {WEIGHT:.1f} Pa, relative", abs(dp / WEIGHT - 1), 0.08)
        t = read_thermo(os.path.join(out, "log.liggghts"))
        c.below("solid volume, relative error", max(t["gas[6]"] if "gas[6]" in t else t["f_gas[6]"]), 1e-13)
        c.below("momentum exchange, relative error", max(t["gas[7]"] if "gas[7]" in t else t["f_gas[7]"]), 1e-12)
        with open(os.path.join(out, "log.liggghts")) as f:
            atoms = re.findall(r"^Loop time of .* with (\d+) atoms", f.read(), re.M)
        c.true(f"{atoms[-1]} grains at the end (wanted: 9240)", atoms[-1] == "9240")
        half_the_drag(c, "mueller_bed", out)
    c.end()


if __name__ == "__main__":
    main()
