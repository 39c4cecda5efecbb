"""docs/scene-file.md is true: example, keys and defaults are the code's."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel
from scipy import special

from retrodict.scene import parse_scene
from retrodict.scene.defaults import DEFAULTS, FRICTION, SLIDING
from retrodict.scene.entries.vehicle import MarkEntry, VehicleEntry
from retrodict.scene.kinds import Kind
from retrodict.scene.priors import default_priors
from retrodict.scene.schema import SceneEntry

PAGE = (Path(__file__).parents[2] / "docs" / "scene-file.md").read_text(encoding="utf-8")


def example() -> str:
    found = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found[1]


def tables(model: type[BaseModel]) -> set[type[BaseModel]]:
    """A table of the schema and all tables in it."""
    found = {model}
    for field in model.model_fields.values():
        todo = [field.annotation]
        while todo:
            part = todo.pop()
            if isinstance(part, type) and issubclass(part, BaseModel):
                found |= tables(part)
            todo += getattr(part, "__args__", ())
    return found


def test_the_example_is_a_scene():
    scene = parse_scene(example(), "example")
    assert scene.vehicles["b"].mass.value == 3920 * 0.45359237
    assert scene.rest["b"].turns_known


def test_every_key_is_documented():
    assert {VehicleEntry, MarkEntry} < tables(SceneEntry)
    for table in tables(SceneEntry):
        for name, field in table.model_fields.items():
            key = name if name in "AB" else field.alias or name
            assert re.search(rf"[`.\[]{key}[`\].]", PAGE), f"{table.__name__}.{key}"


def test_every_default_is_documented_with_grade_and_source():
    for default in DEFAULTS.values():
        row = f"| {default.value:g} {default.unit} | {default.grade} | {default.source} |"
        assert f"| {default.quantity} {row}" in PAGE


def test_judgement_is_graded_as_judgement():
    for default in DEFAULTS.values():
        assert default.grade in "ABC"
        assert (default.grade == "C") == default.source.startswith("judgement")


def test_every_example_in_the_schema_is_itself_accepted():
    kinds = 0
    for table in tables(SceneEntry):
        for field in table.model_fields.values():
            for kind in field.metadata:
                if isinstance(kind, Kind):
                    kinds += 1
                    measured = kind.read(kind.example)
                    assert measured.assumed == ""
    assert kinds >= 8


def test_every_friction_and_prior_is_documented_with_grade_and_source():
    for kind, friction in (FRICTION | SLIDING).items():
        row = f"{friction.value:g} ± {friction.sd:g} | {friction.grade} | {friction.source}"
        assert f'| `"{kind}"` | {row} |' in PAGE
    for name, prior in default_priors().items():
        row = f"{prior.text} | {prior.grade} | {prior.reason} | {prior.source}"
        assert f"| `{name}` | {row} |" in PAGE


@pytest.mark.parametrize(
    ("share", "sd", "stated"),
    [
        (0.30, 0.10, "0.30 ± 0.10 becomes a law of mean {:.2f} and standard deviation {:.2f}"),
        (0.03, 0.02, "0.03 ± 0.02 one of {:.3f} and {:.3f}."),
    ],
)
def test_the_logit_normal_law_has_the_moments_that_the_page_states(share, sd, stated):
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    law = special.expit(special.logit(share) + sd / (share * (1 - share)) * nodes)
    mean = np.average(law, weights=weights)
    spread = np.sqrt(np.average((law - mean) ** 2, weights=weights))
    assert stated.format(mean, spread) in " ".join(PAGE.split())
