"""A drawing as SVG to scale: 10 mm of paper for a metre, one group for each layer."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from retrodict.interchange.plan_drawing import (
    Drawing,
    Ellipse,
    Line,
    Point,
    Shape,
    Text,
    on_one_line,
)

_MM = 10.0  # of paper for a metre: 1 : 100
_MARGIN = 1.0  # m
_LINE = 0.05  # m, width
_SVG, _INKSCAPE = "http://www.w3.org/2000/svg", "http://www.inkscape.org/namespaces/inkscape"


def svg(drawing: Drawing) -> bytes:
    """The drawing as an SVG file, whose units are metres on the road and 10 mm on paper.

    Args:
        drawing: drawing to write.

    Returns:
        The file; y points up on paper, and so is counted negative in it. Coordinates are to 0.1 mm on
        the road. Every text is escaped. Drawing programs take its groups for layers.
    """
    ET.register_namespace("", _SVG)
    ET.register_namespace("inkscape", _INKSCAPE)
    x0, x1, y0, y1 = drawing.bounds
    width, height = x1 - x0 + 2 * _MARGIN, y1 - y0 + 2 * _MARGIN
    size = {
        "width": f"{width * _MM:.1f}mm",
        "height": f"{height * _MM:.1f}mm",
        "viewBox": _numbers(x0 - _MARGIN, -y1 - _MARGIN, width, height),
    }
    root = ET.Element(f"{{{_SVG}}}svg", size)
    ET.SubElement(root, f"{{{_SVG}}}title").text = on_one_line(drawing.title)
    for layer in drawing.layers:
        look = {
            "id": layer.name,
            f"{{{_INKSCAPE}}}groupmode": "layer",
            f"{{{_INKSCAPE}}}label": layer.name,
            "fill": "none",
            "stroke": layer.colour,
            "stroke-width": f"{_LINE}",
            **({"stroke-dasharray": "0.4 0.2"} if layer.dashed else {}),
        }
        group = ET.SubElement(root, f"{{{_SVG}}}g", look)
        for shape in layer.shapes:
            _add(group, shape, layer.colour, drawing.text_height)
    ET.indent(root)
    return ET.tostring(root, "utf-8", xml_declaration=True) + b"\n"


def _add(group: ET.Element, shape: Shape, colour: str, height: float) -> None:
    def add(name: str, **attributes: str) -> ET.Element:
        return ET.SubElement(
            group, f"{{{_SVG}}}{name}", {k.replace("_", "-"): v for k, v in attributes.items()}
        )

    match shape:
        case Line(points, closed):
            corners = " ".join(f"{x:.4f},{-y:.4f}" for x, y in points)
            add("polygon" if closed else "polyline", points=corners)
        case Ellipse((x, y), (a, b)):
            add("ellipse", cx=f"{x:.4f}", cy=f"{-y:.4f}", rx=f"{a:.4f}", ry=f"{b:.4f}")
        case Point((x, y)):
            r = height / 2
            cross = f"m{-r} {-r} l{2 * r} {2 * r} m0 {-2 * r} l{-2 * r} {2 * r}"
            add("path", d=f"M{x:.4f} {-y:.4f} {cross}")
        case Text((x, y), text):
            look = {"fill": colour, "stroke": "none", "font_size": f"{height}"}
            add(
                "text", x=f"{x:.4f}", y=f"{-y:.4f}", font_family="sans-serif", **look
            ).text = on_one_line(text)


def _numbers(*values: float) -> str:
    return " ".join(f"{value:.4f}" for value in values)
