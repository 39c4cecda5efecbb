"""Files of evidence that are dropped onto the board: surveyed points and recorders' tables, by a map."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from retrodict.explore.board.plan_lines import plan_lines
from retrodict.explore.board.state import Place, State
from retrodict.interchange.column_map import load_map
from retrodict.interchange.dxf_in import drawing_points
from retrodict.interchange.importing import import_evidence, placed_points
from retrodict.interchange.source_file import read_source
from retrodict.scene.errors import SceneError

_NOTHING = "takes nothing"  # how the import says that a map only describes points


def taken(state: State, name: str, content: bytes, map_name: str, map_content: bytes) -> State:
    """The state with a file's points and lines, and with what its map takes of it.

    Args:
        state: state of the board.
        name: name of the file: survey points or a recorder's table as CSV, or a drawing as DXF.
        content: bytes of the file.
        map_name: name of the map.
        map_content: the map, TOML.

    Raises:
        SceneError: the file or the map cannot be used, or the scene lacks what the map needs of it.
    """
    with TemporaryDirectory() as folder:
        file = Path(folder) / (Path(name).name or "file.csv")
        map_file = Path(folder) / f"map-{Path(map_name).name}"
        into = Path(folder) / "into.scene.toml"
        file.write_bytes(content)
        map_file.write_bytes(map_content)
        into.write_text(state.text.removeprefix("\ufeff"), "utf-8")
        try:
            points = placed_points(file, map_file)
            lines = _lines_of(file, map_file, points)
            text = import_evidence(file, map_file, into).text
        except SceneError as error:
            if not any(problem.fix.startswith(_NOTHING) for problem in error.problems):
                raise SceneError(Path(name).name, error.problems) from None
            text = state.text
    bom = "\ufeff" if state.text.startswith("\ufeff") and not text.startswith("\ufeff") else ""
    return replace(
        state,
        text=bom + text,
        points=points or state.points,
        lines=lines or state.lines,
        said=f"{Path(name).name}",
    )


def _lines_of(
    file: Path, map_file: Path, points: tuple[tuple[str, float, float], ...]
) -> tuple[tuple[Place, ...], ...]:
    """Lines of a drawing in the scene's frame; none of any other file."""
    entry = load_map(map_file).drawing
    if entry is None:
        return ()
    drawn, _ = drawing_points(read_source(file), entry)
    of_file = [(point.x, point.y) for point in drawn if not point.fault]
    return plan_lines(file.read_bytes(), of_file, [(x, y) for _, x, y in points])
