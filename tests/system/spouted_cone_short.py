#!/usr/bin/python3
"""The short mode of cases/spouted_cone: surfaces, script, comparison and pictures work, on fewer grains and coarse cells.

Without this test the case could rot: a nozzle that leads from an inlet into a vessel with the inlet's side closed behind it, a mesh that only
grains feel beside one that is the gas's wall, the balance of momentum of a cone. What needs a long mean (the spout, minimum spouting, symmetry) is
printed by the comparison without a verdict.
"""
from harness import short_mode

if __name__ == "__main__":
    short_mode("spouted_cone", 8, "mean_void_fraction", "cut", "curve", "snapshots", "profiles", "pressure", "grains")
