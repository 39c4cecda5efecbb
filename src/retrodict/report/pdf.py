"""A document as PDF/A-2a and PDF/UA-1, by Typst; the same to the byte for the same document."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass, replace
from datetime import UTC, date, datetime
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from retrodict.report.blocks import Table
from retrodict.report.libraries import imported

if TYPE_CHECKING:
    from retrodict.report.blocks import Document

STANDARDS = ["a-2a", "ua-1"]
_UNDATED = date(1970, 1, 1)  # PDF/A demands a date


class NoGlyph(ValueError):
    """A text has characters that no font at hand can print."""


def render(document: Document) -> bytes:
    """The PDF file of a document.

    Args:
        document: document to render; its texts go in as data, which Typst does not read as markup. Its
            date stands in the file's properties if it is written as 2026-03-14.

    Returns:
        The file.

    Raises:
        MissingLibrary: typst is not installed.
        NoGlyph: no font at hand can print a text.
    """
    typst = imported("typst", "a PDF")
    with TemporaryDirectory(prefix="retrodict-") as name:
        folder = Path(name)
        images: list[bytes] = []
        plain = json.dumps(_plain(replace(document, replay=""), images), ensure_ascii=False)
        (folder / "document.json").write_text(plain, encoding="utf-8")
        for number, image in enumerate(images):
            (folder / f"{number}.png").write_bytes(image)
        source = folder / "main.typ"
        source.write_bytes(resources.files(__package__).joinpath("document.typ").read_bytes())
        for embedded_only in (True, False):  # fonts of this machine only where they are needed
            try:
                made: bytes = typst.compile(
                    source,
                    root=folder,
                    ignore_system_fonts=embedded_only,
                    pdf_standards=STANDARDS,
                    timestamp=int(_date(document).timestamp()),
                )
                return made
            except typst.TypstError as error:
                refusal = str(error)
                if "could not be displayed" not in refusal:
                    raise
    raise NoGlyph(f"{refusal.splitlines()[0]}: install a font that has it, or write HTML")


def _date(document: Document) -> datetime:
    try:
        stated = date.fromisoformat(document.date)
    except ValueError:
        stated = _UNDATED
    return datetime(stated.year, stated.month, stated.day, tzinfo=UTC)


def _plain(value: Any, images: list[bytes]) -> Any:
    """A tree for JSON; each image is appended to `images` and replaced by its index there."""
    if isinstance(value, bytes):
        images.append(value)
        return len(images) - 1
    if isinstance(value, tuple):
        return [_plain(each, images) for each in value]
    if is_dataclass(value):
        own = {each.name: _plain(getattr(value, each.name), images) for each in fields(value)}
        if isinstance(value, Table):
            own["shares"] = value.shares
        return own | {"block": type(value).__name__}
    return value
