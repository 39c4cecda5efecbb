"""The page stands alone: no script, no request."""

from itertools import pairwise

from retrodict.report.html import render
from tests.report.documents import Page, document_of


def test_the_page_stands_alone(outcome):
    made = render(document_of(outcome))
    page = Page(made)
    assert not {"script", "link", "iframe"} & set(page.tags)
    assert page.tags.count("img") == 1
    assert all(load.startswith("data:image/png;base64,") for load in page.loads)
    assert b"url(" not in made
    assert b"@import" not in made
    assert b"default-src 'none'" in made


def test_headings_do_not_skip_a_level(outcome):
    levels = [
        int(tag[1])
        for tag in Page(render(document_of(outcome))).tags
        if tag[0] == "h" and tag[1:].isdigit()
    ]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(b - a <= 1 for a, b in pairwise(levels))
