"""The rows of a table in a text file: its character set, its separator, its header."""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from retrodict.interchange.map_tables import BLANKS, TableEntry
from retrodict.interchange.source_file import SourceFile
from retrodict.scene.errors import SceneError, shown

ROWS = 100_000
_COLUMNS = 200
_CELL = 1_000  # characters
_SEPARATORS = ";\t,"
_BOMS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
# Windows-1252 alone first: with the others beside it, three letters of French look like Polish
_TRIED = (["cp1252"], ["cp1250", "cp1251", "cp1253"])
_NO_TEXT = re.compile(r"[\0-\x08\x0e-\x19\x1b-\x1f\x7f-\x9f]")  # old tables end in Ctrl-Z


@dataclass(frozen=True, slots=True)
class Row:
    """A line of a table: its number in the file, from 1, and its cells."""

    number: int
    cells: tuple[str, ...]

    def cell(self, place: int | None) -> str:
        """The cell at an index from 0; empty where there is none."""
        return self.cells[place] if place is not None and place < len(self.cells) else ""


@dataclass(frozen=True, slots=True)
class TableIn:
    """A table of a file.

    Args:
        rows: rows below the header, or all where there is none.
        places: index of each wanted column from 0, by what it holds.
        headings: text in the header of each of them; empty where there is no header.
        left: lines, each on something of the file that was not taken.
        again: numbers of the rows in which the header stands once more.
    """

    rows: list[Row]
    places: dict[str, int]
    headings: dict[str, str] = field(default_factory=dict)
    left: list[str] = field(default_factory=list)
    again: frozenset[int] = frozenset()


def read_table(
    file: SourceFile, entry: TableEntry, wanted: Mapping[str, int | str], table: str
) -> TableIn:
    """A table of a text file.

    Args:
        file: text in UTF-8, with or without a byte order mark, in UTF-16 with one, in the map's
            character set, or in one of Windows.
        entry: the map's table on the file.
        wanted: name in the header, or number from 1, of each wanted column, by what it holds.
        table: name of the map's table, for messages.

    Returns:
        The rows that the map asks for, cells without spaces around them, and where the columns stand.

    Raises:
        SceneError: the file is no text, has too many rows, columns or characters, or lacks a column.
    """
    text, left = _text(file, entry.encoding, table)
    by_number = all(isinstance(each, int) for each in wanted.values())
    wanted = {**wanted, **{f"only.{column}": column for column in entry.only}}
    if by_number:
        rows = _below(file, _rows(file, text, _separators(text, entry)[0]), entry.below, table)
        places = {key: int(each) - 1 for key, each in wanted.items()}
        found = TableIn(rows, places)
    else:
        found = _with_header(file, text, entry, wanted, table)
    found = replace(found, left=[*left, *found.left])
    return _only(file, found, entry, table)


def _with_header(
    file: SourceFile,
    text: str,
    entry: TableEntry,
    wanted: Mapping[str, int | str],
    table: str,
) -> TableIn:
    """The table whose header has all wanted columns, by the first separator that makes one."""
    faults: list[SceneError] = []
    for separator in _separators(text, entry):
        try:
            rows = _below(file, _rows(file, text, separator), entry.below, table)
            top = _header(file, rows, wanted, table)
        except SceneError as fault:
            faults.append(fault)
            continue
        header, below = rows[top], rows[top + 1 :]
        short: list[Row] = []
        if separator in BLANKS:  # where a cell is empty, those after it stand in other columns
            count = len(header.cells)
            short = [row for row in below if len(row.cells) < count]
            below = [_as_long(row, count) for row in below if len(row.cells) >= count]
        names = [plain(cell) for cell in header.cells]
        again = [row.number for row in below if [plain(cell) for cell in row.cells] == names]
        if entry.below and again:
            below = [row for row in below if row.number < again[0]]
        places = {key: names.index(plain(str(column))) for key, column in wanted.items()}
        left = [
            f"column {shown(cell)}: not in the map"
            for i, cell in enumerate(header.cells)
            if cell and i not in places.values()
        ]
        left += [f"row {row.number}: it has fewer cells than the header" for row in short]
        if top and not entry.below:
            left.append(f"{_lines(rows[:top])}: above the header")
        headings = {key: header.cells[place] for key, place in places.items()}
        return TableIn(below, places, headings, left, frozenset(again))
    raise faults[0]


def _header(
    file: SourceFile, rows: Sequence[Row], wanted: Mapping[str, int | str], table: str
) -> int:
    """The index of the first row that has each wanted name once."""
    names = {key: plain(str(column)) for key, column in wanted.items()}
    nearest, most = 0, -1
    for i, row in enumerate(rows):
        counts = Counter(map(plain, row.cells))
        count = sum(counts[name] > 0 for name in names.values())
        if all(counts[name] == 1 for name in names.values()):
            return i
        if count > most:
            nearest, most = i, count
    header = rows[nearest].cells if rows else ()
    counts = Counter(map(plain, header))
    key = next((key for key, name in names.items() if counts[name] != 1), next(iter(names)))
    has = ", ".join(shown(cell) for cell in header[:12] if cell)
    what = "has it twice" if counts[names[key]] > 1 else "has no such column"
    fix = f"the header {what}; it has {has}; correct [{table}.columns] in the map"
    if len(header) == 1 and " " in header[0]:
        fix += ', or, if blanks separate its columns, write separator = " "'
    raise file.refuse(fix, key, shown(wanted[key]))


def _below(file: SourceFile, rows: list[Row], line: str | None, table: str) -> list[Row]:
    """The rows below the first one that has a text, such as the title of an event."""
    if line is None:
        return rows
    sought = _words(line)
    for i, row in enumerate(rows):
        if sought in _words(" ".join(row.cells)):
            return rows[i + 1 :]
    fix = f"no line has this text; correct {table}.below in the map"
    raise file.refuse(fix, "below", shown(line))


def _only(file: SourceFile, found: TableIn, entry: TableEntry, table: str) -> TableIn:
    """A table without the rows whose cells are not those that the map asks for."""
    rows, places, left = found.rows, dict(found.places), list(found.left)
    for column, cell in entry.only.items():
        place = places.pop(f"only.{column}")
        kept = [row for row in rows if plain(row.cell(place)) == plain(cell)]
        if not kept:
            has = ", ".join(list({shown(row.cell(place)): None for row in rows})[:8]) or "no rows"
            fix = f"no row has {shown(cell)} in it; it has {has}; correct {table}.only in the map"
            raise file.refuse(fix, f"column {shown(column)}")
        if len(kept) < len(rows):
            many = f"{len(rows) - len(kept)} rows" if len(rows) - len(kept) > 1 else "1 row"
            left.append(f"{many}: {shown(str(column))} is not {shown(cell)}")
        rows = kept
    return replace(found, rows=rows, places=places, left=left)


def _lines(rows: Sequence[Row]) -> str:
    first, last = rows[0].number, rows[-1].number
    return f"row {first}" if first == last else f"rows {first} to {last}"


def _as_long(row: Row, count: int) -> Row:
    """A row that blanks separate, its last cell with the words that its header's has."""
    if len(row.cells) <= count:
        return row
    return Row(row.number, (*row.cells[: count - 1], " ".join(row.cells[count - 1 :])))


def _separators(text: str, entry: TableEntry) -> list[str]:
    """Separators to try, those of most lines first."""
    if entry.separator:
        return [entry.separator]
    lines = [line for line in text.splitlines() if line.strip()][:ROWS]
    counts = {each: sum(each in line for line in lines) for each in _SEPARATORS}
    there = [each for each in _SEPARATORS if counts[each]]
    return sorted(there, key=lambda each: -counts[each]) or [","]


def _rows(file: SourceFile, text: str, separator: str) -> list[Row]:
    """All rows that are not empty."""
    rows = []
    for number, cells in _split(file, text, separator):
        stripped = tuple(cell.strip() for cell in cells)
        if len(cells) > _COLUMNS or any(len(cell) > _CELL for cell in stripped):
            fix = f"more than {_COLUMNS} columns, or {_CELL} characters in a cell; is it a table?"
            raise file.refuse(fix, f"row {number}")
        if any(stripped):
            rows.append(Row(number, stripped))
        if len(rows) > ROWS:
            raise file.refuse(f"more than {ROWS} rows; export only what belongs to the scene")
    return rows


def _split(file: SourceFile, text: str, separator: str) -> Iterator[tuple[int, list[str]]]:
    if separator in BLANKS:
        pattern = re.compile(r"\s+" if separator == " " else r"\s{2,}")
        for number, line in enumerate(text.splitlines(), 1):
            yield number, pattern.split(line.strip())
        return
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    try:
        for cells in reader:
            if separator == "|" and cells and not cells[0].strip():  # lines begin with it
                cells = cells[1:]
            yield reader.line_num, cells
    except csv.Error as error:
        raise file.refuse(f"not CSV ({error}); export it anew", f"row {reader.line_num}") from None


def _text(file: SourceFile, encoding: str | None, table: str) -> tuple[str, list[str]]:
    """The text of a file, and a line on its character set where it was found by its bytes."""
    marked = next((name for bom, name in _BOMS.items() if file.content.startswith(bom)), "")
    left = []
    try:
        text = file.content.decode(marked or encoding or "utf-8-sig")
    except UnicodeDecodeError as error:
        line = file.content.count(b"\n", 0, error.start) + 1
        if marked or encoding:
            fix = f"is not {encoding or marked} text; correct {table}.encoding in the map"
            raise file.refuse(fix, f"line {line}") from None
        text, found = _by_its_bytes(file, line, table)
        left.append(
            f'character set: not UTF-8, read as {found}; where names look wrong, write encoding = "…"'
        )
    if "\0" in text:
        raise file.refuse("is binary, not text; save the table as CSV UTF-8")
    return text, left


def _by_its_bytes(file: SourceFile, line: int, table: str) -> tuple[str, str]:
    """A text that is not UTF-8, and its character set."""
    ways = f'save the table as CSV UTF-8, or write [{table}] encoding = "cp1252" in the map'
    try:
        from charset_normalizer import from_bytes
    except ImportError:
        fix = f"is not UTF-8 text, and charset-normalizer is not installed; {ways}"
        raise file.refuse(fix, f"line {line}") from None
    for names in _TRIED:
        if (found := from_bytes(file.content, cp_isolation=names).best()) is None:
            continue
        try:
            text = file.content.decode(found.encoding)
        except UnicodeDecodeError:  # of a large file it reads parts
            continue
        if not _NO_TEXT.search(text):
            return text, found.encoding
    raise file.refuse(f"is not UTF-8 text; {ways}", f"line {line}")


def plain(name: str) -> str:
    """A name or cell without capitals and further blanks, for comparison."""
    return " ".join(name.split()).casefold()


def _words(line: str) -> str:
    """A line without the separators of its cells."""
    return plain(re.sub(r"[;,|\t]", " ", line))
