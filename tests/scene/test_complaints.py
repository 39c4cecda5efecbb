"""Scene files that are wrong: each problem is one line with file, key, value and fix."""

from __future__ import annotations

import os
import pickle
from pathlib import Path

import pytest

from retrodict.scene import SceneError, load_scene, parse_scene
from tests.shared.scene_file import OIL, SCENE, changed, stripped, without

EXAMPLES = Path(__file__).parents[2] / "examples"
A, B = "vehicles.A", "vehicles.B"
EDGE = 'edge = { point = ["0 m", "4 m"], direction = "9 deg", side = "right" }'
NAN_HEADING = '{ value = nan, sd = 2, unit = "deg" }'

# what is written instead of what; the key, the value and the fix that the line must hold
WRONG = [
    # units
    ('"1857 ± 37 kg"', '"1857"', f"{A}.mass", '"1857"', 'write "1857 kg"'),
    ('"1857 ± 37 kg"', "1857", f"{A}.mass", "1857", 'write "1857 kg"'),
    ('"1857 ± 37 kg"', '"1857 bricks"', f"{A}.mass", '"1857 bricks"', "kg or lb"),
    ('"1857 ± 37 kg"', '"4094 lbf"', f"{A}.mass", '"4094 lbf"', 'pounds of mass are "lb"'),
    ('"1857 ± 37 kg"', "{ value = 9 }", f"{A}.mass", "{value = 9}", 'add unit = "kg"'),
    ('"45 ± 2 mph"', '"45 ± 2 kg"', f"{A}.approach.speed", '"45 ± 2 kg"', "m/s, km/h, mph or ft/s"),
    ('"45 ± 2 mph"', '"45 ± 2 MHP"', f"{A}.approach.speed", "MHP", 'did you mean "mph"'),
    ('"45 ± 2 mph"', '"20 degC"', f"{A}.approach.speed", '"20 degC"', "does not measure a speed"),
    ('"0.50 ± 0.03"', '"0.50 ± 0.03 m"', "surfaces.road.friction", "m", "without a unit"),
    # wrong types and malformed text
    ('"1857 ± 37 kg"', "true", f"{A}.mass", "true", 'like "1857 ± 37 kg"'),
    ('"1857 ± 37 kg"', "[1857]", f"{A}.mass", "[1857]", 'like "1857 ± 37 kg"'),
    ('"1857 ± 37 kg"', "2020-01-01", f"{A}.mass", "2020-01-01", 'like "1857 ± 37 kg"'),
    ('"1857 ± 37 kg"', '"about a ton"', f"{A}.mass", '"about a ton"', 'like "1857 ± 37 kg"'),
    ('"1.54 m"', '"1,54 m"', f"{A}.track", '"1,54 m"', "decimal point"),
    ('title = "Two cars on a bend"', "title = 3", "title", "3", "text in quotes"),
    ('title = "Two cars on a bend"', 'title = ""', "title", '""', "text in quotes"),
    ('title = "Two cars on a bend"', 'title = "a\\u001b[2J"', "title", "\\x1b[2J", "one line"),
    ('notes = ["a remark", "another"]', 'notes = "one"', "notes", '"one"', 'notes = ["one remark"'),
    ('notes = ["a remark", "another"]', "notes = [3]", "notes[0]", "3", "text in quotes"),
    ('["6.1 m", "-9 m"]', '"6.1 m"', f"{B}.rest.position", '"6.1 m"', 'position = ["-5.1'),
    ('["6.1 m", "-9 m"]', '["6.1 m"]', f"{B}.rest.position", "", 'position = ["-5.1'),
    ('["6.1 m", "-9 m"]', '["6 m", "9"]', f"{B}.rest.position[1]", '"9"', 'write "9 m"'),
    ('["6.1 m", "-9 m"]', '["6 m", "9 m", "1 m"]', f"{B}.rest.position", "[", "position = ["),
    ('side = "left"', 'side = "up"', "surfaces.berm.edge.side", '"up"', '"left" or "right"'),
    ("schema = 1", "schema = 2", "schema", "2", "write schema = 1"),
    ("schema = 1", "schema = true", "schema", "true", "write schema = 1"),
    ("schema = 1", 'schema = "1"', "schema", '"1"', "write schema = 1"),
    # keys
    ("mass =", "mas =", f"{A}.mas", "1857", 'did you mean "mass"'),
    ("mass =", "weight =", f"{A}.weight", "1857", 'did you mean "mass"'),
    ("contact_line", "Gamma", "impact.Gamma", "-8.9", 'did you mean "contact_line"'),
    ("contact_line", "gamma", "impact.gamma", "-8.9", 'did you mean "contact_line"'),
    ("impact_centre", "impact_center", f"{A}.impact_center", "{", 'did you mean "impact_centre"'),
    ("length =", "colour =", f"{A}.colour", '"5.2 m"', "leave it out (known here: name, class, mass"),
    ("length =", "skid =", f"{A}.skid", '"5.2 m"', "belongs in [vehicles.A.approach]"),
    ("length =", "friction =", f"{A}.friction", '"5.2 m"', "belongs in [surfaces.NAME]"),
    ("mass = ", "mass = “1857 kg” #", "line 9, column 8", '"mass = ', "typographic quotes"),
    ("mass = ", "mass = 0,72 #", "line 9, column 9", '"mass = ', "decimal point"),
    ("mass = ", "mass = –5 #", "line 9, column 8", '"mass = ', "a minus sign"),
    ("friction =", "mu =", "surfaces.berm.mu", "0.40", 'did you mean "friction"'),
    ('mass = "1778 kg"', 'mas = "1778 kg"', f"{B}.mas", '"1778 kg"', 'did you mean "mass"'),
    ("[vehicles.B]", "[vehicles.C]\n[vehicles.B]", "vehicles.C", "{}", "known here: A, B"),
    ("[vehicles.B]", "[vehicles.a]\n[vehicles.B]", "vehicles.a", "{}", "keep either A or a"),
    ("[vehicles.B]", "[vehicles.B.approach]\nspeed = 3\n[vehicles.B]",
     f"{B}.approach.speed", "3", 'write "3 m/s"'),
    ('"1778 kg"', '{ value = 1, unit = "kg", std = 3 }', f"{B}.mass.std", "3", 'did you mean "sd"'),
    ("[surfaces.road]", "[surfaces.Road]", "surfaces.Road", '"Road"', "lower case"),
    ("[surfaces.road]", '[surfaces."a b"]', "surfaces.a b", '"a b"', "lower case"),
    ("[surfaces.road]", '[surfaces."é"]', "surfaces.é", '"é"', "lower case"),
    # bounds
    ('"1857 ± 37 kg"', '"1e9 kg"', f"{A}.mass", '"1e9 kg"', "between 50 and 100000 kg"),
    ('"1857 ± 37 kg"', '"-1857 kg"', f"{A}.mass", '"-1857 kg"', "between 50 and 100000 kg"),
    ('"1857 ± 37 kg"', '"0 kg"', f"{A}.mass", '"0 kg"', "between 50 and 100000 kg"),
    ('"45 ± 2 mph"', '"1000 ± 2 m/s"', f"{A}.approach.speed", "1000", "between 0 and 150 m/s"),
    ('"45 ± 2 mph"', '"-5 ± 2 mph"', f"{A}.approach.speed", "-5", "between 0 and 335.5 mph"),
    ('"1.54 m"', '"-1.54 m"', f"{A}.track", '"-1.54 m"', "between 0.2 and 5 m"),
    ('"0.50 ± 0.03"', '"1.6 ± 0.03"', "surfaces.road.friction", "1.6", "between 0.01 and 1.5"),
    ('"0.50 ± 0.03"', '"0 ± 0.03"', "surfaces.road.friction", "0 ±", "between 0.01 and 1.5"),
    ('"6.1 m"', '"503112 m"', f"{B}.rest.position[0]", "503112", "origin near the impact"),
    ('"-12 deg"', '"708 deg"', f"{B}.rest.heading", "708", "whole turns go into rotation"),
    # uncertainties
    ('"45 ± 2 mph"', '"45 mph"', f"{A}.approach.speed", '"45 mph"', 'like "45 ± 2 mph"'),
    ('"0.50 ± 0.03"', "0.5", "surfaces.road.friction", "0.5", 'like "0.50 ± 0.03"'),
    ('"-8.9 ± 3 deg"', '"-8.9 deg"', "impact.contact_line", '"-8.9 deg"', 'like "-8.9 ± 3 deg"'),
    ('"45 ± 2 mph"', '"45 ± 0 mph"', f"{A}.approach.speed", '"45 ± 0 mph"', "above 0"),
    ('"45 ± 2 mph"', '"45 ± -2 mph"', f"{A}.approach.speed", '"45 ± -2 mph"', "above 0"),
    ('"45 ± 2 mph"', '"45 ± 2e4 mph"', f"{A}.approach.speed", "2e4", "plausible uncertainty"),
    ('"45 ± 2 mph"', '"45 ± 1e-320 mph"', f"{A}.approach.speed", "e-320", "plausible uncertainty"),
    ('"1857 ± 37 kg"', '"1857 ± 1900 kg"', f"{A}.mass", "1900", "over 100 %"),
    ('"2.09 ± 0.05 m"', '"0.05 m"', f"{A}.impact_centre.distance", '"0.05 m"', "over 100 %"),
    ('"180 ± 2 deg"', NAN_HEADING, f"{A}.impact.heading", "nan", "finite"),
    ('"35 deg"', '"35 ± 3 deg"', f"{A}.rest.rotation", "35 ± 3", 'like "35 deg"'),
    ('"5.2 m"', '"5.2 ± 0.1 m"', f"{A}.length", "5.2 ± 0.1", 'like "5.2 m"'),
    ('["0 m", "4 m"]', '["0 m", "4 ± 1 m"]', "surfaces.berm.edge.point[1]", "4 ± 1",
     "goes into its key uncertainty"),
    ('"1778 kg"', '{ value = 1, unit = "kg", "a.b" = 3 }', f"{B}.mass.a.b", "3", "unknown"),
    # the question
    ('["mu", "speed_b"]', '"mu"', "question", '"mu"', 'like ["speed_b"]'),
    ('["mu", "speed_b"]', "[]", "question", "[]", 'like ["speed_b"]'),
    ('["mu", "speed_b"]', '["speed"]', "question", '"speed"', 'cannot be asked; write one or more'),
    ('["mu", "speed_b"]', "[[1]]", "question", "[", "cannot be asked; write one or more"),
    # what is known before and after the impact
    ('errors = "robust"', 'errors = "some"', "errors", '"some"', 'write errors = "robust", or "normal"'),
    ('"12 ± 0.4 m"', '"12"', f"{A}.approach.skid", '"12"', 'write "12 m"'),
    ('"12 ± 0.4 m"', '"0 m"', f"{A}.approach.skid", '"0 m"', "between 0.1 and 500 m"),
    ('"12 ± 0.4 m"', '"0.3 m"', f"{A}.approach.skid", '"0.3 m"', "default uncertainty is over 100 %"),
    (
        *('skid = "12 ± 0.4 m"', "skid_braking = 0.7", f"{A}.approach.skid_braking", "0.7"),
        "it says something of skid alone; leave it out, or add skid",
    ),
    ('rotation = "35 deg"', 'skid = "3 m"', f"{A}.rest.skid", '"3 m"', "known here: position, distance"),
    ('heading = "215 ± 3 deg"', "", f"{A}.rest.rotation", '"35 deg"', 'or write heading = "215 ± 3'),
    ('"30 ± 2 mph"', '"30 mph"', f"{B}.departure.delta_v", '"30 mph"', 'like "12 ± 1 m/s"'),
    ('"30 ± 2 mph"', '"-30 ± 2 mph"', f"{B}.departure.delta_v", "-30", "between 0 and 335.5 mph"),
    ('"-13 ± 1 m/s"', '"-13 m/s"', f"{A}.departure.delta_v_forward", "-13", 'like "-12 ± 1 m/s"'),
    ('"5 ± 1 m/s"', '"5 m/s"', f"{A}.departure.speed", '"5 m/s"', 'like "45 ± 2 mph"'),
    ('"35 ± 5 deg/s"', '"35 deg/s"', f"{A}.departure.yaw_rate", "35", 'like "35 ± 5 deg/s"'),
    ('delta_v = "30 ± 2 mph"', "", f"{B}.departure", "{}", "write one or more of direction, speed"),
    ('delta_v_left = "-2 ± 1 m/s"', 'delta_v = "13 ± 1 m/s"', f"{A}.departure.delta_v", '"13 ± 1 m/s"',
     "the same measurement twice"),
    ("delta_v_left", "delta_v_right", f"{A}.departure.delta_v_right", "-2", "did you mean"),
    ('["-2 m", "0.5 m"]', '["-2 m"]', f"{A}.marks[0].point", "", 'write point = ["3 m", "1 m"]'),
    ('["-2 m", "0.5 m"]', '["-2 m", "5"]', f"{A}.marks[0].point[1]", '"5"', 'write "5 m"'),
    ('["-2 m", "0.5 m"]', '["-2 m", "5 ± 1 m"]', f"{A}.marks[0].point[1]", "5 ±",
     "goes into its key uncertainty"),
    ('point = ["-2 m", "0.5 m"],', "", f"{A}.marks[0].point", "", 'missing; write point = ["3 m"'),
    ('"front_left", unc', '"bumper", unc', f"{A}.marks[0].of", '"bumper"', 'or a wheel: "front_left"'),
    ('"0.2 m", speed', '"0.2 ± 0.1 m", speed', f"{A}.marks[0].uncertainty", "0.2 ±", 'like "0.2 m"'),
    ('of = "front_left"', 'off = "front_left"', f"{A}.marks[0].off", "front_left", 'did you mean "of"'),
    ("marks = [", "marks = [] \nmark = [", f"{A}.mark", "[{", 'did you mean "marks"'),
    ("marks = [", "marks = 3\nnotes = [", f"{A}.marks", "3", "write marks = [{ point ="),
    ("marks = [", "marks = [3,", f"{A}.marks[0]", "3", "write marks = [{ point ="),
    ("marks = [", "marks = [" + 49 * "{},", f"{A}.marks", "[{…}", "51 marks; write at most 50"),
    ('"4 ± 1 m/s"', '"4 m/s"', f"{A}.marks[0].speed", '"4 m/s"', 'like "45 ± 2 mph"'),
    ('"4 ± 1 m/s"', '"-4 ± 1 m/s"', f"{A}.marks[0].speed", "-4", "between 0 and 150 m/s"),
    ('course = "170', 'direction = "170', f"{A}.marks[1].direction", "170", 'did you mean "course"'),
    ('"170 ± 4 deg"', '"170 ± 4"', f"{A}.marks[1].course", '"170 ± 4"', 'write "170 ± 4 deg"'),
    ('"-4 ± 0.5 m"', '"-4 m"', f"{A}.end_of_rotation.x", '"-4 m"', 'like "3 ± 0.5 m"'),
    ('"-4 ± 0.5 m"', '"4000 ± 1 m"', f"{A}.end_of_rotation.x", "4000", "between -1000 and 1000 m"),
    ('"200 ± 5 deg"', '"200 deg"', f"{A}.end_of_rotation.heading", '"200 deg"', 'like "20 ± 5 deg"'),
    ('{ x = "-4 ± 0.5 m", y = "1.5 ± 0.4 m", heading = "200 ± 5 deg" }', "{}",
     f"{A}.end_of_rotation", "{}", "is empty; write one or more of x, y, heading"),
    ('{ x = "-4 ± 0.5 m",', '{ position = "3 m",', f"{A}.end_of_rotation.position", '"3 m"',
     "known here: x, y, heading"),
    ("end_of_rotation = {", "end_of_rotation = 3 #", f"{A}.end_of_rotation", "3",
     "write end_of_rotation = { x ="),
    # wheels and grip
    ('"1.02 ± 0.04"', '"5 ± 0.04"', f"{A}.grip", "5", "between 0.2 and 2"),
    ('front_left = "locked"', 'front_left = "lockt"', f"{A}.wheels.front_left", "lockt", '"rolling"'),
    ('front_left = "locked"', "front_left = 1.2", f"{A}.wheels.front_left", "1.2", "between 0 and 1"),
    ('front_left = "locked"', "left = 1", f"{A}.wheels.left", "1", 'did you mean "rear_left"'),
    ('front_left = "locked"', "", f"{A}.wheels.front_left", "", 'write front_left = "locked"'),
    ('"0.3 ± 0.1"', '"0.3 ± 0.22"', f"{A}.wheels.rear_left", "0.22", 'like "0.3 ± 0.1"'),
    ('"0.3 ± 0.1"', '"1 ± 0.1"', f"{A}.wheels.rear_left", "1 ±", "value (1 - value)"),
    ('"0.3 ± 0.1"', '"0.3 m"', f"{A}.wheels.rear_left", "m", "without a unit"),
    ('mass = "1778 kg"', 'mass = "1778 kg"\nwheels = "free"', f"{B}.wheels", '"free"',
     'write "locked", or each wheel: wheels = {'),
    ('mass = "1778 kg"', 'mass = "1778 kg"\nsteer = "2 deg"', f"{B}.steer", '"2 deg"',
     "locked wheels do not steer"),
    ('mass = "1778 kg"', 'mass = "1778 kg"\ndrag_factor = "1 ± 0.3"', f"{B}.drag_factor",
     '"1 ± 0.3"', "locked wheels stay locked"),
    ("steer =", 'run_out_error = { position = "4 ± 1 %" }\nsteer =', f"{A}.run_out_error.position",
     "4 ± 1 %", "one standard deviation"),
    ("steer =", 'run_out_error = { position = 4 }\nsteer =', f"{A}.run_out_error.position", "4",
     'write "4 %"'),
    ("steer =", 'run_out_error = { yaw = "4 deg" }\nsteer =', f"{A}.run_out_error.yaw", '"4 deg"',
     "known here: position, heading"),
    ('"3 ± 2 deg"', '"3 ± 2"', f"{A}.steer", '"3 ± 2"', "deg"),
    # kinds of surface
    ('"dry asphalt"', '"tarmac"', "surfaces.road.kind", '"tarmac"', '"wet asphalt"'),
    ('"dry asphalt"', "[1]", "surfaces.road.kind", "[1]", '"wet asphalt"'),
    # priors
    ('"40 mph"', '"40"', "priors.speed_b.scale", '"40"', 'write "40 m/s"'),
    ('"40 mph"', '"40 ± 1 mph"', "priors.speed_b.scale", "40 ±", "no uncertainty is used here"),
    ('"40 mph"', '"400 m/s"', "priors.speed_b.scale", "400", "between 0.1 and 150 m/s"),
    ('scale = "40 mph"', "", "priors.speed_b.scale", "", 'write scale = "40 m/s"'),
    ('source = "a survey"', "", "priors.speed_b.source", "", "missing; write source ="),
    ("[priors.speed_b]", "[priors.speed]", "priors.speed", "{", 'did you mean "speed_b"'),
    ('"50 mph"', '"50"', "priors.speed_a.scale", '"50"', 'write "50 m/s"'),
    ('fast = 0.2\nslow = 0.6\nover = "12 mph"', "", "priors.e", "{", "write one or more of fast"),
    ("fast =", "top =", "priors.e.top", "0.2", "known here: source, fast, slow, over"),
    ("[priors.speed_b]", "[priors]\nmu = 1\n[priors.speed_b]", "priors.mu", "1", "write mu = { scale"),
    # contradictions
    ('"2.85 m"', '"3.85 m"', f"{A}.wheelbase", '"3.85 m"', "add up to 2.85 m"),
    ('"35 deg"', '"200 deg"', f"{A}.rest.rotation", '"200 deg"', "differ by 35 deg"),
    ('"2.09 ± 0.05 m"', '"4 ± 0.05 m"', f"{A}.impact_centre.distance", "4 ±", "at most 3.251 m"),
    ('"2.09 ± 0.05 m"', '"14 ± 0.2 ft"', f"{A}.impact_centre.distance", "14 ±", "at most 10.67 ft"),
    ('"2.09 ± 0.05 m"', '"900 ft"', f"{A}.impact_centre.distance", "900", "ft"),
    ('"5.2 m"', '"2 m"', f"{A}.length", '"2 m"', "shorter than the wheelbase of 2.85 m"),
    ('"1.35 m"\ncg_to_rear_axle = "1.50 m"', '"2.84 m"',
     f"{A}.wheelbase", '"2.85 m"', "write one above 2.84 m"),
    ("edge = {", "# {", "surfaces", "{", "berm, road have none"),
    ("[surfaces.road]\n", f"[surfaces.verge]\n{EDGE}\n", "surfaces", "{", "here none is without"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "key", "value", "fix"), WRONG)
def test_a_problem_names_file_key_value_and_fix(old, new, key, value, fix):
    with pytest.raises(SceneError) as caught:
        parse_scene(changed((old, new)), "bend.toml")
    lines = str(caught.value).splitlines()
    said = f"bend.toml: {key} = " if value else f"bend.toml: {key}: "
    line = next((line for line in lines if line.startswith(said)), None)
    assert line is not None, lines
    assert value in line
    assert fix in line


OUTLINE = '[["3 m", "-5 m"], ["7 m", "-6 m"], ["8 m", "-3 m"]]'
_SQUARE = '[["0 m", "0 m"], ["2 m", "0 m"], ["2 m", "2 m"], ["0 m", "2 m"]'
_TWO = '["3 m", "-5 m"], ["7 m", "-6 m"]'
CORNERS = "surfaces.oil.outline.corners"

# of an outline: what is written in the place of what; the key, and the fix
WRONG_OUTLINES = [
    (OUTLINE, f"[{_TWO}]", CORNERS, "an outline of 2 corners; write 3 to 100"),
    (OUTLINE, f"[{', '.join([_TWO] * 51)}]", CORNERS, "an outline of 102 corners; write 3 to 100"),
    (OUTLINE, '"a square"', CORNERS, 'write corners = [["2 m", "-3 m"], '),
    (OUTLINE, f"{_SQUARE}, [0, 0]]", f"{CORNERS}[4][0]", 'write "0 m"'),
    (OUTLINE, f'{_SQUARE}, ["0 m", "0 m"]]', CORNERS, "corner 5 is corner 1 again; write each once"),
    (OUTLINE, f'{_SQUARE}, ["3 m", "1 m"]]', CORNERS,
     "sides from corner 2 to 3 and from corner 4 to 5 meet; write the corners in order"),
    (OUTLINE, f'{_SQUARE}, ["1 m", "0 m"]]', CORNERS, "from corner 1 to 2 and from corner 4 to 5 meet"),
    (OUTLINE, '[["0 m", "0 m"], ["1 m", "1 m"], ["3 m", "3 m"]]', CORNERS, "meet"),
    (OUTLINE, '[["0 m", "0 m"], ["1 m", "0 m"], ["1 m", "1 mm"]]', CORNERS, "less than 0.01 m²"),
    ('"7 m"', '"7 ± 1 m"', f"{CORNERS}[1][0]", "goes into its key uncertainty"),
    ('"7 m"', '"1700 m"', f"{CORNERS}[1][0]", "between -1000 and 1000 m"),
    ('uncertainty = "0.2 m"', 'uncertainty = "0 m"', "surfaces.oil.outline.uncertainty", "0.0001"),
    ("corners =", "points =", "surfaces.oil.outline.points", "known here: corners, uncertainty"),
    ("outline =", f"{EDGE}\noutline =", "surfaces.oil.outline", "ends twice; keep it, or edge"),
    ("outline =", "# ", "surfaces", "write an edge or outline for every surface but one, the road"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "key", "fix"), WRONG_OUTLINES)
def test_a_problem_of_an_outline_names_key_and_fix(old, new, key, fix):
    assert old in OIL
    with pytest.raises(SceneError) as caught:
        parse_scene(SCENE + OIL.replace(old, new, 1), "bend.toml")
    lines = str(caught.value).splitlines()
    found = [
        line for line in lines if line.startswith((f"bend.toml: {key} = ", f"bend.toml: {key}: "))
    ]
    assert len(found) == 1, lines
    assert fix in found[0]


REQUIRED = [
    ("schema", "schema: missing; write schema = 1"),
    ("title", 'title: missing; write title = "Two cars'),
    ("mass", f'{A}.mass: missing; write mass = "1857 ± 37 kg"'),
    ("track", f'{A}.track: missing; write track = "1.54 m"'),
    ('heading = "180', f'{A}.impact.heading: missing; write heading = "180 ± 2 deg"'),
    ("position", f"{A}.rest.position: missing; write position = ["),
    ("point", "impact.point: missing; write point = ["),
    ("friction", 'surfaces.berm.friction: missing; write friction = "0.50 ± 0.03"'),
]


@pytest.mark.parametrize(("start", "line"), REQUIRED)
def test_a_missing_key_says_what_to_write(start, line):
    with pytest.raises(SceneError) as caught:
        parse_scene(without(start), "bend.toml")
    assert f"bend.toml: {line}" in str(caught.value)


def test_missing_tables_say_what_to_write():
    with pytest.raises(SceneError) as caught:
        parse_scene('schema = 1\ntitle = "t"\n[vehicles.A]\nmass = "1 t"\n', "bend")
    said = str(caught.value)
    for key in (f"{A}.impact", "vehicles.B"):
        assert f"bend: {key}: missing; write " in said


def test_a_scene_without_evidence_after_the_impact_says_what_to_write():
    with pytest.raises(SceneError) as caught:
        parse_scene(stripped(), "bend")
    (line,) = str(caught.value).splitlines()
    assert line.startswith("bend: vehicles = {")
    assert "write rest = { position = [" in line
    assert line.endswith(", departure, marks or end_of_rotation of one")


@pytest.mark.parametrize(
    ("written", "needed"),
    [
        ('rest = { position = ["1 m", "2 m"] }', True),
        ('marks = [{ point = ["1 m", "2 m"] }]', True),
        ('end_of_rotation = { x = "3 ± 1 m" }', True),
        ('departure = { speed = "3 ± 1 m/s" }\napproach = { skid = "9 m" }', True),
        ('departure = { speed = "3 ± 1 m/s" }', False),
    ],
)
def test_surfaces_are_needed_where_something_slid(written, needed):
    text = stripped(written)
    if needed:
        with pytest.raises(SceneError) as caught:
            parse_scene(text, "bend")
        assert str(caught.value) == (
            'bend: surfaces: missing; write surfaces = { road = { friction = "0.50 ± 0.03" } }'
        )
    else:
        assert parse_scene(text, "bend").surfaces


def test_every_problem_has_its_line():
    text = changed(('"1857 ± 37 kg"', '"1857"'), ("contact_line", "gamma"), ('"left"', '"up"'))
    with pytest.raises(SceneError) as caught:
        parse_scene(text, "bend")
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {f"{A}.mass", "impact.gamma", "surfaces.berm.edge.side"}
    assert len(str(caught.value).splitlines()) == 3


def test_many_problems_are_cut_short():
    text = "\n".join(f"k{i} = {i}" for i in range(200)) + "\n" + SCENE
    with pytest.raises(SceneError) as caught:
        parse_scene(text, "bend")
    lines = str(caught.value).splitlines()
    assert len(lines) < 40
    assert "170 problems more" in lines[-1]


def test_a_long_or_hostile_value_is_clipped_and_escaped():
    for hostile in ("x" * 500, "\\u001b[31m" * 50, "\\n" * 500):
        with pytest.raises(SceneError) as caught:
            parse_scene(changed(('"1857 ± 37 kg"', f'"{hostile}"')), "bend")
        (line,) = str(caught.value).split("\n")
        assert line.isprintable()
        assert len(line) < 200


TOML = [
    ('"1857 ± 37 kg"', "1857 kg", "line 9, column 13 = ", '"mass = 1857 kg"', "stand in quotes"),
    ("[surfaces.berm]", "[surfaces.road]\n[surfaces.road]", "line 74", "surfaces.road", "once"),
    ("track =", 'mass = "3 kg"\ntrack =', "line 14", "mass", "once"),
    ("schema = 1", "schema = " + "9" * 5000, "line 1 = ", "schema = 9", "2000 characters"),
    ("schema = 1", "schema = [\n" + "9" * 1999 + "]", "schema", "[a whole", "write schema = 1"),
    ("schema = 1", "schema = " + "[" * 1500 + "]" * 400, "", "", "nested too deeply"),
    ("schema = 1", "schema = 0x" + "f" * 1900, "schema", "a whole number", "write schema = 1"),
    ("schema = 1", "a" + ".a" * 900 + " = 1", "a = {a = {…}}", "", "unknown key"),
    ("schema = 1", "#\x00", "line 1", "#\\x00", "not valid TOML"),
    ("title", "#" * 100_000 + "\ntitle", "", "", "longer than 100000 bytes"),
]


@pytest.mark.parametrize(("old", "new", "key", "value", "fix"), TOML)
def test_broken_toml_names_its_place(old, new, key, value, fix):
    with pytest.raises(SceneError) as caught:
        parse_scene(changed((old, new)), "bend")
    line = next(line for line in str(caught.value).splitlines() if fix in line)
    assert line.startswith(f"bend: {key}")
    assert value in line


def test_files_that_cannot_be_read_are_problems_too(tmp_path):
    latin = tmp_path / "latin.toml"
    latin.write_bytes(SCENE.encode("latin-1"))
    huge = tmp_path / "huge.toml"
    huge.write_bytes(b"#" + "é".encode() * 60_000)
    cases = [
        (tmp_path / "none.toml", "no such file"),
        (tmp_path, "is a folder"),
        (latin, "line 9 is not UTF-8"),
        (huge, "longer than"),
        ("\0", "write the path"),
        ("x" * 5000, "path"),
        ("/dev/zero", "not a file"),
    ]
    if os.geteuid() != 0:  # root reads everything
        secret = tmp_path / "secret.toml"
        secret.write_text(SCENE)
        secret.chmod(0)
        cases.append((secret, "cannot be read"))
    for path, fix in cases:
        with pytest.raises(SceneError) as caught:
            load_scene(path)
        assert fix in str(caught.value)
        assert str(path)[:20].replace("\0", "\\x00") in str(caught.value)
        assert str(caught.value).isprintable()


def test_the_error_survives_pickling():
    with pytest.raises(SceneError) as caught:
        parse_scene("", "bend")
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_rest_poses_that_were_exchanged_are_named() -> None:
    text = (EXAMPLES / "brach-1977" / "scene.toml").read_text()
    exchanged = text.replace("A.rest]", "?.rest]").replace("B.rest]", "A.rest]")
    with pytest.raises(
        SceneError, match=r"vehicles\.A\.rest\.position = .*seem exchanged"
    ) as caught:
        parse_scene(exchanged.replace("?.rest]", "B.rest]"), "exchanged.toml")
    assert "vehicles.A.rest.rotation" in str(caught.value)  # and the contradiction itself
