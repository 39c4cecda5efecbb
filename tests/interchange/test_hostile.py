"""Whatever a file holds, the command ends in a scene file or in lines that name the file and a fix."""

from __future__ import annotations

import io
import random
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest
import typer

from retrodict.cli import import_
from tests.interchange import hostile
from tests.interchange.test_drawing import MAP as DRAWING_MAP
from tests.interchange.test_survey import ONE, ROOT

SCENE = (ROOT / "examples" / "brach-1977" / "scene.toml").read_bytes()
KINDS: dict[str, tuple[str, str, Callable[[random.Random], bytes]]] = {
    "survey": ("points.csv", ONE, hostile.table),
    "drawing": ("scene.dxf", DRAWING_MAP.split("[edges")[0], hostile.drawing),
}


def verdicts(folder: Path, kind: str, count: int) -> dict[int, int]:
    """How often each exit status came of `count` hostile files."""
    name, map_text, make = KINDS[kind]
    file, map_file, scene = folder / name, folder / "map.toml", folder / "scene.toml"
    map_file.write_text("schema = 1\n" + map_text, "utf-8")
    found: dict[int, int] = {}
    for seed in range(count):
        scene.write_bytes(SCENE)
        file.write_bytes(make(random.Random(seed)))
        status, lines = ran(file, map_file, scene)
        assert lines, seed
        assert all(line.isprintable() for line in lines), (seed, lines)
        if status:
            assert scene.read_bytes() == SCENE, seed
            assert all(line.startswith(str(folder)) for line in lines), (seed, lines)
        found[status] = found.get(status, 0) + 1
    return found


def ran(file: Path, map_file: Path, scene: Path) -> tuple[int, list[str]]:
    """Exit status of the command, and what it printed. Parsing options takes most of its time."""
    text = io.StringIO()
    with redirect_stdout(text), redirect_stderr(text):
        try:
            import_(file, map_file, scene)
        except typer.Exit as ended:
            return ended.exit_code, text.getvalue().splitlines()
    return 0, text.getvalue().splitlines()


@pytest.mark.parametrize("kind", KINDS)
def test_a_hundred_hostile_files(tmp_path: Path, kind: str) -> None:
    found = verdicts(tmp_path, kind, 100)
    assert set(found) == {0, 2}  # some are sound after all


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_five_thousand_hostile_files(tmp_path: Path, kind: str) -> None:
    assert set(verdicts(tmp_path, kind, 5000)) == {0, 2}
