#!/usr/bin/python3
"""The short mode of cases/round_bed: the STL surface, script, comparison and pictures work, on a thin bed and coarse cells.

Without this test the case could rot: a renamed keyword, a comparison that reads the wrong column, a vessel that leaks. What needs a long
mean (pressure against weight, symmetry) is printed by the comparison without a verdict.
"""
from harness import short_mode

if __name__ == "__main__":
    short_mode("round_bed", 7, "mean_void_fraction", "section", "snapshots", "profiles", "pressure", "grains")
