"""States of the drawing board: a scene file's text, and what such a file cannot say."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

Place = tuple[float, float]

EMPTY = """\
# Made on the drawing board of retrodict explore.
schema = 1
title = "Untitled collision"

[vehicles.A]

[vehicles.B]

[impact]
"""


@dataclass(frozen=True, slots=True)
class Backdrop:
    """A photograph under the drawing.

    Args:
        file: name of the image, which lies beside the scene file.
        sha256: digest of the image's bytes.
        width: width of the image, pixels.
        height: height of the image, pixels.
        metres: length of a pixel on the ground, m.
        x: x coordinate of the image's upper left corner, m.
        y: y coordinate of the image's upper left corner, m.
        turn: angle by which the image is turned counter-clockwise about that corner, rad.
        scaled: whether somebody has set the scale; else it is a guess.
        original: name of the file that the image was made from, beside it; empty where it is that file.
    """

    file: str
    sha256: str
    width: int
    height: int
    metres: float
    x: float = 0.0
    y: float = 0.0
    turn: float = 0.0
    scaled: bool = False
    original: str = ""


@dataclass(frozen=True, slots=True)
class State:
    """A state of the board.

    Args:
        text: text of the scene file, which need not be complete.
        said: name of the step that led to the state, in words.
        loose: positions at impact, by letter, of vehicles that do not touch the impact point yet, m.
        backdrop: photograph under the drawing; None for none.
        points: surveyed points that are shown and snapped to: name, x, y in m.
        lines: lines of a plan that are shown: places in m.
    """

    text: str
    said: str = ""
    loose: Mapping[str, Place] = field(default_factory=dict)
    backdrop: Backdrop | None = None
    points: tuple[tuple[str, float, float], ...] = ()
    lines: tuple[tuple[Place, ...], ...] = ()

    def rest(self, since: State | None = None) -> dict[str, Any]:
        """Everything but the text, in the form that JSON has.

        Args:
            since: state before; what is the same in it is left out.
        """
        forms: dict[str, Callable[[], Any]] = {
            "said": lambda: self.said,
            "loose": lambda: {v: list(at) for v, at in self.loose.items()},
            "backdrop": lambda: asdict(self.backdrop) if self.backdrop else None,
            "points": lambda: [list(point) for point in self.points],
            "lines": lambda: [[list(place) for place in line] for line in self.lines],
        }
        return {
            key: form()
            for key, form in forms.items()
            if since is None or getattr(self, key) != getattr(since, key)
        }


def state_from(text: str, rest: Mapping[str, Any], before: State | None = None) -> State:
    """The state that `State.rest` and a text describe.

    Args:
        text: text of the scene file.
        rest: everything else, as JSON has it.
        before: state before, from which comes what `rest` does not have.

    Raises:
        ValueError, TypeError, KeyError: it describes none.
    """
    readers: dict[str, Callable[[Any], Any]] = {
        "said": str,
        "loose": lambda loose: {str(v): (float(x), float(y)) for v, (x, y) in loose.items()},
        "backdrop": lambda backdrop: Backdrop(**backdrop) if backdrop else None,
        "points": lambda points: tuple((str(name), float(x), float(y)) for name, x, y in points),
        "lines": lambda lines: tuple(
            tuple((float(x), float(y)) for x, y in line) for line in lines
        ),
    }
    found = {key: read(rest[key]) for key, read in readers.items() if key in rest}
    return replace(before or State(""), text=text, **found)
