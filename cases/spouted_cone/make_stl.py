#!/usr/bin/python3
"""Writes the vessel's wall (nozzle, base, cone, cylinder above) and the screen over the nozzle as triangulated surfaces.

    make_stl.py VESSEL.stl SCREEN.stl [--facets 96] [--turn 0]

--turn: degrees by which the facets' edges are turned about the axis. The lengths are below, in m; in.spouted_cone and compare.py have the same.
"""
import argparse
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import revolve  # noqa: E402

X0 = Y0 = 31e-3                  # the axis
NOZZLE, BASE, TOP = 8e-3, 12e-3, 30e-3   # radii: of the gas inlet, of the cone's base, of the cylinder above the cone
HALF_ANGLE = 18.0                # degrees
FLOOR, HEIGHT = 6e-3, 126e-3     # length of the nozzle, of the whole
SHOULDER = FLOOR + (TOP - BASE) / np.tan(np.radians(HALF_ANGLE))  # where the cone ends


def radius(z):
    """Of the vessel at the height z."""
    return np.where(z < FLOOR, NOZZLE, np.minimum(BASE + (z - FLOOR) * np.tan(np.radians(HALF_ANGLE)), TOP))


def line(low, high, pieces):
    """Points of a straight line, without its last."""
    return [tuple(low + (high - low) * i / pieces) for i in range(pieces)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("vessel")
    parser.add_argument("screen")
    parser.add_argument("--facets", type=int, default=96)
    parser.add_argument("--turn", type=float, default=0.0)
    o = parser.parse_args()
    corners = [np.array(c) for c in ((NOZZLE, 0), (NOZZLE, FLOOR), (BASE, FLOOR), (TOP, SHOULDER), (TOP, HEIGHT))]
    profile = [p for low, high, n in zip(corners[:-1], corners[1:], (1, 1, 12, 4)) for p in line(low, high, n)] + [tuple(corners[-1])]
    revolve.write(o.vessel, "vessel", profile, X0, Y0, o.facets, o.turn)
    revolve.write(o.screen, "screen", [(0, FLOOR), (NOZZLE, FLOOR)], X0, Y0, 24, o.turn)


if __name__ == "__main__":
    main()
