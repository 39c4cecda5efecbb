"""A PDF is archivable, accessible and the same to the byte for the same document."""

import io
from dataclasses import replace

import pytest
from pypdf import PdfReader

from retrodict.report.pdf import NoGlyph, render
from tests.report.documents import document_of


@pytest.fixture(scope="module")
def document(outcome):
    return document_of(outcome)


def test_twice_the_same_to_the_byte(document):
    assert render(document) == render(document)


def test_it_declares_its_standards_and_is_tagged(document):
    """Typst refuses to write a file that breaks the standards it is asked for."""
    made = PdfReader(io.BytesIO(render(document)))
    root = made.trailer["/Root"]
    metadata = root["/Metadata"].get_data().decode()
    assert "<pdfaid:part>2</pdfaid:part>" in metadata
    assert "<pdfaid:conformance>A</pdfaid:conformance>" in metadata
    assert "<pdfuaid:part>1</pdfuaid:part>" in metadata
    assert root["/MarkInfo"]["/Marked"]
    assert str(root["/Lang"]).startswith("en")
    assert made.metadata.title == document.title


def test_the_date_is_the_stated_one(document):
    stated = PdfReader(io.BytesIO(render(replace(document, date="2026-03-14"))))
    assert stated.metadata.creation_date.date().isoformat() == "2026-03-14"
    for other in ("", "in March"):
        made = PdfReader(io.BytesIO(render(replace(document, date=other))))
        assert made.metadata.creation_date.year == 1970


def test_a_character_without_a_glyph_is_reported(document):
    with pytest.raises(NoGlyph, match="write HTML"):
        render(replace(document, title="\U00012000 (cuneiform)"))
