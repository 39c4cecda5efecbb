"""Figures that another process draws are those that this one would."""

import subprocess
import sys

import pytest

from retrodict import findings
from retrodict.report.figures.drawing_process import DrawingProcess
from retrodict.report.figures.registry import FIGURES, images


@pytest.mark.slow
def test_the_other_process_draws_the_same_images(outcome, monkeypatch):
    expected = images(findings.compute(outcome), outcome, "us")
    drawn = DrawingProcess().begin(findings.compute(outcome), outcome, "us")
    here = []
    monkeypatch.setattr(
        "retrodict.report.figures.registry.images",
        lambda *arguments: here.append(arguments) or images(*arguments),
    )
    assert drawn() == expected
    assert list(expected) == list(FIGURES)
    assert len(here) == 1  # the last figure; the others came from there


@pytest.mark.slow
def test_a_process_that_is_gone_is_done_without(outcome):
    drawing = DrawingProcess()
    drawing._process.kill()
    drawing._process.wait()
    assert list(drawing.begin(findings.compute(outcome), outcome, "si")()) == list(FIGURES)


def test_the_process_ends_with_the_one_that_wants_the_figures():
    drawing = DrawingProcess()
    drawing._process.stdin.close()  # as the system does when a process ends
    assert drawing._process.wait(timeout=60) != 0


def test_drawing_does_not_wait_for_jax():
    code = (
        "import sys, retrodict.inference.outcome, retrodict.report.figures.registry;"
        "sys.exit('jaxlib' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
