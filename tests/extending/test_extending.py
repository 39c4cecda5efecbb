"""What CONTRIBUTING says of adding things is true: a toy one of each, by the registries it names."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from retrodict.models import RUNGS, Rung
from retrodict.models.runouts import slide

from retrodict import findings
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.outcome import Outcome
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers import METHODS, Method
from retrodict.interchange.importing import POINTS
from retrodict.options import RunOptions
from retrodict.report import html
from retrodict.report.document import document_of
from retrodict.report.figures.registry import FIGURES, Registered, images
from retrodict.scene import SceneError, load_scene, parse_scene
from retrodict.scene.load import READERS
from retrodict.scene.priors import Prior
from retrodict.scene.quantities import REPORTED
from retrodict.scene.records import Scene
from retrodict.studies.ladder import allowed
from tests.extending import (
    toy_fields,
    toy_figure,
    toy_impact,
    toy_points,
    toy_reader,
    toy_sampler,
    toy_table,
)
from tests.interchange.test_survey import ONE, imported, refusal
from tests.models.test_rungs import agrees, drawn
from tests.report.conftest import make_outcome
from tests.shared.scene_file import SCENE, changed, stripped
from tests.shared.scenes import collision

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "retrodict"
TABLE = re.findall(
    r"^\| (an? .*?) \| `(\w+)` \| (\d+)(.*?) \| (.*) \|$",
    (ROOT / "CONTRIBUTING.md").read_text("utf-8"),
    re.MULTILINE,
)


@pytest.mark.parametrize(("what", "registry", "count", "more", "which"), TABLE)
def test_as_many_files_are_named_as_promised_and_one_holds_the_registry(
    what: str, registry: str, count: str, more: str, which: str
) -> None:
    files = re.findall(r"`([\w./-]+)`", re.sub(r"\(or .*?\)", "", which))
    assert len(files) == int(count)
    there = [file for file in files if "NAME" not in file]
    texts = [(ROOT / file).read_text("utf-8") for file in there]
    assert (
        sum(re.search(rf"^{registry}\b.* = ", text, re.MULTILINE) is not None for text in texts)
        == 1
    )


def test_every_registry_has_a_row() -> None:
    assert {registry for _, registry, *_ in TABLE} == {
        *(
            "RUNGS",
            "REPORTED",
            "VEHICLE",
            "DEPARTURE",
            "AFTER",
            "METHODS",
            "FIGURES",
            "FORMATS",
            "EXPORTS",
            "POINTS",
            "READERS",
        )
    }


@pytest.fixture(scope="module")
def rung() -> Iterator[str]:
    """The toy impact with a straight slide, registered, and the labels of its coefficients."""
    with pytest.MonkeyPatch.context() as patch:
        added = Rung(toy_impact.IMPACT, slide.RUN_OUT)
        patch.setitem(RUNGS, added.name, added)
        patch.setitem(REPORTED, "ratio", ("impulse over that of a common velocity", "number"))
        patch.setitem(REPORTED, "swerve", ("direction of the impulse from the closing", "angle"))
        yield added.name


@pytest.fixture(scope="module")
def scene() -> Scene:
    plain = collision(share=0.0, berm=False)
    prior = Prior((0.0, 0.5), "log-normal, 1 within a factor of 1.6", "a toy", "a toy", "C")
    return replace(plain, priors=plain.priors | {"ratio": prior})


@pytest.fixture(scope="module")
def outcome(rung: str, scene: Scene) -> Iterator[Outcome]:
    """Of the toy rung by the toy sampler."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(METHODS, "toy", Method("a toy sampler", True, 1000, toy_sampler.draw))
        yield reconstruct(scene, RunOptions(model=rung, method="toy"), pictured=False)


def test_a_rung_is_offered_where_its_coefficient_is_asked(rung: str, scene: Scene) -> None:
    assert allowed(scene, ("speed_b", "ratio")) == [rung]


@pytest.mark.slow
def test_a_rung_has_its_posterior(rung: str, scene: Scene) -> None:
    agrees(scene, rung)


def test_a_sampler_draws_what_importance_sampling_does(
    outcome: Outcome, rung: str, scene: Scene
) -> None:
    assert outcome.settings["method"] == "toy"
    assert outcome.checks.passed, outcome.checks.reasons
    sure = drawn(prepare(scene, rung))
    for name in ("speed_b", "ratio"):
        draws = outcome.idata["posterior"][name].values
        error = np.sqrt(1 / outcome.checks.min_ess_bulk + 1 / 4000) * draws.std()
        assert draws.mean() == pytest.approx(sure[name].mean(), abs=5 * error), name


def test_a_coefficient_is_reported_with_its_prior(outcome: Outcome) -> None:
    found = findings.compute(outcome)
    assert found.quantities["ratio"].label == REPORTED["ratio"][0]
    assert (REPORTED["ratio"][0], "log-normal, 1 within a factor of 1.6") in [
        (label, prior) for label, prior, _ in outcome.description.priors
    ]


def test_a_figure_is_drawn_and_in_the_report(monkeypatch: pytest.MonkeyPatch) -> None:
    toy = Registered(toy_figure.toy_figure, "A toy", toy_figure.CAPTION)
    monkeypatch.setitem(FIGURES, "toy", toy)
    made_up = make_outcome()
    found = findings.compute(made_up)
    drawn = images(found, made_up)
    assert drawn["toy"][1:4] == b"PNG"
    document = document_of(found, made_up, drawn=drawn)
    page = html.render(document).decode()
    assert toy.title in page
    assert toy.caption in page


def test_a_file_reader_gives_the_same_scene(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(READERS, ".json", toy_reader.json_of)
    file = tmp_path / "crash.json"
    file.write_text(json.dumps(tomllib.loads(SCENE)), encoding="utf-8")
    expected = parse_scene(SCENE, "crash")
    assert load_scene(file) == replace(expected, text=file.read_text("utf-8"))
    file.write_text("{")
    with pytest.raises(SceneError, match=r"crash\.json: not valid JSON"):
        load_scene(file)


def test_a_file_of_points_is_imported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(POINTS, "survey", toy_points.points_of)
    found = imported(tmp_path, '{"7": [1, 2]}', ONE, "points.json")
    assert (found.scene.contact.x.value, found.scene.contact.y.value) == (1, 2)
    assert found.scene.contact.x.source.startswith("points.json, point 7, key 7; SHA-256 ")
    assert found.left == ("a line",)
    assert "points.json: not valid JSON" in refusal(tmp_path, "{", ONE, "points.json")


def test_an_item_of_evidence_is_read_labelled_and_predicted() -> None:
    text = stripped('departure = { forward = "6 ± 0.5 m/s" }')
    asked = [sys.executable, "-m", "tests.extending.toy_evidence"]
    done = subprocess.run(asked, input=text, cwd=ROOT, capture_output=True, text=True, check=True)
    label, measured, prediction = done.stdout.splitlines()
    assert label == "speed of B along its heading|m/s"
    assert measured == "6.0 0.5"
    found, expected = map(float, prediction.split())
    assert found == pytest.approx(expected, abs=1e-9)


@pytest.fixture(scope="module")
def with_toy_fields(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package in which the files that CONTRIBUTING names have the toy quantities."""
    return copied(tmp_path_factory.mktemp("copy"), "VEHICLE", toy_fields.ADDED)


def copied(folder: Path, registry: str, added: dict[str, tuple[tuple[str, str], ...]]) -> Path:
    """A folder with a copy of the package, in which only the files of a row of CONTRIBUTING changed."""
    package = folder / "retrodict"
    shutil.copytree(SOURCE, package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(
        ROOT / "models", package / "models", ignore=shutil.ignore_patterns("__pycache__")
    )
    ((*_, which),) = (row for row in TABLE if row[1] == registry)
    assert list(added) == re.findall(r"`([\w./-]+\.py)`", which)
    for file, additions in added.items():
        path = package / file.removeprefix("src/retrodict/")
        text = path.read_text("utf-8")
        for line, addition in additions:
            assert text.count(f"\n{line}\n") == 1, line
            text = text.replace(f"\n{line}\n", f"\n{line}\n{addition}\n")
        path.write_text(text, encoding="utf-8")
    return folder


def test_a_table_of_evidence_goes_from_the_file_to_the_report(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(Path(toy_table.__file__))],
        input=stripped('kerb = { course = "30 ± 5 deg", speed = "6 ± 0.5 m/s" }'),
        env=os.environ | {"PYTHONPATH": str(copied(tmp_path, "AFTER", toy_table.ADDED))},
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(done.stdout)
    values = {"kerb_speed_b": [6.0, 0.5], "kerb_course_b": pytest.approx(np.radians([30, 5]))}
    assert list(found["values"]) == list(values)
    assert found["values"] == values
    assert found["written"] == values
    assert found["labels"] == ["speed of B at the kerb", "course of B at the kerb"]
    assert set(found["sliders"]) == {"vehicles.B.kerb.speed", "vehicles.B.kerb.course"}
    assert found["predicted"] == pytest.approx(found["speed"])
    assert all(label in found["report"] for label in found["labels"])


def test_a_measured_quantity_goes_from_the_file_to_the_report(with_toy_fields: Path) -> None:
    text = changed(
        ('grip = "1.02 ± 0.04"', 'grip = "1.02 ± 0.04"\nreach = "2 ± 0.5 m"'),
        ("contact_line =", 'depth = "3 ft"\ncontact_line ='),
        ('kind = "dry asphalt"', 'kind = "dry asphalt"\nlayer = "0.5 ± 0.1 m"'),
    )
    done = subprocess.run(
        [sys.executable, str(Path(toy_fields.__file__))],
        input=text,
        env=os.environ | {"PYTHONPATH": str(with_toy_fields)},
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(done.stdout)
    feet = 3 * 0.3048
    assert found["values"] == {
        "reach_a": [2.0, 0.5],
        "depth": [pytest.approx(feet), pytest.approx(0.05 * feet)],
        "layer_road": [0.5, 0.1],
    }
    assert found["written"] == {name: pytest.approx(v[0]) for name, v in found["values"].items()}
    assert found["labels"] == {
        "reach_a": "reach of A", "depth": "depth of the contact", "layer_road": "layer of the road"
    }  # fmt: skip
    assert set(found["units"].values()) == {"ft"}
    assert {"vehicles.A.reach", "impact.depth", "surfaces.road.layer"} <= set(found["sliders"])
    for name, (value, sd) in found["values"].items():
        assert 0 < abs(found["draws"][name] - value) < 5 * sd
        assert found["labels"][name] in found["report"]
