"""How progress is shown: often enough, not too often, and where it is asked for."""

import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from types import ModuleType

import pytest

from retrodict import progress
from retrodict.progress import Tracker, duration, prefixed, reporting, shown_in_notebooks


class Clock:
    """A clock that a test advances."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hundredths of the seconds between lines."""
    for name in ("_GRACE", "_BEAT", "_MOST", "_LEAST"):
        monkeypatch.setattr(progress, name, getattr(progress, name) / 100)


def heartbeats() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == "progress"]


def test_it_is_imported_without_what_is_slow_to_import() -> None:
    code = "import sys, retrodict.progress; print({'jax', 'rich', 'numpy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_a_long_stage_has_a_line_every_five_seconds_and_not_one_a_heartbeat(capsys, clock) -> None:
    tracker = Tracker(clock)
    tracker.record("wheels (4 of 9): sampling", 0, 1)
    with progress._lines() as show:
        while clock.seconds < 120:
            show(tracker.now())
            clock.seconds += progress._BEAT
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "retrodict: 0 s: wheels (4 of 9): sampling"
    assert lines[-1] == "retrodict: 1 min 56 s: wheels (4 of 9): sampling"
    assert 120 / 5 < len(lines) <= 120 / progress._MOST


def test_a_stage_is_named_when_it_begins_but_no_more_than_one_a_second(capsys, clock) -> None:
    tracker = Tracker(clock)
    with progress._lines() as show:
        for i in range(40):
            tracker.record(f"stage {i}", 0, 1)
            show(tracker.now())
            clock.seconds += 0.125
        clock.seconds += 0.875
        show(tracker.now())
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(": ")[-1] for line in lines] == [
        "stage 0", "stage 8", "stage 16", "stage 24", "stage 32", "stage 39",
    ]  # fmt: skip


def test_the_time_left_is_that_of_a_steady_rate_without_the_wait_before_it(clock) -> None:
    """A compiler takes 30 s; then 5 of 100 are done a second, so that at 45 there are 11 s left."""
    tracker = Tracker(clock)
    for done in range(0, 50, 5):
        clock.seconds = 30 + done / 5 if done else 0
        tracker.record("sampling", done, 100)
        now = tracker.now()
        assert (now.left is None) == (done < 25)  # a fifth after the first ones were done
    assert now.left == pytest.approx(11)
    assert now.line == "retrodict: 39 s: sampling, 45 %, about 11 s left in this stage"
    tracker.record("sampling", 0, 100)  # once more
    assert tracker.now().line == "retrodict: 39 s: sampling"
    tracker.record("sampling", 100, 100)
    clock.seconds += 10
    assert tracker.now().left is None


def test_a_call_that_blocks_python_s_main_thread_is_not_silent(hasty, capsys) -> None:
    with reporting() as report:
        report("compiling", 0, 1)
        time.sleep(0.8)  # in C, without Python's lock, as XLA compiles
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) > 3
    assert set(lines) <= {f"retrodict: {i} s: compiling" for i in range(60)}


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_the_heartbeat_ends_with_its_context(error, hasty) -> None:
    def work() -> None:
        with reporting() as report:
            report("sampling", 1, 2)
            assert len(heartbeats()) == 1
            raise error

    with pytest.raises(error):
        work()
    assert not heartbeats()


def test_quiet_is_silent_and_has_no_heartbeat(hasty, capsys) -> None:
    with reporting(quiet=True) as report:
        report("sampling", 1, 2)
        assert not heartbeats()
        time.sleep(0.1)
    assert capsys.readouterr() == ("", "")


def test_what_is_refused_at_once_shows_no_progress(capsys) -> None:
    with pytest.raises(ValueError, match="refused"), reporting():
        raise ValueError("refused")
    assert capsys.readouterr() == ("", "")


def test_no_control_character_of_a_name_reaches_the_terminal(capsys) -> None:
    with reporting() as report:
        prefixed(report, "\x1b[2Jcase\a\n\u202e")("sampling", 0, 1)
    assert capsys.readouterr().err == "retrodict: 0 s:  [2Jcase   : sampling\n"


def test_work_goes_on_when_nobody_reads(hasty, monkeypatch) -> None:
    class Gone:
        def write(self, text: str) -> None:
            raise BrokenPipeError

        def isatty(self) -> bool:
            return False

    monkeypatch.setattr(sys, "stderr", Gone())
    with reporting() as report:
        report("sampling", 1, 2)
        time.sleep(0.1)
        report("predicting", 1, 1)


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch, capsys) -> Callable[[], list[str]]:
    """A terminal on standard error; gives the frames that were drawn on it, without their colours."""
    for name, value in (("FORCE_COLOR", "1"), ("TERM", "xterm"), ("COLUMNS", "100")):
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(progress, "_display", progress._bars)

    def frames() -> list[str]:
        out, err = capsys.readouterr()
        assert out == "an answer\n"  # what a command prints is not redirected
        return [re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", frame) for frame in err.split("\x1b[2K")]

    return frames


def test_a_terminal_has_a_bar_for_each_part_of_the_work(terminal) -> None:
    with reporting() as report:
        for i in (1, 2):
            inner = prefixed(report, f"[b]case ({i} of 2)")
            inner("sampling", 1, 2)
            inner("predicting", 1, 1)
        print("an answer")
    frames = terminal()
    assert frames[0].startswith("[b]case (1 of 2): sampling ━━━")
    finished, present = frames[-1].splitlines()
    assert finished.startswith("[b]case (1 of 2)  ")
    assert present.startswith("[b]case (2 of 2): predicting ━━━")


@pytest.mark.parametrize(
    ("terminal", "kind", "display"),
    [(True, "xterm", "bars"), (True, "dumb", "lines"), (False, "xterm", "lines")],
)
def test_bars_are_drawn_only_where_they_can_be(terminal, kind, display, monkeypatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")  # as CI sets it, whose logs are no terminals
    monkeypatch.setenv("TERM", kind)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    for name in ("bars", "lines"):
        monkeypatch.setattr(progress, f"_{name}", lambda name=name: name)
    assert progress._display() == display


def test_an_error_leaves_no_bar(terminal) -> None:
    def work() -> None:
        with reporting() as report:
            report("sampling", 1, 2)
            print("an answer")
            raise ValueError("failed")

    with pytest.raises(ValueError, match="failed"):
        work()
    frames = terminal()
    assert "sampling" in frames[0]
    assert not frames[-1].strip()


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, str]]:
    """What a cell shows, one bundle after another."""
    shown: list[dict[str, str]] = []

    class Handle:
        def update(self, bundle: dict[str, str], *, raw: bool) -> None:
            assert raw
            shown.append(bundle)

    def display(bundle: dict[str, str], *, raw: bool, display_id: bool) -> Handle:
        assert threading.current_thread() is threading.main_thread()
        assert raw
        assert display_id
        shown.append(bundle)
        return Handle()

    module = ModuleType("IPython.display")
    module.display = display  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    monkeypatch.setattr(progress, "in_notebook", lambda: True)
    return shown


@shown_in_notebooks
def work(answer: int, *, progress: progress.Progress | None = None) -> int:
    if progress:
        progress("<i>sampling", 1, 4)
    return answer


def test_a_notebook_shows_progress_in_its_cell_and_takes_it_away(hasty, notebook, capsys) -> None:
    assert work(42) == 42
    assert capsys.readouterr() == ("", "")
    html = '<progress value="0.250"></progress> retrodict: 0 s: &lt;i&gt;sampling, 25 %'
    assert html in [bundle["text/html"] for bundle in notebook]
    assert notebook[-1] == {"text/plain": "", "text/html": ""}


def test_a_callback_that_is_given_is_the_only_one(hasty, notebook) -> None:
    seen = []
    assert work(42, progress=lambda *at: seen.append(at)) == 42
    assert seen == [("<i>sampling", 1, 4)]
    assert not notebook


def test_a_script_shows_nothing_unasked(hasty, capsys) -> None:
    assert not progress.in_notebook()
    assert work(42) == 42
    assert capsys.readouterr() == ("", "")


def test_durations_are_given_in_minutes_from_a_minute_on() -> None:
    assert [duration(s) for s in (0.4, 59.4, 59.6, 200)] == [
        "0 s",
        "59 s",
        "1 min 0 s",
        "3 min 20 s",
    ]
