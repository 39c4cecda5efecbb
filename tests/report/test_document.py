"""Every format holds the same numbers, shows a stranger's text as text, and is written whole."""

import io
import json
import sys

import docx
import pytest

from retrodict.report import document
from retrodict.report.blocks import Table
from retrodict.report.document import FORMATS, UnknownFormat, renderers, write_report
from retrodict.report.figures import registry as figures
from retrodict.report.libraries import MissingLibrary
from retrodict.storage import files
from tests.report.conftest import found_of
from tests.report.documents import (
    EVIL,
    EVIL_PRINTED,
    Page,
    blocks,
    document_of,
    evil_outcome,
    pdf_text,
    tables,
)


@pytest.fixture(scope="module")
def made(rolled):
    document = document_of(rolled)
    return document, {name: render(document) for name, render in FORMATS.items()}


def test_html_and_word_have_the_cells_of_the_content(made):
    document, files = made
    assert Page(files["html"]).tables == tables(document)
    word = docx.Document(io.BytesIO(files["docx"]))
    read = [[tuple(cell.text for cell in row.cells) for row in table.rows] for table in word.tables]
    assert read == tables(document)


def test_pdf_has_the_cells_of_the_content_in_their_order(made):
    document, files = made
    text, place, count = pdf_text(files["pdf"]), 0, 0
    for table in (b for b in blocks(document) if isinstance(b, Table)):
        for row in table.rows:
            for cell in filter(None, row):
                found = text.find(" ".join(cell.split()), place)
                assert found >= 0, (cell, text[place : place + 200])
                place, count = found + len(cell) // 2, count + 1
    assert count > 300


def test_the_words_of_headings_are_no_wider_than_their_columns(made):
    """Else they would run into one another: 170 mm of a page, bold letters of 1.3 mm on average."""
    for table in (b for b in blocks(made[0]) if isinstance(b, Table)):
        for cell, share in zip(table.header, table.shares, strict=False):
            widest = max(map(len, cell.split()), default=0)
            assert 1.3 * widest + 2.8 <= 170 * share, (cell, table.header)


@pytest.mark.parametrize("suffix", ["html", "pdf", "docx"])
def test_a_strangers_text_shows_as_text(outcome, suffix):
    made = FORMATS[suffix](document_of(evil_outcome(outcome, EVIL)))
    if suffix == "html":
        page = Page(made)
        assert "script" not in page.tags
        text = " ".join(page.texts)
    elif suffix == "pdf":
        text = pdf_text(made)
    else:
        word = docx.Document(io.BytesIO(made))
        text = "\n".join(p.text for p in word.paragraphs)
        assert word.core_properties.title == EVIL_PRINTED
    assert text.count(EVIL_PRINTED) >= 4  # title, vehicle, remark, reason, flag, note
    assert "root:" not in text
    assert "\x1b" not in text


def test_a_new_format_is_one_function_and_one_line(outcome, tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "FIGURES", {})
    monkeypatch.setitem(FORMATS, "toy", lambda document: json.dumps(document.title).encode())
    path = write_report(found_of(outcome), outcome, tmp_path / "deep" / "report.toy")
    assert json.loads(path.read_bytes()) == outcome.scene.title
    assert [p.name for p in path.parent.iterdir()] == ["report.toy"]


def test_an_unknown_format_and_a_missing_library_are_reported_in_a_line(
    outcome, tmp_path, monkeypatch
):
    with pytest.raises(UnknownFormat, match=r"'odt': choose of html, pdf, docx"):
        write_report(found_of(outcome), outcome, tmp_path / "report.odt")
    assert list(renderers([" PDF", "html"])) == ["pdf", "html"]
    monkeypatch.setitem(sys.modules, "typst", None)
    with pytest.raises(MissingLibrary, match=r"pip install .*'python-docx"):
        FORMATS["pdf"](document_of(outcome))
    assert list(tmp_path.iterdir()) == []


def test_a_failing_write_leaves_the_old_report(outcome, tmp_path, monkeypatch):
    path = tmp_path / "report.html"
    path.write_text("old")
    monkeypatch.setattr(figures, "FIGURES", {})
    monkeypatch.setitem(document.FORMATS, "html", lambda _: b"new")

    def refuse(*_):
        raise OSError("disk full")

    monkeypatch.setattr(files.os, "replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        write_report(found_of(outcome), outcome, path)
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("report.html", "old")]
