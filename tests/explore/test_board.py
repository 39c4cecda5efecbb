"""The drawing board without a browser: what actions write, what is undone, what a kill leaves."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from retrodict.explore.board.actions import ACTIONS, perform
from retrodict.explore.board.board import Board, untitled
from retrodict.explore.board.journal import InUse, applied, difference
from retrodict.explore.board.plan import plan_of
from retrodict.explore.board.state import EMPTY, State
from retrodict.scene import load_scene
from retrodict.scene.errors import SceneError
from retrodict.scene.text_edit import edited

ROOT = Path(__file__).parents[2]
SCENES = sorted(
    [
        *(ROOT / "examples").glob("*/scene.toml"),
        *(ROOT / "benchmarks" / "users" / "scenes").glob("*.toml"),
    ]
)
EXAMPLES = [path for path in SCENES if path.name == "scene.toml"]
BRACH = ROOT / "examples" / "brach-1977" / "scene.toml"
# the paper's collision, as somebody draws it on an empty board
DRAWN: list[tuple[str, dict[str, Any]]] = [
    ("write", {"key": "title", "value": "Head-on collision of A with B"}),
    ("write", {"key": "vehicles.A.mass", "value": "1857 ± 37 kg"}),
    ("write", {"key": "vehicles.A.yaw_inertia", "value": "3374 ± 270 kg m^2"}),
    ("write", {"key": "vehicles.A.cg_to_front_axle", "value": "1.35 m"}),
    ("write", {"key": "vehicles.A.cg_to_rear_axle", "value": "1.50 m"}),
    ("write", {"key": "vehicles.A.track", "value": "1.54 m"}),
    ("write", {"key": "vehicles.B.mass", "value": "1778 ± 36 kg"}),
    ("write", {"key": "vehicles.B.yaw_inertia", "value": "3007 ± 240 kg m^2"}),
    ("write", {"key": "vehicles.B.cg_to_front_axle", "value": "1.30 m"}),
    ("write", {"key": "vehicles.B.cg_to_rear_axle", "value": "1.45 m"}),
    ("write", {"key": "vehicles.B.track", "value": "1.52 m"}),
    ("place", {"vehicle": "A", "at": "impact", "x": 2.08, "y": 0.205, "heading": 180}),
    ("place", {"vehicle": "B", "at": "impact", "x": -0.653, "y": -1.636, "heading": -22}),
    ("point", {"x": 0, "y": 0}),
    ("line", {"angle": -8.9, "sd": 3}),
    ("place", {"vehicle": "A", "at": "rest", "x": -3.63, "y": 2.22}),
    ("turn", {"vehicle": "A", "at": "rest", "by": 38.1}),
    ("place", {"vehicle": "B", "at": "rest", "x": 8.97, "y": -12.9}),
    ("turn", {"vehicle": "B", "at": "rest", "by": 743}),
    ("write", {"key": "surfaces.road.friction", "value": "0.50 ± 0.03"}),
    ("edge", {"name": "berm", "kind": "gravel", "x": 0, "y": 1.75, "angle": 0, "side": "left"}),
    ("write", {"key": "surfaces.berm.friction", "value": "0.40 ± 0.03"}),
    ("write", {"key": "vehicles.A.approach.speed", "value": "45 ± 2 mph"}),
    ("write", {"key": "vehicles.B.approach.direction", "value": "unknown"}),
]


def drawn(board: Board) -> None:
    for name, values in DRAWN:
        assert board.do(name, values), (name, values)


def comments(text: str) -> list[str]:
    """Comments at the ends of lines and on their own."""
    return [line.partition("#")[2] for line in text.splitlines() if "#" in line]


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    made = Board(tmp_path / "new.toml")
    yield made
    made.close()


def test_a_scene_drawn_from_nothing_is_the_one_written_by_hand(board: Board) -> None:
    drawn(board)
    assert board.needs == ()
    ours, theirs = board.scene, load_scene(BRACH)
    assert ours is not None
    for v in "ab":
        assert math.dist(ours.at_impact(v), theirs.at_impact(v)) < 0.02
        turned = ours.vehicles[v].heading.value - theirs.vehicles[v].heading.value
        assert abs(math.remainder(turned, math.tau)) < math.radians(0.5)
        mine, his = ours.rest[v], theirs.rest[v]
        assert math.dist((mine.x.value, mine.y.value), (his.x.value, his.y.value)) < 0.02
        assert mine.heading
        assert his.heading
        assert mine.turns_known == (v == "b")
        rotation = mine.heading.value - ours.vehicles[v].heading.value
        assert abs(rotation - (his.heading.value - theirs.vehicles[v].heading.value)) < 0.03
    assert math.isclose(ours.contact.Gamma.value, theirs.contact.Gamma.value, abs_tol=0.005)
    path = board.save()
    assert load_scene(path).title == "Head-on collision of A with B"


def test_what_is_missing_is_asked_in_the_order_of_drawing(board: Board) -> None:
    words = [need.words for need in board.needs]
    assert words[0] == "the class or model of A, or its mass and track and wheelbase"
    assert "the impact point: click it, or the place that was hit on an outline" in words
    left = len(words)
    for name, values in DRAWN:
        board.do(name, values)
        left = min(left, len(board.needs))
    assert left == len(board.needs) == 0


def test_momentum_answers_without_a_contact_line_but_not_a_crash_into_a_wall(board: Board) -> None:
    drawn(board)
    board.do("write", {"key": "impact.contact_line", "value": ""})
    assert [(need.key, need.more) for need in board.needs] == [("impact.contact_line", True)]
    assert board.scene is not None
    assert board.scene.unwritten == ("impact.contact_line",)
    board.do("barrier", {"kind": "wall"})
    assert ("impact.contact_line", False) in [(need.key, need.more) for need in board.needs]
    assert board.scene is None


def test_a_ring_says_how_uncertain_a_place_is(board: Board) -> None:
    drawn(board)
    before = board.scene
    assert before is not None
    assert board.do("spread", {"thing": "point", "x": 0.25, "y": 0.1})
    assert board.do("spread", {"thing": "car", "vehicle": "A", "x": 0.3, "y": 0.3})
    assert board.do("spread", {"thing": "car", "vehicle": "A", "by": 1.1})
    after = board.scene
    assert after is not None
    assert (after.contact.x.sd, after.contact.y.sd) == pytest.approx((0.25, 0.1))
    assert (after.rest["a"].x.sd, after.rest["a"].y.sd) == pytest.approx((0.33, 0.33))
    assert after.rest["a"].x.value == before.rest["a"].x.value
    assert not board.do("spread", {"thing": "car", "vehicle": "A", "by": 1})
    board.do("write", {"key": "vehicles.B.rest", "value": ""})
    with pytest.raises(SceneError, match="place it first"):
        board.do("spread", {"thing": "car", "vehicle": "B", "x": 1, "y": 1})


def test_whether_a_driver_could_have_stopped_is_asked_and_no_longer_asked(board: Board) -> None:
    drawn(board)
    text = board.state.text
    how = {"vehicle": "A", "limit": "35 mph", "reaction": "1.5 ± 0.3 s", "deceleration": "0.7 g"}
    board.do("ask_avoidable", {**how, "seen_time": "2.5 s"})
    board.do("ask_avoidable", {**how, "seen_time": "2.5 s", "limit": "50 km/h"})
    assert board.scene is not None
    (asked,) = board.scene.questions.avoidance
    assert asked.limit == pytest.approx(50 / 3.6)
    with pytest.raises(SceneError, match="speed limit"):
        board.do("ask_avoidable", {**how, "seen_time": "", "limit": ""})
    with pytest.raises(SceneError, match="limit"):
        board.do("ask_avoidable", {**how, "seen_time": "", "limit": "slow"})
    board.do("ask_avoidable", {})
    assert board.state.text.startswith(text)
    assert board.scene.questions.avoidance == ()


def test_edges_that_are_drawn_one_after_the_other_are_two_surfaces(board: Board) -> None:
    edge = {"stem": "verge", "kind": "gravel", "x": 0, "angle": 0, "side": "left"}
    board.do("edge", {**edge, "y": 3})
    board.do("edge", {**edge, "y": 5})
    assert [ground.name for ground in board.plan.grounds] == ["verge", "verge_2"]
    board.do("line", {"angle": 10})
    for _ in range(3):
        board.do("line", {"by": 1})
    assert board.plan.line == pytest.approx(math.radians(13))


@pytest.mark.parametrize(
    "path",
    [p if p in EXAMPLES else pytest.param(p, marks=pytest.mark.slow) for p in SCENES],
    ids=lambda path: f"{path.parent.name}-{path.stem}",
)
def test_a_scene_moved_by_nothing_or_moved_and_undone_has_the_same_bytes(
    path: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "scene.toml"
    copy.write_bytes(path.read_bytes())
    board = Board(copy)
    for car in board.plan.cars.values():
        at = {"vehicle": car.letter}
        if car.at:
            x, y = car.at
            assert not board.do("place", {**at, "at": "impact", "x": x, "y": y})
            assert not board.do("turn", {**at, "at": "impact", "by": 0})
        if car.rest:
            x, y = car.rest
            assert not board.do("place", {**at, "at": "rest", "x": x, "y": y})
            if car.rest_heading is not None:
                assert not board.do("turn", {**at, "at": "rest", "by": 0})
    assert not list(tmp_path.glob("*.jsonl"))  # nothing was done
    board.save()
    assert copy.read_bytes() == path.read_bytes()
    steps = 0
    before = comments(board.state.text)
    for car in board.plan.cars.values():
        at = {"vehicle": car.letter}
        tried = [("turn", {**at, "at": "impact", "by": 7.3})]
        if car.at:
            x, y = car.at
            tried.append(("place", {**at, "at": "impact", "x": x + 0.1, "y": y - 0.05}))
        tried.append(("place", {**at, "at": "rest", "x": 3.3, "y": -4.1}))
        tried.append(("turn", {**at, "at": "rest", "by": -400}))
        tried += [("mark", {**at, "x": 1.0, "y": 2.0, "of": "front_left"})]
        tried += [("line", {"angle": 12.5}), ("wheel", {**at, "wheel": "front_left"})]
        tried += [("write", {"key": f"vehicles.{car.letter}.name", "value": "moved"})]
        for name, values in tried:
            with suppress(SceneError):
                steps += board.do(name, values)
    assert steps > 3
    # every comment is still there
    assert set(before) <= set(comments(board.state.text))
    for _ in range(steps):
        assert board.undo()
    assert not board.undo()
    board.save()
    assert copy.read_bytes() == path.read_bytes()
    board.close()


def test_a_vehicle_that_is_turned_stays_where_it_is_and_its_rotation_too(board: Board) -> None:
    drawn(board)
    before = board.plan.cars["B"]
    assert board.do("turn", {"vehicle": "B", "at": "impact", "by": 30})
    after = board.plan.cars["B"]
    assert before.at
    assert after.at
    assert before.rest
    assert after.rest
    assert math.dist(before.at, after.at) < 0.002
    assert after.heading == pytest.approx(math.radians(8), abs=1e-3)
    assert after.rest_heading == before.rest_heading
    assert after.rotation == pytest.approx(math.radians(713), abs=1e-3)


def test_a_quantity_keeps_its_unit_and_its_uncertainty(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(
        BRACH.read_text("utf-8").replace('"0 ± 0.1 m", "0 ± 0.1 m"', '"0 ± 4 in", "0 ft"')
    )
    board = Board(path)
    board.do("point", {"x": 0.254, "y": -0.3048, "along": True})
    assert tomllib.loads(board.state.text)["impact"]["point"] == ["10 ± 4 in", "-1 ft"]
    # the source no longer supports the number, and the comment beside it stays
    board.do("turn", {"vehicle": "A", "at": "impact", "by": 5})
    heading = tomllib.loads(board.state.text)["vehicles"]["A"]["impact"]["heading"]
    assert heading == {"value": -175, "sd": 2, "unit": "deg"}
    board.close()


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("place", {"vehicle": "A", "at": "impact", "x": math.nan, "y": 0}),
        ("place", {"vehicle": "A", "at": "impact", "x": 50, "y": 0}),
        ("place", {"vehicle": "C", "at": "impact", "x": 0, "y": 0}),
        ("place", {"vehicle": "A", "at": "impact", "x": True, "y": 0}),
        ("point", {"x": 40, "y": 0}),
        ("write", {"key": "vehicles.A.mass", "value": "heavy"}),
        ("write", {"key": "vehicles.A.weight", "value": "1 kg"}),
        ("write", {"key": "vehicles.A.mass.x", "value": "1 kg"}),
        ("write", {"key": "a..b", "value": "1"}),
        ("write", {"key": "title", "value": "\ud800"}),
        ("write", {"key": "foo.bar", "value": "1"}),
        ("edge", {"name": "Über", "kind": "gravel", "x": 0, "y": 0, "angle": 0, "side": "left"}),
        ("outline", {"name": "x", "kind": "gravel", "corners": [[0, 0], [1, 1], [2, 2]]}),
        ("move_mark", {"vehicle": "A", "number": 3, "x": 0, "y": 0}),
        ("scale", {"x1": 0, "y1": 0, "x2": 1, "y2": 1, "distance": 5}),
        ("fly", {}),
    ],
)
def test_what_a_scene_may_not_have_is_refused_in_a_line(
    board: Board, name: str, values: Mapping[str, Any]
) -> None:
    drawn(board)
    before = board.state
    with pytest.raises(SceneError) as refusal:
        board.do(name, values)
    assert len(str(refusal.value).splitlines()) == 1
    assert board.state is before


def test_a_barrier_takes_the_place_of_b_and_gives_it_back(board: Board) -> None:
    drawn(board)
    board.do("barrier", {"kind": "pole"})
    assert not {need.thing for need in board.needs} & {"B"}
    assert board.plan.barrier == "pole"
    assert "B" not in board.plan.cars
    board.do("barrier", {"kind": "wall"})
    assert board.scene is not None
    assert board.scene.barrier is not None
    board.do("barrier", {"kind": "vehicle"})
    assert any(need.thing == "B" for need in board.needs)
    for _ in range(3):
        board.undo()
    assert board.needs == ()


def test_wheels_go_from_locked_to_rolling_to_damaged(board: Board) -> None:
    drawn(board)
    for state in ("rolling", "damaged", "locked"):
        board.do("wheel", {"vehicle": "A", "wheel": "rear_right"})
        wheels = board.plan.cars["A"].wheels
        assert wheels
        assert wheels["rear_right"] == state
        assert wheels["front_left"] == "locked"


def test_a_photograph_is_scaled_and_turned_about_what_was_clicked() -> None:
    from retrodict.explore.board.state import Backdrop

    state = State(EMPTY, backdrop=Backdrop("a.png", "0" * 64, 1000, 500, 0.1, x=-50, y=25))
    scaled = perform(state, "scale", {"x1": 10, "y1": 0, "x2": 20, "y2": 0, "distance": 5}).backdrop
    assert scaled
    assert scaled.metres == pytest.approx(0.05)
    assert (scaled.x, scaled.y) == pytest.approx((-20, 12.5))
    north = perform(
        State(EMPTY, backdrop=scaled), "north", {"x1": 0, "y1": 0, "x2": 3, "y2": 0}
    ).backdrop
    assert north
    assert north.turn == pytest.approx(math.pi / 2)
    assert (north.x, north.y) == pytest.approx((-12.5, -20))


def test_a_board_goes_on_where_it_was(tmp_path: Path) -> None:
    board = Board(tmp_path / "new.toml")
    drawn(board)
    board.undo()
    board.undo()
    state, undoes = board.state, board.undoes
    with pytest.raises(InUse):
        Board(tmp_path / "new.toml")
    board.close()
    again = Board(tmp_path / "new.toml")
    assert (again.state, again.undoes) == (state, undoes)
    assert "goes on where it was" in again.note
    assert again.redo()
    assert again.redo()
    assert not again.redo()
    assert again.needs == ()
    for _ in DRAWN:
        assert again.undo()
    assert again.state.text == EMPTY
    again.close()


def test_a_file_changed_elsewhere_is_shown_and_undo_leads_back(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_bytes(BRACH.read_bytes())
    board = Board(path)
    board.do("line", {"angle": 1})
    drawn_before = board.state.text
    board.close()
    path.write_bytes(BRACH.read_bytes() + b"# by hand\n")
    again = Board(path)
    assert again.state.text.endswith("# by hand\n")
    assert "changed elsewhere" in again.note
    again.undo()
    assert again.state.text == drawn_before
    again.close()


@pytest.mark.parametrize("cut", [1, 5, 40])
def test_a_torn_last_line_costs_that_step_alone(tmp_path: Path, cut: int) -> None:
    board = Board(tmp_path / "new.toml")
    drawn(board)
    board.undo()
    before = board.state
    board.redo()
    board.do("line", {"angle": 10})
    board.close()
    file = next(tmp_path.glob("*.jsonl"))
    file.write_bytes(file.read_bytes()[:-cut])
    again = Board(tmp_path / "new.toml")
    again.undo()
    assert again.state == before
    assert not list(tmp_path.glob("*.damaged"))
    again.close()


def test_a_damaged_journal_is_put_aside(tmp_path: Path) -> None:
    (tmp_path / "new.board.jsonl").write_text('0123 {"format": 1}\n')
    board = Board(tmp_path / "new.toml")
    assert board.state.text == EMPTY
    assert list(tmp_path.glob("*.damaged"))
    board.close()


_ENDLESS = """
import sys
from pathlib import Path
from retrodict.explore.board.board import Board
board = Board(Path(sys.argv[1]))
print("ready", flush=True)
for i in range(100000):
    board.do("write", {"key": "title", "value": f"step {i}"})
    print(i, flush=True)
"""


@pytest.mark.parametrize(
    "moment", [0, 3, 17, 40, *(pytest.param(n, marks=pytest.mark.slow) for n in range(50, 210, 10))]
)
def test_a_killed_board_has_every_step_that_was_shown(tmp_path: Path, moment: int) -> None:
    path = tmp_path / "new.toml"
    with subprocess.Popen(
        [sys.executable, "-c", _ENDLESS, str(path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout
        shown = -1
        for line in process.stdout:
            if line.strip() != "ready":
                shown = int(line)
            if shown >= moment:
                break
        process.send_signal(signal.SIGKILL)
        process.wait()
        shown = max([shown, *map(int, process.stdout.read().split()[:-1])])
    board = Board(path)
    title = tomllib.loads(board.state.text)["title"]
    assert int(title.split()[1]) >= shown
    while board.undo():
        pass
    assert board.state.text == EMPTY
    board.close()


def test_a_new_scene_has_the_first_name_that_is_free(tmp_path: Path) -> None:
    assert untitled(tmp_path).name == "untitled.toml"
    untitled(tmp_path).write_text("schema = 1\n")
    assert untitled(tmp_path).name == "untitled-2.toml"


def test_an_edit_keeps_everything_else(tmp_path: Path) -> None:
    text = '# head\nschema=1\n\n[impact] # here\npoint = [ "0 m",  "1 m" ] # two\n'
    new = edited(text, {"impact.point[1]": "2 m"}, "x")
    assert new == text.replace('"1 m"', '"2 m"')


@pytest.mark.parametrize(("one", "other"), [("", "a"), ("abc", "abXc"), ("aaa", "aa"), ("é", "ée")])
def test_a_difference_leads_from_one_text_to_the_other(one: str, other: str) -> None:
    assert applied(one, difference(one, other)) == other
    assert applied(other, difference(other, one)) == one


# random sequences of actions

_coordinate = st.floats(-30, 30).map(lambda value: round(value, 3)) | st.sampled_from(
    [math.inf, -1e9, None, "0", 0]
)
_letter = st.sampled_from(["A", "B", "A", "B", "C"])
_angle = st.floats(-800, 800).map(lambda value: round(value, 2))
_at = st.sampled_from(["impact", "rest"])
_wheel = st.sampled_from(["centre", "front_left", "front_right", "rear_left", "rear_right"])
_key = st.sampled_from(
    [
        "title",
        "vehicles.A.class",
        "vehicles.B.class",
        "vehicles.A.mass",
        "vehicles.B.track",
        "vehicles.A.approach.speed",
        "vehicles.B.departure.delta_v",
        "vehicles.A.impact_centre.distance",
        "impact.contact_line",
        "impact.point[0]",
        "surfaces.road.kind",
        "surfaces.road.friction",
        "slope.grade",
        "questions.exceeds",
        "nonsense",
        "vehicles.A.marks[0].speed",
        "barrier",
    ]
)
_value = st.sampled_from(
    ["", "compact car", "1500 kg", "5' 1\"", "45 ± 2 mph", "0.7 ± 0.03", "dry asphalt", "2 m"]
) | st.text(max_size=12)


class Drawing(RuleBasedStateMachine):
    """A board under random actions: nothing raises but a refusal, nothing is lost, undo leads back."""

    def __init__(self) -> None:
        super().__init__()
        import tempfile

        self.folder = tempfile.TemporaryDirectory()
        self.path = Path(self.folder.name) / "scene.toml"

    @initialize(of=st.sampled_from([None, BRACH, *SCENES]))
    def begin(self, of: Path | None) -> None:
        if of is not None:
            self.path.write_bytes(of.read_bytes())
        self.board = Board(self.path)
        self.first = self.board.state
        self.steps = 0

    def do(self, action: str, **values: object) -> None:
        before = self.board.state
        try:
            if self.board.do(action, json.loads(json.dumps(values))):
                self.steps += 1
        except SceneError:
            assert self.board.state is before

    @rule(vehicle=_letter, at=_at, x=_coordinate, y=_coordinate)
    def place(self, vehicle: str, at: str, x: object, y: object) -> None:
        self.do("place", vehicle=vehicle, at=at, x=x, y=y)

    @rule(
        thing=st.sampled_from(["car", "point", "mark", "x"]),
        vehicle=_letter,
        at=_at,
        dx=st.sampled_from([0.1, -1, 0.0]),
        along=st.booleans(),
    )
    def nudge(self, thing: str, vehicle: str, at: str, dx: float, along: bool) -> None:
        self.do("nudge", thing=thing, vehicle=vehicle, at=at, dx=dx, dy=0.01, along=along, number=0)

    @rule(vehicle=_letter, at=_at, by=_angle)
    def turn(self, vehicle: str, at: str, by: float) -> None:
        self.do("turn", vehicle=vehicle, at=at, by=by)

    @rule(x=_coordinate, y=_coordinate, along=st.booleans())
    def point(self, x: object, y: object, along: bool) -> None:
        self.do("point", x=x, y=y, along=along)

    @rule(vehicle=_letter, ahead=st.floats(-3, 3), left=st.floats(-1, 1))
    def struck(self, vehicle: str, ahead: float, left: float) -> None:
        self.do("struck", vehicle=vehicle, ahead=ahead, left=left)

    @rule(angle=_angle, by=st.booleans())
    def line(self, angle: float, by: bool) -> None:
        self.do("line", **{"by" if by else "angle": angle})

    @rule(
        thing=st.sampled_from(["car", "point"]),
        vehicle=_letter,
        x=_coordinate,
        y=st.floats(0, 9),
        by=st.sampled_from([None, 1.1, 1 / 1.1, 0]),
    )
    def spread(self, thing: str, vehicle: str, x: object, y: float, by: float | None) -> None:
        how = {"x": x, "y": y} if by is None else {"by": by}
        self.do("spread", thing=thing, vehicle=vehicle, **how)

    @rule(vehicle=_letter, limit=_value, seen=st.sampled_from(["", "2.5 s", "soon"]))
    def ask_avoidable(self, vehicle: str, limit: str, seen: str) -> None:
        if vehicle == "C":
            self.do("ask_avoidable")
            return
        how = {"reaction": "1.5 ± 0.3 s", "deceleration": "0.7 g", "seen_time": seen}
        self.do("ask_avoidable", vehicle=vehicle, limit=limit, **how)

    @rule(vehicle=_letter, angle=_angle)
    def course(self, vehicle: str, angle: float) -> None:
        self.do("course", vehicle=vehicle, angle=angle)

    @rule(vehicle=_letter, x=_coordinate, y=_coordinate, of=_wheel)
    def mark(self, vehicle: str, x: object, y: object, of: str) -> None:
        self.do("mark", vehicle=vehicle, x=x, y=y, of=of)

    @rule(vehicle=_letter, number=st.integers(-1, 3), x=_coordinate, y=_coordinate)
    def move_mark(self, vehicle: str, number: int, x: object, y: object) -> None:
        self.do("move_mark", vehicle=vehicle, number=number, x=x, y=y)

    @rule(vehicle=_letter, number=st.integers(0, 2))
    def remove_mark(self, vehicle: str, number: int) -> None:
        self.do("remove_mark", vehicle=vehicle, number=number)

    @rule(vehicle=_letter, x=_coordinate, y=_coordinate)
    def end_of_rotation(self, vehicle: str, x: object, y: object) -> None:
        self.do("end_of_rotation", vehicle=vehicle, x=x, y=y)

    @rule(vehicle=_letter, wheel=_wheel)
    def wheel(self, vehicle: str, wheel: str) -> None:
        self.do("wheel", vehicle=vehicle, wheel=wheel)

    @rule(vehicle=_letter, at=_at, x=st.floats(-9, 9), y=st.floats(-9, 9))
    def corners(self, vehicle: str, at: str, x: float, y: float) -> None:
        places = [[x + u, y + w] for u, w in ((2.3, 0.9), (2.3, -0.9), (-2.3, -0.9), (-2.3, 0.9))]
        self.do("corners", vehicle=vehicle, at=at, corners=places)

    @rule(kind=st.sampled_from(["wall", "pole", "vehicle", "tree"]))
    def barrier(self, kind: str) -> None:
        self.do("barrier", kind=kind)

    @rule(
        name=st.sampled_from(["road", "verge", "berm", "X"]),
        named=st.sampled_from(["name", "stem"]),
        x=_coordinate,
        y=_coordinate,
        angle=_angle,
        side=st.sampled_from(["left", "right"]),
    )
    def edge(self, name: str, named: str, x: object, y: object, angle: float, side: str) -> None:
        where = {"x": x, "y": y, "angle": angle, "side": side}
        self.do("edge", **{named: name}, kind="gravel", **where)

    @rule(corners=st.lists(st.tuples(_coordinate, _coordinate), min_size=2, max_size=5))
    def outline(self, corners: list[object]) -> None:
        self.do("outline", name="ice", kind="ice", corners=corners)

    @rule(key=_key, value=_value)
    def write(self, key: str, value: str) -> None:
        self.do("write", key=key, value=value)

    @precondition(lambda self: self.steps > 0)
    @rule()
    def undo(self) -> None:
        assert self.board.undo()
        self.steps -= 1

    @rule()
    def redo(self) -> None:
        self.steps += self.board.redo()

    @rule()
    def killed(self) -> None:
        state = self.board.state
        self.board.close()
        self.board = Board(self.path)
        assert self.board.state == state

    @rule()
    def save(self) -> None:
        self.board.save()
        assert self.path.read_bytes() == self.board.state.text.encode()
        assert not self.board.unsaved

    @invariant()
    def is_toml_that_can_be_drawn(self) -> None:
        if not hasattr(self, "board"):
            return
        plan_of(self.board.state)
        if all(need.more for need in self.board.needs):
            assert self.board.scene is not None

    def teardown(self) -> None:
        if hasattr(self, "board"):
            for _ in range(self.steps):
                assert self.board.undo()
            assert self.board.state == self.first
            self.board.close()
        self.folder.cleanup()


Drawing.TestCase.settings = settings(
    max_examples=int(os.environ.get("RETRODICT_SEQUENCES", "10")),
    stateful_step_count=30,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)
TestDrawing = Drawing.TestCase


def test_every_action_is_in_the_state_machine() -> None:
    of_photographs = {"scale", "north", "origin", "no_backdrop"}
    assert set(ACTIONS) - of_photographs <= set(dir(Drawing))
