"""Files of evidence that are dropped onto the board: surveyed points and recorders' tables, by a map."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from retrodict.explore.board.state import State
from retrodict.interchange.importing import import_evidence, placed_points
from retrodict.scene.errors import SceneError

_NOTHING = "takes nothing"  # how the import says that a map only describes points


def taken(state: State, name: str, content: bytes, map_name: str, map_content: bytes) -> State:
    """The state with a file's points, and with what its map takes of it.

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
            text = import_evidence(file, map_file, into).text
        except SceneError as error:
            if not any(problem.fix.startswith(_NOTHING) for problem in error.problems):
                raise SceneError(Path(name).name, error.problems) from None
            text = state.text
    bom = "\ufeff" if state.text.startswith("\ufeff") and not text.startswith("\ufeff") else ""
    return replace(state, text=bom + text, points=points or state.points, said=f"{Path(name).name}")
