"""What is reported of an impact with a barrier speaks of vehicle A and of the barrier alone."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.patches import FancyArrowPatch
from matplotlib.text import Text

from retrodict import findings
from retrodict.findings.run_outs import motions
from retrodict.findings.summary import summarise
from retrodict.inference.outcome import Outcome
from retrodict.report.export import Asked, motion_files
from retrodict.report.figures.plan_geometry import barrier_outline, impact_pose
from retrodict.report.figures.registry import FIGURES
from retrodict.report.figures.scene import plan_figure
from retrodict.report.fragments import findings_html, scene_html
from retrodict.report.replay_html import replay_fragment
from retrodict.report.scene_layers import scene_drawing
from retrodict.report.scene_svg import scene_svg
from retrodict.scene import load_scene
from retrodict.scene.names import vehicle_of
from retrodict.scene.questions import questions_from
from retrodict.scene.records import Barrier
from tests.report.conftest import DESCRIPTION, make_outcome
from tests.report.documents import document_of, text_of

ROOT = Path(__file__).parents[2]
ASKED = {
    "limit": "15 m/s",
    "reaction": "1 ± 0.2 s",
    "deceleration": "7 ± 1 m/s^2",
    "seen_time": "2 s",
}
QUESTIONS = {
    "exceeds": "speed_a > 20 m/s",
    "avoidable": [{"vehicle": "A", **ASKED}],
    "time_distance": "3 s",
}


def only_a(found: dict) -> dict:
    return {v: each for v, each in found.items() if v == "a"}


@pytest.fixture(scope="module")
def struck() -> Outcome:
    """The made-up outcome without its vehicle B, A's speed being sought."""
    outcome = make_outcome()
    scene = replace(
        outcome.scene,
        vehicles=only_a(outcome.scene.vehicles),
        approach={"a": replace(outcome.scene.approach["a"], speed=None)},
        rest=only_a(outcome.scene.rest),
        barrier=Barrier("wall", "concrete wall"),
        question=("speed_a", "e"),
        questions=questions_from(QUESTIONS, "test"),
    )
    tree = outcome.idata.copy()
    for name in list(tree.children):
        data = tree[name].to_dataset()
        of_b = [n for n in data.data_vars if vehicle_of(str(n)) == "b"]
        data = data.drop_vars(of_b)
        if "item" in data.dims:
            data = data.drop_sel(item=[name for name in data["item"].values if name.endswith("_b")])
        if name == "trajectories":
            data = data.sel(vehicle=["a"])
        if name == "posterior":
            draws = np.random.default_rng(1).normal(20.3, 0.7, data["e"].shape)
            data["speed_a"] = (data["e"].dims, draws)
        tree[name] = xr.DataTree(data)
    description = replace(DESCRIPTION, assumptions=(), priors=())
    return replace(outcome, scene=scene, idata=tree, description=description)


def test_nothing_that_is_said_is_of_a_vehicle_b(struck: Outcome) -> None:
    found = findings.compute(struck)
    said = {
        "summary": json.dumps(summarise(found), allow_nan=False).replace("speed_b", ""),
        "document": text_of(document_of(struck)),
        "replay": replay_fragment(found, struck, "si"),
        "picture": scene_svg(struck.scene),
        "notebook": scene_html(struck.scene) + findings_html(found),
    }
    for where, text in said.items():
        for word in ("vehicle B", "of B", "B's", '_b"', "both vehicles"):
            assert word not in text, (where, word)
        if where != "summary":
            assert "concrete wall" in text, where


def test_the_answer_is_the_speed_of_a(struck: Outcome) -> None:
    found = findings.compute(struck)
    assert found.question.startswith("How fast did vehicle A travel before the impact?")
    assert found.answers["si"].startswith("Vehicle A (saloon A) was travelling at about 20.3 m/s")
    assert list(found.quantities) == ["speed_a", "e", "e_m", "mu"]
    assert {"delta_v_a", "pdof_a", "Vax", "Omega_a"} <= set(found.derived)
    for item in summarise(found)["left_out"].values():
        assert item["speed_a"] == pytest.approx(20.3, abs=1)
        assert item["speed_b"] is None


def test_the_force_comes_from_where_the_velocity_changed_from(struck: Outcome) -> None:
    """From (-20.3, 0) m/s to (-7, 2.4): pushed back and to its right, from ahead and a little left."""
    pdof = findings.compute(struck).derived["pdof_a"]
    assert pdof.mean == pytest.approx(-np.arctan2(2.4, 20.3 - 7.0), abs=0.05)


def test_a_barrier_never_clears_the_way(struck: Outcome) -> None:
    answered = {each.kind: each for each in findings.compute(struck).questions}
    avoidable, distances = answered["avoidability"], answered["time_distance"]
    assert avoidable.numbers.passed.value == 0
    assert avoidable.numbers.avoided.value == avoidable.numbers.stopped.value
    assert "out of the way" not in " ".join(avoidable.sentences)
    assert list(distances.numbers.distances) == ["a"]
    assert len(distances.header) == 3


def test_motions_are_ordered_by_the_speed_of_a(struck: Outcome) -> None:
    speeds = [motion.speed for motion in motions(struck, 5)]
    assert [list(each) for each in speeds] == [["a"]] * 5
    assert np.all(np.diff([each["a"] for each in speeds]) >= 0)


@pytest.mark.parametrize("name", ["scene", "delta_v"])
def test_figures_are_drawn_of_one_vehicle(struck: Outcome, name: str) -> None:
    figure = FIGURES[name].draw(findings.compute(struck), struck, "si")
    texts = [text.get_text() for text in figure.findobj(Text)]
    assert any("A" in text.split() or "A:" in text for text in texts)
    assert not [text for text in texts if text.startswith(("B", "vehicle B"))]


@pytest.mark.parametrize("barrier", [Barrier("wall", "wall"), Barrier("pole", "pole", 0.4)])
def test_a_barrier_is_drawn_beyond_the_contact_line(struck: Outcome, barrier: Barrier) -> None:
    scene = replace(struck.scene, barrier=barrier)
    centre = np.array([scene.contact.x.value, scene.contact.y.value])
    normal = np.array([np.cos(scene.contact.Gamma.value), np.sin(scene.contact.Gamma.value)])
    off = (barrier_outline(scene, 20.0) - centre) @ normal
    car = (np.array(impact_pose(scene, "a")[:2]) - centre) @ normal
    assert abs(off).min() == pytest.approx(0, abs=1e-3)  # a pole has 36 corners
    assert np.all(off * car <= 1e-9)


@pytest.mark.parametrize("example", ["iihs-cf10028-barrier", "brach-1977"])
def test_a_plan_holds_the_barrier_and_the_normal_of_the_contact(example: str) -> None:
    scene = load_scene(ROOT / "examples" / example / "scene.toml")
    figure = plan_figure(scene)
    figure.draw_without_rendering()  # an arrow's head is as large as on paper
    (axes,) = figure.axes
    (arrow,) = [p for p in axes.patches if isinstance(p, FancyArrowPatch) and p.get_zorder() == 8]
    corners = [arrow.get_path().get_extents().get_points()]
    corners += [barrier_outline(scene, 1.0)] if scene.barrier else []
    low, high = np.transpose([axes.get_xlim(), axes.get_ylim()])
    for each in corners:
        assert np.all((each > low) & (each < high)), each


@pytest.mark.parametrize("barrier", [Barrier("wall", "a wall"), Barrier("pole", "a pole", 0.3)])
def test_an_export_draws_the_barrier_and_moves_a_alone(struck: Outcome, barrier: Barrier) -> None:
    outcome = replace(struck, scene=replace(struck.scene, barrier=barrier))
    found = findings.compute(outcome)
    drawn = {layer.name: layer for layer in scene_drawing(found, outcome).layers}
    (area,) = drawn["BARRIER"].shapes
    assert area.closed
    assert not [name for name in drawn if name.startswith("B-")]
    files = motion_files(found, outcome, Asked(draws=("median",)))
    assert sorted(files) == ["motion/a-median.csv", "motion/motion.json"]
    assert list(json.loads(files["motion/motion.json"])["vehicles"]) == ["a"]
