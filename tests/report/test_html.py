"""The page stands alone: no request, and no script but the replay's."""

import base64
import hashlib
import re
from dataclasses import replace
from itertools import pairwise

from retrodict.findings import compute
from retrodict.report.html import render
from retrodict.report.replay_html import replay_fragment
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


def test_no_script_but_the_replays_may_run(outcome):
    evil = replace(outcome.scene.vehicles["a"], name="</script><script>alert(1)</script>")
    scene = replace(outcome.scene, vehicles=outcome.scene.vehicles | {"a": evil})
    found = replace(outcome, scene=scene)
    fragment = replay_fragment(compute(found), found)
    assert fragment
    made = render(replace(document_of(found), replay=fragment)).decode()
    assert Page(made.encode()).tags.count("script") == 2  # its data and its code
    (code,) = re.findall(r"<script>(.*?)</script>", made, flags=re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}';" in made
    assert "unsafe-inline" not in made.split("script-src")[1].split(";")[0]
