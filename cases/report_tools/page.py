"""One self-contained HTML page: style, sections, tables, pictures as data URIs. No script, nothing from the network."""
import base64
import html
import io

STYLE = """
:root { color-scheme: light }
* { box-sizing: border-box }
body { margin: 0 auto; max-width: 1180px; padding: 0 16px 48px; background: #fff; color: #1a1a1a; font: 16px/1.5 system-ui, sans-serif }
h1 { font-size: 1.5rem; line-height: 1.25; margin: 24px 0 4px; overflow-wrap: anywhere }
h2 { font-size: 1.15rem; margin: 40px 0 8px; padding-top: 8px; border-top: 1px solid #ddd }
p, figcaption, li { overflow-wrap: anywhere }
p { margin: 8px 0; max-width: 75ch }
ul { margin: 4px 0; padding-left: 1.2em; max-width: 90ch }
nav { display: flex; flex-wrap: wrap; gap: 4px 16px; margin: 12px 0; font-size: .9rem }
a { color: #0b57a4 }
.facts { display: grid; grid-template-columns: repeat(auto-fill, minmax(130px, 1fr)); gap: 8px; margin: 16px 0 }
.facts div { border: 1px solid #ddd; border-radius: 6px; padding: 8px 10px }
.facts b { display: block; font-size: 1.15rem; font-weight: 600 }
.facts span, figcaption, .quiet { color: #555; font-size: .88rem }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 350px), 1fr)); gap: 16px; align-items: start }
figure { margin: 0 }
.wide { grid-column: 1 / -1; overflow-x: auto }
.wide img { max-width: none; margin: 0 }
img { display: block; max-width: 100%; height: auto; margin: 0 auto }
figcaption { margin-top: 4px }
table { border-collapse: collapse; width: 100%; font-size: .92rem }
td, th { text-align: left; vertical-align: top; padding: 5px 10px 5px 0; border-bottom: 1px solid #eee; overflow-wrap: anywhere }
th { font-weight: 600; border-bottom-color: #bbb; overflow-wrap: normal }
.number { white-space: nowrap }
td:first-child { min-width: 5.5em }
.word { font-weight: 700; white-space: nowrap }
.pass { color: #14662a } .fail { color: #b00020 }
.missing { border-left: 4px solid #bbb; padding: 6px 12px; background: #f6f6f6; color: #333 }
.warning, .failed { border-left: 4px solid #c77700; padding: 6px 12px; background: #fff6e5 }
.bar { display: grid; grid-template-columns: 7.5em 1fr 3.5em; gap: 8px; align-items: center; font-size: .92rem; margin: 3px 0 }
.bar i { display: block; height: 14px; background: #4477aa; min-width: 1px }
.bar b { font-weight: 400; text-align: right }
.swatch { display: inline-block; margin-right: 14px; color: #1a1a1a }
.swatch i { display: inline-block; width: 18px; height: 6px; margin-right: 5px; vertical-align: middle }
.scale { max-width: 420px; margin: 6px auto; font-size: .82rem; color: #333 }
.scale i { display: block; height: 10px; border: 1px solid #ccc }
.scale span { display: flex; justify-content: space-between }
pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: .82rem; background: #f6f6f6; padding: 8px }
"""


def escape(text):
    return html.escape(str(text), quote=True)


def table(heads, rows):
    """Cells are text; a tuple (class, text) gives a cell its class."""
    def cell(c):
        return f'<td class="{c[0]}">{escape(c[1])}</td>' if isinstance(c, tuple) else f"<td>{escape(c)}</td>"
    head = "<tr>" + "".join(f"<th>{escape(h)}</th>" for h in heads) + "</tr>" if heads else ""
    return "<table>" + head + "".join("<tr>" + "".join(map(cell, r)) + "</tr>" for r in rows) + "</table>"


def missing(text):
    return f'<p class="missing">{escape(text)}</p>'


def image(data, kind, alt, width, height, caption="", legend=()):
    """width, height: in pixels of the page."""
    source = f"data:image/{kind};base64,{base64.b64encode(data).decode()}"
    return (f'<figure><img src="{source}" alt="{escape(alt)}" width="{width:.0f}" height="{height:.0f}">' +
            (f"<figcaption>{swatches(legend)}{escape(caption)}</figcaption>" if caption or legend else "") + "</figure>")


def swatches(legend):
    return "".join(f'<span class="swatch"><i style="background:{colour}"></i>{escape(label)}</span>' for colour, label in legend)


def drawing(figure, alt, caption="", legend=()):
    """A figure of matplotlib, 100 pixels of the page an inch, twice as many in the file."""
    from matplotlib import pyplot
    from PIL import Image
    raw, out = io.BytesIO(), io.BytesIO()
    figure.draw_without_rendering()  # the layout knows the ticks' widths only then, else it cuts labels
    figure.savefig(raw, dpi=200, format="png")
    pyplot.close(figure)
    picture = Image.open(raw).convert("RGB")
    picture.quantize(128, dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
    return image(out.getvalue(), "png", alt, picture.width / 2, picture.height / 2, caption, legend)


def picture_file(path, alt, caption=""):
    """A picture that is there, no wider than 1400 pixels."""
    from PIL import Image
    picture, out = Image.open(path).convert("RGB"), io.BytesIO()
    if picture.width > 1400:
        picture = picture.resize((1400, round(1400 * picture.height / picture.width)), Image.Resampling.LANCZOS)
    picture.save(out, "WEBP", quality=88)
    shrink = 1 if picture.width <= 520 else 0.62
    shown = image(out.getvalue(), "webp", alt, shrink * picture.width, shrink * picture.height, caption)
    # Several panels beside each other would be too small on a phone: there they scroll in their own frame.
    return f'<div class="wide">{shown}</div>' if picture.width > 1.5 * picture.height else shown


def pictures(*figures):
    return '<div class="pictures">' + "".join(figures) + "</div>"


def bars(shares):
    return "".join(f'<div class="bar"><span>{escape(k)}</span><i style="width:{max(v, 0.2):.1f}%"></i><b>{v:.1f} %</b></div>' for k, v in shares.items())


def whole(title, sections):
    """sections: (name, heading, HTML); the first without a heading."""
    links = "".join(f'<a href="#{n}">{escape(h)}</a>' for n, h, _ in sections if h)
    body = "".join(f'<section id="{n}">' + (f"<h2>{escape(h)}</h2>" if h else "") + text + (f"<nav>{links}</nav>" if not h else "") + "</section>\n" for n, h, text in sections)
    return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
            f'<link rel="icon" href="data:,"><title>{escape(title)}</title><style>{STYLE}</style></head>\n<body>\n{body}</body></html>\n')
