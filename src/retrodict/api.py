"""The public functions: reconstruct one scene or many, compare models, calibrate, validate, replay."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from retrodict.inference.modes import ModeSearch
from retrodict.inference.outcome import Outcome
from retrodict.inference.own import Priors, Terms, with_own
from retrodict.inference.plan import suited
from retrodict.inference.reconstruct import reconstruct as _reconstruct
from retrodict.models import RUNGS
from retrodict.notebook import Scene  # with what it shows of itself
from retrodict.options import DEFAULT_RUNG, RunOptions
from retrodict.progress import Progress, prefixed, shown_in_notebooks, silent
from retrodict.report.libraries import imported
from retrodict.result import CHAINS, Result, load_result
from retrodict.scene.load import as_scene
from retrodict.scene.own import own_of
from retrodict.scene.quantities import Units
from retrodict.storage import checkpoint
from retrodict.studies import calibration as _calibration
from retrodict.studies import validation as _validation
from retrodict.studies.calibration import Calibration
from retrodict.studies.comparison import Ladder
from retrodict.studies.engine import engine
from retrodict.studies.ladder import AUTO, chosen_for
from retrodict.studies.ladder import ladder as _ladder
from retrodict.studies.validation import Validation

if TYPE_CHECKING:
    import pandas as pd

    from retrodict.findings.reproduction import Reproduction


__all__ = [
    "CHAINS",
    "Calibration",
    "Ladder",
    "Result",
    "Validation",
    "batch",
    "calibrate",
    "ladder",
    "load_result",
    "reconstruct",
    "replay",
    "validate",
]

_KEPT_EVERY = 20.0  # s between two writings of a validation that goes on

ladder = shown_in_notebooks(_ladder)


@shown_in_notebooks
def replay(
    path: str | Path,
    *,
    progress: Progress | None = None,
    priors: Priors | None = None,
    extra: Terms | None = None,
) -> Reproduction:
    """Verify an archive, run it anew as it was asked for, and compare every number.

    Args:
        path: path of an archive, as `Result.archive` writes it.
        progress: progress callback, as in `reconstruct`.
        priors, extra: priors and likelihood terms of your own that the run had, as in `reconstruct`; an
            archive names them but does not hold them.

    Returns:
        The numbers that came out the same, and the versions that differ.

    Raises:
        NotArchived: the file is no archive, or was altered; the message names the altered part.
        SceneError: this version does not read the scene.
        ValueError: the run had priors or terms of the user's own that are not given here, or others.
        Unanswerable, Interrupted: as in `reconstruct`.

    Examples:
        >>> import retrodict as rd
        >>> asked = {"model": "momentum+slide", "method": "importance"}
        >>> result = rd.reconstruct("examples/brach-1977/scene.toml", **asked)
        >>> rd.replay(result.archive("brach-1977.retrodict.zip")).reproduced
        True
    """
    from retrodict.findings.reproduction import compare
    from retrodict.findings.stored import draws_of
    from retrodict.report.result_archive import recorded_in
    from retrodict.storage.archive import read_archive

    archive = read_archive(Path(path))
    recorded = recorded_in(archive, str(path))
    scene = with_own(recorded.scene, priors, extra)
    if own_of(scene) != recorded.own:
        raise ValueError(
            f"{path}: the run had of the user's own {', '.join(recorded.own) or 'nothing'}, which an "
            "archive does not hold; give replay the same priors and extra, and no others"
        )
    result = reconstruct(scene, **recorded.asked, progress=progress)
    draws = draws_of(recorded.draws)
    return compare(archive.link, recorded.summary, draws, result.findings, result.idata)


@shown_in_notebooks
def reconstruct(
    scene: Scene | str | Path,
    *,
    model: str = AUTO,
    method: str = AUTO,
    chains: int = 4,
    draws: int | None = None,
    warmup: int = 150,
    seed: int = 0,
    progress: Progress | None = None,
    resume: Path | None = None,
    priors: Priors | None = None,
    extra: Terms | None = None,
) -> Result:
    """The joint posterior of B's approach, e, e_m and mu.

    Args:
        scene: scene with the measurements, or the path of a scene file.
        model: name of a rung; "auto" for the one that the ladder chooses among those that the
            question and the evidence allow, or the most detailed of these where it chooses none.
        method: nuts (the reference), importance, smc, laplace, monte-carlo or linear; "auto" for nuts,
            and for importance where some wheel rolls, whose run-outs have no cheap derivatives. Where
            nuts or importance fails, another stands in; a note says so.
        chains: number of chains, or of independent replicates where a method has no chains.
        draws: number of draws kept of each chain; None for the method's default.
        warmup: number of warm-up iterations before the draws, where a method has any.
        seed: integer seed of all random numbers; same seed, same machine, same numbers.
        progress: callback, called with (stage, done, total) as the work goes on, each stage prefixed by
            the name of the model; None shows the progress in a notebook, and nothing elsewhere.
        resume: path of the `chains.npz` of an interrupted run, to go on with; None to begin anew.
        priors: distribution of NumPyro for an unknown by its name (speed_a, speed_b, e, e_m, mu), in SI
            units, in place of the scene's prior; None for the scene's.
        extra: log likelihood terms by a name of yours: functions of the recorded quantities of a crash
            by name, SI units and radians, in `jax.numpy`; None for none.

    Returns:
        The result.

    Raises:
        SceneError: the scene file cannot be used.
        ValueError: no model or method has that name, `resume` is of another run, or a prior or term
            cannot be used.
        Unanswerable: the scene has no posterior that could be sampled; the message says why.
        Interrupted: the run was stopped before any draw was kept.

    Examples:
        >>> import retrodict as rd
        >>> scene = rd.load_scene("examples/brach-1977/scene.toml")
        >>> result = rd.reconstruct(scene, model="momentum+slide", method="importance")
        >>> result.checks.passed
        True
        >>> list(result.summary("us").columns[:3])
        ['unit', 'mean', 'sd']
    """
    begin, scene = time.perf_counter(), with_own(as_scene(scene), priors, extra)
    asked = RunOptions(model, method, chains, draws, warmup, seed)
    if resume is not None:
        checkpoint.read(resume)  # what is damaged is refused before the work
    comparison, search = None, ModeSearch(scene, seed)
    if method == AUTO:
        method = suited(scene)
    if model == AUTO:
        model, comparison = chosen_for(scene, seed=seed, progress=progress, search=search)
        search.unload_others(model)
    outcome = _reconstruct(
        scene,
        replace(asked, model=model, method=method),
        asked=asked,
        progress=prefixed(progress or silent, model),
        resume=resume,
        search=search,
    )
    return _timed(outcome, comparison, begin)


def _timed(outcome: Outcome, comparison: Ladder | None, begin: float) -> Result:
    """The result, whose total is the time that the user waited, the comparison of models included."""
    seconds = outcome.seconds | {"total": time.perf_counter() - begin}
    return Result(replace(outcome, seconds=seconds), comparison)


@shown_in_notebooks
def calibrate(
    scene: Scene | str | Path | None = None,
    *,
    model: str = DEFAULT_RUNG,
    method: str = "importance",
    simulations: int = 1000,
    seed: int = 0,
    out: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Calibration:
    """Whether a model and a method can be relied on: simulated crashes, and where the truth lies.

    Several processes are started; a script calls this under `if __name__ == "__main__":`.

    Args:
        scene: scene whose inputs and errors are the design of the simulations, or the path of its scene
            file; None for the design in the package.
        model: name of a rung.
        method: importance, nuts or smc.
        simulations: number of simulated crashes.
        seed: integer seed of all random numbers.
        out: folder for calibration.csv, .json, .png and .svg; a run goes on with a .csv that is already
            there. None writes nothing.
        workers, scheduler: number of processes, or address of a Dask cluster, as in `batch`.
        progress: progress callback, as in `reconstruct`; stages have no model's name.

    Returns:
        The ranks; `retrodict.studies.uniformity.uniformity` judges them. When interrupted, those of
        the simulations that were finished.

    Raises:
        SceneError: the scene file cannot be used.
        ValueError: no model or method has that name, the scene cannot be simulated, or the file in
            `out` is of another calibration.
        MissingLibrary, NoScheduler: as in `batch`.
        OSError: a file could not be written.

    Examples:
        >>> import retrodict as rd
        >>> rd.calibrate(model="momentum+spin", simulations=2, workers=1).simulations  # 1000 in earnest
        2
    """
    from retrodict.report.calibration import read_ranks, write_calibration, write_ranks

    _see_that_engine_is_installed(workers, scheduler)
    scene = _calibration.design() if scene is None else as_scene(scene)
    asked = Calibration(scene, model, method, seed, simulations)
    folder = None if out is None else Path(out)
    found = _calibration.calibrate(
        scene,
        model=model,
        method=method,
        simulations=simulations,
        seed=seed,
        known=read_ranks(asked, folder) if folder else (),
        workers=workers,
        scheduler=scheduler,
        progress=progress,
        keep=partial(write_ranks, directory=folder) if folder else None,
    )
    if folder:
        write_calibration(found, folder)
    return found


@shown_in_notebooks
def batch(
    scenes: Iterable[Scene | str | Path],
    *,
    model: str = DEFAULT_RUNG,
    seed: int = 0,
    units: Units = "si",
    out: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Answers to many scenes in one table, each as if it were alone.

    Several processes are started; a script calls this under `if __name__ == "__main__":`.

    Args:
        scenes: scenes with the measurements, or paths of scene files.
        model: name of a rung; "auto" for the one that the ladder chooses for each scene, which takes
            many times as long.
        seed: integer seed of all random numbers.
        units: units of the table, "si" or "us".
        out: folder for table.csv and table.parquet; each answer is kept there as it comes, and a run
            goes on with those that are there. None writes nothing.
        workers: number of processes on this machine; 1 for the present process alone; None for one a
            core, or 1 where Dask is not installed.
        scheduler: address of a Dask cluster to use in place of such processes.
        device: device that JAX computes on, "cpu" or "gpu"; with a GPU one worker is the default.
        progress: callback, called with (stage, done, total).

    Returns:
        One row a scene, as in `retrodict.report.batch.table_of`: in `checks` the verdict, or why there
        is no answer. When interrupted, the scenes that were answered, and no table is written.

    Raises:
        ValueError: no model has that name, or JAX does not find the device.
        MissingLibrary: workers need Dask, which is not installed.
        NoScheduler: there is no scheduler at the address.
        OSError: a file could not be written, or another run answers into `out`.

    Examples:
        >>> import retrodict as rd
        >>> scene = rd.load_scene("examples/brach-1977/scene.toml")
        >>> faster = scene.change({"vehicles.A.approach.speed": "50 ± 1 mph"})
        >>> rd.batch([scene, faster], model="momentum+slide", workers=1)["checks"].tolist()
        ['passed', 'passed']
    """
    from retrodict.report import batch as files
    from retrodict.storage import rows
    from retrodict.studies.batch import Asked, Entry, answers

    if model not in (AUTO, *RUNGS):
        raise ValueError(f"model is auto or one of {', '.join(RUNGS)}; not {model!r}")
    if device == "gpu" and workers is None:
        workers = 1  # each takes most of a GPU's memory
    _see_that_engine_is_installed(workers, scheduler)
    entries = [Entry.of(scene) for scene in scenes]
    folder = None if out is None else Path(out)
    with ExitStack() as stack:
        known = {}
        if folder:
            stack.enter_context(rows.locked(folder))
            known = files.read_answers(folder)
        found = answers(
            entries,
            Asked(model, seed, device),
            stack.enter_context(engine(workers, scheduler)),
            known=known,
            keep=partial(files.write_answers, folder=folder) if folder else None,
            progress=progress,
        )
        table = files.table_of([entry.label for entry in entries], found, units)
        if folder and None not in found:
            files.write_table(table, folder)
    return table


def _see_that_engine_is_installed(workers: int | None, scheduler: str | None) -> None:
    if scheduler or (workers or 1) > 1:
        imported("distributed", "more than one worker", "cluster")


@shown_in_notebooks
def validate(
    folder: str | Path | Sequence[str | Path] = "examples",
    *,
    model: str = AUTO,
    method: str = "importance",
    exchange: bool = False,
    units: Units = "si",
    out: str | Path | None = None,
    progress: Progress | None = None,
) -> Validation:
    """How reconstructions of staged collisions compare with what was measured.

    Args:
        folder: folder of the cases, each a folder with scene.toml and truth.toml; or several of them.
        model: name of a rung, or "auto" for the one that the ladder chooses.
        method: sampling method, as in `reconstruct`.
        exchange: whether each case is also run with A and B exchanged, and read in other units.
        units: units of the table and the chart, "si" or "us".
        out: folder for validation.md, .csv, .json and the charts. None writes nothing.
        progress: progress callback, as in `reconstruct`; each stage begins with the name of the case.

    Returns:
        The scores; when interrupted, those of the cases that were finished.

    Raises:
        ValueError: no model or method has that name, or there is no case in the folder.
        OSError: a file could not be written.

    Examples:
        >>> import shutil
        >>> import retrodict as rd
        >>> folder = shutil.copytree("examples/ricsac-06", "staged/ricsac-06")
        >>> found = rd.validate("staged", model="momentum+slide", method="importance")
        >>> [score.quantity for score in found.scores]
        ['speed_a', 'speed_b']
    """

    def run(scene: Scene, progress: Progress) -> Outcome:
        return reconstruct(scene, model=model, method=method, progress=progress).outcome

    written = -_KEPT_EVERY

    def write(found: Validation) -> None:
        if out is not None:
            from retrodict.report.validation import write_validation

            write_validation(found, Path(out), units)

    def keep(found: Validation) -> None:
        nonlocal written
        if time.monotonic() - written >= _KEPT_EVERY:  # charts of many cases take a second or two
            write(found)
            written = time.monotonic()

    folders = [folder] if isinstance(folder, str | Path) else folder
    found = _validation.validate(
        _validation.cases(*map(Path, folders)),
        run,
        model=model,
        method=method,
        progress=progress,
        keep=keep,
        exchange=exchange,
    )
    write(found)
    return found
