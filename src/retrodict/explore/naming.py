"""Names of scene files that somebody types on a page."""

from __future__ import annotations

from pathlib import Path

from retrodict.scene.errors import Problem, SceneError


def named(folder: Path, name: str, over: bool = False) -> Path:
    """The path of a scene file by the name that somebody typed.

    Args:
        folder: folder of the file.
        name: name of the file, without a folder.
        over: whether there may be such a file.

    Raises:
        SceneError: the name is no file name, or is taken.
    """
    plain = name.strip()
    if not plain.strip(".") or Path(plain).name != plain or "\\" in plain:
        raise SceneError(name, [Problem("", "", "write the name of a file, without a folder")])
    path = folder / (plain if plain.endswith(".toml") else f"{plain}.toml")
    if path.exists() and not over:
        fix = 'there is such a file; choose another name, or tick "replace it"'
        raise SceneError(path.name, [Problem("", "", fix)])
    return path
