"""The library of vehicles on a terminal: every entry, and every source that a number refers to."""

from __future__ import annotations

import io
import re

import pytest
from rich.console import Console

from retrodict.report.vehicles import library_rows, print_vehicles
from retrodict.scene.vehicle_library import vehicles


@pytest.mark.parametrize("width", [60, 250])
def test_entries_and_sources_are_all_printed(width: int) -> None:
    out = io.StringIO()
    print_vehicles(Console(file=out, width=width))
    printed = out.getvalue()
    _, sources = library_rows()
    for number, source in enumerate(sources, start=1):
        assert f"[{number}] {source}" in printed
    for name, entry in vehicles().items():
        assert f"{name}: {entry.what}" in printed
        assert re.search(rf"^\W*{name}", printed, re.M)
    assert "1143 ± 46 [" in printed


def test_each_number_refers_to_its_own_source() -> None:
    rows, sources = library_rows()
    by_name = {name: cells for name, *cells in rows}
    for name, entry in vehicles().items():
        (mass, *_, width) = by_name[name]
        found = re.fullmatch(r"\d+ ± \d+ \[(\d+)\]", mass)
        assert found
        assert sources[int(found[1]) - 1] == entry.mass.source
        assert (width == "–") == (entry.width is None)
