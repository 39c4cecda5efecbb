"""Whatever a file holds, the command ends in a scene file or in lines that name the file and a fix."""

from __future__ import annotations

import io
import random
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest
import typer

from retrodict.cli.import_ import import_
from tests.interchange import hostile
from tests.interchange.test_drawing import MAP as DRAWING_MAP
from tests.interchange.test_survey import ONE, ROOT

SCENE = (ROOT / "examples" / "brach-1977" / "scene.toml").read_bytes()
RECORDER_MAP = """
[recorder]
vehicle = "A"
columns = { time = "Time", speed = "Speed" }
units = { time = "s", speed = "m/s" }
[recorder.speed]
impact = ["-1 s", "0 s"]
uncertainty = "1 mph"
"""
REPORT_MAP = RECORDER_MAP.replace('"Speed"', '"Speed (MPH [km/h])"').replace('"m/s"', '"mph"')
REPORT_MAP = REPORT_MAP.replace("[recorder]", '[recorder]\nbelow = "Event 1"')
LONG_MAP = RECORDER_MAP.replace(
    "[recorder]",
    """[recorder]
only = { Event = 1 }
long = { parameter = "What", value = "Value", unit = "Unit" }""",
)
DEGREES_MAP = ONE.replace('"m"', '"deg"').replace(
    "columns", 'origin = ["-83.04575 deg", "42.33141 deg"]\ncolumns'
)
DEGREES_MAP = DEGREES_MAP.replace('"x"', '"Longitude"').replace('"y"', '"Latitude"')
STATIONS_MAP = ONE.replace('x = "x", y = "y"', 'station = "Station", offset = "Offset"').replace(
    "[impact_point]",
    """[survey.baseline]
start = "10+00"
line = [["0 m", "0 m"], ["90 m", "0 m"], ["90 m", "90 m"]]
[impact_point]""",
)
LANDXML_MAP = """
[landxml]
unit = "m"
precision = "0.03 m"
[impact_point]
point = 7
uncertainty = "0.04 m"
"""
SOUND = b"id,x,y,Time,Speed\n7,1,2,-1,20\n8,2,3,0,15\n"


def _hostile_file(
    make: Callable[[random.Random], bytes], map_text: str
) -> Callable[[random.Random], tuple[bytes, bytes]]:
    return lambda rng: (make(rng), f"schema = 1\n{map_text}".encode())


def _hostile_map(rng: random.Random) -> tuple[bytes, bytes]:
    return SOUND, hostile.map_text(rng, "schema = 1\n" + rng.choice(MAPS))


MAPS = [ONE, RECORDER_MAP, REPORT_MAP, LONG_MAP, DEGREES_MAP, STATIONS_MAP, LANDXML_MAP]
# name of the file, and the file and its map at random
KINDS: dict[str, tuple[str, Callable[[random.Random], tuple[bytes, bytes]]]] = {
    "survey": ("points.csv", _hostile_file(hostile.survey, ONE)),
    "recorder": ("recorder.csv", _hostile_file(hostile.recorder, RECORDER_MAP)),
    "drawing": ("scene.dxf", _hostile_file(hostile.drawing, DRAWING_MAP.split("[edges")[0])),
    "character set": ("points.csv", _hostile_file(hostile.character_set, ONE)),
    "report": ("report.csv", _hostile_file(hostile.report, REPORT_MAP)),
    "values in rows": ("long.csv", _hostile_file(hostile.values_in_rows, LONG_MAP)),
    "degrees": ("points.csv", _hostile_file(hostile.degrees, DEGREES_MAP)),
    "stations": ("points.csv", _hostile_file(hostile.stations, STATIONS_MAP)),
    "landxml": ("points.xml", _hostile_file(hostile.landxml, LANDXML_MAP)),
    "map": ("both.csv", _hostile_map),
}


def verdicts(folder: Path, kind: str, count: int) -> dict[int, int]:
    """How often each exit status came of `count` hostile files."""
    name, make = KINDS[kind]
    file, map_file, scene = folder / name, folder / "map.toml", folder / "scene.toml"
    found: dict[int, int] = {}
    for seed in range(count):
        content, map_text = make(random.Random(seed))
        scene.write_bytes(SCENE)
        file.write_bytes(content)
        map_file.write_bytes(map_text)
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
    if kind == "degrees":
        pytest.importorskip("pyproj")
    found = verdicts(tmp_path, kind, 100)
    assert set(found) == {0, 2}  # some are sound after all


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_five_thousand_hostile_files(tmp_path: Path, kind: str) -> None:
    if kind == "degrees":
        pytest.importorskip("pyproj")
    assert set(verdicts(tmp_path, kind, 5000)) == {0, 2}
