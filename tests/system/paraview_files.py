#!/usr/bin/python3
"""Output files in ParaView: VTK's reader gives back what the HDF5 file holds, at every frame; cases/paraview_scene.py draws grains on a cut of the gas
and its state file opens with all frames.

Without this test an .xdmf file could name what its HDF5 file doesn't hold, or another frame's; the scene could be empty after the first frame
(the reader calls the gas "fluid" there and "fluid[1]" later); and a bed that is thinner in x, has a body or no grains could show nothing. Wanted
values: those of the HDF5 file read by h5py. Ends with 77, skipped, without VTK's Python; its part on ParaView wants pvpython and xvfb-run.

    paraview_files.py EXECUTABLE RANKS
"""
import os
import shutil
import subprocess
import sys

import h5py
import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles

SCENE = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases", "paraview_scene.py"))
BOX, THIN = "0 0.0096 0 0.0036 0 0.0144", "0 0.0036 0 0.0096 0 0.0144"  # along the other direction

GAS = """
fix motion all nve/sphere
fix gas all twogrid fine {cells} ratio {ratio} density 1.2 viscosity 1.8e-5 every 5
fix_modify gas boundary zlo inlet 0 0 0.6 boundary zhi pressure 0
fix_modify gas output every 20 file bed.h5 {fields}
{more}
run 60
"""


def scripts():
    """Two sizes of grains around a tube, thinner in y; without a body, thinner in x; gas alone in the file, without its velocity."""
    x = np.array([[(i + .5) * 1.2e-3, (j + .5) * 1.2e-3, (k + .5) * 1.2e-3] for k in range(2) for j in range(3) for i in range(8)])
    d = np.where(np.arange(len(x)) % 3 == 0, 1.1e-3, 0.7e-3)
    tube = "region tube cylinder y 0.0048 0.009 0.0012 INF INF units box\nfix_modify gas solid tube region tube"
    yield "tube", head_with_particles(2e-5, boundary="f f f") + GAS.format(cells="16 3 24", ratio="4 3 4", fields="", more=tube), data_file(BOX, x, d, 1000)
    yield "thin", head_with_particles(2e-5, boundary="f f f") + GAS.format(cells="3 8 12", ratio="3 2 3", fields="", more=""), data_file(THIN, x[:, [1, 0, 2]], d, 1000)
    yield "gas", head_with_particles(2e-5, boundary="f f f") + GAS.format(cells="8 3 12", ratio="1 1 1", fields="fields eps p particles no", more=""), data_file(BOX, x, d, 1000)


def read_by_vtk(c, name, path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader
    reader = vtkXdmfReader()
    reader.SetFileName(path[:-3] + ".xdmf")
    reader.UpdateInformation()
    times = list(reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()) or [])
    with h5py.File(path, "r") as f:
        frames = sorted(f["fluid"])
        c.true(f"{name}: {len(times)} times (wanted: those of {len(frames)} frames)", np.allclose(times, [f["fluid"][n]["time"][()] for n in frames], rtol=0, atol=1e-12))
        wrong = []
        for n, time in zip(frames, times):
            reader.UpdateTimeStep(time)
            blocks = reader.GetOutputDataObject(0)
            blocks = [blocks.GetBlock(i) for i in range(blocks.GetNumberOfBlocks())] if hasattr(blocks, "GetNumberOfBlocks") else [blocks]
            eps = vtk_to_numpy(blocks[0].GetCellData().GetArray("eps"))
            wrong += [f"{n}: void fraction"] * (not np.array_equal(eps, f["fluid"][n]["eps"][:].ravel()))
            if "particles" in f and len(f["particles"][n]["radius"]):
                wrong += [f"{n}: velocity"] * (not np.array_equal(vtk_to_numpy(blocks[1].GetPointData().GetArray("velocity")), f["particles"][n]["velocity"][:]))
                wrong += [f"{n}: position"] * (not np.allclose(vtk_to_numpy(blocks[1].GetPoints().GetData()), f["particles"][n]["position"][:], rtol=1e-6, atol=0))
    c.true(f"{name}: frames as in the HDF5 file{': not ' + ', '.join(wrong) if wrong else ''}", not wrong)


# Runs in pvpython: cells of the cut and spheres at each time, of the scene and of its state file; a picture.
DRIVER = """
import sys
sys.path.insert(0, sys.argv[1])
import paraview_scene as s
from paraview import simple as pv
s.PIXELS = 400
def count(plane, spheres, times):
    out = []
    for t in times:
        for source in (plane, spheres):
            n = 0
            if source:
                source.UpdatePipeline(t)
                n = source.GetDataInformation().GetNumberOfCells()
            out.append(n)
    return out
def scene(name, gas):
    reader, plane, spheres, box = s.pipeline(name + "/bed.xdmf", gas, None)
    print("SCENE", name, *count(plane, spheres, list(reader.TimestepValues)))
    return list(reader.TimestepValues), (reader, plane, spheres, box, gas, -1)
times, tube = scene("tube", "u")
pv.SaveScreenshot("tube.png", s.show(*tube))
pv.SaveState("tube.pvsm")
scene("thin", "p")
for part in pv.GetSources().values():
    pv.Hide(part)
s.show(*scene("gas", "eps")[1])
pv.ResetSession()
pv.LoadState("tube.pvsm")
print("STATE", "tube", *count(pv.FindSource("cut of the gas"), pv.FindSource("spheres"), times))
"""


def in_paraview(c, folder):
    from PIL import Image
    done = subprocess.run(["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24", "pvpython", "driver.py", os.path.dirname(SCENE)], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          errors="replace", timeout=200)
    got = {tuple(line.split()[:2]): [int(w) for w in line.split()[2:]] for line in done.stdout.split("\n") if line.startswith(("SCENE ", "STATE "))}
    if len(got) != 4 or done.returncode != 0:
        print(done.stdout[-3000:])
    for name in ("tube", "thin", "gas"):
        counts = got.get(("SCENE", name), [])
        c.true(f"{name}: cells of the cut and of spheres at each of 4 frames: {counts}", len(counts) == 8 and min(counts[::2]) > 0 and (min(counts[1::2]) > 0) == (name != "gas"))
    c.true("tube: the same from its state file; all are drawn", got.get(("SCENE", "tube")) == got.get(("STATE", "tube")) and done.returncode == 0)
    path = os.path.join(folder, "tube.png")
    colours = len(Image.open(path).convert("RGB").getcolors(1 << 24)) if os.path.exists(path) else 0
    c.true(f"tube: a picture of {colours} colours (wanted: more than 300)", colours > 300)


def main():
    executable, _ = arguments()
    if not os.path.isdir("/usr/lib/python3/dist-packages/vtkmodules"):
        print("VTK's Python is not here (apt-get install paraview python3-paraview): skipped")
        sys.exit(77)
    c = Checks("output files in VTK and ParaView")
    runs = []
    for name, script, data in scripts():
        runs.append(Run(executable, script, files={"particles.data": data}))
        read_by_vtk(c, name, runs[-1].file("bed.h5"))
        if name != "tube":
            os.symlink(runs[-1].path, runs[0].file(name))
    os.symlink(runs[0].path, runs[0].file("tube"))
    done = subprocess.run([sys.executable, SCENE, "nothing.xdmf"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    c.true(f"a file that is not there: {done.stdout.strip()}", done.returncode == 1 and "wanted is the .xdmf file" in done.stdout and "Traceback" not in done.stdout)
    if shutil.which("pvpython") and shutil.which("xvfb-run"):
        with open(runs[0].file("driver.py"), "w") as f:
            f.write(DRIVER)
        in_paraview(c, runs[0].path)
    else:
        c.note("no pvpython or no xvfb-run here: the scene is not drawn")
    c.end()


if __name__ == "__main__":
    main()
