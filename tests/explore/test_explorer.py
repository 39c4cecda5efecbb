"""The work behind the page: the newest change is answered, older ones are not; files are safe."""

from __future__ import annotations

import asyncio
import re
import threading
from collections.abc import Callable, Coroutine
from pathlib import Path

import pytest

from retrodict.explore.explorer import Explorer
from retrodict.scene import SceneError, load_scene, parse_scene
from tests.explore.made_up import BRACH, MPH, MadeUpAnswer, MadeUpSession

SPEED = "vehicles.A.approach.speed"


class Seen:
    """A view that keeps what it is shown."""

    def __init__(self) -> None:
        self.speeds: list[float] = []
        self.faults: list[str] = []
        self.busy: list[bool] = []
        self.over = False

    def working(self, busy: bool) -> None:
        self.busy.append(busy)

    def answered(self, answer: MadeUpAnswer) -> None:
        speed = answer.scene.approach["a"].speed
        assert speed
        self.speeds.append(round(speed.value / MPH, 3))

    def failed(self, why: str) -> None:
        self.faults.append(why)

    def superseded(self) -> None:
        self.over = True


def run(steps: Callable[[Explorer, Seen, list[MadeUpSession]], Coroutine[None, None, None]],
        wait: Callable[[], object] = lambda: None) -> None:  # fmt: skip
    """Go through steps with an explorer, what it shows, and the sessions it opens."""
    sessions: list[MadeUpSession] = []

    def opened(scene, model, _):
        sessions.append(MadeUpSession(scene, model, wait))
        return sessions[-1]

    async def all_of_it() -> None:
        seen = Seen()
        explorer = Explorer(load_scene(BRACH), opened)
        explorer.show_in(seen)
        await explorer.settled()
        await steps(explorer, seen, sessions)

    asyncio.run(all_of_it())


def set_speed(explorer: Explorer, mph: float) -> None:
    text = f"{mph} ± 2 mph"
    explorer.change(SPEED, text, {SPEED: text})


def test_only_the_newest_of_changes_that_wait_is_answered() -> None:
    gate = threading.Event()

    async def steps(explorer: Explorer, seen: Seen, sessions: list[MadeUpSession]) -> None:
        for mph in (46, 47, 48, 49):
            set_speed(explorer, mph)
            await asyncio.sleep(0.02)  # the first is under way
        gate.set()
        await explorer.settled()
        assert seen.speeds == [45, 46, 49]
        assert len(sessions[0].asked) == 2

    run(steps, lambda: gate.wait(10))


def test_a_wrong_value_leaves_scene_and_answer_as_they_were() -> None:
    async def steps(explorer: Explorer, seen: Seen, sessions: list[MadeUpSession]) -> None:
        before = explorer.scene
        with pytest.raises(SceneError, match="write a speed between 0 and 335"):
            set_speed(explorer, 500)
        assert explorer.scene is before
        assert not sessions[0].asked
        assert seen.speeds == [45]

    run(steps)


def test_after_a_scene_without_an_answer_the_next_one_is_answered() -> None:
    async def steps(explorer: Explorer, seen: Seen, _: list[MadeUpSession]) -> None:
        set_speed(explorer, 70)
        await explorer.settled()
        assert explorer.answer is None
        assert "no motion leads there" in seen.faults[0]
        with pytest.raises(RuntimeError, match="no motion"):
            await explorer.confirm(Path("nowhere"), "si")
        set_speed(explorer, 50)
        await explorer.settled()
        assert seen.speeds == [45, 50]

    run(steps)


def test_another_model_is_another_session_of_the_scene_as_it_is() -> None:
    async def steps(explorer: Explorer, seen: Seen, sessions: list[MadeUpSession]) -> None:
        set_speed(explorer, 50)
        await explorer.settled()
        explorer.choose("planar+spin")
        await explorer.settled()
        assert [each.model for each in sessions] == ["auto", "planar+spin"]
        assert seen.speeds == [45, 50, 50]
        assert explorer.of_file is None  # this model has not answered the file's scene
        explorer.reset()
        await explorer.settled()
        assert seen.speeds[-1] == 45
        assert explorer.of_file is explorer.answer

    run(steps)


def test_auto_chooses_anew_once_another_part_of_the_contact_is_known() -> None:
    async def steps(explorer: Explorer, _: Seen, sessions: list[MadeUpSession]) -> None:
        whole = load_scene(BRACH)
        without = parse_scene(re.sub(r"contact_line = .*", "", whole.text), "without")
        assert without.unwritten == ("impact.contact_line",)
        explorer.follow(without)
        await explorer.settled()
        set_speed(explorer, 50)
        await explorer.settled()
        assert len(sessions) == 2
        explorer.follow(whole)
        await explorer.settled()
        assert len(sessions) == 3

    run(steps)


def test_the_newest_page_takes_over() -> None:
    async def steps(explorer: Explorer, seen: Seen, _: list[MadeUpSession]) -> None:
        other = Seen()
        explorer.show_in(other)
        assert seen.over
        assert other.speeds == [45]
        set_speed(explorer, 50)
        await explorer.settled()
        assert seen.speeds == [45]
        assert other.speeds == [45, 50]

    run(steps)


def test_a_scene_is_saved_beside_its_file_and_replaces_none_unasked(tmp_path: Path) -> None:
    original = tmp_path / "scene.toml"
    original.write_bytes(BRACH.read_bytes())

    async def steps(explorer: Explorer, seen: Seen, _: list[MadeUpSession]) -> None:
        set_speed(explorer, 50)
        with pytest.raises(SceneError, match="choose another name"):
            explorer.save(tmp_path, "scene")
        for name in ("", "..", "../scene", "a/b", "a\\b", str(tmp_path / "x")):
            with pytest.raises(SceneError, match="without a folder"):
                explorer.save(tmp_path, name, replace=True)
        assert original.read_bytes() == BRACH.read_bytes()
        path = explorer.save(tmp_path, "changed")
        assert path == tmp_path / "changed.toml"
        speed = load_scene(path).approach["a"].speed
        assert speed
        assert speed.value == pytest.approx(50 * MPH)
        assert explorer.save(tmp_path, "scene.toml", replace=True) == original
        assert original.read_text("utf-8") == path.read_text("utf-8")

    run(steps)


def test_what_is_confirmed_is_written(tmp_path: Path) -> None:
    async def steps(explorer: Explorer, seen: Seen, _: list[MadeUpSession]) -> None:
        assert (await explorer.confirm(tmp_path / "out", "si")).read_text() == "<p>The report.</p>"
        assert (await explorer.archive(tmp_path / "out")).read_text() == "The archive."

    run(steps)
