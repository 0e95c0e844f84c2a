"""An animated picture (WebP) of grains and fluid: grains true to size, coloured by their vertical velocity; beside or below it the fluid's velocity."""
import io
import os
import typing

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

import plot_fields
from . import figures

FRAMES = 40          # at most
WIDTH, HEIGHT = 720, 900   # of the picture at most, pixels
SOLID = tuple(int(plot_fields.SOLID[i:i + 2], 16) for i in (1, 3, 5))


def font(size):
    return ImageFont.truetype(os.path.join(matplotlib.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf"), size)


def colours(values, scale):
    """RGB of values by a Scale."""
    return (matplotlib.cm.get_cmap(scale.colours)(np.clip((values - scale.low) / (scale.high - scale.low), 0, 1))[..., :3] * 255).astype(np.uint8)


class View:
    """What is drawn: the plane, its part with something in it, its size in pixels."""

    def __init__(self, file, names):
        self.across, self.along = plot_fields.view(file)
        self.edges = plot_fields.nodes(file)
        a, z = self.edges[self.across], self.edges[2]
        top = max((float(file["particles"][n]["position"][:, 2].max()) for n in names if n in file.get("particles", ()) and len(file["particles"][n]["position"])), default=z[-1])
        self.lo, self.hi = (a[0], z[0]), (a[-1], min(z[-1], z[0] + 1.2 * (top - z[0])))
        self.depth = 0.5 * (self.edges[self.along][0] + self.edges[self.along][-1])
        self.beside = (self.hi[1] - self.lo[1]) > 0.8 * (self.hi[0] - self.lo[0])
        w, h = (WIDTH - 12) / 2 if self.beside else WIDTH, HEIGHT if self.beside else (HEIGHT - 12) / 2
        self.scale = min(w / (self.hi[0] - self.lo[0]), h / (self.hi[1] - self.lo[1]))  # pixels a metre
        self.shape = tuple(int(round((self.hi[k] - self.lo[k]) * self.scale)) for k in (1, 0))

    def cells(self, values):
        """Cell values of the plane, an entry a pixel, top row first."""
        at = [self.lo[k] + (np.arange(self.shape[1 - k]) + 0.5) / self.scale for k in (0, 1)]
        i = [np.clip(np.searchsorted(e, p) - 1, 0, len(e) - 2) for e, p in zip((self.edges[self.across], self.edges[2]), at)]
        return values[np.ix_(i[1], i[0])][::-1]


def grains(view, picture, x, radius, colour):
    """Discs, those nearer to the eye over the others, shaded towards their rim."""
    order = np.argsort(-x[:, view.along])
    for part in np.array_split(order, 1 + len(order) // 20000):
        discs(view, picture, x[part], radius[part], colour[part])


def discs(view, picture, x, radius, colour):
    """In the order given."""
    at = (x[:, [view.across, 2]] - view.lo) * view.scale
    r = np.maximum(radius * view.scale, 0.7)
    reach = int(np.ceil(r.max()))
    dy, dx = np.mgrid[-reach:reach + 1, -reach:reach + 1].reshape(2, -1)
    column, row = np.floor(at[:, :1]).astype(int) + dx, np.floor(at[:, 1:]).astype(int) + dy
    off = ((column + 0.5 - at[:, :1])**2 + (row + 0.5 - at[:, 1:])**2) / r[:, None]**2
    inside = (off <= 1) & (column >= 0) & (column < view.shape[1]) & (row >= 0) & (row < view.shape[0])
    which = np.broadcast_to(np.arange(len(r))[:, None], off.shape)[inside]  # the last one that is written to a pixel holds
    pixel = ((view.shape[0] - 1 - row) * view.shape[1] + column)[inside]
    flat = picture.reshape(-1, 3)
    flat[pixel] = (colour[which] * (1 - 0.35 * off[inside])[:, None]).astype(np.uint8)


class Scale(typing.NamedTuple):
    """What a colour stands for, from low to high, and what has been met with at least and at most: beyond the ends all has the end's colour."""

    what: str
    colours: str
    low: float
    high: float
    least: float
    most: float

    def ends(self):
        """Labels of low, middle and high."""
        little = 0.005 * (self.high - self.low)
        below, beyond = self.least < self.low - little, self.most > self.high + little
        return ("\u2264 " if below else "") + f"{self.low:.3g}", f"{0.5 * (self.low + self.high):.3g}", ("\u2265 " if beyond else "") + f"{self.high:.3g}"


def velocity_scale(what, values, signed=False):
    """For vertical velocities, an array a frame: from 0 up; both ways alike if so much goes down that it can't be left out. But for 0.5 % of the fastest."""
    up, down = (max(np.percentile(sign * v, 99.5) for v in values) for sign in (1, -1))
    least, most = min(v.min() for v in values), max(v.max() for v in values)
    fastest = max(up, down, 0) or max(most, -least) or 1.0
    return Scale(what, "coolwarm", -fastest, fastest, least, most) if signed or down > 0.1 * up else Scale(what, "viridis", 0.0, fastest, least, most)


def in_words(grains_scale, fluid_scale):
    """What the colours say, for a caption: of grains and fluid."""
    said = ["grains, red: up, blue: down"] if grains_scale else []
    name = fluid_scale.what.split(",")[0]
    if "velocity" not in fluid_scale.what:
        said.append("void fraction, yellow: 1")
    elif fluid_scale.low < 0:
        said.append(f"{name}, red: up, blue: down, {fluid_scale.high:.3g} m/s at full colour")
    else:
        said.append(f"{name}, yellow: fast, {fluid_scale.high:.3g} m/s at full colour")
    return "; ".join(said)


def frame(file, name, view, grains_scale, fluid_scale, theta):
    """The two pictures of one frame."""
    solid = None if theta is None else view.cells(plot_fields.plane(theta, view.edges, view.along, view.depth)) == 0
    left = np.full((*view.shape, 3), 255, np.uint8)
    values = file["fluid"][name]["u"][..., 2] if "velocity" in fluid_scale.what else file["fluid"][name]["eps"][:]
    right = colours(view.cells(np.asarray(plot_fields.plane(values, view.edges, view.along, view.depth))), fluid_scale)
    if solid is not None:
        left[solid] = right[solid] = SOLID
    if name in file.get("particles", ()) and len(file["particles"][name]["position"]):
        p = file["particles"][name]
        x, v = p["position"][:], p["velocity"][:, 2]
        # In a deep bed what lies before the middle would hide the rest.
        keep = x[:, view.along] >= view.depth if np.ptp(view.edges[view.along]) > 16 * p["radius"][:].mean() else slice(None)
        if len(x[keep]):
            grains(view, left, x[keep], p["radius"][:][keep], colours(v[keep], grains_scale))
    return left, right


def scale_bar(view):
    """A round length of about a fourth of the width: metres, text."""
    quarter = 0.25e3 * (view.hi[0] - view.lo[0])
    power = 10 ** np.floor(np.log10(quarter))
    mm = max(m * power for m in (1, 2, 5) if m * power <= quarter)
    return mm / 1e3, f"{mm:g} mm"


def animate(file, names, most=FRAMES):
    """WebP data, its size (pixels), frames drawn, the scales of grains (None without) and fluid, where the cut lies, whether only what lies behind it is drawn, whether
    the two pictures lie beside each other."""
    names = [names[i] for i in sorted({int(i) for i in np.linspace(0, len(names) - 1, min(most, len(names)))})]
    view, theta = View(file, names), plot_fields.open_share(file)
    has_u = all("u" in file["fluid"][n] for n in names)
    with_grains = [n for n in names if n in file.get("particles", ()) and len(file["particles"][n]["position"])]
    grains_scale = velocity_scale("grains, vertical velocity (m/s)", [file["particles"][n]["velocity"][:, 2] for n in with_grains], True) if with_grains else None
    fluid_scale = (velocity_scale(f"{figures.fluid(file)}, vertical velocity (m/s)", [file["fluid"][n]["u"][..., 2] for n in names]) if has_u else
                   Scale("void fraction", "viridis", 0.4, 1.0, min(file["fluid"][n]["eps"][:].min() for n in names), 1.0))
    h, w = view.shape
    big, pictures = font(22), []
    length, label = scale_bar(view)
    needed = int(150 + length * view.scale + 30 + big.getlength(label))  # time and length beside each other
    head, gap = 34, max(12, needed - 2 * w) if view.beside else 12
    size = (2 * w + gap, h + head) if view.beside else (w, 2 * (h + head))
    for name in names:
        canvas = Image.new("RGB", size, "white")
        draw = ImageDraw.Draw(canvas)
        places = ((0, head), (w + gap, head)) if view.beside else ((0, head), (0, h + 2 * head))
        for place, part in zip(places, frame(file, name, view, grains_scale, fluid_scale, theta)):
            canvas.paste(Image.fromarray(part), place)
            draw.rectangle((place[0], place[1], place[0] + w - 1, place[1] + h - 1), outline=(150, 150, 150))
        draw.text((2, 4), f"t = {float(file['fluid'][name]['time'][()]):.3f} s", fill="black", font=big)
        x0, y0 = size[0] - 14 - length * view.scale - big.getlength(label), 22
        draw.line((x0, y0, x0 + length * view.scale, y0), fill="black", width=4)
        draw.text((x0 + length * view.scale + 8, 4), label, fill="black", font=big)
        pictures.append(canvas)
    out = io.BytesIO()
    pictures[0].save(out, "WEBP", save_all=True, append_images=pictures[1:], duration=[120] * (len(pictures) - 1) + [900], loop=0, quality=55, method=2)
    where = f"cut at {'xy'[view.along]} = {1e3 * view.depth:.1f} mm"
    deep = with_grains and np.ptp(view.edges[view.along]) > 16 * file["particles"][with_grains[0]]["radius"][:].mean()
    return out.getvalue(), size, len(names), (grains_scale, fluid_scale), where, deep, view.beside
