"""The replay: the draws' own motion, in a fragment in which no text of a scene can run."""

import base64
import hashlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
import xarray as xr

from retrodict.findings.run_outs import motions
from retrodict.report.replay_html import replay_fragment, replay_script_hash
from tests.report.conftest import found_of


class Page(HTMLParser):
    """The start tags of a page, and what its scripts hold."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.scripts, self._within = [], [], False
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._within = tag == "script"

    def handle_endtag(self, tag):
        self._within = False

    def handle_data(self, data):
        if self._within:
            self.scripts.append(data)


def fragment(outcome, units="si"):
    return replay_fragment(found_of(outcome), outcome, units)


def test_the_script_moves_the_vehicles_as_the_draws_do(outcome):
    page = Page(fragment(outcome))
    data = json.loads(page.scripts[0])
    found = motions(outcome, len(data["draws"]))
    for drawn, motion in zip(data["draws"], found, strict=True):
        assert drawn["lasts"] == pytest.approx(motion.lasts, abs=1e-3)
        for v in "ab":
            time, x, y, heading = (np.array(each) for each in drawn["rows"][v])
            # one unit for the drawing's length: lengths and angles are those of the draw
            length = np.hypot(np.diff(x), np.diff(y)) / data["scale"]
            whole = np.hypot(*np.diff(motion.pose[v][[0, -1], :2], axis=0)[0])
            assert np.hypot(x[-1] - x[1], y[-1] - y[1]) / data["scale"] == pytest.approx(
                whole, abs=0.02
            )
            assert length[0] / (time[1] - time[0]) == pytest.approx(motion.speed[v], rel=0.01)
            turned = np.degrees(motion.pose[v][-1, 2] - motion.pose[v][0, 2])
            assert heading[-1] - heading[1] == pytest.approx(-turned, abs=0.11)  # y points down
            assert (np.diff(time) > 0).all()


def test_speeds_are_printed_in_the_units_asked_for(outcome):
    us, si = fragment(outcome, "us"), fragment(outcome, "si")
    assert "mph" in us
    assert "m/s" not in us
    assert "mph" not in si
    scales = [json.loads(Page(each).scripts[0])["scale"] for each in (si, us)]
    assert scales[1] / scales[0] == pytest.approx(0.44704)


def test_no_text_of_the_scene_ends_an_element(outcome):
    evil = "</script><script>alert(1)</script>{{7*7}}\"'><img src=x onerror=alert(1)>"
    vehicles = {v: replace(each, name=evil) for v, each in outcome.scene.vehicles.items()}
    surfaces = tuple(replace(each, name=evil) for each in outcome.scene.surfaces)
    plain = Page(fragment(outcome))
    found = found_of(outcome)
    scene = replace(outcome.scene, vehicles=vehicles, surfaces=surfaces)
    page = Page(replay_fragment(replace(found, scene=scene), outcome))
    assert [tag for tag, _ in page.tags] == [tag for tag, _ in plain.tags]
    assert not [name for _, attrs in page.tags for name in attrs if name.startswith("on")]


def test_the_fragment_loads_nothing_and_its_script_is_the_one_that_a_page_allows(outcome):
    text = fragment(outcome)
    page = Page(text)
    assert not [a for _, a in page.tags if {"src", "href", "xlink:href"} & set(a)]
    assert not re.search(r"url\(|@import|https?:|fetch\(|XMLHttp|import\(", text)
    digest = hashlib.sha256(page.scripts[1].encode()).digest()
    assert replay_script_hash() == f"'sha256-{base64.b64encode(digest).decode()}'"


def test_every_control_has_a_name(outcome):
    page = Page(fragment(outcome))
    assert [tag for tag, _ in page.tags if tag in ("button", "input", "select")] == [
        "button",
        "input",
        "select",
    ]
    assert len([tag for tag, _ in page.tags if tag == "label"]) == 2
    (picture,) = [attrs for tag, attrs in page.tags if tag == "svg"]
    assert picture["aria-label"]


def test_a_failed_run_says_so_in_its_replay(outcome, failing):
    assert "NOT TO BE RELIED ON" in fragment(failing)
    assert "NOT TO BE RELIED ON" not in fragment(outcome)


def test_without_recorded_motions_there_is_no_replay(outcome, sparse):
    assert fragment(replace(outcome, idata=xr.DataTree())) == ""
    assert "<svg" in fragment(sparse)  # A's rest and B's heading at rest were not measured
