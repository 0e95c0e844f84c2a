#!/usr/bin/python3
"""Vessels that are no cylinder, from the script on: pipes that end in the domain's sides; the pressure drop of a packed cone; gas that stays at rest in a cone, in a U-bend and
over a tube bank, beds with a sharp surface in them; a draft tube without thickness.

What would pass falsely without it: drag or mass by the area of whole cells where the section changes; a wall that pumps, or a bed's surface
beside one, where pressure gradients and open shares are not taken at the same places; a tube that solids are smeared through; the lids of
a mesh, or the ends of a region, in the planes of inlet, outlet and periodic sides, that rub on the gas or stop it.

References: Ergun (1952) summed over the cone's own sections, U(z) = Q/A(z) (the slope of the wall, 3.2 degrees, makes 0.2 % of it); rest. The
cone's cells are so small, 20 to 32 a diameter, because a volume that is 0.1 % too small makes the drop 0.5 % too large.
"""
import h5py
import numpy as np

from bodies import last, spread, stl
from harness import Checks, Run, arguments, data_file, head, head_with_particles

MU, RHO, D = 1.8e-5, 1.2, 0.7e-3
WALL = """fix cad all mesh/surface file wall.stl type 1
fix steel all wall/gran model hooke/stiffness tangential history mesh n_meshes 1 meshes cad absolute_damping on
"""


def held(executable, box, fine, ratio, x, lines, columns, files, ranks=1, steps=100, options=("-fluid_pressure_rtol", "1e-9")):
    script = head_with_particles(1e-4, boundary="f f f") + WALL + f"""
fix gas all twogrid fine {fine[0]} {fine[1]} {fine[2]} ratio {ratio} {ratio} {ratio} density {RHO} viscosity {MU!r} every 10
fix_modify gas drag ergun {lines}
thermo_style custom step atoms f_gas[4] f_gas[6] f_gas[7] {columns}
thermo_modify format float %.17g lost error norm no
thermo {steps}
run {steps}
"""
    size = " ".join(f"0 {s!r}" for s in box)
    return Run(executable, script, ranks, options, files={"particles.data": data_file(size, x, D, 2500), **files})


def packed_cone(c, executable):
    below, above, height, wide, U = 6e-3, 8e-3, 36e-3, 18e-3, 0.4
    volume = np.pi * height * (below**2 + below * above + above**2) / 3
    n = int(0.5 * volume / (np.pi / 6 * D**3))
    # Evenly over the volume: the height by the share of the cone below it.
    z = height * ((below**3 + spread(n, 5) * (above**3 - below**3))**(1 / 3) - below) / (above - below)
    r = 0.985 * (below + (above - below) * z / height) * np.sqrt(spread(n, 2))
    a = 2 * np.pi * spread(n, 3)
    eps = 1 - n * np.pi / 6 * D**3 / volume
    heights = np.linspace(0, height, 4001)
    u = U * (below / (below + (above - below) * 0.5 * (heights[1:] + heights[:-1]) / height))**2
    ergun = np.sum(150 * MU * (1 - eps)**2 / (eps**3 * D**2) * u + 1.75 * RHO * (1 - eps) / (eps**3 * D) * u * u) * height / 4000
    drops = []
    for i, j in ((0, 0), (0.3e-3, -0.2e-3)):
        centre = np.array([0.5 * wide + i, 0.5 * wide + j])
        x = np.stack([centre[0] + r * np.cos(a), centre[1] + r * np.sin(a), z], axis=1)
        run = held(executable, (wide, wide, height), (36, 36, 72), 4, x, f"solid cone mesh cad slip boundary zlo inlet 0 0 {U!r} boundary zhi pressure 0", "f_gas[10]",
                   {"wall.stl": stl([(below, 0.0), (above, height)], 2, centre, 180)})
        drops.append(last(run, "f_gas[4]"))
        c.below(f"cone: pressure drop {drops[-1]:.3f} Pa against {ergun:.3f} of Ergun over its sections, relative", abs(drops[-1] / ergun - 1), 0.01)
        c.below("cone: solids ledger", last(run, "f_gas[6]"), 1e-13)
    c.below("cone: moved on the grid, relative", abs(drops[1] / drops[0] - 1), 0.01)


def ends_in_the_sides(c, executable):
    R, wide, high, U, mu = 8e-3, 19e-3, 24e-3, 1.0, 2e-3
    angle = 2 * np.pi * np.arange(96) / 96
    ring = np.stack([R * np.cos(angle), R * np.sin(angle)], axis=1)

    def lids():
        out = [((0, 0, z), (*ring[i], z), (*ring[i - 1], z)) for z in (0.0, high) for i in range(96)]
        pipe = stl([(R, 0.0), (R, high)], 2, (0.0, 0.0), 96)
        return pipe[:pipe.rindex("endsolid")] + stl_of(out).split("\n", 1)[1]

    def gas(boundary, lines, columns, files):
        script = head(f"{-0.5 * wide!r} {0.5 * wide!r} {-0.5 * wide!r} {0.5 * wide!r} 0 {high!r}", 1e-3, boundary=boundary) + f"""
fix felt all wall/gran model hooke/stiffness tangential history primitive type 1 zcylinder {R!r} 0 0 absolute_damping on
fix gas all twogrid fine 19 19 12 density {RHO} viscosity {mu!r} every 5
{lines}
thermo_style custom step {columns}
thermo_modify format float %.17g norm no
thermo 60
run 60
"""
        return Run(executable, script, 1, ("-fluid_pressure_rtol", "1e-9"), files=files)

    flow = f"fix_modify gas boundary zlo inlet 0 0 {U!r} boundary zhi pressure 0"
    drops = {}
    for name, lines, files in (("region without ends", f"region pipe cylinder z 0 0 {R!r} INF INF side out units box\nfix_modify gas solid pipe region pipe", {}),
                               ("region that ends at the sides", f"region pipe cylinder z 0 0 {R!r} 0 {high!r} side out units box\nfix_modify gas solid pipe region pipe", {}),
                               ("open mesh", "fix cad all mesh/surface file wall.stl type 1\nfix_modify gas solid pipe mesh cad fluid_at 0 0 0.01", {"wall.stl": stl([(R, 0.0), (R, high)], 2, (0.0, 0.0), 96)}),
                               ("mesh with lids", "fix cad all mesh/surface file wall.stl type 1\nfix_modify gas solid pipe mesh cad fluid_at 0 0 0.01", {"wall.stl": lids()})):
        drops[name] = last(gas("f f f", f"{lines}\n{flow}", "f_gas[4]", files), "f_gas[4]")
    c.note(f"empty pipe: pressure drop {drops['region without ends']:.4f} Pa")
    c.below("region that ends at the sides against one that goes on: drop, relative", abs(drops["region that ends at the sides"] / drops["region without ends"] - 1), 1e-6)
    c.below("mesh with lids in the sides against one without: drop, relative", abs(drops["mesh with lids"] / drops["open mesh"] - 1), 1e-6)
    # Poiseuille's: 8 pi mu U L, once the flow has grown (R^2/nu is 0.04 s; the slowest part decays in 7 ms).
    for ends in ("INF INF", f"0 {high!r}"):
        force = last(gas("f f p", f"region pipe cylinder z 0 0 {R!r} {ends} side out units box\nfix_modify gas solid pipe region pipe flow_rate z {U!r}", "f_gas[19]", {}), "f_gas[19]")
        c.below(f"periodic pipe, region {ends}: force {force:.5e} N against Poiseuille's, relative", abs(force / (8 * np.pi * mu * U * high) - 1), 0.02)


def tube(path, radius, facets=32):
    """Triangles of a tube around a path in the x-z plane: points (n,3) and radii."""
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.stack([-along[:, 2], np.zeros(len(path)), along[:, 0]], axis=1)
    angle = 2 * np.pi * np.arange(facets) / facets
    rings = [p + q * (np.cos(angle)[:, None] * e + np.sin(angle)[:, None] * np.array([0, 1.0, 0])) for p, q, e in zip(path, radius, across)]
    out = []
    for low, high in zip(rings[:-1], rings[1:]):
        for i in range(facets):
            j = (i + 1) % facets
            out += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
    return out


def stl_of(triangles):
    lines = ["solid wall"]
    for t in triangles:
        lines += ["facet normal 0 0 0", "outer loop"] + ["vertex " + " ".join(f"{c:.12g}" for c in p) for p in t] + ["endloop", "endfacet"]
    return "\n".join(lines + ["endsolid wall", ""])


def bend(wide, high):
    """A U whose legs leave the box above."""
    s = np.linspace(0, np.pi, 25)
    left, right, low, turn = 0.27 * wide, 0.74 * wide, 0.42 * high, 0.235 * wide
    arc = np.stack([0.5 * (left + right) - turn * np.cos(s), np.full_like(s, 0.51 * wide), low - turn * np.sin(s)], axis=1)
    legs = np.linspace(high, low, 6)[:-1]
    def leg(x):
        return np.stack([np.full_like(legs, x), np.full_like(legs, 0.51 * wide), legs], axis=1)
    path = np.concatenate([leg(left), arc, leg(right)[::-1]])
    return tube(path, np.full(len(path), 0.15 * wide))


def bank(wide):
    """Nine tubes across the box, staggered: each an axis along y that goes through both sides."""
    out = []
    for k in range(3):
        for i in range(3):
            x, z = (0.2 + 0.3 * i + 0.07 * (k % 2)) * wide, (0.75 + 0.28 * k) * wide
            path = np.array([[x, -0.1 * wide, z], [x, 1.1 * wide, z]])
            along = path[1] - path[0]
            angle = 2 * np.pi * np.arange(24) / 24
            rings = [p + 0.083 * wide * np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1) for p in path]
            assert along[1] > 0
            for a in range(24):
                b = (a + 1) % 24
                out += [(rings[0][a], rings[0][b], rings[1][b]), (rings[0][a], rings[1][b], rings[1][a])]
    return out


def at_rest(c, executable, ranks):
    wide, high = 18e-3, 36e-3
    scenes = {"cone": stl([(1.5e-3, 0.0), (1.5e-3, 3e-3), (8e-3, 20e-3), (8e-3, high)], 2, (8.7e-3, 9.2e-3), 60),
              "U-bend": stl_of(bend(wide, high)), "tube bank": stl_of(bank(wide))}
    for name, wall in scenes.items():
        # A bed up to mid-height, in the vessel or where its outside is closed; those behind the wall lie in steel and are left out.
        n = 4000
        x = np.stack([wide * spread(n, 2), wide * spread(n, 3), 0.5 * high * spread(n, 5)], axis=1)
        if name == "cone":
            r = np.where(x[:, 2] < 3e-3, 1.5e-3, np.minimum(8e-3, 1.5e-3 + 6.5e-3 * (x[:, 2] - 3e-3) / 17e-3))
            x = x[np.hypot(x[:, 0] - 8.7e-3, x[:, 1] - 9.2e-3) < 0.95 * r]
        elif name == "U-bend":
            s = np.linspace(0, np.pi, 200)
            arc = np.stack([0.505 * wide - 0.235 * wide * np.cos(s), 0.42 * high - 0.235 * wide * np.sin(s)], axis=1)
            arc = np.concatenate([arc, [[0.27 * wide, z] for z in np.linspace(0.42 * high, high, 100)], [[0.74 * wide, z] for z in np.linspace(0.42 * high, high, 100)]])
            away = np.min(np.hypot(x[:, None, 0] - arc[None, :, 0], x[:, None, 2] - arc[None, :, 1]), axis=1)
            x = x[np.hypot(away, x[:, 1] - 0.51 * wide) < 0.13 * wide]
        else:
            for k in range(3):
                for i in range(3):
                    x = x[np.hypot(x[:, 0] - (0.2 + 0.3 * i + 0.07 * (k % 2)) * wide, x[:, 2] - (0.75 + 0.28 * k) * wide) > 0.09 * wide]
        run = held(executable, (wide, wide, high), (24, 24, 48), 3, x, f"solid steel mesh cad boundary zhi pressure 100\nfix_modify gas output every 100 file o.h5 fields u p eps faces",
                   "f_gas[9]", {"wall.stl": wall}, ranks, options=("-fluid_pressure_rtol", "1e-12"))
        with h5py.File(run.file("o.h5")) as f:
            frame = f["fluid"][sorted(f["fluid"])[-1]]
            theta = f["grid/theta"][()]
            fastest = max(np.abs(frame["faces/u" + d][()]).max() for d in "xyz")
            p = frame["p"][()][theta > 0]
        c.note(f"{name}: {np.mean(theta):.3f} open, {len(x)} spheres, smallest void fraction {last(run, 'f_gas[9]'):.3f}")
        c.below(f"{name}: fastest gas over the speed that the outlet's 100 Pa could give it", fastest / np.sqrt(2 * 100 / RHO), 1e-12)
        c.below(f"{name}: pressure apart from the outlet's 100 Pa, relative", np.abs(p / 100 - 1).max(), 1e-12)


def draft_tube(c, executable, ranks):
    """A tube without thickness in a box: spheres around it, none in it."""
    wide, high, r, n = 18e-3, 36e-3, 5.2e-3, 6000
    x = np.stack([wide * spread(n, 2), wide * spread(n, 3), high * spread(n, 5)], axis=1)
    x = x[np.hypot(x[:, 0] - 0.5 * wide, x[:, 1] - 0.5 * wide) > r + 0.5 * D]
    tube = stl([(r, 6e-3), (r, high - 6e-3)], 2, (0.5 * wide, 0.5 * wide), 48)
    runs = {}
    for n in (1, *ranks):
        # Particle cells of 1.5 mm: the middle one of the tube has no part of the surface, nor have its neighbours.
        run = runs[n] = held(executable, (wide, wide, high), (24, 24, 48), 2, x, "solid riser mesh cad sheet boundary zlo inlet 0 0 0.3 boundary zhi pressure 0\n"
                             "fix_modify gas output every 100 file o.h5 fields u p eps faces", "f_gas[9] f_gas[19]", {"wall.stl": tube}, n)
        c.below(f"draft tube, {n} rank(s): solids ledger", last(run, "f_gas[6]"), 1e-13)
        with h5py.File(run.file("o.h5")) as f:
            frame = f["fluid"][sorted(f["fluid"])[-1]]
            eps, up = frame["eps"][()], frame["faces/flux_z"][()][24]
        c.true(f"draft tube, {n} rank(s): no solids in its middle (void fraction {eps[16:32, 11:13, 11:13].min():.6f}), as many around it as there are ({eps[:, :2, :].mean():.3f})",
               eps[16:32, 11:13, 11:13].min() == 1 and eps[:, :2, :].mean() < 0.95)
        area = (wide / 24)**2
        at = np.hypot(*np.meshgrid((np.arange(24) + 0.5) * wide / 24 - 0.5 * wide, (np.arange(24) + 0.5) * wide / 24 - 0.5 * wide)) < r
        c.note(f"draft tube: {np.sum(up[at]) / np.sum(up):.3f} of the gas goes through it, {np.mean(at):.3f} of the section; force on it {last(run, 'f_gas[19]'):.3e} N")
        c.below("draft tube: what passes at half height against the inlet", abs(np.sum(up) * area / (0.3 * wide**2) - 1), 1e-6)
    for n in ranks:
        c.true(f"draft tube: {n} ranks have the bits of one in the void fraction", last(runs[n], "f_gas[9]") == last(runs[1], "f_gas[9]"))


def main():
    executable, ranks = arguments()
    c = Checks("cone, U-bend and tube bank")
    ends_in_the_sides(c, executable)
    packed_cone(c, executable)
    at_rest(c, executable, ranks[-1])
    draft_tube(c, executable, ranks)
    c.end()


if __name__ == "__main__":
    main()
