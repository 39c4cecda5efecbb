"""A drawing with every shape, for the tests of its formats."""

import numpy as np

from retrodict.interchange.plan_drawing import Drawing, Ellipse, Layer, Line, Point, Text

HOSTILE = "^J0\nEOF\r\n%%u</svg><script>alert(1)</script>\x00\u202e μ"
PLAN = Drawing(
    "A plan",
    (
        Layer(
            "A-PATH",
            "#0072B2",
            (
                Line(np.array([[1 / 3, -2 / 3], [1e5 + 0.1234567, 2.0]])),
                Line(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 2.0]]), closed=True),
            ),
            dashed=True,
        ),
        Layer("ERROR", "#222222", (Ellipse((1.0, -2.0), (0.5, 1.5)), Point((3.25, -4.5)))),
        Layer("NOTES", "#222222", (Text((-3.0, 7.0), HOSTILE),)),
    ),
)
