"""A file that evidence is taken from: its bytes, its SHA-256, and what it is refused for."""

from __future__ import annotations

import codecs
import csv
import hashlib
import io
import math
import re
from dataclasses import dataclass
from pathlib import Path

from retrodict.scene.errors import Problem, SceneError, clipped, shown

MEGABYTES = 20
ROWS = 100_000
_COLUMNS = 200
_CELL = 1_000  # characters
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:[.][0-9]*)?|[.][0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_NAME = 60  # characters of a file's name in a source
_SOURCE = 200  # characters that a scene file allows a source
_BOMS = {codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}


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


@dataclass(frozen=True, slots=True)
class Row:
    """A line of a table: its number in the file, from 1, and its cells."""

    number: int
    cells: tuple[str, ...]


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


def table_rows(file: SourceFile, separator: str = "") -> list[Row]:
    """The rows of a table as CSV.

    Args:
        file: text in UTF-8, with or without a byte order mark, or in UTF-16 with one.
        separator: separator of cells; empty for the first of semicolon, tab and comma that the first
            line has.

    Returns:
        All rows that are not empty, cells without spaces around them.

    Raises:
        SceneError: the file is no text, or has too many rows, columns or characters.
    """
    text = _text(file)
    first = next((line for line in text.splitlines() if line.strip()), "")
    delimiter = separator or next((each for each in ";\t," if each in first), ",")
    rows = []
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    try:
        for cells in reader:
            stripped = tuple(cell.strip() for cell in cells)
            if len(cells) > _COLUMNS or any(len(cell) > _CELL for cell in stripped):
                fix = (
                    f"more than {_COLUMNS} columns, or {_CELL} characters in a cell; is it a table?"
                )
                raise file.refuse(fix, f"row {reader.line_num}")
            if any(stripped):
                rows.append(Row(reader.line_num, stripped))
            if len(rows) > ROWS:
                raise file.refuse(f"more than {ROWS} rows; export only what belongs to the scene")
    except csv.Error as error:
        raise file.refuse(f"not CSV ({error}); export it anew", f"row {reader.line_num}") from None
    return rows


def _text(file: SourceFile) -> str:
    encoding = next((name for bom, name in _BOMS.items() if file.content.startswith(bom)), "")
    try:
        text = file.content.decode(encoding or "utf-8-sig")
    except UnicodeDecodeError as error:
        line = file.content.count(b"\n", 0, error.start) + 1
        raise file.refuse(
            "is not UTF-8 text; save the table as CSV UTF-8", f"line {line}"
        ) from None
    if "\0" in text:
        raise file.refuse("is binary, not text; save the table as CSV UTF-8")
    return text


class NoNumber(ValueError):
    """A cell that is no number; says why."""


def number(cell: str, decimal: str) -> float:
    """The number in a cell.

    Args:
        cell: text of the cell.
        decimal: decimal sign, "." or ",".

    Raises:
        NoNumber: the cell is no number.
    """
    if not cell:
        raise NoNumber("is empty")
    if cell[0] in "=@":
        raise NoNumber("is a formula; export values")
    plain = cell.replace("\N{MINUS SIGN}", "-")
    if decimal == ",":
        if "." in plain:
            raise NoNumber('has a point, and the map says decimal = ","')
        plain = plain.replace(",", ".", 1)
    if not _NUMBER.fullmatch(plain):
        comma = "," in plain and decimal == "."
        hint = '; if the comma is its decimal sign, write decimal = ","' if comma else ""
        raise NoNumber(f"is not a number{hint}")
    value = float(plain)
    if not math.isfinite(value):
        raise NoNumber("is too large")
    return value
