"""Drag on the grains of a frame, computed anew from the laws' papers and what the output file holds: positions and velocities of grains, void
fraction, gas. It shares nothing with the program but the file.

The gas that a grain reads is the mean flux eps u over its particle cell over that cell's void fraction, or between such cells where the run reads so: the mean over the
faces that are solved for, each counted by half of the cells on its sides, without those of inlets and walls. Where the
file has the flux at the cells' faces (fields ... faces) that is what the program reads: the sums agree to 0.02 %, and to 0.3 % where cells beyond a periodic side are read between, which
this leaves out. Without faces it is taken from the velocities of cells, which hold an inlet's faces, where the duct is empty: grains that read
a particle cell at an inlet are left out, and the sums agree to some 5 %; so they do where bodies cut the cells.
"""
import numpy as np

import plot_fields


def ergun_wenyu(eps, Re):
    """beta d^2/mu of Ergun (1952) and Wen & Yu (1966), joined by Deb & Tafti's arc tangent; Re = eps rho |u - v| d/mu."""
    solid = 1 - eps
    ergun = 150 * solid**2 / eps + 1.75 * solid * Re / eps
    C_D = np.where(Re < 1000, 24 / np.maximum(Re, 1e-12) * (1 + 0.15 * Re**0.687), 0.44)
    wen_yu = 0.75 * C_D * solid * Re * eps**-2.65
    psi = np.arctan(150 * 1.75 * (0.2 - solid)) / np.pi + 0.5
    return (1 - psi) * ergun + psi * wen_yu


def beetstra(eps, Re):
    """beta d^2/mu of Beetstra, van der Hoef & Kuipers (2007)."""
    solid, Re = 1 - eps, np.maximum(Re, 1e-12)
    F = 10 * solid / eps**2 + eps**2 * (1 + 1.5 * np.sqrt(solid))
    F = F + 0.413 * Re / (24 * eps**2) * (1 / eps + 3 * eps * solid + 8.4 * Re**-0.343) / (1 + 10**(3 * solid) * Re**(-0.5 - 2 * solid))
    return 18 * eps * solid * F


def wen_yu(eps, Re):
    """beta d^2/mu of Wen & Yu (1966), with the drag of a lone sphere by Schiller & Naumann (1935)."""
    C_D = np.where(Re < 1000, 24 / np.maximum(Re, 1e-12) * (1 + 0.15 * Re**0.687), 0.44)
    return 0.75 * C_D * (1 - eps) * Re * eps**-2.65


def di_felice(eps, Re):
    """beta d^2/mu of Di Felice (1994), with the drag of a lone sphere by Dalla Valle (1948)."""
    Re = np.maximum(Re, 1e-12)
    chi = 3.7 - 0.65 * np.exp(-0.5 * (1.5 - np.log10(Re))**2)
    return 0.75 * (0.63 + 4.8 / np.sqrt(Re))**2 * (1 - eps) * Re * eps**(1 - chi)


LAWS = {"ergun/wenyu": ergun_wenyu, "beetstra": beetstra, "wenyu": wen_yu, "difelice": di_felice}


def block_means(values, weights, ratio):
    """Of a vector field on the fine cells over the particle cells."""
    def sums(a):
        shape = [n for size, r in zip(a.shape, ratio[::-1]) for n in (size // r, r)]
        return a.reshape(*shape, *a.shape[3:]).sum(axis=(1, 3, 5))
    return sums(values * weights[..., None]) / np.maximum(sums(weights), 1e-300)[..., None]


def between(at, edges, values, solids, smooth):
    """values of cells at the positions: of the cell, or linearly between the cells' centres, among those that are about as full as its own: a cell counts
    in full where it holds 0.7 of the solids of the grain's cell, not at all below 0.3, linearly between."""
    home = tuple(np.clip(np.searchsorted(e, at[:, k]) - 1, 0, len(e) - 2) for k, e in enumerate(edges))[::-1]
    if not smooth:
        return values[home]
    low, share = [], []
    for k, e in enumerate(edges):
        c = plot_fields.centres(e)
        i = np.clip(np.searchsorted(c, at[:, k]) - 1, 0, max(len(c) - 2, 0))
        low.append(i)
        share.append(np.clip((at[:, k] - c[i]) / (c[i + 1] - c[i]), 0, 1) if len(c) > 1 else np.zeros(len(at)))
    got, total = np.zeros((len(at), 3)), np.zeros(len(at))
    for corner in np.ndindex(2, 2, 2):
        i = tuple(np.minimum(low[k] + corner[k], len(edges[k]) - 2) for k in range(3))[::-1]
        weight = np.prod([share[k] if corner[k] else 1 - share[k] for k in range(3)], axis=0)
        weight = weight * np.clip((solids[i] / np.maximum(solids[home], 1e-12) - 0.3) / 0.4, 0, 1)
        got, total = got + weight[:, None] * values[i], total + weight
    return got / np.maximum(total, 1e-12)[:, None]


def given(boundary, side):
    """Whether the flux through all faces of a side is given: inlets and walls."""
    kinds = [part.split()[1:] for part in boundary.split(";") if part.split()[0] == side]
    return bool(kinds) and not any(word in part for part in kinds for word in ("pressure", "periodic"))


def by_law(file, name):
    """Vertical drag on the grains of a frame (N): as the law has it, as the program wrote it; how many grains. None where that isn't known."""
    record, settings = file["record"].attrs, file["record/settings"].attrs
    said = lambda key: settings[key].decode() if isinstance(settings[key], bytes) else str(settings[key])
    law, read = LAWS.get(said("drag")), said("read").split(" (")[0]
    if law is None or read not in ("cell", "trilinear") or "u" not in file["fluid"][name] or name not in file.get("particles", ()):
        return None
    x, y, z = plot_fields.nodes(file)
    volume = np.diff(z)[:, None, None] * np.diff(y)[:, None] * np.diff(x)
    theta = plot_fields.open_share(file)
    frame, inlets = file["fluid"][name], {part.split()[0] for part in said("boundary").split(";") if " inlet " in part}
    eps = frame["eps"][:] if theta is None else frame["eps"][:] * theta
    u = eps[..., None] * frame["u"][:]
    counted = np.ones(u.shape)
    if "faces" in frame:
        # Volume flux at the lower and upper side of each cell; a periodic direction has its last side at its first.
        for k, c in enumerate("xyz"):
            flux, axis = frame["faces/flux_" + c][:], 2 - k
            upper, n = np.roll(flux, -1, axis), u.shape[axis]
            low, high = np.full(n, 0.5), np.full(n, 0.5)
            low[0] *= not given(said("boundary"), c + "lo")
            high[-1] *= not given(said("boundary"), c + "hi")
            shape = [n if a == axis else 1 for a in range(3)]
            u[..., k] = low.reshape(shape) * np.take(flux, range(n), axis) + high.reshape(shape) * np.take(upper, range(n), axis)
            counted[..., k] = (low + high).reshape(shape)
        inlets.discard("zlo")
    solids = 1 - block_means(np.repeat((eps if theta is None else frame["eps"][:])[..., None], 3, axis=3), volume if theta is None else volume * theta, record["ratio"])[..., 0]
    u = block_means(u, volume, record["ratio"]) / np.maximum(block_means(counted, volume, record["ratio"]), 1e-12)
    u = u / np.maximum(block_means(np.repeat(eps[..., None], 3, axis=3), volume, record["ratio"]), 1e-12)
    grains, cells = file["particles"][name], plot_fields.nodes(file, "particle_grid")
    at, d, eps = grains["position"][:], 2 * grains["radius"][:], grains["eps"][:]
    far = np.ones(len(at), bool)
    for side in inlets:
        e, k = cells["xyz".index(side[0])], "xyz".index(side[0])
        if side.endswith("lo"):
            far &= at[:, k] > (e[1] if read == "cell" else 0.5 * (e[1] + e[min(2, len(e) - 1)]))
        else:
            far &= at[:, k] < (e[-2] if read == "cell" else 0.5 * (e[-2] + e[max(-3, -len(e))]))
    slip = between(at, cells, u, solids, read == "trilinear") - grains["velocity"][:]
    mu = float(record["viscosity"])
    Re = eps * float(record["density"]) * np.linalg.norm(slip, axis=1) * d / mu
    # Where sizes differ, B has the pressure gradient's force apart from the drag, as A has.
    b = law(eps, Re) * mu * np.pi / 6 * d / (1 - eps) / (eps if said("formulation") == "B" and np.ptp(d) <= 1e-6 * d.max() else 1)
    return np.sum((b * slip[:, 2])[far]), np.sum(grains["drag"][:, 2][far]), far.sum()


def check(file, verdict):
    """The vertical drag, summed over some 20 frames, against the law's."""
    names = plot_fields.frames(file)[1:]
    bound = 0.01 if names and "faces" in file["fluid"][names[0]] and plot_fields.open_share(file) is None else 0.15
    pairs = [p for p in (by_law(file, n) for n in names[::1 + len(names) // 20]) if p]
    if not pairs:
        verdict.note("drag: not computed anew (a law or a way of reading that this script doesn't know, or no frames with u and particles)")
        return
    law, written, n = np.sum(pairs, axis=0)
    if not n:
        verdict.note("drag: not computed anew: all grains lie at an inlet, and there are no faces in the file")
        return
    verdict.between(1 - bound, written / law, 1 + bound, f"vertical drag on the grains of {len(pairs)} frames, {n / len(pairs):.0f} in each: {written / law:.3f} of what the law gives at the mean gas of their cells (wanted 1 +- {bound:g})")
