#!/usr/bin/python3
"""The short mode of cases/jetting_bed: script, comparison and pictures work, on a thin bed; and half the drag fails.

Without this test the case could rot: a renamed keyword, a comparison that reads the wrong column, a jet of another width. A jet's length
wants a long mean and a deep bed, and is printed by the comparison without a verdict.
"""
from harness import short_mode

if __name__ == "__main__":
    short_mode("jetting_bed", 7, "mean_void_fraction", "snapshots", "profiles", "pressure")
