"""Files that are brought to the board: photographs, survey points, recorders' tables; contact lines."""

from __future__ import annotations

import io
import math
import struct
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image, TiffImagePlugin

from retrodict.explore.board.actions import perform
from retrodict.explore.board.backdrop import by_world_file, image_at, kept, size_of
from retrodict.explore.board.contact import proposed
from retrodict.explore.board.drawing import drawing
from retrodict.explore.board.evidence import taken
from retrodict.explore.board.plan import plan_of
from retrodict.explore.board.state import EMPTY, Backdrop, State, state_from
from retrodict.scene.errors import SceneError
from tests.explore.photographs import png

IMPORT = Path(__file__).parents[2] / "examples" / "import"
JPEG = (
    b"\xff\xd8\xff\xe0"
    + struct.pack(">H", 16)
    + bytes(14)
    + b"\xff\xff\xc2"
    + struct.pack(">HBHH", 11, 8, 480, 640)
    + bytes(8)
)


def test_the_size_of_a_photograph_is_read_from_its_header() -> None:
    assert size_of(png(30, 20)) == ("image/png", 30, 20)
    assert size_of(JPEG) == ("image/jpeg", 640, 480)


@pytest.mark.parametrize(
    "content",
    [b"", b"<svg onload='x'/>", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"\xff\xd8\x00", b"GIF89a"],
)
def test_what_is_no_photograph_is_refused(content: bytes, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="PNG or JPEG"):
        kept(content, tmp_path, "scene")
    assert not list(tmp_path.iterdir())


def test_a_photograph_is_kept_beside_the_scene_under_its_digest(tmp_path: Path) -> None:
    backdrop = kept(png(600, 300), tmp_path, "scene")
    path = tmp_path / backdrop.file
    assert path.read_bytes() == png(600, 300)
    assert backdrop.sha256[:8] in backdrop.file
    assert image_at(tmp_path, backdrop) == (path, "image/png")
    again = state_from(EMPTY, State(EMPTY, backdrop=backdrop).rest())
    assert again.backdrop == backdrop


@pytest.mark.parametrize("name", ["../secret.png", "/etc/passwd", "x.svg", "a\\b.png", "none.png"])
def test_no_other_file_is_served_as_a_photograph(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.png").write_bytes(png(3, 3))
    (tmp_path / "x.svg").write_text("<svg/>")
    folder = tmp_path / "scenes"
    folder.mkdir()
    assert image_at(folder, Backdrop(name, "0", 3, 3, 1.0)) is None


def test_a_world_file_scales_and_turns_its_photograph() -> None:
    backdrop = Backdrop("a.png", "0", 200, 100, 1.0)
    north_up = by_world_file(backdrop, "0.05\n0\n0\n-0.05\n400000\n5600000\n")
    assert (north_up.metres, north_up.turn, north_up.scaled) == (0.05, 0.0, True)
    assert (north_up.x, north_up.y) == pytest.approx((-5, 2.5))
    with pytest.raises(SceneError, match="six numbers"):
        by_world_file(backdrop, "0.05 x")
    with pytest.raises(SceneError, match="stretches"):
        by_world_file(backdrop, "0.05 0 0 -0.06 0 0")


def _placed(b_heading: float, b: tuple[float, float]) -> State:
    state = State(EMPTY)
    for name, values in (
        ("place", {"vehicle": "A", "at": "impact", "x": 0, "y": 0, "heading": 0}),
        ("place", {"vehicle": "B", "at": "impact", "x": b[0], "y": b[1], "heading": b_heading}),
        ("point", {"x": 2.2, "y": 0.3}),
    ):
        state = perform(state, name, values)
    return state


def test_the_line_through_the_crossings_of_the_outlines_is_proposed() -> None:
    # A's front, 4.6 m by 1.8 m, lies 0.3 m within B's side: the outlines cross on a line along B
    found = proposed(plan_of(_placed(90, (2.9, 0.2))))
    assert found is not None
    assert "cross" in found.why
    assert math.degrees(found.angle) == pytest.approx(0, abs=1e-6)


def test_the_side_that_was_hit_is_proposed_where_outlines_do_not_cross() -> None:
    found = proposed(plan_of(_placed(70, (3.6, 0.0))))
    assert found is not None
    assert "side of" in found.why
    assert -math.pi / 2 <= found.angle <= math.pi / 2


def test_nothing_is_proposed_where_nothing_is_placed_and_for_a_wall() -> None:
    assert proposed(plan_of(State(EMPTY))) is None
    walled = perform(_placed(90, (2.9, 0.2)), "barrier", {"kind": "wall"})
    assert proposed(plan_of(walled)) is None
    assert drawing(walled, plan_of(walled))["barrier"] == "wall"


def test_survey_points_are_shown_and_what_the_map_takes_is_written() -> None:
    state = State((IMPORT / "before.toml").read_text("utf-8"))
    survey, of_map = IMPORT / "survey.csv", IMPORT / "survey.toml"
    after = taken(state, survey.name, survey.read_bytes(), of_map.name, of_map.read_bytes())
    assert len(after.points) > 5
    names = {name: (x, y) for name, x, y in after.points}
    assert names["101"] == pytest.approx((0, 0))
    assert plan_of(after).cars["A"].rest is not None
    assert "survey.csv" in after.text


def test_a_map_that_takes_nothing_shows_the_points() -> None:
    of_map = b'schema = 1\n[survey]\nunit = "m"\nprecision = "0.02 m"\naxes = ["east", "north"]\n'
    of_map += b'columns = { id = "id", x = "x", y = "y" }\n'
    after = taken(State(EMPTY), "p.csv", b"id,x,y\na,1,2\nb,3,4\n", "m.toml", of_map)
    assert after == replace(State(EMPTY), points=(("a", 1.0, 2.0), ("b", 3.0, 4.0)), said="p.csv")
    with pytest.raises(SceneError, match=r"p\.csv"):
        taken(State(EMPTY), "p.csv", b"\xff", "m.toml", of_map)


def geotiff(
    *, unit: int = 9001, kind: int = 1, scale: tuple[float, ...] = (0.05, 0.05, 0.0)
) -> bytes:
    """A GeoTIFF of 40 by 20 pixels."""
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags[33550], tags.tagtype[33550] = scale, 12
    tags[33922], tags.tagtype[33922] = (0.0, 0.0, 0.0, 400_000.0, 5_600_000.0, 0.0), 12
    keys = (1, 1, 0, 2, 1024, 0, 1, kind, 3076, 0, 1, unit)
    tags[34735], tags.tagtype[34735] = keys, 3
    made = io.BytesIO()
    Image.new("RGB", (40, 20), (90, 120, 60)).save(made, "TIFF", tiffinfo=tags)
    return made.getvalue()


def test_a_geotiff_has_its_scale_and_is_kept_beside_what_is_shown(tmp_path: Path) -> None:
    content = geotiff()
    backdrop = kept(content, tmp_path, "scene")
    assert backdrop.scaled
    assert backdrop.metres == pytest.approx(0.05)
    assert (backdrop.x, backdrop.y, backdrop.turn) == pytest.approx((-1.0, 0.5, 0.0))
    assert (tmp_path / backdrop.original).read_bytes() == content
    found = image_at(tmp_path, backdrop)
    assert found is not None
    assert size_of(found[0].read_bytes()) == ("image/jpeg", 40, 20)
    feet = kept(geotiff(unit=9002), tmp_path, "feet")
    assert feet.metres == pytest.approx(0.05 * 0.3048)


def test_a_geotiff_of_degrees_or_stretched_pixels_is_refused(tmp_path: Path) -> None:
    for content, words in (
        (geotiff(kind=2), "degrees"),
        (geotiff(unit=9035), "neither the metre nor the foot"),
        (geotiff(scale=(0.05, 0.07, 0.0)), "stretches"),
        (geotiff()[:200], "cannot be read"),
    ):
        with pytest.raises(SceneError, match=words):
            kept(content, tmp_path, "scene")


def test_a_tiff_without_georeference_waits_for_a_scale(tmp_path: Path) -> None:
    made = io.BytesIO()
    Image.new("RGBA", (40, 20)).save(made, "TIFF")
    backdrop = kept(made.getvalue(), tmp_path, "scene")
    assert (backdrop.scaled, Path(backdrop.file).suffix) == (False, ".png")
    north_up = by_world_file(backdrop, "0.05\n0\n0\n-0.05\n400000\n5600000\n")
    assert north_up.metres == 0.05


def test_lines_of_a_plan_lie_where_its_points_lie() -> None:
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new()
    space = document.modelspace()
    # in feet, x to the north and y to the west
    space.add_line((0, 0), (100, 0), dxfattribs={"layer": "kerb"})
    space.add_lwpolyline([(0, 10), (50, 10), (50, 30)], dxfattribs={"layer": "kerb"})
    space.add_circle((20, 20), 5)
    stream = io.StringIO()
    document.write(stream)
    of_map = b'schema = 1\n[drawing]\nunit = "ft"\nprecision = "0.02 m"\naxes = ["north", "west"]\n'
    after = taken(State(EMPTY), "plan.dxf", stream.getvalue().encode(), "m.toml", of_map)
    foot = 0.3048
    straight, bent, circle = after.lines
    assert straight[0] == pytest.approx((0, 0), abs=2e-3)
    assert straight[1] == pytest.approx((0, 100 * foot), abs=2e-3)
    assert bent[2] == pytest.approx((-30 * foot, 50 * foot), abs=2e-3)
    around = [math.dist(place, (-20 * foot, 20 * foot)) for place in circle]
    assert around == pytest.approx([5 * foot] * len(around), abs=2e-3)
    assert len(around) >= 8
    again = state_from(after.text, after.rest())
    assert again == after
