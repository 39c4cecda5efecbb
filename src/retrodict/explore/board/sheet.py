"""The plan to scale in the browser, as an element of the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nicegui.element import Element

from retrodict.scene.quantities import Units


class Sheet(Element, component="board.js"):
    """The plan to scale, with its tools.

    Args:
        first: drawing at the beginning.
        survey: surveyed points: name, x, y in m.
        lines: lines of a plan: places in m.
        units: units of grid and ruler.
    """

    def __init__(
        self, first: dict[str, Any], survey: Sequence[Any], lines: Sequence[Any], units: Units
    ) -> None:
        super().__init__()
        self._props["first"] = first
        self._props["survey"] = survey
        self._props["lines"] = lines
        self._props["units"] = units
