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
    assert found.left == ('delta_v_forward, row 5: no value ("N/A")',)


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


# as copied from the report of a retrieval tool (invented)
REPORT = """\
Event Data Recorder Report
VIN: 1XXXX00XXXX000000,, Event Record 1 (Most Recent Event)
System Status at Event (Event Record 1)
Complete File Recorded,Yes
Pre-Crash Data (Event Record 1)
Times (sec),"Speed, Vehicle Indicated (MPH [km/h])",Service Brake,Yaw Rate (deg/s)
-1.0,45 [72],Off,SNA
-0.5,44 [70],On,-2.0
0.0,34 [54],On,Invalid
Deceleration (Event Record 1)
Times (msec),Longitudinal Delta-V (MPH [km/h])
0,0.0 [0.0]
50,-12.5 [-20.1]
Pre-Crash Data (Event Record 2)
Times (sec),"Speed, Vehicle Indicated (MPH [km/h])",Service Brake,Yaw Rate (deg/s)
-1.0,5 [8],Off,SNA
0.0,0 [0],On,SNA
"""
OF_REPORT = """
[recorder]
vehicle = "A"
columns = { time = "Times (sec)", speed = "Speed, Vehicle Indicated (MPH [km/h])" }
units = { time = "s", speed = "km/h" }
below = "pre-crash data (event record 1)"
[recorder.speed]
impact = "-0.5 s"
uncertainty = "1 km/h"
"""


@pytest.mark.parametrize(
    ("unit", "speed"), [("km/h", 70 / 3.6), ("mph", 44 * 0.44704), ("m/s", None)]
)
def test_of_two_units_in_a_heading_the_map_s_is_taken(
    tmp_path: Path, unit: str, speed: float | None
) -> None:
    asked = OF_REPORT.replace('speed = "km/h"', f'speed = "{unit}"')
    if speed is None:
        said = refusal(tmp_path, REPORT, asked)
        assert 'its header says "MPH" and "km/h"' in said
        return
    found = imported(tmp_path, REPORT, asked)
    assert found.scene.approach["a"].speed.value == pytest.approx(speed, abs=1e-3)
    assert "rows 10 to 14: below the table" in found.left


def test_an_event_of_a_report_is_chosen_by_the_line_above_it(tmp_path: Path) -> None:
    second = OF_REPORT.replace("record 1", "record 2").replace("-0.5 s", "0 s")
    found = imported(tmp_path, REPORT, second)
    assert found.scene.approach["a"].speed.value == 0
    assert "rows 16 to 17" in found.scene.approach["a"].speed.source
    both = "\n".join(line for line in OF_REPORT.split("\n") if "below" not in line)
    assert imported(tmp_path, REPORT, both).scene.approach["a"].speed.value == pytest.approx(
        70 / 3.6, abs=1e-3
    )
    no_pulse = REPORT[: REPORT.index("Deceleration")] + REPORT[REPORT.rindex("Times (sec),") :]
    assert "times do not increase" in refusal(tmp_path, no_pulse, both)


def test_two_numbers_that_are_not_one_value_are_left(tmp_path: Path) -> None:
    wrong = REPORT.replace("44 [70]", "44 [80]")
    found = imported(tmp_path, wrong, OF_REPORT)
    assert found.scene.approach["a"].speed.value == pytest.approx((72 + 54) / 2 / 3.6, abs=1e-3)
    assert any("not one value in the two units" in line for line in found.left)


def test_cells_without_a_value_have_one_line(tmp_path: Path) -> None:
    yaw = OF_REPORT.replace("columns = {", 'columns = { yaw_rate = "Yaw Rate (deg/s)",').replace(
        "units = {", 'units = { yaw_rate = "deg/s",'
    )
    yaw += '[recorder.yaw_rate]\nat = "-0.5 s"\nto = "approach"\nuncertainty = "2 deg/s"\n'
    found = imported(tmp_path, REPORT, yaw)
    assert found.scene.approach["a"].yaw_rate.value == pytest.approx(math.radians(-2), abs=1e-4)
    assert 'yaw_rate, rows 7 to 9 (2 of them): no value ("SNA", "Invalid")' in found.left


LONG = """\
Event;Vehicle;Parameter;Time;Value;Unit
1;V1;Speed;-1;72;km/h
1;V1;Brake;-1;Off;
1;V2;Speed;-1;50;km/h
2;V1;Speed;-1;8;km/h
1;V1;Speed;0;54;km/h
1;V1;Longitudinal acceleration;0;0;g
1;V1;Longitudinal acceleration;0.05;-20;g
1;V1;Longitudinal acceleration;0.1;0;g
1;V1;Longitudinal acceleration;0.15;0;g
"""
OF_LONG = """
[recorder]
vehicle = "B"
only = { Event = 1, Vehicle = "v1" }
long = { parameter = "Parameter", value = "Value", unit = "Unit" }
columns = { time = "Time", speed = "Speed", acceleration_forward = "Longitudinal acceleration" }
units = { time = "s", speed = "km/h", acceleration_forward = "g" }
[recorder.speed]
impact = ["-0.6 s", "-0.1 s"]
uncertainty = "1 km/h"
[recorder.delta_v]
at = "end"
ended = "after the impact"
uncertainty = "1 km/h"
"""


def test_a_table_with_a_row_for_each_value(tmp_path: Path) -> None:
    found = imported(tmp_path, LONG, OF_LONG)
    record = found.scene.approach["b"].record
    assert record.times == (-1.0, 0.0)
    assert record.speeds == pytest.approx((20.0, 15.0))
    assert 'parameter "Brake": not in the map' in found.left
    assert '1 row: "Event" is not "1"' in found.left


def test_an_acceleration_is_integrated_to_the_end_of_its_pulse(tmp_path: Path) -> None:
    """A triangle of 20 g over 0.1 s: its area."""
    found = imported(tmp_path, LONG, OF_LONG)
    forward = found.scene.departure["b"]["delta_v_forward"]
    assert forward.value == pytest.approx(-20 * 9.80665 * 0.1 / 2, abs=1e-3)
    assert [t.remark for t in found.taken if "delta_v" in t.key] == ["at 0.12 s"]
    early = OF_LONG.replace('"after the impact"', '"early"')
    assert 'recorder.delta_v.at = "end"' in refusal(tmp_path, LONG, early)
    going_on = "\n".join(LONG.split("\n")[:-3]) + "\n"
    assert "the pulse has not ended: delta-v still changes by" in refusal(
        tmp_path, going_on, OF_LONG
    )


@pytest.mark.parametrize(
    ("content", "map_text", "said"),
    [
        (LONG, OF_LONG.replace("Event = 1", "Event = 3"), 'no row has "3" in it; it has "1", "2"'),
        (
            LONG,
            OF_LONG.replace('speed = "Speed"', 'speed = "Velocity"'),
            "no row has this parameter",
        ),
        (LONG, OF_LONG.replace('speed = "km/h"', 'speed = "mph"'), "its unit is not that of speed"),
        (LONG, OF_LONG.replace('"Time", speed', "4, speed"), "columns by name, or all by number"),
        (
            LONG,
            OF_LONG.replace("only = { Event = 1, Vehicle", "only = { Vehicle"),
            "do not increase",
        ),
        (
            LONG,
            OF_LONG.replace(
                'acceleration_forward = "Long',
                'delta_v_forward = "x", acceleration_forward = "Long',
            ),
            "the same twice",
        ),
    ],
)
def test_a_long_table_that_the_map_does_not_fit_is_refused(
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
    text = "\n".join(line for line in PAPER.text.splitlines() if not line.startswith("title"))
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    (tmp_path / "points.csv").write_text(PRE_CRASH, encoding="utf-8")
    (tmp_path / "map.toml").write_text("schema = 1\n" + BEFORE, encoding="utf-8")
    found = import_evidence(*(tmp_path / name for name in ("points.csv", "map.toml", "scene.toml")))
    assert found.scene is None
    assert any("speed_record" in taken.key for taken in found.taken)
    assert found.left[-1].startswith("the scene is not complete yet: title: missing")
    assert "speed_record" in found.text
