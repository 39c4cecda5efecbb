"""Documents of made-up reconstructions, and readers of what a format made of them."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from html.parser import HTMLParser

from retrodict import findings
from retrodict.inference.outcome import Checks
from retrodict.report.blocks import Section, Table
from retrodict.report.content import content
from retrodict.report.figures.drawing import to_png
from retrodict.report.figures.registry import Registered
from tests.report.conftest import found_of

EVIL = '<script>alert(1)</script> {{7*7}} #read("/etc/passwd") \x1b[2J $x$ *b*'
EVIL_PRINTED = EVIL.replace("\x1b", "\\x1b")


def evil_outcome(outcome, text):
    """The outcome of a scene of which every text is the given one."""
    scene = outcome.scene
    vehicle = replace(
        scene.vehicles["b"], name=text, mass=replace(scene.vehicles["b"].mass, source=text)
    )
    scene = replace(
        scene,
        title=text,
        name=text,
        text=text,
        notes=(text,),
        vehicles={**scene.vehicles, "b": vehicle},
    )
    checks = Checks(1, 1.1, 5.0, 5.0, False, (text,), ("e",), (text,))
    return replace(outcome, scene=scene, checks=checks, notes=(text,))


def small_png():
    from matplotlib.figure import Figure

    figure = Figure(figsize=(1, 1))
    figure.add_subplot()
    return to_png(figure)


def document_of(outcome, units="si", case=None, ladder=None, **changes):
    """A document with one small figure in it."""
    figures = {
        "scene": Registered(None, "The scene", "Drawn to scale. With a legend.", "first page")
    }
    found = findings.compute(outcome, ladder) if ladder else found_of(outcome)
    found = replace(found, **changes)
    return content(found, {"scene": small_png()}, figures, units, case)


def blocks(document):
    """All blocks of a document, in order."""

    def walk(items):
        for block in items:
            yield block
            if isinstance(block, Section):
                yield from walk(block.blocks)

    yield from walk((*document.first, *document.sections))


def tables(document):
    """All tables of a document, as rows of cells, with their headings."""
    return [
        [*([b.header] if b.header else []), *b.rows]
        for b in blocks(document)
        if isinstance(b, Table)
    ]


def section(document, title):
    """The section of that title."""
    return next(b for b in blocks(document) if isinstance(b, Section) and b.title == title)


def text_of(block):
    """All texts of a block or document, with spaces between them."""
    if isinstance(block, str):
        return block
    if isinstance(block, tuple):
        return " ".join(filter(None, map(text_of, block)))
    if hasattr(block, "__dataclass_fields__"):
        return text_of(tuple(getattr(block, name) for name in block.__dataclass_fields__))
    return ""


def flat(page):
    """A page's text without figures, tags and line breaks."""
    page = re.sub(r"data:image/png;base64,[^\"]+", "", page)
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))


class Page(HTMLParser):
    """What a page holds: its tags, what they load, its tables, its text."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.loads, self.tables, self.texts = [], [], [], []
        self._cell = None
        self.feed(page.decode())

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.loads += [value for name, value in attrs if name in ("src", "href")]
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append(())
        elif tag in ("td", "th"):
            self._cell = ""

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self.tables[-1][-1] += (self._cell,)
            self._cell = None

    def handle_data(self, data):
        self.texts.append(data)
        if self._cell is not None:
            self._cell += data


def pdf_text(made):
    """A PDF's text, with one space between words."""
    from pypdf import PdfReader

    pages = [page.extract_text() for page in PdfReader(io.BytesIO(made)).pages]
    return re.sub(r"\s+", " ", " ".join(pages).replace("\u200b", ""))
