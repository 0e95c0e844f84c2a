#!/usr/bin/python3
"""The short modes of two_sizes, flat_spouted_bed, goldschmidt_bed, netl_bed and slot_spouted_bed under cases/: scripts, comparisons and pictures work, on fewer grains.

Without this test the cases could rot: four scenes in one script that change form and grains; a jet through a slot beside gas through the floor, both turned
up, or through the slot alone; walls, floor and lid in the balance of momentum; slices of large beds. What needs a long mean (segregation, spout, pressure against weight, symmetry) is printed by the
comparisons without a verdict.
"""
from harness import short_modes

USUAL = ("mean_void_fraction", "snapshots", "profiles", "pressure", "grains")

if __name__ == "__main__":
    short_modes(("two_sizes", 11, *USUAL, "two_sizes"), ("flat_spouted_bed", 6, *USUAL, "curve"), ("goldschmidt_bed", 6, *USUAL, "curve"),
                ("netl_bed", 6, *USUAL, "curve"), ("slot_spouted_bed", 6, *USUAL, "curve"))
