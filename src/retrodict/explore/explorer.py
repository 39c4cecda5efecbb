"""State behind the page: the scene as changed so far, its newest answer, and the work under way."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from retrodict.explore.naming import named
from retrodict.progress import Progress, Tracker
from retrodict.scene.quantities import Units
from retrodict.scene.records import Scene
from retrodict.storage.files import write_whole

if TYPE_CHECKING:
    from retrodict.explore.answers import Answer


# stages, until a piece of work names its own
_PREPARING, _COMPUTING, _WRITING = "preparing the model", "computing", "writing the results"


class Saved(Protocol):
    """A result that can be written."""

    def save(self, directory: Path, units: Units = "si") -> Path:
        """Write it."""

    def archive(self, path: Path) -> Path:
        """Write it as one file."""


class Session(Protocol):
    """A warm posterior of one model, such as `retrodict.live.Session`."""

    @property
    def answer(self) -> Answer:
        """The present answer."""

    def update(self, changes: Scene) -> Answer:
        """Answer the scene as it is to be; where that fails, the session is as it was."""

    def confirm(self, *, progress: Progress) -> Saved:
        """The result by NUTS of the scene that was answered."""


# scene, a model's name or "auto", and a function that is called with progress -> a session
Open = Callable[[Scene, str, Progress], Session]


@dataclass(frozen=True, slots=True)
class Setting:
    """Settings of the page, besides the scene.

    Args:
        models: names of the models that can be chosen.
        out: folder that results are written to.
        file: path of the scene file; a changed scene is saved in the same folder.
        units: system of units that is shown first, "si" or "us".
    """

    models: tuple[str, ...]
    out: Path
    file: Path
    units: Units = "si"


class View(Protocol):
    """A page that shows what an explorer knows."""

    def working(self, busy: bool) -> None:
        """Say whether an answer is being computed."""

    def answered(self, answer: Answer) -> None:
        """Show an answer."""

    def failed(self, why: str) -> None:
        """Say why there is no answer."""

    def superseded(self) -> None:
        """Say that another page has taken over."""


class Explorer:
    """A scene that is changed, and asked again as soon as the answer before has come.

    All methods belong to one event loop. Work is done in a thread, one piece at a time; changes that
    arrive meanwhile are answered together, so that no answer is computed that nobody waits for.

    Args:
        scene: scene as its file has it; None while it is not complete.
        open_session: function that makes a session of a scene and a model.
        model: a rung's name, or "auto".
        edit: function that makes the changed scene of changes by key, such as on a drawing board; None
            for `Scene.change`.
        reset: function that is called where the scene goes back to the original.
    """

    def __init__(
        self,
        scene: Scene | None,
        open_session: Open,
        model: str = "auto",
        edit: Callable[[Mapping[str, object]], Scene] | None = None,
        reset: Callable[[Scene], object] | None = None,
    ) -> None:
        self.original = self.scene = scene
        self._edit, self._reset = edit, reset
        self.model = model
        self.texts: dict[str, str] = {}  # texts of changed quantities, by key
        self.answer: Answer | None = None
        self.of_file: Answer | None = None  # the answer for the original scene, by the same model
        self.fault = ""
        self.result: Saved | None = None  # the newest that was confirmed
        self._open = open_session
        self._session: Session | None = None
        self._model = ""  # the model of the session
        self._unwritten: tuple[str, ...] = ()  # what the scene that it was opened with leaves out
        self._asked = False  # whether the scene or the model has changed since it was last asked
        self._tracker: Tracker | None = None
        self._view: View | None = None
        self._task: asyncio.Task[None] | None = None
        self._busy = asyncio.Lock()

    def show_in(self, view: View) -> None:
        """Show in this view from now on, and in no other; begin the work if there is no answer yet."""
        if self._view is not None:
            self._view.superseded()
        self._view = view
        if self.answer is not None:
            view.answered(self.answer)
        if self.answer is None and self.scene is not None:
            self._ask()

    def follow(self, scene: Scene | None) -> None:
        """Go on to a scene that was drawn, and ask about it.

        Args:
            scene: scene as it is now; None while it is not complete.
        """
        if scene == self.scene:
            return
        self.scene, self.answer = scene, None
        self.fault = ""
        if scene is None:
            self._asked = False
        else:
            self._ask()

    def start_from_here(self) -> None:
        """Take the present scene for the one that changes are compared with."""
        if self.original is not self.scene:
            self.original, self.texts, self.of_file = self.scene, {}, None

    def leave(self, view: View) -> None:
        """Stop showing in a view that was closed."""
        if self._view is view:
            self._view = None

    def shown_in(self, view: View) -> bool:
        """Whether this view is the present one."""
        return self._view is view

    def change(self, key: str, text: str, changes: Mapping[str, object]) -> None:
        """Change the scene, and ask about it.

        Args:
            key: dotted key of the quantity.
            text: text of the quantity on the page, which `texts` keeps.
            changes: new values by dotted key, as `Scene.change` takes them.

        Raises:
            SceneError: the scene would be wrong; it stays as it was.
        """
        assert self.scene is not None
        self.scene = self._edit(changes) if self._edit else self.scene.change(changes)
        self.texts[key] = text
        self._ask()

    def reset(self) -> None:
        """Go back to the scene as its file has it."""
        self.texts = {}
        if self._reset and self.original is not None:
            self._reset(self.original)
        self.scene = self.original
        self._ask()

    def choose(self, model: str) -> None:
        """Ask another model.

        Args:
            model: a rung's name, or "auto".
        """
        self.model, self.of_file = model, None
        self._ask()

    async def settled(self) -> None:
        """Wait until everything that was asked is answered."""
        if self._task is not None:
            await self._task

    async def confirm(
        self,
        directory: Path,
        units: Units,
        around: Callable[[], AbstractContextManager[object]] = nullcontext,
    ) -> Path:
        """Reconstruct the scene as it is now by NUTS, and write the result.

        Args:
            directory: folder that the result is written to, as by `Result.save`.
            units: "si" or "us".
            around: function that makes the context in which it is written.

        Returns:
            The report's path.

        Raises:
            RuntimeError: there is no session to confirm.
            OSError: the result could not be written.
        """
        await self.settled()
        async with self._busy:
            if self._session is None or self._model != self.model or self.answer is None:
                raise RuntimeError(self.fault or "there is no answer to confirm")
            confirm = partial(self._session.confirm, progress=self._record)
            result = self.result = await self._run(_PREPARING, confirm)

            def write() -> None:
                with around():
                    result.save(directory, units)

            await self._run(_WRITING, write)
        return directory / "report.html"

    async def archive(self, directory: Path) -> Path:
        """Put the result that was confirmed last into one file beside its folder.

        Args:
            directory: folder that `confirm` wrote to; its result is read where this process has none.

        Returns:
            Path of the archive.

        Raises:
            NotStored: there is no result in the folder.
            OSError: the archive could not be written.
        """
        from retrodict.result import load_result
        from retrodict.storage.archive import SUFFIX

        path = directory.resolve().with_name(f"{directory.resolve().name}{SUFFIX}")

        def work() -> Path:
            result = self.result or load_result(directory)
            result.archive(path)
            return path

        async with self._busy:
            return await self._run(_WRITING, work)

    def save(self, directory: Path, name: str, replace: bool = False) -> Path:
        """Write the scene as it is now.

        Args:
            directory: folder of the file.
            name: name of the file; a suffix .toml is added where it has none.
            replace: whether a file of that name may be replaced.

        Returns:
            Path of the file.

        Raises:
            SceneError: the name is no file name, or is taken.
            OSError: the file could not be written.
        """
        path = named(directory, name, replace)
        assert self.scene is not None
        return write_whole(path, self.scene.to_toml().encode())

    @property
    def doing(self) -> str:
        """Progress of the present piece of work, in words; empty where there is none."""
        tracker = self._tracker
        return "" if tracker is None else tracker.now().line.removeprefix("retrodict: ")

    def _ask(self) -> None:
        self._asked = True
        if self._task is None or self._task.done():
            self._task = asyncio.get_running_loop().create_task(self._work())

    async def _work(self) -> None:
        """Answer until nothing waits."""
        async with self._busy:
            while self._asked:
                self._asked = False
                if self._view:
                    self._view.working(True)
                await self._answer()
        if self._view:
            self._view.working(False)

    async def _answer(self) -> None:
        scene, model = self.scene, self.model
        if scene is None:
            return
        session = self._session if self._model == model else None
        if model == "auto" and scene.unwritten != self._unwritten:
            session = None  # with another part of the contact known, another model is to be chosen
        try:
            if session is None:
                session = await self._run(_PREPARING, self._open, scene, model, self._record)
                self._unwritten = scene.unwritten
                answer = session.answer
            else:
                answer = await self._run(_COMPUTING, session.update, scene)
        except Exception as error:  # any is shown where the answer would stand
            self.answer, self.fault = None, str(error) or type(error).__name__
        else:
            self._session, self._model = session, model
            self.answer, self.fault = answer, ""
            if scene is self.original:
                self.of_file = answer
        if self.scene is None:
            self.answer = None  # it was drawn on, and is no longer complete
        if self.model != model or self._view is None or self.scene is None:
            return  # nobody asks any longer, or there is no view
        if self.answer is None:
            self._view.failed(self.fault)
        else:
            self._view.answered(self.answer)

    async def _run[T](self, stage: str, work: Callable[..., T], *args: Any) -> T:
        """Do a piece of work in a thread, with its progress in `doing`.

        The thread is a daemon: the command can end while a library computes.
        """
        loop, self._tracker = asyncio.get_running_loop(), Tracker()
        self._tracker.record(stage, 0, 1)
        done: asyncio.Future[T] = loop.create_future()

        def settle(found: T | None, error: BaseException | None) -> None:
            if done.done():  # nobody waits any more
                return
            if error is None:
                done.set_result(cast(T, found))
            else:
                done.set_exception(error)

        def run() -> None:
            found, error = None, None
            try:
                found = work(*args)
            except BaseException as raised:
                error = raised
            with suppress(RuntimeError):  # where the loop has been closed
                loop.call_soon_threadsafe(settle, found, error)

        threading.Thread(target=run, daemon=True).start()
        try:
            return await done
        finally:
            self._tracker = None

    def _record(self, stage: str, done: int, total: int) -> None:
        if self._tracker is not None:
            self._tracker.record(stage, done, total)
