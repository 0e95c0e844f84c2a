#!/usr/bin/python3
"""The short mode of cases/tube_bank: both scenes, comparison and pictures work, on fewer grains and coarse cells.

Without this test the case could rot: cylinders that grains and gas both see in a box that is periodic along them, the force on each of eight bodies, two
scenes in one script, a bank of tubes in gas alone against what is published. What needs a long mean (pressure against weight, minimum fluidisation,
symmetry) is printed by the comparison without a verdict.
"""
from harness import short_mode

if __name__ == "__main__":
    short_mode("tube_bank", 9, "mean_void_fraction", "cut", "snapshots", "profiles", "pressure", "grains")
