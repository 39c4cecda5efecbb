"""Recorder tables as CSV become evidence with the error model that the map asks for."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from rich.console import Console

from retrodict.interchange.importing import import_evidence
from retrodict.report.imported import print_import
from retrodict.scene import parse_scene
from retrodict.scene.write import scene_toml
from tests.interchange.test_survey import PAPER, imported, refusal

PRE_CRASH = """\
Time (s);Speed (km/h);Brake;Yaw rate
-1,0;72,0;off;1,5
-0,5;70,2;on;2,0
0,0;54,0;on;3,0
"""
PULSE = """\
ms,Longitudinal (mph),Lateral (mph)
0,0,0
50,-12.5,1.5
100,-22,3
110,N/A,3.1
"""
BEFORE = """
[recorder]
vehicle = "A"
decimal = ","
columns = { time = "Time (s)", speed = "Speed (km/h)", yaw_rate_clockwise = "Yaw rate" }
units = { time = "s", speed = "km/h", yaw_rate_clockwise = "deg/s" }
[recorder.speed]
impact = ["-0.6 s", "-0.1 s"]
uncertainty = "1 km/h"
[recorder.yaw_rate]
at = "-0.25 s"
to = "approach"
uncertainty = "2 deg/s"
"""
AFTER = """
[recorder]
vehicle = "B"
units = { time = "0.001 s", delta_v_forward = "mph", delta_v_right = "mph" }
columns = { time = "ms", delta_v_forward = "Longitudinal (mph)", delta_v_right = "Lateral (mph)" }
[recorder.delta_v]
at = "last"
ended = "early"
uncertainty = "1 mph"
""".replace('"0.001 s"', '"ms"')


def test_an_unknown_time_zero_takes_the_record_about_the_window(tmp_path: Path) -> None:
    found = imported(tmp_path, PRE_CRASH, BEFORE)
    approach = found.scene.approach["a"]
    assert approach.record is not None
    assert approach.record.times == (-1.0, -0.5, 0.0)
    assert approach.record.speeds == pytest.approx((20.0, 19.5, 15.0))
    assert (approach.record.low, approach.record.high) == (-0.6, -0.1)
    assert approach.record.sd == pytest.approx(1 / 3.6, rel=2e-3)
    assert approach.speed is not None
    assert approach.speed.source.startswith("points.csv, speed, rows 2 to 4; SHA-256 ")
    assert approach.yaw_rate is not None
    assert approach.yaw_rate.value == pytest.approx(math.radians(-2.5), abs=1e-4)
    # the speed that the scene had stands no more, which is said
    removed = [taken for taken in found.taken if taken.value is None]
    assert [taken.key for taken in removed] == ["vehicles.A.approach.speed"]
    assert found.left == ('column "Brake": not in the map',)


def test_a_known_time_zero_takes_the_speed_between_rows(tmp_path: Path) -> None:
    known = BEFORE.replace('["-0.6 s", "-0.1 s"]', '"-0.1 s"')
    approach = imported(tmp_path, PRE_CRASH, known).scene.approach["a"]
    assert approach.record is None
    assert approach.speed is not None
    assert approach.speed.value == pytest.approx(15.9)
    assert approach.speed.sd == pytest.approx(1 / 3.6, rel=2e-3)


def test_a_pulse_that_ended_early_is_a_lower_bound(tmp_path: Path) -> None:
    found = imported(tmp_path, PULSE, AFTER)
    departure = found.scene.departure["b"]
    assert set(departure) == {"delta_v_forward_at_least", "delta_v_left_at_least"}
    forward, left = departure["delta_v_forward_at_least"], departure["delta_v_left_at_least"]
    assert forward.value == pytest.approx(-22 * 0.44704, abs=1e-4)
    assert left.value == pytest.approx(-3.1 * 0.44704, abs=1e-4)  # the file counts to the right
    assert forward.sd == pytest.approx(0.447, abs=1e-3)
    assert found.left == ('row 5: time = "110", delta_v_forward = "N/A" is not a number',)


def test_a_whole_pulse_is_measured(tmp_path: Path) -> None:
    whole = AFTER.replace('"early"', '"after the impact"').replace('"last"', '"0.075 s"')
    departure = imported(tmp_path, PULSE, whole).scene.departure["b"]
    assert departure["delta_v_forward"].value == pytest.approx(-17.25 * 0.44704, abs=1e-4)


@pytest.mark.parametrize(
    ("content", "map_text", "said"),
    [
        (
            PRE_CRASH,
            BEFORE.replace('speed = "km/h", ', ""),
            'no unit of speed; write speed = "m/s"',
        ),
        (
            PRE_CRASH,
            BEFORE.replace('"-0.1 s"]', '"0.4 s"]'),
            "recorder.speed.impact: recorded from",
        ),
        (PRE_CRASH, BEFORE.replace('["-0.6 s", "-0.1 s"]', '"0.4 s"'), "not at 0.4 s"),
        (PRE_CRASH.replace("-0,5", "-1,5"), BEFORE, "times do not increase"),
        (PRE_CRASH.replace("72,0", "=B2"), BEFORE, "recorder.speed.impact: recorded from"),
        (PULSE, AFTER.replace('ended = "early"\n', ""), "recorder.delta_v.ended: missing"),
        (PULSE, AFTER + '[impact_point]\npoint = 1\nuncertainty = "1 m"\n', "points are taken of"),
        (PULSE.replace("-22", "-2200"), AFTER.replace('"last"', '"0.1 s"'), "not plausible"),
        ("time;speed\n", BEFORE, "the header has no such column"),
        (PRE_CRASH.split("\n")[0], BEFORE, "no row has a time and a number"),
    ],
)
def test_what_a_recorder_does_not_say_is_refused(
    tmp_path: Path, content: str, map_text: str, said: str
) -> None:
    assert said in refusal(tmp_path, content, map_text)


def test_a_long_record_can_be_read_again(tmp_path: Path) -> None:
    """200 speeds, in lines that a scene file may have."""
    rows = "".join(f"{-2 + i / 100:.2f};{72 - i / 20:.4f};;0\n" for i in range(200))
    whole = BEFORE.replace('["-0.6 s", "-0.1 s"]', '["-2 s", "-0.01 s"]').replace(
        'decimal = ","', 'decimal = "."'
    )
    found = imported(tmp_path, PRE_CRASH.split("\n")[0] + "\n" + rows, whole)
    record = found.scene.approach["a"].record
    assert record is not None
    assert len(record.times) == 200
    for text in (found.text, scene_toml(found.scene)):
        assert parse_scene(text, "again").approach["a"].record == record


def test_one_import_after_another(tmp_path: Path) -> None:
    """A scene file that was imported into takes the next."""
    first = imported(tmp_path, PRE_CRASH, BEFORE)
    (tmp_path / "scene.toml").write_text(first.text, "utf-8")
    (tmp_path / "pulse.csv").write_text(PULSE, "utf-8")
    (tmp_path / "pulse.toml").write_text("schema = 1\n" + AFTER, "utf-8")
    scene = import_evidence(
        tmp_path / "pulse.csv", tmp_path / "pulse.toml", tmp_path / "scene.toml"
    ).scene
    assert scene.approach["a"].record is not None
    assert scene.departure["b"]
    assert scene.rest == PAPER.rest


def test_a_unit_that_is_not_the_header_s_is_refused(tmp_path: Path) -> None:
    said = refusal(tmp_path, PRE_CRASH, BEFORE.replace('speed = "km/h"', 'speed = "mph"'))
    assert 'column Speed (km/h): its header says "km/h"' in said
    assert 'write speed = "km/h"' in said


def test_first_and_last_sample_are_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    print_import(imported(tmp_path, PRE_CRASH, BEFORE), Console(width=200))
    assert "3 times and speeds: 20 m/s at -1 s to 15 m/s at 0 s" in capsys.readouterr().out


def test_a_scene_that_is_not_complete_yet_takes_evidence(tmp_path: Path) -> None:
    """What was missing before is said, and anything that the import would make wrong is refused."""
    text = "\n".join(
        line for line in PAPER.text.splitlines() if not line.startswith("contact_line")
    )
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    (tmp_path / "points.csv").write_text(PRE_CRASH, encoding="utf-8")
    (tmp_path / "map.toml").write_text("schema = 1\n" + BEFORE, encoding="utf-8")
    found = import_evidence(*(tmp_path / name for name in ("points.csv", "map.toml", "scene.toml")))
    assert found.scene is None
    assert any("speed_record" in taken.key for taken in found.taken)
    assert found.left[-1].startswith("the scene is not complete yet: impact.contact_line: missing")
    assert "speed_record" in found.text
