"""A document that Word can edit: its headings, tables and captions have Word's own styles."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

from retrodict.report.blocks import (
    Block,
    Code,
    Form,
    Listing,
    Paragraph,
    Picture,
    Section,
    Table,
)
from retrodict.report.libraries import imported

if TYPE_CHECKING:
    from retrodict.report.blocks import Document

_WIDTH, _HEIGHT = 17.0, 17.0  # cm, of a picture
_PAPER = {"si": (21.0, 29.7), "us": (21.59, 27.94)}  # cm: A4, letter
_STYLES = {"answer": "Intense Quote", "held": "Intense Quote", "note": "Quote"}


def render(document: Document) -> bytes:
    """The Word file of a document.

    Args:
        document: document to render; its texts are written as plain runs.

    Returns:
        The .docx file.

    Raises:
        MissingLibrary: python-docx is not installed.
    """
    docx = imported("docx", "a Word document")
    made = docx.Document()
    section = made.sections[0]
    sides = _PAPER[document.units]
    section.page_width, section.page_height = map(docx.shared.Cm, sides)
    section.left_margin = section.right_margin = docx.shared.Cm(2.0)
    section.top_margin = section.bottom_margin = docx.shared.Cm(2.0)
    _restyle(made.styles)
    # the properties in the library's template belong to another document
    properties = made.core_properties
    properties.title, properties.author, properties.comments = document.title, document.author, ""
    made.add_heading(document.title, 0)
    made.add_paragraph(document.subtitle)
    for block in document.first:
        _add(made, block, 2)
    for block in document.sections:
        _add(made, block, 1)
    file = io.BytesIO()
    made.save(file)
    return file.getvalue()


def _restyle(styles: Any) -> None:
    """Make the styles plainer than the library's template, with black text."""
    from docx.shared import Cm, Pt, RGBColor

    for name, points, bold in (
        ("Normal", 10, False),
        ("Title", 16, True),
        ("Heading 1", 14, True),
        ("Heading 2", 12, True),
        ("Heading 3", 10, True),
        ("Caption", 9, False),
        ("Intense Quote", 11, False),
    ):
        font = styles[name].font
        font.size, font.bold, font.italic = Pt(points), bold, False
        font.color.rgb = RGBColor(0, 0, 0)
    styles["Normal"].paragraph_format.space_after = Pt(4)
    quote = styles["Intense Quote"].paragraph_format
    quote.left_indent = quote.right_indent = Cm(0.3)


def _add(made: Any, block: Block, level: int) -> None:
    match block:
        case Section():
            made.add_heading(f"{block.number}  {block.title}".strip(), level)
            for each in block.blocks:
                _add(made, each, level + 1)
        case Paragraph():
            paragraph = made.add_paragraph(style=_STYLES.get(block.kind))
            _run(paragraph, block.text, 9 if block.kind == "quiet" else None)
        case Listing():
            for item in block.items:
                made.add_paragraph(item, style="List Bullet")
        case Table():
            _add_table(made, block)
        case Picture():
            _add_picture(made, block)
        case Code():
            _run(made.add_paragraph(), block.text, 7).font.name = "Consolas"
        case Form():
            for field in block.fields:
                made.add_paragraph(f"\n{field}: {'_' * 40}")


def _run(paragraph: Any, text: str, points: int | None) -> Any:
    from docx.shared import Pt

    run = paragraph.add_run(text)
    run.font.size = points and Pt(points)
    return run


def _add_table(made: Any, block: Table) -> None:
    from docx.enum.text import WD_ALIGN_PARAGRAPH
    from docx.oxml import OxmlElement
    from docx.shared import Cm

    if block.title:
        _run(made.add_paragraph(), block.title, None).bold = True
    rows = ([block.header] if block.header else []) + list(block.rows)
    table = made.add_table(len(rows), len(rows[0]), style="Table Grid")
    table.autofit = False
    for share, column in zip(block.shares, table.columns, strict=True):
        column.width = Cm(_WIDTH * share)
    for number, (cells, row) in enumerate(zip(rows, table.rows, strict=True)):
        for column, (text, cell) in enumerate(zip(cells, row.cells, strict=True)):
            (paragraph,) = cell.paragraphs
            cell.width = Cm(_WIDTH * block.shares[column])
            _run(paragraph, text, 8).bold = number == 0 and bool(block.header)
            if column and column not in block.texts and block.header:
                paragraph.alignment = WD_ALIGN_PARAGRAPH.RIGHT
        if number == 0 and block.header:  # repeated on each page
            row._tr.get_or_add_trPr().append(OxmlElement("w:tblHeader"))
    made.add_paragraph()


def _add_picture(made: Any, block: Picture) -> None:
    from docx.shared import Cm

    paragraph = made.add_paragraph()
    picture = paragraph.add_run().add_picture(io.BytesIO(block.image), width=Cm(_WIDTH))
    most = Cm(_HEIGHT)
    if picture.height > most:
        picture.width, picture.height = round(picture.width * most / picture.height), most
    shown = picture._inline.docPr
    shown.set("descr", block.title)
    paragraph.paragraph_format.keep_with_next = True
    caption = made.add_paragraph(style="Caption")
    caption.add_run(f"Figure {block.number}. {block.title}. ")
    caption.add_run(block.caption)
