#!/usr/bin/python3
"""The short modes of cases/sedimentation and cases/liquid_bed: scripts, comparisons and pictures work, on fewer grains.

Without this test the cases could rot: several scenes in one script, by clear and next, each with a file of its own; a column that nothing flows through; an
inlet whose velocity goes down in steps; the drag of two sizes in formulation B, computed anew. Fronts and expansion are printed without a verdict.
"""
from harness import short_modes

if __name__ == "__main__":
    short_modes(("sedimentation", 5, "mean_void_fraction", "sedimentation", "snapshots", "profiles", "grains"),
                ("liquid_bed", 6, "mean_void_fraction", "liquid_bed", "snapshots", "profiles", "grains"))
