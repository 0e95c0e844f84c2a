#!/usr/bin/python3
"""Writes the vessel's wall as a triangulated surface: a cylinder, open at both ends.

    make_stl.py FILE.stl [--radius 0.030] [--height 0.090] [--x 0.031] [--y 0.031] [--facets 120] [--turn 0]

--turn: degrees by which the facets' edges are turned about the axis. Lengths in m.
"""
import argparse

import numpy as np


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
    # The polygon has the circle's area: its corners stand a little outside, its facets' middles a little inside.
    n = o.facets
    corner = o.radius * np.sqrt(2 * np.pi / n / np.sin(2 * np.pi / n))
    angle = np.radians(o.turn) + 2 * np.pi * np.arange(n + 1) / n
    x, y = o.x + corner * np.cos(angle), o.y + corner * np.sin(angle)
    levels = np.linspace(0, o.height, 5)
    with open(o.file, "w") as f:
        f.write("solid vessel\n")
        for low, high in zip(levels[:-1], levels[1:]):
            for i in range(n):
                a, b = (x[i], y[i]), (x[i + 1], y[i + 1])
                for triangle in (((*a, low), (*b, low), (*b, high)), ((*a, low), (*b, high), (*a, high))):
                    f.write("facet normal 0 0 0\nouter loop\n")
                    for corner_at in triangle:
                        f.write("vertex %.9e %.9e %.9e\n" % corner_at)
                    f.write("endloop\nendfacet\n")
        f.write("endsolid vessel\n")


if __name__ == "__main__":
    main()
