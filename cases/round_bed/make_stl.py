#!/usr/bin/python3
"""Writes the vessel's wall as a triangulated surface: a cylinder, open at both ends.

    make_stl.py FILE.stl [--radius 0.030] [--height 0.090] [--x 0.031] [--y 0.031] [--facets 120] [--turn 0]

--turn: degrees by which the facets' edges are turned about the axis. Lengths in m.
"""
import argparse
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import revolve  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file")
    parser.add_argument("--radius", type=float, default=0.030)
    parser.add_argument("--height", type=float, default=0.090)
    parser.add_argument("--x", type=float, default=0.031)
    parser.add_argument("--y", type=float, default=0.031)
    parser.add_argument("--facets", type=int, default=120)
    parser.add_argument("--turn", type=float, default=0.0)
    o = parser.parse_args()
    revolve.write(o.file, "vessel", [(o.radius, z) for z in np.linspace(0, o.height, 5)], o.x, o.y, o.facets, o.turn)


if __name__ == "__main__":
    main()
