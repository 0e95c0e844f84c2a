#!/usr/bin/python3
"""Draws a run in three dimensions: the grains of a frame behind a vertical cut, coloured by their vertical velocity, and its bodies.

    picture_3d.py bed.h5 --out grains.png [--frame -1] [--cut Y] [--stl FILE] [--azimuth DEGREES] [--elevation DEGREES]

--cut: mm; what lies before it is left out (the middle if not given; "none": nothing is). --stl: the surface of the bodies; without it they are
drawn from the open shares of the cells. Needs python3-vtk9, and xvfb where there is no display.
"""
import argparse
import os
import shutil
import subprocess
import sys

import h5py
import numpy as np

PACKAGES = "python3-vtk9 xvfb xauth libgl1-mesa-dri"


def grains(file, frame, cut):
    """Actor of spheres of their own size, with its colours; None without grains."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    from vtkmodules.vtkFiltersSources import vtkSphereSource
    from vtkmodules.vtkRenderingCore import vtkActor, vtkColorTransferFunction, vtkGlyph3DMapper
    if "particles" not in file or frame not in file["particles"]:
        return None
    p = file["particles"][frame]
    x, v, r = p["position"][:], p["velocity"][:][:, 2], p["radius"][:]
    keep = x[:, 1] >= cut
    if not keep.any():
        return None
    fastest = max(np.percentile(np.abs(v), 99), 1e-9)
    points, data = vtkPoints(), vtkPolyData()
    points.SetData(numpy_to_vtk(x[keep], deep=True))
    data.SetPoints(points)
    for name, values in (("diameter", 2 * r[keep]), ("velocity", v[keep])):
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        data.GetPointData().AddArray(array)
    data.GetPointData().SetActiveScalars("velocity")
    ball = vtkSphereSource()
    ball.SetRadius(0.5), ball.SetThetaResolution(12), ball.SetPhiResolution(8)
    colours = vtkColorTransferFunction()
    colours.SetColorSpaceToDiverging()
    colours.AddRGBPoint(-fastest, 0.23, 0.3, 0.75), colours.AddRGBPoint(0, 0.87, 0.87, 0.87), colours.AddRGBPoint(fastest, 0.71, 0.02, 0.15)
    mapper = vtkGlyph3DMapper()
    mapper.SetInputData(data), mapper.SetSourceConnection(ball.GetOutputPort())
    mapper.SetScaleArray("diameter"), mapper.SetScaleModeToScaleByMagnitude()
    mapper.SetLookupTable(colours), mapper.SetScalarRange(-fastest, fastest), mapper.UseLookupTableScalarRangeOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    return actor, colours


def bodies(file, cut, stl):
    """Actor of the surface of bodies behind the cut: that of the file stl, else where half of a cell is open; None without bodies."""
    from vtkmodules.vtkCommonDataModel import vtkPlane
    from vtkmodules.vtkFiltersCore import vtkClipPolyData, vtkContourFilter, vtkPolyDataNormals
    from vtkmodules.vtkIOGeometry import vtkSTLReader
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper
    if "theta" not in file["grid"]:
        return None
    surface = vtkSTLReader() if stl else vtkContourFilter()
    if stl:
        surface.SetFileName(stl)
    else:
        surface.SetInputData(open_shares(file)), surface.SetValue(0, 0.5)
    plane = vtkPlane()
    plane.SetOrigin(0, cut, 0), plane.SetNormal(0, 1, 0)
    clip = vtkClipPolyData()
    clip.SetInputConnection(surface.GetOutputPort()), clip.SetClipFunction(plane)
    normals = vtkPolyDataNormals()
    normals.SetInputConnection(clip.GetOutputPort()), normals.SetFeatureAngle(60)
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(normals.GetOutputPort()), mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.6, 0.55, 0.5), actor.GetProperty().SetOpacity(0.45)
    return actor


def open_shares(file):
    """The open shares of cells as values at the cells' centres."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkRectilinearGrid
    # One more layer at each side, so that what touches a side of the domain is drawn up to it.
    theta = np.pad(file["grid/theta"][:], 1, mode="edge")
    grid = vtkRectilinearGrid()
    grid.SetDimensions(*theta.shape[::-1])
    for c in "xyz":
        e = file["grid"][c][:]
        getattr(grid, f"Set{c.upper()}Coordinates")(numpy_to_vtk(np.concatenate([[e[0]], 0.5 * (e[1:] + e[:-1]), [e[-1]]]), deep=True))
    array = numpy_to_vtk(theta.ravel(), deep=True)
    array.SetName("theta")
    grid.GetPointData().SetScalars(array)
    return grid


def render(path, out, frame=-1, cut=None, stl=None, azimuth=20, elevation=15):
    import vtkmodules.vtkInteractionStyle  # noqa: F401
    import vtkmodules.vtkRenderingFreeType  # noqa: F401
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    from vtkmodules.vtkFiltersModeling import vtkOutlineFilter
    from vtkmodules.vtkFiltersSources import vtkCubeSource
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkTextActor, vtkWindowToImageFilter
    renderer, window = vtkRenderer(), vtkRenderWindow()
    renderer.SetBackground(1, 1, 1)
    renderer.SetUseDepthPeeling(1), renderer.SetMaximumNumberOfPeels(20)
    window.SetOffScreenRendering(1), window.SetAlphaBitPlanes(1), window.SetMultiSamples(0)
    window.AddRenderer(renderer)
    with h5py.File(path, "r") as file:
        edges = [file["grid"][c][:] for c in "xyz"]
        name = sorted(file["fluid"])[frame]
        time = float(file["fluid"][name]["time"][()])
        size = [np.ptp(e) for e in edges]
        behind = edges[1].mean() if cut is None else cut
        balls, solid = grains(file, name, behind), bodies(file, behind, stl)
    # A parallel view that just holds the box, with room for the colours at the right.
    up, round_ = np.radians(elevation), np.radians(azimuth)
    across = size[0] * np.cos(round_) + size[1] * np.sin(abs(round_))
    tall = size[2] * np.cos(up) + (size[0] * np.sin(abs(round_)) + size[1] * np.cos(round_)) * np.sin(up)
    pixels = min(820 / tall, 900 / across)
    window.SetSize(int(pixels * across) + 280, int(pixels * tall) + 80)
    box, outline, mapper, frame_actor = vtkCubeSource(), vtkOutlineFilter(), vtkPolyDataMapper(), vtkActor()
    box.SetBounds(edges[0][0], edges[0][-1], max(behind, edges[1][0]), edges[1][-1], edges[2][0], edges[2][-1])
    outline.SetInputConnection(box.GetOutputPort())
    mapper.SetInputConnection(outline.GetOutputPort())
    frame_actor.SetMapper(mapper), frame_actor.GetProperty().SetColor(0.4, 0.4, 0.4)
    renderer.AddActor(frame_actor)
    if solid:
        renderer.AddActor(solid)
    if balls:
        renderer.AddActor(balls[0])
        bar = vtkScalarBarActor()
        bar.SetLookupTable(balls[1]), bar.SetTitle("vertical velocity / (m/s)\n "), bar.SetNumberOfLabels(5), bar.SetLabelFormat("%.2g")
        bar.SetUnconstrainedFontSize(1), bar.SetPosition(1 - 215 / window.GetSize()[0], 0.3), bar.SetWidth(200 / window.GetSize()[0]), bar.SetHeight(0.4), bar.SetBarRatio(0.2)
        for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
            text.SetColor(0, 0, 0), text.SetFontSize(16), text.ItalicOff(), text.BoldOff(), text.ShadowOff()
        renderer.AddActor2D(bar)
    label = vtkTextActor()
    label.SetInput(f"t = {time:.3f} s; box {1e3 * size[0]:.0f} x {1e3 * size[1]:.0f} x {1e3 * size[2]:.0f} mm" +
                   ("" if behind <= edges[1][0] else f", cut at y = {1e3 * behind:.1f} mm"))
    label.GetTextProperty().SetColor(0, 0, 0), label.GetTextProperty().SetFontSize(18), label.SetPosition(16, 12)
    renderer.AddActor2D(label)
    camera = renderer.GetActiveCamera()
    middle = [0.5 * (e[0] + e[-1]) for e in edges]
    camera.SetFocalPoint(*middle), camera.SetPosition(middle[0], middle[1] - 4 * max(size), middle[2]), camera.SetViewUp(0, 0, 1)
    camera.Azimuth(azimuth), camera.Elevation(elevation)
    camera.ParallelProjectionOn(), camera.SetParallelScale(0.5 * window.GetSize()[1] / pixels)
    camera.SetWindowCenter(180 / window.GetSize()[0], 0)
    renderer.ResetCameraClippingRange()
    window.Render()
    image, writer = vtkWindowToImageFilter(), vtkPNGWriter()
    image.SetInput(window), image.ReadFrontBufferOff()
    writer.SetInputConnection(image.GetOutputPort()), writer.SetFileName(out), writer.Write()


def draw(path, out, **options):
    """Draws in a process of its own, with a display of its own where there is none. Says what is missing where it can't; returns whether it could."""
    if "TWOGRID_NO_PICTURES" in os.environ:
        return False
    words = [sys.executable, os.path.abspath(__file__), path, "--out", out] + [w for k, v in options.items() if k != "stl" or os.path.exists(v) for w in ("--" + k, str(v))]
    if not os.environ.get("DISPLAY"):
        if not shutil.which("xvfb-run"):
            print(f"  no picture in three dimensions: xvfb-run is not there (apt-get install {PACKAGES})")
            return False
        words = ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24"] + words
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    if done.returncode == 0 and os.path.exists(out):
        print("  " + os.path.abspath(out))
        return True
    print("  no picture in three dimensions: " + (done.stdout.strip().splitlines() or ["?"])[-1] + f" (apt-get install {PACKAGES})")
    return False


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--out", default="grains.png")
    parser.add_argument("--frame", type=int, default=-1)
    parser.add_argument("--cut", default=None)
    parser.add_argument("--stl", default=None)
    parser.add_argument("--azimuth", type=float, default=20)
    parser.add_argument("--elevation", type=float, default=15)
    o = parser.parse_args()
    render(o.file, o.out, o.frame, -np.inf if o.cut == "none" else float(o.cut) / 1e3 if o.cut else None, o.stl, o.azimuth, o.elevation)


if __name__ == "__main__":
    main()
