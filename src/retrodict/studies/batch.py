"""Answers many scenes, each by itself.

An answer depends on its scene, model, seed and this package's version, and on nothing else: neither on
the order in which scenes are answered nor on what else is in the batch. The failure of one scene
stops no other.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from itertools import batched
from pathlib import Path

from retrodict.inference import points
from retrodict.inference.density.together import Calls, Together, room
from retrodict.inference.errors import Interrupted, Unanswerable
from retrodict.inference.outcome import Checks
from retrodict.inference.reconstruct import compile_search, reconstruct
from retrodict.inference.threads import one_blas_thread
from retrodict.models import RUNGS
from retrodict.options import RunOptions
from retrodict.progress import Progress, silent
from retrodict.scene.errors import SceneError
from retrodict.scene.load import READERS, read_text, scene_from, toml_of
from retrodict.scene.records import Scene
from retrodict.scene.write import scene_toml
from retrodict.studies import device as devices
from retrodict.studies.engine import Engine, WorkerDied
from retrodict.studies.ladder import AUTO, allowed, chosen_for
from retrodict.studies.short import Short, of_draws, of_points

_SCENES = {"cpu": 4, "gpu": 64}  # scenes that a worker answers at a time, by device
_TIMES = 4  # factor of the points of scenes that a GPU answers where the first ones do not do
_FILES = 50  # files that a worker reads at a time


Keyed = Sequence[tuple[str, Scene]]  # scenes, each with the key that its answer is kept under


@dataclass(frozen=True, slots=True)
class Answered:
    """The answer to a scene, or why there is none.

    Args:
        model: name of the rung; empty where none was reached.
        method: name of the method that gave the numbers, or those that failed their checks.
        reason: why there are no numbers; empty where there are.
        flags: findings about the scene, as in `Checks`.
        numbers: statistics of each reported quantity, SI units and radians.
    """

    model: str = ""
    method: str = ""
    reason: str = ""
    flags: tuple[str, ...] = ()
    numbers: Short = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Asked:
    """What is asked of every scene of a batch.

    Args:
        model: a rung's name; "auto" for the one that the ladder chooses for each scene.
        seed: integer seed of all random numbers.
        device: device that JAX computes on, "cpu" or "gpu".
        version: version of this package.
    """

    model: str
    seed: int = 0
    device: str = "cpu"
    version: str = field(default_factory=partial(version, "retrodict"))


@dataclass(frozen=True, slots=True)
class Entry:
    """A scene of a batch.

    Args:
        label: path of the scene's file, or name of the scene where it has no file.
        source: the text of its file; or the scene itself; or why the file cannot be read.
        key: digest of the scene's content, which `kept_under` joins with what is asked.
    """

    label: str
    source: str | Scene | SceneError
    key: str

    @classmethod
    def of(cls, scene: Scene | str | Path) -> Entry:
        """The entry of a scene, or of the scene file at a path."""
        if isinstance(scene, Scene):
            said = scene_toml(scene), scene.inputs(), scene.evidence()
            return cls(scene.name, scene, _digest(repr(said)))
        try:
            text = read_text(scene)
        except SceneError as error:
            return cls(str(scene), error, _digest(str(scene)))
        return cls(str(scene), text, _digest(text))

    def scene(self) -> Scene:
        """The measured scene.

        Raises:
            SceneError: the file cannot be used.
        """
        if isinstance(self.source, SceneError):
            raise self.source
        if isinstance(self.source, Scene):
            return self.source
        path = Path(self.label)
        tables = READERS.get(path.suffix.lower(), toml_of)(self.source, self.label)
        return scene_from(tables, path.stem, self.source, self.label)

    def kept_under(self, asked: Asked) -> str:
        """The key that the answer is kept under, given what is asked."""
        return _digest(f"{self.key} {asked.model} {asked.seed} {asked.device} {asked.version}")


def answer(scene: Scene, model: str, seed: int) -> Answered:
    """The statistics of a scene's posterior.

    They come from weighted points; where wheels roll, or the points fail their checks, from the draws
    of `reconstruct`, by tempering in the latter case.

    Args:
        scene: the measured scene.
        model: a name in `retrodict.models.RUNGS`, or "auto".
        seed: integer seed of all random numbers.

    Returns:
        The answer; or the reason why there is none, unexpected errors included.

    Raises:
        KeyboardInterrupt: the run was stopped before the answer was known.
    """
    name = ""
    try:
        with one_blas_thread():
            name = chosen_for(scene, seed=seed)[0] if model == AUTO else model
            found = _by_points(scene, name, seed)
            if found and not found.reason:
                return found
            return _by_draws(scene, name, seed, "smc" if found else "importance")
    except Unanswerable as refusal:
        return Answered(name, reason=f"refused: {refusal}")
    except Interrupted:
        raise KeyboardInterrupt from None
    except Exception as error:
        return Answered(name, reason=_unexpected(error))


def _by_points(scene: Scene, model: str, seed: int, times: int = 1) -> Answered | None:
    """The answer by weighted points, which may have failed; None where there cannot be any."""
    if room() is None:
        compile_search(scene, model)
    try:
        found = points.answer(scene, model, seed, times)
    except Unanswerable:
        return None
    return _answered(model, "importance", found.checks, partial(of_points, found))


def _by_draws(scene: Scene, model: str, seed: int, method: str) -> Answered:
    # where the method fails, another stands in
    found = reconstruct(scene, RunOptions(model=model, method=method, seed=seed), pictured=False)
    if not found.complete:
        raise KeyboardInterrupt
    return _answered(model, str(found.settings["method"]), found.checks, partial(of_draws, found))


def _answered(model: str, method: str, checks: Checks, numbers: Callable[[], Short]) -> Answered:
    reason = f"checks failed: {'; '.join(checks.reasons)}" if checks.reasons else ""
    return Answered(model, method, reason, checks.flags, {} if reason else numbers())


def _unexpected(error: Exception) -> str:
    said = str(error).splitlines() or [""]
    return f"unexpected: {type(error).__name__}: {said[0]}"


def answers(
    entries: Sequence[Entry],
    asked: Asked,
    engine: Engine,
    *,
    known: Mapping[str, Answered] | None = None,
    keep: Callable[[Mapping[str, Answered]], None] | None = None,
    progress: Progress | None = None,
) -> list[Answered | None]:
    """Answer every scene of a batch that is not yet answered.

    Args:
        entries: the scenes.
        asked: model, seed, device and version to answer each scene with.
        engine: engine that the jobs run on.
        known: answers of an earlier run by `Entry.kept_under`, which are not sought again.
        keep: called with some answers as they come, by the same keys.
        progress: called with (stage, done, of all).

    Returns:
        The answer of each entry; when interrupted, None where it did not come.

    Raises:
        NoDevice: a worker does not find the device.
        ValueError: a worker has another version of this package.
    """
    report = progress or silent
    done = dict(known or {})  # and what is refused as it is read, which is not kept
    by_key = {entry.kept_under(asked): entry for entry in entries}

    def report_answered() -> None:
        report("answering scenes", sum(key in done for key in by_key), len(by_key))

    try:
        alike: dict[Hashable, list[tuple[str, Scene]]] = {}
        unknown = [(key, entry) for key, entry in by_key.items() if key not in done]
        read_so_far = 0
        report("reading scenes", read_so_far, len(unknown))
        for files, read in engine.each(partial(_read_all, asked), batched(unknown, _FILES)):
            if isinstance(read, WorkerDied):
                raise read
            for (key, _), (scene, structure) in zip(files, read, strict=True):
                if isinstance(scene, Answered):
                    done[key] = scene
                else:
                    alike.setdefault(structure, []).append((key, scene))
                read_so_far += 1
            report("reading scenes", read_so_far, len(unknown))
        report_answered()
        # some of each structure go first: they keep the compiled programs that the others load
        at_once = _SCENES[asked.device]
        few = 1 if asked.device == "cpu" else at_once
        first = {scenes[0][0]: scenes[few:] for scenes in alike.values()}

        def more(scenes: Keyed, found: list[Answered] | WorkerDied) -> list[Keyed]:
            alone = batched(scenes, 1) if isinstance(found, WorkerDied) and len(scenes) > 1 else ()
            return [*alone, *batched(first.pop(scenes[0][0], []), at_once)]

        job = partial(_answer_all, asked)
        ones: list[Keyed] = [scenes[:few] for scenes in alike.values()]
        for scenes, found in engine.each(job, ones, more):
            if isinstance(found, WorkerDied):
                if len(scenes) > 1:  # they come again, each alone
                    continue
                found = [Answered(reason=f"unexpected: {found}")]
            new = {key: one for (key, _), one in zip(scenes, found, strict=True)}
            if keep:
                keep(new)
            done |= new
            report_answered()
    except KeyboardInterrupt:
        pass
    return [done.get(entry.kept_under(asked)) for entry in entries]


def _ready(asked: Asked) -> None:
    """See that a worker gives the answers that are asked for."""
    if (here := version("retrodict")) != asked.version:
        raise ValueError(
            f"a worker has retrodict {here}, and this is {asked.version}: install the same on all"
        )
    devices.choose(asked.device)


def _read_all(
    asked: Asked, entries: Sequence[tuple[str, Entry]]
) -> list[tuple[Scene | Answered, Hashable]]:
    """Scenes, each with what it shares its programs with; or why there is none."""
    _ready(asked)
    return [_read_one(asked, entry) for _, entry in entries]


def _read_one(asked: Asked, entry: Entry) -> tuple[Scene | Answered, Hashable]:
    try:
        scene = entry.scene()
        model = allowed(scene)[-1] if asked.model == AUTO else asked.model
        return scene, RUNGS[model].of_scene(scene)[0]
    except SceneError as error:
        return Answered(reason=f"unusable: {'; '.join(map(str, error.problems))}"), None
    except Unanswerable as refusal:
        return Answered(reason=f"refused: {refusal}"), None
    except Exception as error:
        return Answered(reason=_unexpected(error)), None


def _answer_all(asked: Asked, scenes: Keyed) -> list[Answered]:
    _ready(asked)
    found: dict[str, Answered] = {}
    if asked.device != "cpu" and asked.model != AUTO:
        for times in (1, _TIMES):
            left = [each for each in scenes if each[0] not in found]
            found |= _all_by_points(left, asked, times)
        with devices.processor():  # what is left is by other methods, which a GPU takes longer for
            left = [each for each in scenes if each[0] not in found]
            found |= {key: answer(scene, asked.model, asked.seed) for key, scene in left}
        return [found[key] for key, _ in scenes]
    # one after another: a core is as busy with one scene as with several, and calls that wait for
    # several carry more rows that nobody asked for (1.4 times the seconds, of 20 simulated crashes)
    return [answer(scene, asked.model, asked.seed) for _, scene in scenes]


def _all_by_points(scenes: Keyed, asked: Asked, times: int) -> dict[str, Answered]:
    """The answers of `_by_points` that passed, by key."""

    def one(scene: Scene) -> Answered | None:
        try:
            return _by_points(scene, asked.model, asked.seed, times)
        except Exception:  # `answer` will say what it is
            return None

    found = Together(Calls()).results([partial(one, scene) for _, scene in scenes])
    return {
        key: each for (key, _), each in zip(scenes, found, strict=True) if each and not each.reason
    }


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:32]
