"""A document that Word can edit: its headings, tables and captions have Word's own styles."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

from retrodict.report.content import (
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
    from retrodict.report.content import Document

_WIDTH, _HEIGHT, _SMALL = 17.0, 18.0, 9.0  # cm, of a picture
_STYLES = {"answer": "Intense Quote", "held": "Intense Quote", "note": "Quote"}


def render(document: Document) -> bytes:
    """The Word document.

    Args:
        document: what it says; its texts are plain runs.

    Returns:
        The .docx file.

    Raises:
        MissingLibrary: python-docx is not installed.
    """
    docx = imported("docx", "a Word document")
    made = docx.Document()
    section = made.sections[0]
    section.page_width, section.page_height = docx.shared.Cm(21.0), docx.shared.Cm(29.7)
    section.left_margin = section.right_margin = docx.shared.Cm(2.0)
    section.top_margin = section.bottom_margin = docx.shared.Cm(2.0)
    made.styles["Normal"].font.size = docx.shared.Pt(10)
    # those that the library's template has are of another document
    properties = made.core_properties
    properties.title, properties.author, properties.comments = document.title, document.author, ""
    made.add_heading(document.title, 0)
    made.add_paragraph(document.subtitle)
    for block in document.first:
        _add(made, block, 2)
    made.add_page_break()
    for block in document.sections:
        _add(made, block, 1)
    file = io.BytesIO()
    made.save(file)
    return file.getvalue()


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
    from docx.oxml.ns import qn

    if block.title:
        _run(made.add_paragraph(), block.title, None).bold = True
    rows = ([block.header] if block.header else []) + list(block.rows)
    table = made.add_table(len(rows), len(rows[0]), style="Light List")
    # Word would print the first row of a table of names and values like a header
    (look,) = table._tbl.tblPr.findall(qn("w:tblLook"))
    look.set(qn("w:firstRow"), "1" if block.header else "0")
    for number, (cells, row) in enumerate(zip(rows, table.rows, strict=True)):
        for column, (text, cell) in enumerate(zip(cells, row.cells, strict=True)):
            (paragraph,) = cell.paragraphs
            _run(paragraph, text, 8)
            if column and column not in block.texts and block.header:
                paragraph.alignment = WD_ALIGN_PARAGRAPH.RIGHT
        if number == 0 and block.header:  # repeated on each page
            row._tr.get_or_add_trPr().append(OxmlElement("w:tblHeader"))
    made.add_paragraph()


def _add_picture(made: Any, block: Picture) -> None:
    from docx.shared import Cm

    paragraph = made.add_paragraph()
    picture = paragraph.add_run().add_picture(io.BytesIO(block.image), width=Cm(_WIDTH))
    most = Cm(_SMALL if block.small else _HEIGHT)
    if picture.height > most:
        picture.width, picture.height = round(picture.width * most / picture.height), most
    shown = picture._inline.docPr
    shown.set("descr", block.title)
    paragraph.paragraph_format.keep_with_next = True
    caption = made.add_paragraph(style="Caption")
    caption.add_run(f"Figure {block.number}. {block.title}. ")
    caption.add_run(block.caption)
