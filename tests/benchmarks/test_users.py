"""The benchmark of users' scenes: every scene is read, and the page is what the rows make."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

from benchmarks import page
from benchmarks.users import __main__ as users
from benchmarks.users import runs, scores
from benchmarks.users.catalogue import FOLDER, UserScene, Value, scenes
from benchmarks.users.chart import draw
from benchmarks.users.runs import AGAIN, COLUMNS, FIRST, Ended, Row
from retrodict.scene.load import load_scene

DOCS = Path(__file__).parents[2] / "docs"
FILES = sorted(FOLDER.glob("*.toml"))
REAR_ENDS = ("rear-end-queue", "rear-end-lights", "rear-end-motorway")
HEAD_ONS = ("head-on-lane", "head-on-skid", "head-on-recorders")


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_scene_is_read_and_says_where_it_is_from(file: Path) -> None:
    assert load_scene(file).name == file.stem
    assert file.read_text("utf-8").startswith(("# Made from a ", "# Simulation: "))


def test_the_table_names_every_scene_and_no_other() -> None:
    assert set(scenes()) == {file.stem for file in FILES}
    assert len(FILES) >= 30
    assert scores.PAPER not in scenes()


def test_right_answers_are_of_quantities_that_a_run_reports() -> None:
    for scene in scenes().values():
        assert set(scene.truth) <= set(runs.QUANTITIES), scene.name
        assert not (scene.truth and scene.refused), scene.name
        assert all(value.sd >= 0 for value in scene.truth.values()), scene.name


@pytest.mark.parametrize("name", [*REAR_ENDS, *HEAD_ONS])
def test_straight_scenes_are_mirror_symmetric_and_state_no_rotation(name: str) -> None:
    """About the x axis: nothing lies off it, and every angle is along it."""
    vehicles = tomllib.loads(scenes()[name].file.read_text("utf-8"))["vehicles"].values()
    assert not any("rotation" in vehicle.get("rest", {}) for vehicle in vehicles)
    scene = load_scene(scenes()[name].file)
    measured = scene.inputs() | scene.evidence()
    off_axis = [key for key in measured if key.startswith(("rest_y", "impact_y"))]
    angles = ("impact_angle", "heading", "direction", "Gamma", "rest_heading", "omega")
    for key in off_axis:
        assert measured[key].value == 0, key
    for key in (key for key in measured if key.startswith(angles)):
        assert abs(measured[key].value) in (0, pytest.approx(3.141592653589793)), key
    headings = [measured[f"heading_{v}"].value for v in "ab"]
    assert (headings[0] == headings[1]) == (name in REAR_ENDS)


# --- reading a run ---------------------------------------------------------------------------------


def summary(**changed: Any) -> dict[str, Any]:
    return {
        "seconds": {"total": 9.0, "compile": 1.0, "sample": 3.0},
        "model": "planar-moment+wheels",
        "settings": {"method": "nuts"},
        "notes": ["one", "two"],
        "checks": {"passed": True, "reasons": [], "flags": []},
        "parameters": {"speed_b": {"mean": 10.0, "sd": 0.5}},
        "measured": {"speed_a": {"mean": 14.0, "sd_found": 1.5}},
    } | changed


def test_a_run_is_read_with_speeds_that_were_asked_for_and_that_were_measured() -> None:
    row = runs.read(Ended(0, 20.0, 12.0, 0), "", summary(), "s.toml")
    assert (row["verdict"], row["cpu"], row["compile"], row["method"]) == (
        "passed",
        "20.00",
        "1",
        "nuts",
    )
    assert (row["speed_b_mean"], row["speed_b_sd"]) == ("10", "0.5")
    assert (row["speed_a_mean"], row["speed_a_sd"]) == ("14", "1.5")
    assert (row["e_mean"], row["notes"]) == ("", "one | two")


@pytest.mark.parametrize(
    ("status", "log", "found", "verdict", "reason"),
    [
        (
            0,
            "",
            summary(checks={"passed": False, "reasons": ["a", "b"], "flags": []}),
            "withheld",
            "a; b",
        ),
        (
            2,
            "retrodict: 1 s: looking\ns.toml: no motion leads there\n",
            None,
            "refused",
            "no motion",
        ),
        (
            1,
            "Traceback (most recent call last):\n  File\nValueError: no\n",
            None,
            "traceback",
            "Value",
        ),
        (None, "retrodict: 599 s: sampling\n", None, "timed out", "599 s"),
        (-9, "", None, "failed", "-9"),
        (0, "", None, "failed", "exit status 0"),
    ],
)
def test_what_became_of_a_run_is_distinguished(
    status: int | None, log: str, found: dict[str, Any] | None, verdict: str, reason: str
) -> None:
    row = runs.read(Ended(status, 1.0, 1.0, 0), log, found, "s.toml")
    assert row["verdict"] == verdict
    assert reason in row["reason"]
    assert "s.toml" not in row["reason"]


def test_a_faulty_scene_is_refused_by_the_command_itself(tmp_path: Path) -> None:
    scene = tmp_path / "faulty.toml"
    scene.write_text('schema = 1\ntitle = "no vehicles"\n', "utf-8")
    row = runs.first(scene, tmp_path / "own")
    assert (row["verdict"], row["status"], row["programs"]) == ("refused", "2", "0")
    assert row["reason"]
    assert float(row["cpu"]) > 0


# --- the page --------------------------------------------------------------------------------------

SCENES = {
    "slow": UserScene("slow", "simulation", {"speed_b": Value(10.0, 0.3)}, False),
    "wrong": UserScene("wrong", "simulation", {"speed_b": Value(14.0)}, False),
    "off": UserScene("off", "textbook problem", {}, True),
    "late": UserScene("late", "public source", {"speed_a": Value(3.0)}, False),
}


def made_up(scene: str, which: str, cpu: float, repeat: int = 0, **changed: str) -> Row:
    row = runs.read(Ended(0, cpu, cpu / 2, 0), "", summary(), f"{scene}.toml")
    return row | {"scene": scene, "repeat": str(repeat), "pass": which} | changed


ROWS = [
    *(made_up(scores.PAPER, FIRST, cpu, i) for i, cpu in enumerate((70.0, 80.0, 99.0))),
    *(made_up(scores.PAPER, AGAIN, cpu, i) for i, cpu in enumerate((20.0, 10.0, 30.0))),
    made_up("slow", FIRST, 160.0),
    made_up("slow", AGAIN, 200.0),
    made_up("wrong", FIRST, 40.0),
    made_up("wrong", AGAIN, 30.0, flags="energy gained"),
    made_up("off", FIRST, 8.0, verdict="refused", reason="a | b"),
    made_up("off", AGAIN, 2.0, verdict="refused", reason="a | b"),
    made_up("late", FIRST, 800.0, verdict="timed out", reason="stopped"),
    made_up("late", AGAIN, 40.0, verdict="withheld", reason="R-hat", programs="3"),
]


def test_speeds_are_ratios_to_the_median_of_the_papers_example() -> None:
    assert scores.paper_seconds(ROWS) == {FIRST: 80.0, AGAIN: 20.0}
    found = {score.scene.name: score.ratios for score in scores.all_scores(ROWS, SCENES)}
    assert found["slow"] == {FIRST: 2.0, AGAIN: 10.0}
    assert found["off"] == {FIRST: 0.1, AGAIN: 0.1}


def test_the_summary_counts_verdicts_and_gives_median_95_per_cent_and_worst() -> None:
    lines = scores.parts(ROWS, SCENES)["summary"]
    assert "4 scenes: 2 passed, 1 withheld, 1 refused, 0 tracebacks, 0 timed out" in lines[0]
    assert "median 1.25, 95 % of scenes at most 10.0, worst 10.0 (late)" in lines[1]
    assert "median 1.75, 95 % of scenes at most 10.0, worst 10.0 (slow)" in lines[2]
    assert "right answer: 2. More than 3 standard deviations from it: wrong (8.0)." in lines[3]
    assert "off: refused" in lines[4]
    assert "Compiled something again: late" in lines[5]


def test_the_table_shows_answer_beside_right_answer() -> None:
    slow, _, off, late = scores.parts(ROWS, SCENES)["table"][2:]
    assert "| passed | speed_a 14.00 ± 1.50; speed_b 10.00 ± 0.50 | speed_b 10.00 ± 0.30 |" in slow
    assert "| 2.00 | 10.0 | planar-moment+wheels nuts |" in slow
    assert "| refused | – | refused or flagged |" in off
    assert "| withheld (first: timed out) | (speed_a 14.00" in late
    assert "| ≥ 10.0 | 2.00 |" in late
    reasons = scores.parts(ROWS, SCENES)["reasons"]
    assert "| off | refused | a \\| b |" in reasons
    assert "| wrong | passed | energy gained |" in reasons


def test_the_page_has_a_place_for_every_part(tmp_path: Path) -> None:
    copy = tmp_path / "users.md"
    shutil.copy(DOCS / "users.md", copy)
    page.refresh(copy, scores.parts(ROWS, SCENES, "two cores"))
    text = copy.read_text("utf-8")
    assert text.count("<!-- end -->") == len(scores.PARTS)
    assert "not run yet" not in text
    assert "- two cores\n" in text
    page.refresh(copy, scores.parts([], SCENES))
    assert copy.read_text("utf-8").count("not run yet") == len(scores.PARTS)


def test_the_picture_is_drawn(tmp_path: Path) -> None:
    draw(scores.all_scores(ROWS, SCENES), tmp_path / "users.png")
    assert (tmp_path / "users.png").read_bytes().startswith(b"\x89PNG")


# --- going on --------------------------------------------------------------------------------------


def test_a_run_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[tuple[str, str]] = []

    def run(which: str) -> Any:
        def one(scene: Path, folder: Path, **_: bool) -> Row:
            ran.append((folder.name, which))
            return dict.fromkeys(COLUMNS, "") | {"cpu": "1.00", "wall": "1.00", "programs": "0"}

        return one

    monkeypatch.setattr(runs, "first", run(FIRST))
    monkeypatch.setattr(runs, "again", run(AGAIN))
    of_paper = [(scores.PAPER, which) for which in (FIRST, AGAIN)] * users.REPEATS
    users.measure(["taxi"], (FIRST, AGAIN), tmp_path)
    assert ran == [*of_paper, ("taxi", FIRST), ("taxi", AGAIN)]
    ran.clear()
    rows = users.measure(["taxi", "pole"], (FIRST, AGAIN), tmp_path)
    assert ran == [("pole", FIRST), ("pole", AGAIN)]
    assert users.read_rows(tmp_path / "results.csv") == rows
    ran.clear()
    users.forget(["taxi"], (AGAIN,), tmp_path)
    users.measure(["taxi"], (AGAIN,), tmp_path)
    assert ran == [("taxi", AGAIN)]
