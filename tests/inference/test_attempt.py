"""What a run does where its draws fall short: more of them, another method, or nothing."""

from dataclasses import replace

import numpy as np
import pytest

from retrodict.inference.attempt import Sampling, may_improve
from retrodict.inference.errors import Interrupted
from retrodict.inference.modes import ModeSearch, PosteriorModes, solutions
from retrodict.inference.outcome import Checks
from retrodict.inference.prior_check import Reference
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers import METHODS, Draws, Method, Task
from retrodict.inference.transforms.choice import Coordinates
from retrodict.options import DEFAULT_RUNG, RunOptions
from tests.shared.scenes import collision

SCENE = collision(share=0.0)
INTERLOCKED = collision(share=0.0, interlocked=True)  # whose programs other tests have compiled


def _failing(name: str) -> Method:
    """A method whose draws are those of Laplace's approximation, and at fault."""

    def draw(task: Task) -> Draws:
        return replace(METHODS["laplace"].draw(task), faults=(f"{name} is stuck",))

    return replace(METHODS[name], draw=draw)


@pytest.mark.slow
def test_a_method_that_fails_hands_over_to_another_and_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(METHODS, "nuts", _failing("nuts"))
    found = reconstruct(SCENE)
    assert found.checks.passed, found.checks.reasons
    assert found.settings["method"] == "importance"
    assert found.checks.pareto_k is not None
    assert "the first sampler, nuts, was not accepted (nuts is stuck)" in found.notes[0]


@pytest.mark.slow
def test_where_every_method_fails_the_first_is_withheld(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("nuts", "importance", "smc"):
        monkeypatch.setitem(METHODS, name, _failing(name))
    found = reconstruct(SCENE)
    assert found.settings["method"] == "nuts"
    assert found.checks.reasons == ("nuts is stuck",)
    assert "smc was tried too, and failed: smc is stuck" in found.notes[0]
    assert "importance was tried too, and failed: importance is stuck" in found.notes[-1]


@pytest.mark.slow
def test_where_both_that_need_a_mode_fail_tempering_stands_in(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("nuts", "importance"):
        monkeypatch.setitem(METHODS, name, _failing(name))
    found = reconstruct(SCENE, pictured=False)
    assert found.settings["method"] == "smc"
    assert found.checks.passed
    assert found.notes[0].startswith(
        "the first sampler, nuts, was not accepted (nuts is stuck) and was replaced"
    )
    usual = reconstruct(SCENE, RunOptions(method="importance"), pictured=False)
    for name in ("speed_b", "e", "e_m", "mu"):
        own, other = (o.idata["posterior"][name].values.ravel() for o in (found, usual))
        assert abs(own.mean() - other.mean()) < 0.12 * other.std(), name
        assert 0.9 < own.std() / other.std() < 1.1, name


@pytest.mark.slow
def test_an_interrupt_while_tempering_stands_in_keeps_what_was_drawn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def stopped(task: Task) -> Draws:
        raise Interrupted("stopped")

    for name in ("nuts", "importance"):
        monkeypatch.setitem(METHODS, name, _failing(name))
    monkeypatch.setitem(METHODS, "smc", replace(METHODS["smc"], draw=stopped))
    found = reconstruct(SCENE, pictured=False)
    assert not found.complete
    assert found.settings["method"] == "nuts"


def test_an_interrupt_before_anything_is_drawn_begins_no_other_method(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where rest poses are at fault deviates come first; Ctrl-C is no reason to turn to NUTS."""

    original = ModeSearch.on

    def unsettled(
        self: ModeSearch, rung: str, where: Coordinates, *, weighted: bool = True
    ) -> PosteriorModes:
        faults = ("a weight is not settled",) if where is Coordinates.PINNED else ()
        return replace(original(self, rung, where, weighted=weighted), faults=faults)

    def stopped(task: Task) -> Draws:
        raise Interrupted("stopped")

    def begun(task: Task) -> Draws:
        pytest.fail("another method was begun")

    monkeypatch.setattr(ModeSearch, "on", unsettled)
    monkeypatch.setitem(METHODS, "importance", replace(METHODS["importance"], draw=stopped))
    monkeypatch.setitem(METHODS, "nuts", replace(METHODS["nuts"], draw=begun))
    with pytest.raises(Interrupted):
        reconstruct(INTERLOCKED, RunOptions(), pictured=False)


@pytest.mark.slow
def test_where_the_model_misses_the_evidence_no_other_method_is_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without a moment impulse the vehicles cannot have turned as far as they did."""
    monkeypatch.setitem(METHODS, "nuts", _failing("nuts"))
    found = reconstruct(SCENE, RunOptions(model="planar-common+spin"), pictured=False)
    assert found.checks.reasons == ("nuts is stuck",)
    assert "misses the evidence" in found.notes[0]
    assert "no other method was tried" in found.notes[0]


def test_draws_go_on_once_where_a_digit_of_the_limits_is_not_sure() -> None:
    (solution,) = solutions(INTERLOCKED, DEFAULT_RUNG)
    task = Task(solution.posterior, 4, 700, 0, 0, lambda *_: None)
    sure = Checks(0, 1.0, 4000.0, 4000.0, True)
    unsure = replace(sure, imprecise=("omega_b",))
    again = [
        may_improve(checks, task, times, "nuts") for checks in (sure, unsure) for times in (1, 2)
    ]
    assert again == [False, False, True, False]


@pytest.mark.parametrize(
    ("weight", "reasons"), [(0.05, 1), pytest.param(0.005, 0, marks=pytest.mark.slow)]
)
def test_only_a_solution_that_counts_is_judged_by_itself(
    monkeypatch: pytest.MonkeyPatch, weight: float, reasons: int
) -> None:
    (solution,) = solutions(INTERLOCKED, DEFAULT_RUNG)
    found = [replace(solution, mode=replace(solution.mode, weight=w)) for w in (1 - weight, weight)]
    faults = iter([(), ("the second is stuck",)])

    def draw(task: Task) -> Draws:
        return replace(METHODS["laplace"].draw(task), faults=next(faults))

    monkeypatch.setitem(METHODS, "nuts", replace(METHODS["nuts"], draw=draw))
    nothing = Reference({}, np.zeros(1), {})
    sampling = Sampling(PosteriorModes(found, ()), nothing, False, lambda *_: None)
    run = sampling.by("nuts", RunOptions(draws=500))
    assert run.checks.reasons == ("the second is stuck",) * reasons
