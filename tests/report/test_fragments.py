"""Fragments for notebooks show results and sources, and escape every text."""

from retrodict.report.fragments import findings_html, scene_html
from tests.report.conftest import found_of
from tests.report.documents import EVIL, evil_outcome, flat


def test_fragments_show_results_and_sources(outcome, failing):
    assert "19.2 ± 0.9" in findings_html(found_of(outcome))
    assert "42.9 ± 2.0" in findings_html(found_of(outcome), "us")
    assert "NOT TO BE RELIED ON" in findings_html(found_of(failing))
    assert "20.10 ± 0.50" in scene_html(outcome.scene)
    assert "event data recorder" in scene_html(outcome.scene)


def test_a_run_out_s_own_error_stands_beside_the_measurement(rolled, sparse):
    missed = rolled.scene.evidence()["rest_x_b"].model_sd
    assert f"6.60 ± 0.30 (a run-out misses ± {missed:.2f})" in flat(scene_html(rolled.scene))
    assert "mark 2 of B" in scene_html(sparse.scene)


def test_texts_of_the_scene_are_escaped_everywhere(outcome):
    evil = evil_outcome(outcome, EVIL)
    for page in (findings_html(found_of(evil)), scene_html(evil.scene)):
        assert "<script" not in page
        assert "&lt;script&gt;" in page
