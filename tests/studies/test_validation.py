"""Staged collisions: what counts as covered, what is read when, and what becomes of faulty files."""

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arviz_base import from_dict
from scipy.special import ndtri

from retrodict.inference.errors import Interrupted, Unanswerable
from retrodict.inference.outcome import Outcome
from retrodict.progress import Progress
from retrodict.scene import load_scene
from retrodict.scene.records import Scene
from retrodict.studies.validation import Score, Validation, cases, kind_of, validate
from tests.report.conftest import fail, make_outcome
from tests.shared.scene_file import SCENE
from tests.studies.made_up import summary

TRUTH = 'speed_b = { value = 19.0, unit = "m/s", source = "a light barrier" }\n'


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """A folder with one case, whose speed of A is known and whose speed of B is sought."""
    folder = tmp_path / "crash"
    folder.mkdir()
    (folder / "scene.toml").write_text(SCENE)
    (folder / "truth.toml").write_text(TRUTH)
    return folder


def drawn(mean: float, sd: float, name: str = "speed_b") -> Outcome:
    """An outcome whose draws of a speed are normal quantiles."""
    quantiles = ndtri((np.arange(4000) + 0.5) / 4000)
    speed = mean + sd * np.random.default_rng(3).permuted(quantiles)
    return replace(make_outcome(), idata=from_dict({"posterior": {name: speed.reshape(4, -1)}}))


def scored(case: Path, run) -> Validation:
    return validate((case,), run, model="auto", method="nuts")


@pytest.mark.parametrize(
    ("mean", "inside"),
    [(19.0, (50, 90, 95)), (20.0, (90, 95)), (20.8, (95,)), (21.2, ())],
)
def test_the_shortest_intervals_of_a_normal_posterior_hold_what_they_should(case, mean, inside):
    """The limits of 50, 90 and 95 % are 0.674, 1.645 and 1.960 standard deviations out."""
    (score,) = scored(case, lambda *_: drawn(mean, 1.0)).scores
    assert tuple(level for level in (50, 90, 95) if score.inside(level)) == inside
    assert score.error == pytest.approx(mean - 19.0, abs=0.01)
    assert score.answer.sd == pytest.approx(1.0, abs=0.01)


def test_the_truth_is_not_read_before_the_posterior_is_there(case):
    """A run that could see the file would find none."""
    (case / "truth.toml").unlink()

    def run(scene: Scene, progress: Progress) -> Outcome:
        assert not (case / "truth.toml").exists()
        (case / "truth.toml").write_text(TRUTH)
        return drawn(19.0, 1.0)

    (score,) = scored(case, run).scores
    assert score.truth == 19.0


def test_a_withheld_answer_is_listed_but_not_counted(case):
    found = scored(case, lambda *_: fail(drawn(19.0, 1.0)))
    (score,) = found.scores
    assert score.answer is not None
    assert score.reasons
    assert score.error is None
    assert not score.inside(95)
    assert found.coverage(90).of == 0


def test_a_scene_without_a_posterior_is_a_score_with_the_reason(case):
    def run(scene: Scene, progress: Progress) -> Outcome:
        raise Unanswerable("nothing leads to this rest pose")

    (score,) = scored(case, run).scores
    assert (score.truth, score.answer) == (19.0, None)
    assert score.reasons == ("nothing leads to this rest pose",)


def test_faulty_files_are_reported_and_the_other_cases_are_run(case):
    bad_truth, bad_scene = case.with_name("bad-truth"), case.with_name("bad-scene")
    for folder, name in ((bad_truth, "truth.toml"), (bad_scene, "scene.toml")):
        folder.mkdir()
        for each in ("scene.toml", "truth.toml"):
            (folder / each).write_text((case / each).read_text())
        (folder / name).write_text("speed_b = 19\n")
    found = validate(cases(case.parent), lambda *_: drawn(19.0, 1.0), model="auto", method="nuts")
    assert [score.case for score in found.scores] == ["bad-scene", "bad-truth", "crash"]
    assert [score.counts for score in found.scores] == [False, False, True]
    assert found.coverage(95).of == 1
    (of_truth,) = (fault for fault in found.faults if "bad-truth" in fault)
    assert of_truth.startswith(f"{bad_truth / 'truth.toml'}: speed_b = 19: no unit; write ")
    assert any(fault.startswith(f"{bad_scene / 'scene.toml'}: ") for fault in found.faults)


def test_a_speed_that_the_scene_knows_is_not_scored(case):
    (case / "truth.toml").write_text(TRUTH.replace("speed_b", "speed_a"))
    found = scored(case, lambda *_: drawn(19.0, 1.0))
    assert "scene.toml knows every speed in it" in found.faults[0]


def test_an_interruption_keeps_what_was_finished(case):
    second = case.with_name("second")
    case.rename(second)
    first = case.with_name("first")
    first.mkdir()
    for each in ("scene.toml", "truth.toml"):
        (first / each).write_text((second / each).read_text())
    turns = iter((drawn(19.0, 1.0), None))

    def run(scene: Scene, progress: Progress) -> Outcome:
        return next(turns) or _stop()

    kept: list[Validation] = []
    found = validate((first, second), run, model="auto", method="nuts", keep=kept.append)
    assert [score.case for score in found.scores] == ["first"]
    assert not found.complete
    assert kept == [found]  # so a run that is killed has lost nothing that was finished


def _stop() -> Outcome:
    raise Interrupted("stopped")


def test_a_folder_without_a_case_is_refused_with_what_to_write(tmp_path):
    with pytest.raises(ValueError, match=r"no case in it; write a folder whose folders hold"):
        cases(tmp_path)


def test_coverage_has_exact_binomial_limits():
    """Clopper & Pearson 1934: of ten, nine: 0.555 to 0.997."""
    scores = [
        Score("c", "speed_b", 10.0, "m", summary(10.0 + 99 * (i == 0), 1.0)) for i in range(10)
    ]
    found = Validation(tuple(scores), "auto", "nuts").coverage(90)
    assert (found.inside, found.of) == (9, 10)
    assert (found.low, found.high) == pytest.approx((0.5550, 0.9975), abs=1e-4)
    assert Validation((), "auto", "nuts").coverage(90).of == 0


def test_the_share_of_draws_below_the_truth_is_counted(case):
    """The truth is one sd above the mean: Φ(1) is 0.841."""
    (score,) = scored(case, lambda *_: drawn(18.0, 1.0)).scores
    assert score.below == pytest.approx(0.8413, abs=0.001)
    assert score.standardised == pytest.approx(-1.0, abs=0.01)
    assert score.seconds is not None


def test_files_are_known_by_their_digests(case):
    """As sha256sum prints them."""
    (score,) = scored(case, lambda *_: drawn(19.0, 1.0)).scores
    assert score.digests == {
        name: hashlib.sha256((case / name).read_bytes()).hexdigest()
        for name in ("scene.toml", "truth.toml")
    }


def test_each_group_is_counted_alone():
    inside, outside = summary(10.0, 1.0), summary(20.0, 1.0)
    found = Validation(
        tuple(
            Score(f"{i}", "speed_b", 10.0, "m", outside if i == 3 else inside, groups=groups)
            for i, groups in enumerate(
                [{"kind": "barrier", "face": "rigid"}] * 2
                + [{"kind": "barrier", "face": "deformable"}, {"kind": "impact only"}]
            )
        ),
        "auto",
        "nuts",
    )
    of = {
        group: (part.coverage(90).inside, part.coverage(90).of)
        for group, part in found.groups().items()
    }
    assert of == {
        ("kind", "barrier"): (3, 3),
        ("kind", "impact only"): (0, 1),
        ("face", "deformable"): (1, 1),
        ("face", "rigid"): (2, 2),
    }
    assert next(iter(of)) == ("kind", "barrier")


@pytest.mark.parametrize(
    ("folder", "kind"),
    [
        ("examples/ricsac-06", {"kind": "whole scene", "wheels": "rolling"}),
        ("examples/brach-1977", {"kind": "whole scene", "wheels": "locked"}),
        ("examples/nhtsa-4363", {"kind": "impact only"}),
        ("benchmarks/staged/cases/iihs-cf11002", {"kind": "barrier"}),
    ],
)
def test_the_kind_of_a_case_follows_from_its_scene(folder, kind):
    root = Path(__file__).parents[2]
    assert kind_of(load_scene(root / folder / "scene.toml")) == kind


def test_uneven_shares_are_improbable():
    """Twenty truths below every draw: the statistic is 1, whose probability is nil."""

    def of(shares):
        scores = [
            Score(f"{i}", "speed_b", 10.0, "m", summary(10.0, 1.0), below=share)
            for i, share in enumerate(shares)
        ]
        return Validation(tuple(scores), "auto", "nuts").evenness()

    assert of([0.0] * 20) < 1e-9
    assert of((np.arange(20) + 0.5) / 20) == pytest.approx(1.0, abs=1e-6)
    assert of([0.5] * 4) is None


def test_with_a_and_b_exchanged_the_same_vehicle_is_compared(case):
    """B's answer is 19 ± 1 m/s; where it is called A, 19.5: half a standard deviation."""

    def run(scene: Scene, progress: Progress) -> Outcome:
        if scene.approach["a"].speed is None:
            assert scene.approach["b"].speed is not None
            return drawn(19.5, 1.0, "speed_a")
        return drawn(19.0, 1.0)

    found = validate((case,), run, model="auto", method="nuts", exchange=True)
    (score,) = found.scores
    assert score.moved == pytest.approx(0.5, abs=0.01)
    assert score.units_agree


def test_folders_are_scored_together(case, tmp_path):
    other = tmp_path / "more" / "crash-2"
    other.mkdir(parents=True)
    for each in ("scene.toml", "truth.toml"):
        (other / each).write_text((case / each).read_text())
    assert cases(case.parent, other.parent) == (case, other)
