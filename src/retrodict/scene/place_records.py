"""Frozen records of where an impact happened: its centre, surfaces, the ground's slope, a barrier."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from retrodict.scene.measured import Measured


@dataclass(frozen=True, slots=True)
class Contact:
    """Impact centre in the road plane (m) and Gamma (rad), the contact line's angle from the y axis.

    `interlocked` says that parts of the vehicles hooked into each other, so that sliding may have been
    reversed; `together` that they went on as one from there to rest, `perhaps_together` that nobody
    knows whether they did.
    """

    x: Measured
    y: Measured
    Gamma: Measured
    interlocked: bool = False
    together: bool = False
    perhaps_together: bool = False


@dataclass(frozen=True, slots=True)
class Edge:
    """A straight edge (m, rad) beyond which a surface lies.

    The surface lies to the `side` of someone who stands at (x, y) and looks along `direction`.
    `offset` shifts the edge towards the surface; its sd is the edge's uncertainty.
    """

    x: float
    y: float
    direction: float
    side: Literal["left", "right"]
    offset: Measured


@dataclass(frozen=True, slots=True)
class Outline:
    """The corners (m) of a surface in the order in which straight sides join them, either way round.

    `offset` shifts the whole outline inwards; its sd is the outline's uncertainty.
    """

    corners: tuple[tuple[float, float], ...]
    offset: Measured


@dataclass(frozen=True, slots=True)
class Surface:
    """A surface: sliding friction f at low speed, f exp(-speed_dependence v) at speed v (s/m).

    It has an edge, or an outline. The first surface of a scene has neither: it lies everywhere that
    no later one covers.
    """

    name: str
    friction: Measured
    speed_dependence: Measured
    edge: Edge | None
    outline: Outline | None = None


@dataclass(frozen=True, slots=True)
class Slope:
    """Slope of the whole ground, in whose plane positions and angles of a scene are measured.

    Args:
        grade: rise over run.
        uphill: direction in which it rises, counter-clockwise from the x axis, rad.
    """

    grade: Measured
    uphill: Measured


@dataclass(frozen=True, slots=True)
class Barrier:
    """Rigid and immovable barrier that vehicle A struck in place of a vehicle B.

    Args:
        kind: "wall", whose face is the contact line, or "pole", which touches that line
            from the side away from A.
        name: description of the barrier, such as "concrete wall".
        diameter: diameter of a pole, m, for drawing; 0 for a wall.
    """

    kind: Literal["wall", "pole"]
    name: str
    diameter: float = 0.0
