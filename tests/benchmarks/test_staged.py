"""The second set of staged collisions: written by its script, and true speeds kept out of the scenes."""

import csv
import json
import math
from dataclasses import asdict

import pytest

from benchmarks.staged.__main__ import CASES, TABLE, files
from benchmarks.validation import score_of
from retrodict.scene import load_scene
from retrodict.scene.records import Measured
from retrodict.scene.truth import load_truth
from retrodict.studies.narrowing import Narrowed
from retrodict.studies.validation import Score
from tests.studies.made_up import summary

ROWS = list(csv.DictReader(x for x in TABLE.read_text("utf-8").splitlines() if x[0] != "#"))


def test_the_files_are_what_the_script_writes():
    """So that one rule made them all."""
    made = files()
    assert set(made) == set(CASES.glob("*/*.toml"))
    for path, text in made.items():
        assert path.read_text("utf-8") == text, path


def test_no_scene_knows_the_speed_that_is_scored():
    scored = sorted(CASES.glob("*/truth.toml"))
    assert len(scored) == 35
    for file in scored:
        scene, truth = load_scene(file.with_name("scene.toml")), load_truth(file)
        for name in truth.speeds:
            assert scene.approach[name[-1]].speed is None, file
        if scene.barrier:
            assert "approach.speed" not in scene.text
            assert not scene.coefficients


def test_corrected_values_are_those_of_the_paper():
    """SAE 2014-01-0469, Appendix 2: an earlier copy has CF11011 for CF11001, and Γ of 74.7 deg."""
    rows = {row["test"]: row for row in ROWS}
    assert len(rows) == 29
    assert "CF11011" not in rows
    assert rows["CF11001"]["vehicle"] == "Volvo S60"
    assert rows["CEN1212"]["Gamma"] == "74.4"
    assert rows["CF10028"]["group"] == "sideswipe"
    assert rows["CEN1212"]["group"] == "non-sideswipe"
    assert math.hypot(45.57, 10.62) == pytest.approx(
        46.90, abs=0.15
    )  # delta-v of CF10020, not 49.9
    assert sum(row["in_priors"] == "yes" for row in ROWS) == 21


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["test"])
def test_impact_centres_lie_within_the_overlap_ahead_of_the_centre_of_gravity(row):
    scene = load_scene(CASES / f"iihs-{row['test'].lower()}" / "scene.toml")
    car = scene.vehicles["a"]
    forward = car.impact_distance.value * math.cos(car.impact_angle.value)
    left = car.impact_distance.value * math.sin(car.impact_angle.value)
    overlap = float(row["overlap"]) / 100 * car.width
    assert car.width / 2 - overlap < left < car.width / 2
    assert 0 < forward < car.length / 2


def test_momentum_of_the_standing_target_closes():
    """NHTSA 7292: what the bullet loses the target gains, to the 5 % that is stated of each."""
    scene = load_scene(CASES / "nhtsa-7292" / "scene.toml")
    gained = 0j
    for v, car in scene.vehicles.items():
        forward, left = (scene.departure[v][f"delta_v_{k}"].value for k in ("forward", "left"))
        angle = car.heading.value
        gained += (
            car.mass.value * complex(forward, left) * complex(math.cos(angle), math.sin(angle))
        )
    assert abs(gained) < 0.06 * 1735 * math.hypot(51.5, 17.6) / 3.6


def test_a_score_comes_back_from_json():
    """A run goes on from the scores that it has kept."""
    score = Score(
        *("c", "speed_b", 10.0, "m", summary(10.0, 1.0), ("withheld",)),
        narrowed=(Narrowed("mass_a", Measured(1500.0, 30.0), 0.5), Narrowed("e", None, 0.4)),
        groups={"kind": "barrier"},
        exchanged=summary(11.0, 1.0),
        units_agree=True,
    )
    assert score_of(json.loads(json.dumps(asdict(score)))) == score
    assert score_of(json.loads(json.dumps(asdict(Score("c"))))) == Score("c")
