"""Triangulated surfaces of revolution about a vertical axis, as STL files: walls of vessels for LIGGGHTS and for the gas."""
import numpy as np


def write(path, name, profile, x, y, facets=120, turn=0.0):
    """profile: corners (radius, height) of the line that turns about the axis at x, y (m); turn: degrees by which the facets' edges are
    turned. The polygon has the circle's area: its corners stand a little outside, its facets' middles a little inside."""
    stretch = np.sqrt(2 * np.pi / facets / np.sin(2 * np.pi / facets))
    angle = np.radians(turn) + 2 * np.pi * np.arange(facets + 1) / facets
    ring = [np.stack([x + r * stretch * np.cos(angle), y + r * stretch * np.sin(angle), np.full(facets + 1, z)], axis=1) for r, z in profile]
    with open(path, "w") as f:
        f.write(f"solid {name}\n")
        for (lower, _), low, (upper, _), high in zip(profile[:-1], ring[:-1], profile[1:], ring[1:]):
            for i in range(facets):
                a, b, c, d = low[i], low[i + 1], high[i + 1], high[i]
                for triangle in ([(a, b, c)] if lower > 0 else []) + ([(a, c, d)] if upper > 0 else []):
                    f.write("facet normal 0 0 0\nouter loop\n")
                    for corner in triangle:
                        f.write("vertex %.9e %.9e %.9e\n" % tuple(corner))
                    f.write("endloop\nendfacet\n")
        f.write(f"endsolid {name}\n")
