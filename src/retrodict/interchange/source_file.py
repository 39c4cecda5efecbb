"""A file that evidence is taken from: its bytes, its SHA-256, and what it is refused for."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from retrodict.scene.errors import Problem, SceneError, clipped, shown

MEGABYTES = 20
_NAME = 60  # characters of a file's name in a source
_SOURCE = 200  # characters that a scene file allows a source


@dataclass(frozen=True, slots=True)
class SourceFile:
    """A file that was read whole.

    Args:
        path: path as the user wrote it.
        content: bytes of the file.
        sha256: SHA-256 of the bytes, in hexadecimal.
    """

    path: str
    content: bytes
    sha256: str

    def source(self, where: str) -> str:
        """What stands as the source of a value: the file's name, the place in it, its SHA-256."""
        name, digest = clipped(shown(Path(self.path).name)[1:-1], _NAME), f"; SHA-256 {self.sha256}"
        return f"{name}, {clipped(where, _SOURCE - len(name) - len(digest) - 2)}{digest}"

    def refuse(self, fix: str, key: str = "", value: str = "") -> SceneError:
        """The error that names the file, the place in it and the fix."""
        return SceneError(self.path, [Problem(key, value, fix)])


def read_source(path: str | Path) -> SourceFile:
    """A file, with its digest.

    Args:
        path: path of a file of at most `MEGABYTES`.

    Raises:
        SceneError: the file cannot be read, is empty or too large.
    """
    empty = SourceFile(str(path), b"", "")
    try:
        if Path(path).is_dir():
            raise empty.refuse("is a folder; write the path of a file")
        with open(path, "rb") as file:
            content = file.read(MEGABYTES * 1_000_000 + 1)
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        reason = getattr(error, "strerror", None) or "not a path"
        raise empty.refuse(f"cannot be read ({reason}); correct the path") from None
    if len(content) > MEGABYTES * 1_000_000:
        raise empty.refuse(f"larger than {MEGABYTES} MB; export only what belongs to the scene")
    if not content.strip():
        raise empty.refuse("the file is empty; export it anew")
    return SourceFile(str(path), content, hashlib.sha256(content).hexdigest())
