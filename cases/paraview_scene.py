"""Any output in ParaView: a layer of grains, coloured by their velocity, on a cut of the gas.

    pvpython cases/paraview_scene.py bed.xdmf [--picture FILE.png] [--state FILE.pvsm] [--frame -1] [--cut MM] [--gas u]
    paraview bed.pvsm                                    the scene in the window: all frames, to be turned and changed
    TWOGRID_XDMF=bed.xdmf paraview --script=cases/paraview_scene.py      the same at once

The cut is vertical and looks along the thinner horizontal direction; it lies in the middle, or at MM. The layer of grains reaches from 1.5 diameters before it
to half a one behind. --gas: u (vertical velocity), p or eps. Where there is no display, put xvfb-run -a before it. Without --state and --picture both are
written beside the .xdmf file.
"""
import argparse
import os
import sys

PIXELS = 900  # the longer side of the bed in the view


def pipeline(path, gas, cut):
    """Reader, cut of the gas, grains (None without), layout: what the scene is made of."""
    from paraview import simple as pv
    reader = pv.XDMFReader(registrationName=os.path.basename(path), FileNames=[path])
    reader.UpdatePipeline()
    fluid = pv.ExtractBlock(registrationName="gas", Input=reader, Selectors=["/Root/*[1]"])
    fluid.UpdatePipeline()
    lo, hi = (fluid.GetDataInformation().GetBounds()[i::2] for i in (0, 1))
    along = 1 if hi[0] - lo[0] >= hi[1] - lo[1] else 0
    middle = [0.5 * (a + b) for a, b in zip(lo, hi)]
    at = middle[along] if cut is None else 1e-3 * cut
    normal = [float(i == along) for i in range(3)]
    plane = pv.Slice(registrationName="cut of the gas", Input=fluid)
    plane.SliceType.Origin, plane.SliceType.Normal = [at if i == along else m for i, m in enumerate(middle)], normal
    grains = pv.ExtractBlock(registrationName="grains", Input=reader, Selectors=["/Root/*[2]"])
    # A file without grains has no such block; one with some may have none in its first frame.
    for time in reader.TimestepValues or [0.0]:
        grains.UpdatePipeline(time)
        if grains.GetDataInformation().GetNumberOfPoints():
            break
    radius = grains.PointData["radius"] if "radius" in grains.PointData.keys() else None
    spheres = None
    if radius:
        d = 2 * radius.GetRange()[1]
        sign = -1 if along == 1 else 1  # the eye is at low y, or at high x
        layer = grains
        for name, where, invert in (("before the cut", at + sign * 1.5 * d, sign > 0), ("behind the cut", at - sign * 0.5 * d, sign < 0)):
            layer = pv.Clip(registrationName=name, Input=layer, ClipType="Plane", Invert=int(invert))
            layer.ClipType.Origin, layer.ClipType.Normal = [where if i == along else m for i, m in enumerate(middle)], normal
        spheres = pv.Glyph(registrationName="spheres", Input=layer, GlyphType="Sphere", OrientationArray=["POINTS", "No orientation array"], ScaleArray=["POINTS", "radius"],
                           ScaleFactor=2.0, GlyphMode="All Points")
    if gas not in fluid.CellData.keys():
        sys.exit(f"paraview_scene: no {gas} of the gas in {path}: it has {', '.join(fluid.CellData.keys())} (fix_modify ID output ... fields u p eps)")
    return reader, plane, spheres, (lo, hi, middle, along)


def show(reader, plane, spheres, box, gas, frame):
    """Colours, their scales, the view."""
    from paraview import simple as pv
    lo, hi, middle, along = box
    view = pv.GetActiveViewOrCreate("RenderView")
    animation = pv.GetAnimationScene()
    animation.UpdateAnimationUsingDataTimeSteps()
    times = list(reader.TimestepValues or [0.0])
    animation.AnimationTime = view.ViewTime = times[frame]
    view.Background, view.UseColorPaletteForBackground, view.OrientationAxesVisibility = [1, 1, 1], 0, 0
    # Wide enough for the scales at the right.
    across = hi[1 - along] - lo[1 - along]
    tall = hi[2] - lo[2]
    pixels = min(PIXELS / tall, PIXELS / across)
    view.ViewSize = [int(pixels * across) + 340, int(pixels * tall) + 60]

    def coloured(source, what, association, title, preset, top, even):
        part = pv.Show(source, view)
        pv.ColorBy(part, (association, what, "Z") if what in ("u", "velocity") else (association, what))
        colours = pv.GetColorTransferFunction(what)
        colours.ApplyPreset(preset, True)
        part.RescaleTransferFunctionToDataRange(False, True)
        points = colours.RGBPoints
        low, high = points[0], points[-4]
        if even:
            low, high = -max(abs(low), abs(high)), max(abs(low), abs(high))
        if high > low:
            colours.RescaleTransferFunction(low, high)
        bar = pv.GetScalarBar(colours, view)
        bar.Title, bar.ComponentTitle = title, ""
        bar.TitleColor = bar.LabelColor = [0, 0, 0]
        bar.TitleFontSize, bar.LabelFontSize, bar.ScalarBarLength, bar.ScalarBarThickness = 16, 16, 0.3, 16
        bar.WindowLocation, bar.Position, bar.RangeLabelFormat, bar.LabelFormat = "Any Location", [1 - 230 / view.ViewSize[0], top], "%.3g", "%.3g"
        part.SetScalarBarVisibility(view, True)
        return part

    titles = {"u": "gas, vertical velocity / (m/s)", "p": "pressure / Pa", "eps": "void fraction"}
    part = coloured(plane, gas, "CELLS", titles.get(gas, gas), "Viridis (matplotlib)", 0.1, False)
    part.Ambient, part.Diffuse = 1.0, 0.0  # its colours as the scale has them
    if spheres:
        coloured(spheres, "velocity", "POINTS", "grains, vertical velocity / (m/s)", "Cool to Warm", 0.56, True)
    note = pv.AnnotateTimeFilter(registrationName="time", Input=reader, Format="t = {time:.3f} s")
    text = pv.Show(note, view)
    text.Color, text.FontSize, text.WindowLocation = [0, 0, 0], 16, "Lower Left Corner"
    pv.Render(view)  # the first one places the camera by itself
    shift = 140 / pixels  # to the left of the scales
    eye = [0.0, -1.0, 0.0] if along == 1 else [1.0, 0.0, 0.0]
    right = [1.0, 0.0, 0.0] if along == 1 else [0.0, 1.0, 0.0]
    view.CameraFocalPoint = [m + shift * r for m, r in zip(middle, right)]
    view.CameraPosition = [f + 5 * max(across, tall) * e for f, e in zip(view.CameraFocalPoint, eye)]
    view.CameraViewUp, view.CameraParallelProjection, view.CameraParallelScale = [0, 0, 1], 1, 0.5 * view.ViewSize[1] / pixels
    pv.Render(view)
    return view


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?", default=os.environ.get("TWOGRID_XDMF"))
    parser.add_argument("--picture")
    parser.add_argument("--state")
    parser.add_argument("--frame", type=int, default=-1)
    parser.add_argument("--cut", type=float)
    parser.add_argument("--gas", default="u")
    o = parser.parse_args([] if os.environ.get("TWOGRID_XDMF") else None)
    if not o.file or not os.path.exists(o.file):
        sys.exit(f"paraview_scene: {o.file or 'no file'}: wanted is the .xdmf file that lies beside an output file of twogrid")
    try:
        from paraview import simple as pv
    except ImportError:
        sys.exit("paraview_scene: this is for ParaView's Python: pvpython cases/paraview_scene.py bed.xdmf (apt-get install paraview python3-paraview)")
    path = os.path.abspath(o.file)
    reader, plane, spheres, box = pipeline(path, o.gas, o.cut)
    view = show(reader, plane, spheres, box, o.gas, o.frame)
    if os.environ.get("TWOGRID_XDMF"):
        return
    base = os.path.splitext(path)[0]
    state, picture = (o.state, o.picture) if o.state or o.picture else (base + ".pvsm", base + ".png")
    if picture:
        pv.SaveScreenshot(picture, view)
        print("picture: " + os.path.abspath(picture))
    if state:
        pv.SaveState(state)
        print("state: " + os.path.abspath(state))


if __name__ == "__main__" or os.environ.get("TWOGRID_XDMF"):
    main()
