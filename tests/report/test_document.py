import hashlib
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from retrodict import findings
from retrodict.inference.outcome import Checks
from retrodict.report import document, figures, files
from retrodict.report.document import findings_html, report_html, scene_html, write_report
from retrodict.scene.records import Measured

EVIL = '<script>alert("x")</script>'


class Tags(HTMLParser):
    """Collects tags and the addresses they load."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.loads = [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.loads += [value for name, value in attrs if name in ("src", "href")]


def html(outcome, units="si"):
    return report_html(findings.compute(outcome), outcome, units)


@pytest.fixture(scope="module")
def good(outcome):
    return html(outcome, "si")


@pytest.fixture(scope="module")
def bad(failing):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "FIGURES", {})
        return html(failing, "us")


@pytest.fixture
def no_figures(monkeypatch):
    """Figures are slow, and are tested by themselves."""
    monkeypatch.setattr(figures, "FIGURES", {})


def flat(page):
    """The page's text without figures, tags and line breaks."""
    page = re.sub(r"data:image/png;base64,[^\"]+", "", page)
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))


def evil_outcome(outcome):
    scene = outcome.scene
    vehicle = replace(scene.vehicles["b"], name=EVIL, mass=Measured(1778.0, 40.0, source=EVIL))
    scene = replace(
        scene,
        title=EVIL,
        name=EVIL,
        text=EVIL,
        notes=(EVIL,),
        vehicles={**scene.vehicles, "b": vehicle},
    )
    checks = Checks(1, 1.1, 5.0, 5.0, False, (EVIL,), ("e",), (EVIL,))
    return replace(outcome, scene=scene, checks=checks, notes=(EVIL,))


def test_the_page_stands_alone(good):
    page = Tags(good)
    assert "script" not in page.tags
    assert "link" not in page.tags
    assert page.tags.count("img") == 4
    assert all(load.startswith("data:image/png;base64,") for load in page.loads)
    assert "url(" not in good
    assert "@import" not in good


def test_the_answer_comes_first_with_its_interval_and_level(good):
    text = flat(good)
    assert text.index("with 95 % probability between 17.5 and 21.0 m/s") < text.index("Results")


def test_results_stand_in_both_systems(good):
    text = flat(good)
    assert "19.2 ± 0.9" in text
    assert "42.9 ± 2.0" in text


@pytest.mark.parametrize(
    "wanted",
    [
        "half-normal, scale 0.2, cut at 1",  # priors
        "staged car crashes",  # and their reasons
        "secondary impacts, and crush as evidence",  # left out
        "skid test",  # sources
        "uncertainty assumed",
        "The weather was dry.",
        "likelihood ratio",
        "ENFSI",
        "4 × 500",
        "To be completed by the expert",
        "retrodict reconstruct scene.toml --model planar-moment+wheels --chains 4 --draws 500 "
        "--warmup 500 --seed 20",
        "3.12.1",
    ],
)
def test_the_report_holds_what_a_court_asks_for(good, wanted):
    assert wanted in flat(good)


@pytest.mark.usefixtures("no_figures")
def test_a_run_out_s_own_error_has_a_column_and_a_line_where_there_is_one(good, rolled):
    page = html(rolled)
    text, missed = flat(page), rolled.scene.evidence()["rest_x_b"].model_sd
    assert "Model ± sd" in text
    assert f"<td>± {missed:.2f}</td>" in page
    assert "the run-out misses each coordinate of B&#39;s place by 4.0 %" in text
    assert "Model ± sd" not in flat(good)
    assert "run-out misses" not in flat(good)
    assert f"6.60 ± 0.30 (a run-out misses ± {missed:.2f})" in flat(scene_html(rolled.scene))


def test_the_scene_file_is_given_verbatim_with_its_hash(outcome, good):
    text = outcome.scene.text
    assert hashlib.sha256(text.encode()).hexdigest() in good
    # autoescape writes quotes as entities; nothing else is changed
    assert text.replace('"', "&#34;") in good


def test_a_failed_run_withholds_its_answer_and_marks_every_result(bad):
    text = flat(bad)
    assert "NOT TO BE RELIED ON" in text
    assert "its speed before impact is withheld" in text
    assert "R-hat of e_m is 1.050" in text
    assert "with 95 % probability" not in text
    assert "19.2 ± 0.9†" in text
    results = bad[bad.index(">Results<") : bad.index(">What the probability means<")]
    numbers = re.findall(r"<td>([^<]+)</td>", results)
    assert len(numbers) > 50
    assert [n for n in numbers if not n.endswith(("†", "withheld"))] == []


def test_posteriors_of_inputs_are_marked_in_a_failed_run(bad):
    assert "4094 ± 75†" in flat(bad)


def test_a_good_run_has_no_mark(good):
    assert "†" not in flat(good)


@pytest.mark.usefixtures("no_figures")
def test_what_would_narrow_the_answer_is_shown_unless_it_failed(good, bad):
    for page, passed in ((good, True), (bad, False)):
        assert ("What would narrow the answer" in page) is passed


def test_texts_of_the_scene_are_escaped_everywhere(outcome):
    evil = evil_outcome(outcome)
    for page in (html(evil), findings_html(findings.compute(evil)), scene_html(evil.scene)):
        assert "<script" not in page
        assert "&lt;script&gt;" in page
        assert "script" not in Tags(page).tags


@pytest.mark.usefixtures("no_figures")
def test_missing_groups_do_not_break_the_report(outcome, drop):
    bare = outcome
    for group in ("prior", "posterior_predictive", "trajectories", "sample_stats"):
        bare = drop(bare, group)
    assert "17.5 and 21.0 m/s" in flat(html(bare))


def test_fragments_show_results_and_sources(outcome, failing):
    assert "19.2 ± 0.9" in findings_html(findings.compute(outcome))
    assert "42.9 ± 2.0" in findings_html(findings.compute(outcome), "us")
    assert "NOT TO BE RELIED ON" in findings_html(findings.compute(failing))
    assert "20.10 ± 0.50" in scene_html(outcome.scene)
    assert "event data recorder" in scene_html(outcome.scene)


@pytest.mark.usefixtures("no_figures")
def test_evidence_of_every_kind_is_registered(sparse):
    text = flat(html(sparse))
    assert "Asked: how fast each vehicle was travelling" in text
    register = text[text.index("What was measured of the vehicles after") :]
    for wanted in (
        "direction of travel of A after impact deg 140.0 ± 8.0 heavy-tailed",
        "delta-v of A along its heading m/s −13.0 ± 1.0 heavy-tailed",
        "mark 1 of B, distance from its path m 0.00 ± 0.20 heavy-tailed",
        "mark 2 of B, speed there m/s 6.00 ± 0.50 heavy-tailed",
        "mark 2 of B, direction of travel there deg −55.0 ± 6.0 heavy-tailed",
        "end of rotation of B, x m 5.50 ± 0.50 heavy-tailed",
        "end of rotation of B, heading deg −50.0 ± 5.0 heavy-tailed",
        "stops sliding sideways and begins to roll",
        "skid of B up to impact m 12.00 ± 0.50 lognormal",
    ):
        assert wanted in register
    assert "mark 1 of B: x = 2.00 m, y = −1.50 m, front left wheel" in register
    assert "mark 2 of B: x = 4.50 m, y = −5.00 m, centre of gravity" in register
    assert "mark 1 of B: x = 6.56 ft, y = −4.92 ft" in flat(html(sparse, "us"))
    assert "rest of A" not in text
    assert "mark 2 of B" in scene_html(sparse.scene)


def test_a_report_where_the_speed_of_a_is_known_asks_for_that_of_b(good):
    assert "Asked: how fast vehicle B was travelling" in flat(good)
    assert "heavy-tailed" not in good
    assert "mark 1 of" not in good
    assert "begins to roll" not in good


def test_a_report_is_written_whole(outcome, tmp_path, monkeypatch):
    monkeypatch.setattr(document, "report_html", lambda *_: "<p>new ±</p>")
    path = write_report(findings.compute(outcome), outcome, tmp_path / "deep" / "report.html")
    assert path.read_text(encoding="utf-8") == "<p>new ±</p>"
    assert [p.name for p in path.parent.iterdir()] == ["report.html"]


def test_a_failing_write_leaves_the_old_report(outcome, tmp_path, monkeypatch):
    path = tmp_path / "report.html"
    path.write_text("old")
    monkeypatch.setattr(document, "report_html", lambda *_: "new")

    def refuse(*_):
        raise OSError("disk full")

    monkeypatch.setattr(files.os, "replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        write_report(findings.compute(outcome), outcome, path)
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("report.html", "old")]
