"""The parts of a document as plain data: every renderer lays out the same texts and numbers."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, Literal

from retrodict.scene.quantities import Units

_NARROWEST, _WIDEST = 10, 48  # characters that a column is taken to have, for its width
_BOLD = 6  # characters added to a word of a heading, which is bold and cannot break


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Text: plain, "quiet" (small print), the "answer", an answer that is "held" back, or a "note"."""

    text: str
    kind: Literal["plain", "quiet", "answer", "held", "note"] = "plain"


@dataclass(frozen=True, slots=True)
class Listing:
    """Items, one line each."""

    items: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Table:
    """A table whose first column names its rows.

    Args:
        rows: rows of cells, one cell per column.
        header: headings of the columns; empty for a table of names and values.
        title: title above the table; empty for none.
        texts: indices from 0 of the columns that hold words, besides 0; all others hold numbers.
    """

    rows: tuple[tuple[str, ...], ...]
    header: tuple[str, ...] = ()
    title: str = ""
    texts: tuple[int, ...] = ()

    @property
    def shares(self) -> tuple[float, ...]:
        """Share of the width for each column, by its longest text within limits; headings may break."""
        longest = [max(map(len, column)) for column in zip(*self.rows, strict=True)]
        headed = [
            max(len(cell) // 2, *(len(word) + _BOLD for word in cell.split()), 0)
            for cell in self.header
        ] or [0] * len(longest)
        widths = [
            min(max(cells, head, _NARROWEST), _WIDEST)
            for cells, head in zip(longest, headed, strict=True)
        ]
        return tuple(width / sum(widths) for width in widths)


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure.

    Args:
        number: number of the figure in the document.
        title: short title; also the alternative text where the figure cannot be seen.
        caption: explanation of what the figure shows and how to read it.
        image: PNG image.
    """

    number: str
    title: str
    caption: str
    image: bytes


@dataclass(frozen=True, slots=True)
class Code:
    """Text that keeps its lines, such as a scene file."""

    text: str


@dataclass(frozen=True, slots=True)
class Form:
    """Lines to be completed by hand."""

    fields: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Section:
    """A heading with what stands below it.

    Args:
        title: text of the heading.
        blocks: content in order; nested sections are the section's parts.
        number: section number such as "3.1"; empty on the first page.
    """

    title: str
    blocks: tuple[Block, ...]
    number: str = ""


Block = Paragraph | Listing | Table | Picture | Code | Form | Section


@dataclass(frozen=True, slots=True)
class Document:
    """A report.

    Args:
        title: title of the scene.
        subtitle: kind of the document, with the names of the vehicles in a report.
        author: the examiner; empty if not stated.
        date: date of the report, as stated; empty if not stated.
        first: blocks of the first page.
        sections: sections after the first page, numbered.
        replay: HTML fragment in which the motion is played, for formats that can; empty for none.
        units: system of units that comes first; the paper is letter with "us", A4 with "si".
    """

    title: str
    subtitle: str
    author: str
    date: str
    first: tuple[Block, ...]
    sections: tuple[Section, ...]
    replay: str = ""
    units: Units = "si"


def numbered(section: Section, number: str) -> Section:
    """A section with its number, and its parts with numbers below it.

    Args:
        section: section to number; numbers that it has are replaced.
        number: number of the section, such as "3".
    """
    parts, blocks = 0, list[Block]()
    for block in section.blocks:
        if isinstance(block, Section):
            parts += 1
            block = numbered(block, f"{number}.{parts}")
        blocks.append(block)
    return replace(section, number=number, blocks=tuple(blocks))


def printable(value: Any) -> Any:
    """A tree with codes in place of characters that do not print.

    Such characters could steer a terminal or a reader's eye, and XML cannot hold them.

    Args:
        value: a document or a part of one.

    Returns:
        The same with other texts.
    """
    if isinstance(value, str):
        return "".join(
            c if c.isprintable() or c in "\n\t\N{NO-BREAK SPACE}" else _code(c) for c in value
        )
    if isinstance(value, tuple):
        return tuple(printable(each) for each in value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{f.name: printable(getattr(value, f.name)) for f in fields(value)})
    return value


def _code(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
