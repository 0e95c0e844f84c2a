"""Random beds of spheres of one diameter with a given profile of the void fraction, and the drag of ergun/wenyu.

All lengths in diameters where not said otherwise.
"""
import functools

import numpy as np


def neighbours(x, box, reach):
    """Pairs (i, j), i < j, closer than reach; x and y periodic, z too if periodic_z. Sorted into cells of that width."""
    n = np.maximum(1, (box / reach).astype(int))
    cell = np.minimum((x / box * n).astype(int), n - 1)
    flat = (cell[:, 2] * n[1] + cell[:, 1]) * n[0] + cell[:, 0]
    order = np.argsort(flat, kind="stable")
    start = np.searchsorted(flat[order], np.arange(n.prod() + 1))
    found = []
    for shift in np.ndindex(3, 3, 3):
        other = (cell + np.array(shift) - 1) % n
        o = (other[:, 2] * n[1] + other[:, 1]) * n[0] + other[:, 0]
        count = start[o + 1] - start[o]
        i = np.repeat(np.arange(len(x)), count)
        j = order[np.repeat(start[o] - np.concatenate(([0], np.cumsum(count)[:-1])), count) + np.arange(count.sum())]
        found.append(np.stack([i, j], 1)[i < j])
    pairs = np.concatenate(found)
    return np.unique(pairs, axis=0) if (n < 3).any() else pairs


@functools.lru_cache(maxsize=None)
def random_bed(width, height, eps, seed, periodic_z=False, closest=0.97):
    """Positions (n,3) in diameters. eps: a number, or a tuple of (z, void fraction) points joined linearly. Heights are
    drawn in layers of equal solid volume, overlaps are pushed apart until no centres are nearer than `closest`; at last the
    heights are set to the wanted profile exactly, which moves neighbours little against each other (overlaps of some
    hundredths don't matter to particles that stay where they are).
    """
    rng = np.random.default_rng(seed)
    box = np.array([width, width, height], float)
    z = np.linspace(0, height, 4001)
    solid = 1 - (np.full_like(z, eps) if np.isscalar(eps) else np.interp(z, *np.array(eps).T))
    below = np.concatenate(([0], np.cumsum(0.5 * (solid[1:] + solid[:-1]) * np.diff(z)))) * width**2
    n = int(below[-1] / (np.pi / 6))
    x = rng.uniform(0, 1, (n, 3)) * box
    x[:, 2] = np.interp((np.arange(n) + rng.uniform(0, 1, n)) / n * below[-1], below, z)
    for turn in range(3000):
        if turn % 5 == 0:
            pairs = neighbours(x, box, 1.25)
        r = x[pairs[:, 0]] - x[pairs[:, 1]]
        wrap = 3 if periodic_z else 2
        r[:, :wrap] -= box[:wrap] * np.round(r[:, :wrap] / box[:wrap])
        distance = np.sqrt((r**2).sum(1))
        close = distance < closest + 0.01
        if not (distance < closest).any():
            break
        push = (0.25 * (closest + 0.01 - distance[close]) / distance[close])[:, None] * r[close]
        for a in range(3):
            x[:, a] += np.bincount(pairs[close, 0], push[:, a], n) - np.bincount(pairs[close, 1], push[:, a], n)
        x[:, :wrap] %= box[:wrap]
        if not periodic_z:
            x[:, 2] = np.clip(x[:, 2], 1e-6, height - 1e-6)
    else:
        raise RuntimeError(f"no bed without overlaps found: {np.sum(distance < closest)} overlaps left")
    if not periodic_z:  # pushing has spread the dense part: put the heights back, in their order
        x[np.argsort(x[:, 2]), 2] = np.interp((np.arange(n) + 0.5) / n * below[-1], below, z)
    return x


def slice_void_fraction(x, width, edges):
    """Exact void fraction between heights (volumes of caps; diameters)."""
    below = [np.sum(np.pi * h**2 * (1.5 - h) / 3) for h in (np.clip(e - x[:, 2] + 0.5, 0, 1) for e in edges)]
    return 1 - np.diff(below) / (width**2 * np.diff(edges))


def ergun_wenyu(eps, re):
    """F of ergun/wenyu as README and DESIGN define it: drag over 3 pi mu d eps |u - v|; re superficial."""
    eps = np.asarray(eps, float)
    s = 1 - eps
    ergun = (150 * s + 1.75 * re) / (18 * eps**2)
    wenyu = np.where(re < 1000, 1 + 0.15 * np.maximum(re, 1e-30)**0.687, 0.44 * re / 24) * eps**-3.65
    psi = np.arctan(150 * 1.75 * (0.2 - s)) / np.pi + 0.5
    return (1 - psi) * ergun + psi * wenyu


def force(eps, d, mu, rho, U):
    """The gas's whole force (drag and pressure gradient, N) on a particle at rest, superficial velocity U."""
    eps = np.asarray(eps, float)
    return 3 * np.pi * mu * d * ergun_wenyu(eps, rho * U * d / mu) * U / eps
