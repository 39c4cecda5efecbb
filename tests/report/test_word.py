"""A Word document has Word's own headings, captions and repeated table headings."""

import io

import docx
import pytest
from docx.oxml.ns import qn

from retrodict.report.word import render
from tests.report.documents import document_of


@pytest.fixture(scope="module")
def word(outcome):
    return docx.Document(io.BytesIO(render(document_of(outcome))))


def test_its_outline_is_made_of_headings(word):
    headings = {p.style.name: p.text for p in reversed(word.paragraphs) if p.text}
    assert headings["Heading 1"] == "1  Results"
    assert headings["Heading 2"] == "The question"
    assert headings["Title"] == "Two cars on a made-up road"
    assert headings["Caption"].startswith("Figure 1. The scene.")


def test_pictures_have_a_text_and_tables_repeat_their_headings(word):
    (picture,) = word.inline_shapes
    assert picture._inline.docPr.get("descr") == "The scene"
    headed = [t for t in word.tables if t.rows[0].cells[0].text in ("Quantity", "Item")]
    assert headed
    assert all(t.rows[0]._tr.trPr.find(qn("w:tblHeader")) is not None for t in headed)
