#!/usr/bin/python3
"""Stress on the surfaces of bodies, from the script to the output file: developed flow through a pipe, whose wall carries G R/2 everywhere.

What would pass falsely without it: friction of another place, or of less than the whole surface; facets that don't lie on the body, or have gaps; a
surface in another order on other ranks, so that a run that goes on writes values beside their places; means that begin anew at a restart;
an XDMF file that points to datasets of other sizes; a body's force that is another than f_gas shows; pictures that are not drawn.
Usage: walls.py EXECUTABLE RANKS...
"""
import os
import subprocess
import sys
import xml.etree.ElementTree as xml

import h5py
import numpy as np

from harness import Checks, Run, arguments, column, data_file, head_with_particles
from same_script import checkpoints, gone_on

R, L, WIDE, C = 8e-3, 4.5e-3, 17e-3, (8.6e-3, 8.3e-3)
MU, G = 1e-2, 30.0
ACROSS, ALONG = 24, 6


def script(axis, fields="fields u p eps walls", body=True):
    fine = [ACROSS] * 3
    fine[axis] = ALONG
    drive = " ".join(repr(-G) if d == axis else "0" for d in range(3))
    return head_with_particles(1e-4, boundary=" ".join("p" if d == axis else "f" for d in range(3))) + f"""
region tube cylinder {'xyz'[axis]} {C[0]!r} {C[1]!r} {R!r} INF INF side out units box
fix integrate all nve/sphere
fix gas all twogrid fine {fine[0]} {fine[1]} {fine[2]} ratio 3 3 3 density 1.2 viscosity {MU!r} every 10
fix_modify gas drag stokes implicit on pressure_gradient {drive}
{"fix_modify gas solid pipe region tube" if body else ""}
fix_modify gas output every 50 file o.h5 {fields} average from 0.015
fix_modify gas checkpoint every 120 keep 9
thermo_style custom step atoms f_gas[1] {'f_gas[17] f_gas[18] f_gas[19]' if body else ''}
thermo_modify format float %.17g lost error norm no
thermo 50
run 200
"""


def pipe(executable, axis, ranks=1, **words):
    size = [WIDE] * 3
    size[axis] = L
    place = [d for d in range(3) if d != axis]
    x = [0.5 * L] * 3
    for q, d in enumerate(place):
        x[d] = C[q]
    expect = words.pop("expect_success", True)
    return Run(executable, script(axis, **words), ranks, ("-fluid_pressure_rtol", "1e-9"), expect_success=expect,
               files={"particles.data": data_file(" ".join(f"0 {s!r}" for s in size), [x], 1e-5, 1.2)})


def surface(run):
    """Of the last frame."""
    with h5py.File(run.file("o.h5")) as f:
        name = sorted(f["walls"])[-1]
        out = {n: d[()] for n, d in f["grid/walls"].items()}
        out.update({n: f["walls"][name][n][()] for n in ("friction", "pressure", "step")})
        out["facets' force"] = f["walls"][name]["force"][()]
        out.update({"mean " + n: f["average/walls"][n][()] for n in ("friction", "pressure")})
        out.update({"body " + n: f["fluid"][name]["bodies"][n][()] for n in ("force", "torque", "friction")})
        out["names"] = f["grid/bodies"].attrs["names"].decode()
        out["same steps"] = [int(f["walls"][n]["step"][()]) for n in sorted(f["walls"])] == [int(f["fluid"][n]["step"][()]) for n in sorted(f["fluid"])]
    return out


def outlines(s):
    """The polygons: lists of points."""
    found, at = [], 0
    while at < len(s["polygons"]):
        kind, n = s["polygons"][at:at + 2]
        assert kind == 3
        found.append(s["points"][s["polygons"][at + 2:at + 2 + n]])
        at += 2 + n
    return found


def friction_of_a_pipe(c, executable):
    axis = 2
    run = pipe(executable, axis)
    s, wanted = surface(run), 0.5 * G * R
    area, along = s["area"], s["friction"][:, axis]
    c.below(f"mean friction {along.mean():.5f} Pa against G R/2 = {wanted:.5f}, relative", abs(along.mean() / wanted - 1), 0.01)
    c.below(f"scatter of {len(area)} facets, rms", np.sqrt(np.mean((along / wanted - 1)**2)), 0.015)
    c.below("  largest", np.abs(along / wanted - 1).max(), 0.04)
    c.below("  time means of the developed flow against the last frame", np.abs(s["mean friction"] - s["friction"]).max() / wanted, 0.01)
    total = (s["friction"] * area[:, None]).sum(axis=0)
    c.below("  sum over facets against the body's force, relative", abs(total[axis] / s["body force"][0][axis] - 1), 0.01)
    c.below("  and as it stands in the frame", np.abs(total - s["facets' force"][0]).max() / total[axis], 1e-6)
    c.true("  the body's force is f_gas[17..19]", all(s["body force"][0][d] == column(run.thermo(), f"f_gas[{17 + d}]")[-1] for d in range(3)))
    c.below("  wall pressure: none, over G L", np.abs(s["pressure"]).max() / (G * L), 1e-3)
    c.true("  its name, and a frame of walls for each of the fluid", s["names"] == "pipe" and s["same steps"])
    c.below("  area against 2 pi R L, relative", abs(area.sum() / (2 * np.pi * R * L) - 1), 0.005)
    # what the polygons enclose
    worst, far, ends = 0, 0, {}
    for a, n, p in zip(area, s["normal"], outlines(s)):
        worst = max(worst, np.abs(0.5 * np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0) - a * n).max() / a)
        far = max(far, abs(np.hypot(p[:, 0] - C[0], p[:, 1] - C[1]) - R).max() / R)
        for q, r in zip(p, np.roll(p, -1, axis=0)):
            e = tuple(np.round(np.concatenate((q, r)) / R * 1e6).astype(int))
            ends[e] = ends.get(e, 0) + 1
    inner = sum(e[3:] + e[:3] in ends for e in ends)
    c.below("  vector area of the polygons against area times normal", worst, 1e-9)
    c.below("  corners' distance from the cylinder, over its radius (a face that is all but closed counts as closed: 0.05 cells)", far, 5e-3)
    c.true(f"  of {len(ends)} edges {inner} are shared with the next facet (wanted: all but those at the two ends)", inner >= len(ends) - 2.2 * len(area) / ALONG)
    read_back(c, run)
    plot = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../cases/plot_fields.py")
    subprocess.run([sys.executable, plot, run.file("o.h5"), "--out", run.path], stdout=subprocess.DEVNULL, check=True)
    c.true("  plot_fields.py draws body_forces.png, walls.png, surface.png", all(os.path.getsize(run.file(n + ".png")) > 5000 for n in ("body_forces", "walls", "surface")))
    return run


def read_back(c, run):
    """Every dataset that the XDMF files name is there and has the size they say."""
    for name, count in (("o.xdmf", 5), ("o_average.xdmf", 1)):
        tree = xml.parse(run.file(name))
        grids = [g for g in tree.iter("Grid") if g.get("Name") == "walls"]
        items, good = 0, True
        for item in tree.iter("DataItem"):
            file, path = item.text.split(":")
            with h5py.File(run.file(file)) as f:
                good &= f[path].shape == tuple(int(n) for n in item.get("Dimensions").split())
                items += 1
        with h5py.File(run.file("o.h5")) as f:
            good &= all(int(g.find("Topology").get("NumberOfElements")) == len(f["grid/walls/area"]) for g in grids)
        c.true(f"  {name}: {len(grids)} surfaces (wanted {count}), {items} datasets of the sizes that it says", good and len(grids) == count)
    try:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
    except ImportError:
        c.note("no VTK with its XDMF reader here: it is not asked")
        return
    reader, s = vtkXdmfReader(), surface(run)
    reader.SetFileName(run.file("o_average.xdmf"))
    reader.Update()
    blocks = reader.GetOutputDataObject(0)
    walls = [b for b in (blocks.GetBlock(i) for i in range(blocks.GetNumberOfBlocks())) if b and b.GetCellData().GetArray("friction")]
    good = len(walls) == 1 and (walls[0].GetNumberOfCells(), walls[0].GetNumberOfPoints(), walls[0].GetCellType(0)) == (len(s["area"]), len(s["points"]), 7)
    c.true(f"  VTK reads a surface of {walls[0].GetNumberOfCells() if walls else 0} polygons with the friction that is in the file (wanted {len(s['area'])})",
           good and np.array_equal(vtk_to_numpy(walls[0].GetCellData().GetArray("friction")), s["mean friction"]))


def on_ranks(c, executable, ranks, one):
    a = surface(one)
    for n in ranks:
        b = surface(pipe(executable, 2, n))
        c.true(f"{n} ranks: the surface has the same bits", all(np.array_equal(a[k], b[k]) for k in ("points", "polygons", "area", "normal", "centre", "body")))
        c.below(f"{n} ranks: friction, relative", np.abs(a["friction"] - b["friction"]).max() / np.abs(a["friction"]).max(), 1e-7)
    # From step 120, in the file that holds frames of 150 and 200; then the same on other ranks, whose facets are shared out in another way.
    name = checkpoints(one.path)[0]
    for n in (1, *ranks[:1]):
        folder, path, again = gone_on(executable, n, one, name, options=("-restart", "auto", "-fluid_pressure_rtol", "1e-9"))
        if again.returncode:
            print(again.stdout[-2000:])
        one_more = type("Again", (), {"file": lambda self, f: os.path.join(path, f)})()
        b = surface(one_more)
        far = max(np.abs(a[k] - b[k]).max() / np.abs(a[k]).max() for k in ("friction", "mean friction", "body force"))
        c.true(f"gone on from {name} on {n} ranks: {'every bit of' if n == 1 else f'{far:.1e} apart,'} frames and means", all(np.array_equal(a[k], b[k]) for k in a) if n == 1 else far < 1e-7)
        c.true("  its frames are those of the run that was never left", b["same steps"] and b["step"] == 200)
        folder.cleanup()


def without(c, executable):
    run = pipe(executable, 2, fields="fields u p eps")
    with h5py.File(run.file("o.h5")) as f:
        c.true("without 'walls': no surface, but forces", "walls" not in f and "walls" not in f["grid"] and "force" in f["fluid/000000/bodies"])
    run = pipe(executable, 2, body=False, expect_success=False)
    said = next((line for line in run.output.splitlines() if "ERROR" in line), "none")
    c.true(f"'walls' without a body is refused: {said[:150]}", run.code != 0 and "walls" in said and "solid" in said)


def main():
    executable, ranks = arguments()
    c = Checks("stress on the surfaces of bodies")
    one = friction_of_a_pipe(c, executable)
    on_ranks(c, executable, [n for n in ranks if n > 1], one)
    without(c, executable)
    c.end()


if __name__ == "__main__":
    main()
