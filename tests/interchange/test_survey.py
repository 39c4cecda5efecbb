"""Survey points as CSV: whatever the convention of the file, the scene gets the same places."""

from __future__ import annotations

import codecs
import hashlib
import math
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from retrodict.cli import app
from retrodict.interchange.importing import Import, import_evidence
from retrodict.interchange.points import fitted_line, fitted_pose, posed, spots_of
from retrodict.scene import SceneError, load_scene
from retrodict.scene.records import Scene

ROOT = Path(__file__).parents[2]
SURVEY = ROOT / "examples" / "import"
PAPER = load_scene(ROOT / "examples" / "brach-1977" / "scene.toml")


def imported(folder: Path, content: str | bytes, map_text: str, name: str = "points.csv") -> Import:
    """What an import into the example's scene without evidence comes to."""
    file, map_file = folder / name, folder / "map.toml"
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    map_file.write_text("schema = 1\n" + map_text, "utf-8")
    return import_evidence(file, map_file, ROOT / "examples" / "brach-1977" / "scene.toml")


def refusal(folder: Path, content: str | bytes, map_text: str, name: str = "points.csv") -> str:
    with pytest.raises(SceneError) as refused:
        imported(folder, content, map_text, name)
    return str(refused.value)


def same_places(found: Scene, expected: Scene, within: float) -> None:
    for name in ("rest_x_a", "rest_y_a", "rest_x_b", "rest_y_b", "impact_x", "impact_y"):
        one, other = (scene.inputs() | scene.evidence() for scene in (found, expected))
        assert one[name].value == pytest.approx(other[name].value, abs=within), name


def test_the_example_makes_the_papers_scene(tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_bytes((SURVEY / "before.toml").read_bytes())
    arguments = ["import", str(SURVEY / "survey.csv"), "--map", str(SURVEY / "survey.toml")]
    done = CliRunner().invoke(app, [*arguments, "--into", str(scene)])
    assert done.exit_code == 0, done.output
    assert "hydrant" in done.output
    found = load_scene(scene)
    foot_hundredth = 0.003
    same_places(found, PAPER, foot_hundredth)
    for v in ("a", "b"):  # whole turns are those that the scene counted
        one, other = found.rest[v].heading, PAPER.rest[v].heading
        assert one is not None
        assert other is not None
        assert one.value == pytest.approx(other.value, abs=1e-3)
    edge, of_paper = found.surfaces[1].edge, PAPER.surfaces[1].edge
    assert edge is not None
    assert of_paper is not None
    assert edge.y == pytest.approx(of_paper.y, abs=foot_hundredth)
    assert edge.direction == pytest.approx(of_paper.direction, abs=1e-3)
    # all else is the paper's
    rest = {"rest_x_a", "rest_y_a", "rest_heading_a", "rest_x_b", "rest_y_b", "rest_heading_b"}
    moved = rest | {"impact_x", "impact_y", "edge_berm"}
    for name, measured in (PAPER.inputs() | PAPER.evidence()).items():
        if name not in moved:
            assert (found.inputs() | found.evidence())[name] == measured, name


def test_the_example_is_what_its_script_writes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(SURVEY)
    import make  # type: ignore[import-not-found]

    assert make.survey() == (SURVEY / "survey.csv").read_text("utf-8")
    assert make.before() == (SURVEY / "before.toml").read_text("utf-8")


def test_every_value_names_the_file_the_place_and_the_sha256(tmp_path: Path) -> None:
    text = "id,x,y\n7,1.5,2.5\n"
    found = imported(tmp_path, text, ONE)
    digest = hashlib.sha256(text.encode()).hexdigest()
    assert found.scene.contact.x.source == f"points.csv, point 7, row 2; SHA-256 {digest}"
    assert found.scene.contact.x.value == 1.5
    assert found.scene.contact.x.sd == pytest.approx(math.hypot(0.03, 0.04))


ONE = """
[survey]
unit = "m"
precision = "0.03 m"
axes = ["east", "north"]
columns = { id = "id", x = "x", y = "y" }
[impact_point]
point = 7
uncertainty = "0.04 m"
"""


def test_comments_of_the_scene_file_are_kept(tmp_path: Path) -> None:
    found = imported(tmp_path, "id,x,y\n7,1.5,2.5\n", ONE)
    old = (ROOT / "examples" / "brach-1977" / "scene.toml").read_text("utf-8")
    kept = [line for line in old.splitlines() if not line.startswith("point = ")]
    lines = iter(found.text.splitlines())
    assert [line for line in kept if line not in lines] == []  # in the same order
    assert tomllib.loads(found.text)["impact"]["point"][0]["value"] == 1.5


@pytest.mark.parametrize("layout", ["CRLF", "lower case", "dotted keys"])
def test_other_layouts_of_a_scene_file_are_kept_too(tmp_path: Path, layout: str) -> None:
    text = (SURVEY / "before.toml").read_text("utf-8")
    if layout == "CRLF":
        text = text.replace("\n", "\r\n")
    elif layout == "lower case":
        text = text.replace("vehicles.A", "vehicles.a")
    else:
        text = text.replace('[vehicles.A.rest]\nrotation = "38 deg"\n', "")
        text = text.replace("[vehicles.A]\n", '[vehicles.A]\nrest.rotation = "38 deg"\n')
    scene = tmp_path / "scene.toml"
    scene.write_bytes(text.encode())
    found = import_evidence(SURVEY / "survey.csv", SURVEY / "survey.toml", scene)
    assert not [line for line in found.left if "comments" in line]
    assert found.text.startswith("# The collision of Brach")
    assert found.scene.rest["a"].turns_known


# the same three points in files of different conventions: (2, 1), (3, -1), (0.4, 0.3)
CONVENTIONS = {
    "BOM, semicolons, decimal commas": (
        codecs.BOM_UTF8 + b"id;x;y\r\n7;2,0;1,0\r\n8;3,0;-1\r\n9;0,4;0,3\r\n",
        'unit = "m"\naxes = ["east", "north"]\ndecimal = ","',
    ),
    "Windows-1252, two lines above the header": (
        (
            "Vermessung Süd, Straße 7\nBüro;Müller\n\n"
            "id;x;y;Höhe\n7;2,0;1,0;1\n8;3,0;-1;1\n9;0,4;0,3;1\n"
        ).encode("cp1252"),
        'unit = "m"\naxes = ["east", "north"]\ndecimal = ","',
    ),
    "Mac Roman, as the map says": (
        "id,x,y,repère\n7,2,1,a\n8,3,-1,b\n9,.4,.3,é\n".encode("mac-roman"),
        'unit = "m"\naxes = ["east", "north"]\nencoding = "mac-roman"',
    ),
    "columns between bars": (
        b"| id | x | y |\n|----|---|---|\n| 7 | 2 | 1 |\n| 8 | 3 | -1 |\n| 9 | 0.4 | 0.3 |\n",
        'unit = "m"\naxes = ["east", "north"]\nseparator = "|"',
    ),
    "columns between blanks": (
        b" id    x     y  what it is\n 7   2.0   1.0  skid begins\n 8   3.0  -1.0  skid ends\n"
        b" 9   0.4   0.3  gouge\n",
        'unit = "m"\naxes = ["east", "north"]\nseparator = "  "',
    ),
    "a comma in names, and semicolons between columns": (
        b"id;x;y;what\n7;2;1;skid, left\n8;3;-1;skid, left\n9;0.4;0.3;gouge, deep\n",
        'unit = "m"\naxes = ["east", "north"]',
    ),
    "one of two surveys below one another": (
        b"Survey of 3 May\nid,x,y\n7,9,9\n8,9,8\n9,9,7\n"
        b"Survey of 4 May\nid,x,y\n7,2,1\n8,3,-1\n9,.4,.3\n",
        'unit = "m"\naxes = ["east", "north"]\nbelow = "survey of 4 may"',
    ),
    "one of two surveys in one table": (
        b"id,day,x,y\n7,3,9,9\n8,3,9,8\n9,3,9,7\n7,4,2,1\n8,4,3,-1\n9,4,.4,.3\n",
        'unit = "m"\naxes = ["east", "north"]\nonly = { day = 4 }',
    ),
    "US survey feet": (
        b"id,x,y\n7,6.561666667,3.280833333\n8,9.8425,-3.280833333\n9,1.312333333,.98425\n",
        'unit = "ftUS"\naxes = ["east", "north"]',
    ),
    "UTF-16 with tabs": (
        "id\tx\ty\n7\t2\t1\n8\t3\t-1\n9\t.4\t.3\n".encode("utf-16"),
        'unit = "m"\naxes = ["east", "north"]',
    ),
    "inches": (
        b"id,x,y\n7,78.740157,39.370079\n8,118.110236,-39.370079\n9,15.748031,11.811024\n",
        'unit = "in"\naxes = ["east", "north"]',
    ),
    "x to the north, y to the east": (
        b"id,x,y\n7,1,2\n8,-1,3\n9,0.3,0.4\n",
        'unit = "m"\naxes = ["north", "east"]',
    ),
    "x to the east, y to the south": (
        b"id,x,y\n7,2,-1\n8,3,1\n9,0.4,-0.3\n",
        'unit = "m"\naxes = ["east", "south"]',
    ),
    "an origin far away": (
        b"id,x,y\n7,500002,4200001\n8,500003,4199999\n9,500000.4,4200000.3\n",
        'unit = "m"\naxes = ["east", "north"]\norigin = ["500000 m", "4200000 m"]',
    ),
    "the scene's x axis due south": (
        b"id,x,y\n7,1,-2\n8,-1,-3\n9,0.3,-0.4\n",
        'unit = "m"\naxes = ["east", "north"]\nangles = "clockwise from north"\nx_axis = "180 deg"',
    ),
    "names of columns in capitals, and another between": (
        b" ID ,Code,Y,X\n7,a,1,2\n8,b,-1,3\n9,c,0.3,0.4\n",
        'unit = "m"\naxes = ["east", "north"]',
    ),
}


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_every_convention_gives_the_same_places(tmp_path: Path, convention: str) -> None:
    content, keys = CONVENTIONS[convention]
    map_text = f"""
[survey]
precision = "0.02 m"
columns = {{ id = "id", x = "x", y = "y" }}
{keys}
[impact_point]
point = 9
uncertainty = "0.2 m"
[[marks.A]]
points = [7, 8]
of = "front_left"
uncertainty = "0.1 m"
"""
    found = imported(tmp_path, content, map_text).scene
    assert (found.contact.x.value, found.contact.y.value) == pytest.approx((0.4, 0.3), abs=1e-6)
    assert [(m.x, m.y, m.of) for m in found.marks["a"]] == [
        (pytest.approx(2, abs=1e-6), pytest.approx(1, abs=1e-6), "front_left"),
        (pytest.approx(3, abs=1e-6), pytest.approx(-1, abs=1e-6), "front_left"),
    ]


def test_columns_by_number_where_there_is_no_header(tmp_path: Path) -> None:
    keys = ONE.replace('{ id = "id", x = "x", y = "y" }', "{ id = 1, x = 3, y = 2 }")
    found = imported(tmp_path, "6,0,0,0,CL\n7,2.5,1.5,0,GOUGE\n", keys)
    assert (found.scene.contact.x.value, found.scene.contact.y.value) == (1.5, 2.5)


@pytest.mark.parametrize(
    ("angles", "written"),
    [("clockwise from north", 60.0), ("counter-clockwise from east", 30.0)],
)
@pytest.mark.parametrize("in_file", [True, False])
def test_a_heading_by_either_convention_is_the_same(
    tmp_path: Path, angles: str, written: float, in_file: bool
) -> None:
    columns = (
        '{ id = "id", x = "x", y = "y", heading = "h" }'
        if in_file
        else ('{ id = "id", x = "x", y = "y" }')
    )
    heading = "" if in_file else f'heading = "{written} ± 4 deg"'
    map_text = f"""
[survey]
unit = "m"
precision = "0.03 m"
axes = ["east", "north"]
angles = "{angles}"
angle_unit = "deg"
columns = {columns}
[rest.B]
points = {{ front_left = 7 }}
{heading}
uncertainty = "0.04 m"
"""
    scene = PAPER.change({"vehicles.B.rest.rotation": None})
    (tmp_path / "bare.toml").write_text(scene.to_toml(), "utf-8")
    (tmp_path / "points.csv").write_text(f"id,x,y,h\n7,10,-9,{written}\n", "utf-8")
    (tmp_path / "map.toml").write_text("schema = 1\n" + map_text, "utf-8")
    found = import_evidence(
        tmp_path / "points.csv", tmp_path / "map.toml", tmp_path / "bare.toml"
    ).scene
    rest = found.rest["b"]
    assert rest.heading is not None
    assert math.remainder(rest.heading.value - math.radians(30), math.tau) == pytest.approx(
        0, abs=1e-5
    )
    ahead, left = spots_of(found.vehicles["b"])["front_left"]
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    expected = (10 - c * ahead + s * left, -9 - s * ahead - c * left)
    assert (rest.x.value, rest.y.value) == pytest.approx(expected, abs=1e-4)
    assert rest.heading.assumed == ("sd" if in_file else "")


def test_a_pose_is_found_again_and_its_errors_are_those_of_many_surveys() -> None:
    rng = np.random.default_rng(1)
    body = [(2.4, 0.9), (2.4, -0.9), (-2.1, 0.9)]
    true, sd = (3.0, -7.0, 2.5), 0.05
    c, s = math.cos(true[2]), math.sin(true[2])
    road = [(true[0] + c * u - s * v, true[1] + s * u + c * v) for u, v in body]
    exact = fitted_pose(body, road, sd)
    assert exact[:3] == pytest.approx(true)
    assert exact.misfit == pytest.approx(0, abs=1e-12)
    poses = [
        fitted_pose(body, [tuple(np.array(p) + sd * rng.standard_normal(2)) for p in road], sd)[:3]
        for _ in range(4000)
    ]
    assert np.std(poses, axis=0) == pytest.approx(exact[3:6], rel=0.05)


def test_one_point_and_a_heading_have_the_errors_of_both() -> None:
    rng = np.random.default_rng(2)
    found = posed((2.0, 0.5), (1.0, 1.0), 0.7, 0.05, 0.04)
    draws = [
        posed(
            (2.0, 0.5),
            tuple(np.array([1.0, 1.0]) + 0.05 * rng.standard_normal(2)),
            0.7 + 0.04 * rng.standard_normal(),
            0.05,
            0.04,
        )[:2]
        for _ in range(4000)
    ]
    assert np.std(draws, axis=0) == pytest.approx(found[3:5], rel=0.05)


def test_a_line_is_the_one_of_least_squares_and_points_from_first_to_last() -> None:
    rng = np.random.default_rng(3)
    points = [(float(3 - t), float(1 + 2 * t + 0.01 * rng.standard_normal())) for t in range(9)]
    (x, y), direction, misfit = fitted_line(points)
    centred = np.array(points) - np.mean(points, axis=0)
    axis = np.linalg.svd(centred)[2][0]
    assert (x, y) == pytest.approx(np.mean(points, axis=0))
    assert abs(math.cos(direction) * axis[0] + math.sin(direction) * axis[1]) == pytest.approx(1)
    assert math.cos(direction) < 0 < math.sin(direction)
    assert misfit == pytest.approx(np.linalg.svd(centred)[1][1] / 3)


REFUSED = {
    "no unit": ("id,x,y\n7,1,2\n", ONE.replace('unit = "m"', ""), "survey.unit: missing"),
    "no axes": (
        "id,x,y\n7,1,2\n",
        ONE.replace('axes = ["east", "north"]', ""),
        "survey.axes: missing",
    ),
    "no precision": (
        "id,x,y\n7,1,2\n",
        ONE.replace('precision = "0.03 m"', ""),
        "survey.precision: missing",
    ),
    "axes along one line": (
        "id,x,y\n7,1,2\n",
        ONE.replace('"north"', '"west"'),
        "one axis points east or west",
    ),
    "another header": ("name,x,y\n7,1,2\n", ONE, 'it has "name", "x", "y"'),
    "a comma in a number": ("id;x;y\n7;1,5;2\n", ONE, 'write decimal = ","'),
    "a point where commas are": (
        "id;x;y\n7;1.500;2\n",
        ONE.replace('unit = "m"', 'unit = "m"\ndecimal = ","'),
        'has a point, and the map says decimal = ","',
    ),
    "a formula": ("id,x,y\n7,=A1+1,2\n", ONE, "is a formula; export values"),
    "no number": ("id,x,y\n7,nan,2\n", ONE, "row 2 of"),
    "too large a number": ("id,x,y\n7,1e999,2\n", ONE, "is too large"),
    "far from the origin": ("id,x,y\n7,5e5,2\n", ONE, "count from an origin near the impact"),
    "no such point": ("id,x,y\n8,1,2\n", ONE, 'it has "8"'),
    "two points of a name": ("id,x,y\n7,1,2\n7,3,4\n", ONE, "(row 2, row 3)"),
    "binary": (b"id,x,y\n7,1,2\0\n", ONE, "is binary"),
    "no character set": (b"id,x,y\n7,1,2\n8,\x81\x98,2\n", ONE, "line 3: is not UTF-8"),
    "another character set": (
        b"id,x,y\n7,1,2\n8,\xe9,2\n",
        ONE.replace('unit = "m"', 'unit = "m"\nencoding = "utf-8"'),
        "line 3: is not utf-8 text; correct survey.encoding",
    ),
    "blanks between columns": ("id x y\n7 1 2\n", ONE, 'write separator = " "'),
    "no such line": (
        "id,x,y\n7,1,2\n",
        ONE.replace('unit = "m"', 'unit = "m"\nbelow = "Event 2"'),
        'below = "Event 2": no line has this text',
    ),
    "no such rows": (
        "id,x,y,day\n7,1,2,3\n",
        ONE.replace('unit = "m"', 'unit = "m"\nonly = { day = 4 }'),
        'no row has "4" in it; it has "3"',
    ),
    "rows by a name where columns have numbers": (
        "7,1,2,3\n",
        ONE.replace(
            '{ id = "id", x = "x", y = "y" }', "{ id = 1, x = 3, y = 2 }\nonly = { day = 4 }"
        ),
        "survey.only = {day =",
    ),
    "nothing": (b"", ONE, "the file is empty"),
    "a header alone": (b"id,x,y\n", ONE, "no points below its header"),
    "nothing to take": ("id,x,y\n7,1,2\n", ONE.split("[impact_point]")[0], "takes nothing"),
    "another vehicle's outline": (
        "id,x,y\n1,0,0\n2,3,0\n",
        ONE.split("[impact_point]")[0]
        + '[rest.A]\npoints = { front_left_corner = 1, rear_left_corner = 2 }\nuncertainty = "0.1 m"',
        "the points miss vehicle A",
    ),
}


@pytest.mark.parametrize("reason", REFUSED)
def test_what_cannot_be_meant_is_refused_with_place_and_fix(tmp_path: Path, reason: str) -> None:
    content, map_text, said = REFUSED[reason]
    message = refusal(tmp_path, content, map_text)
    assert said in message
    assert all(
        line.startswith(str(tmp_path)) or "scene.toml" in line for line in message.split("\n")
    )


def test_a_table_of_windows_is_read_and_its_character_set_said(tmp_path: Path) -> None:
    content = "id,x,y,repère\n7,1.5,2.5,début de trace\n".encode("cp1252")
    found = imported(tmp_path, content, ONE)
    assert found.scene.contact.x.value == 1.5
    assert found.left[0].startswith("character set: not UTF-8, read as cp1252;")
    assert 'column "repère": not in the map' in found.left
    russian = "id,x,y,код\n7,1.5,2.5,след торможения\n8,0,0,осколки стекла\n"
    assert "cp1251" in imported(tmp_path, russian.encode("cp1251"), ONE).left[0]


def test_without_its_library_a_table_of_windows_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "charset_normalizer", None)
    said = refusal(tmp_path, b"id,x,y\n7,1,2\n8,\xe9,2\n", ONE)
    assert "line 3: is not UTF-8 text, and charset-normalizer is not installed;" in said
    assert '[survey] encoding = "cp1252"' in said
    assert "\n" not in said


@pytest.mark.parametrize("name", ["a.CDRX", "a.cdr", "a.pdf", "a.edr", "a.hexdump", "a.dwg"])
def test_formats_of_vendors_are_refused_by_name(tmp_path: Path, name: str) -> None:
    assert "and import that" in refusal(tmp_path, b"anything", ONE, name)


INSTRUMENTS = {
    "GSI": b"110001+00000001 21.322+12345600 22.322+09000000 31..00+00012345\n",
    "GSI of 16 digits": b"*110001+0000000000000001 81..00+0000000001482310\n",
    "SDR": b"00NMSDR33 V04-04.02     01-May-24 08:00 113111\n10NMCRASH\n",
    "RW5": b"JB,NMCRASH,DT05-03-2024,TM08:00:00\nMO,AD0,UN1,SF1.00000000,EC0,EO0.0,AU0\n",
    "JobXML": b'<?xml version="1.0"?>\n<JOBFile jobName="crash" version="5.6">\n',
    "GPX": b'<?xml version="1.0"?><gpx version="1.1"></gpx>',
}


@pytest.mark.parametrize("kind", INSTRUMENTS)
def test_files_of_instruments_are_refused_by_how_they_begin(tmp_path: Path, kind: str) -> None:
    said = refusal(tmp_path, INSTRUMENTS[kind], ONE, "points.txt")
    assert f"({kind.split()[0]})" in said
    assert "and import that" in said


@pytest.mark.parametrize("name", ["a.GSI", "a.sdr", "a.rw5", "a.jxl", "a.kmz", "a.shp"])
def test_formats_of_instruments_are_refused_by_name(tmp_path: Path, name: str) -> None:
    said = refusal(tmp_path, b"anything", ONE, name)
    assert "which is not read; " in said
    assert "as CSV (point, " in said


def test_nothing_is_written_that_the_scene_file_may_not_say(tmp_path: Path) -> None:
    scene, old = tmp_path / "scene.toml", (SURVEY / "before.toml").read_bytes()
    scene.write_bytes(old)
    (tmp_path / "map.toml").write_text("schema = 1\n" + ONE, "utf-8")
    arguments = [str(tmp_path / "points.csv"), "--map", str(tmp_path / "map.toml")]
    for x, code in ((99_000, 2), (1, 0)):
        (tmp_path / "points.csv").write_text(f"id,x,y\n7,{x},2\n", "utf-8")
        done = CliRunner().invoke(app, ["import", *arguments, "--into", str(scene)])
        assert done.exit_code == code
        assert (scene.read_bytes() == old) == bool(code)
    # no rest pose yet: what was missing before does not stand in the way
    assert "the scene is not complete yet" in done.output


def test_a_dry_run_writes_nothing(tmp_path: Path) -> None:
    scene, old = tmp_path / "scene.toml", (SURVEY / "before.toml").read_bytes()
    scene.write_bytes(old)
    arguments = [str(SURVEY / "survey.csv"), "--map", str(SURVEY / "survey.toml")]
    done = CliRunner().invoke(app, ["import", *arguments, "--into", str(scene), "--dry-run"])
    assert done.exit_code == 0
    assert scene.read_bytes() == old
