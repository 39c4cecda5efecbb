"""Reconstruction of a scene: coordinates, draws, checks, and the record of how it was done."""

from __future__ import annotations

import platform
import time
from dataclasses import replace
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

import numpy as np

from retrodict.inference.attempt import Run, Sampling, first_that_passes
from retrodict.inference.density.compiled import COMPILATION, programs_for
from retrodict.inference.density.kernels import (
    BATCH,
    CRASHES,
    EVALUATE,
    INPUTS,
    LEVELS,
    REACHED,
    rows_of,
)
from retrodict.inference.modes import ModeSearch, PosteriorModes, Solution
from retrodict.inference.outcome import Outcome, attributes_of
from retrodict.inference.plan import Way, is_quick, planned
from retrodict.inference.pointwise import pointwise
from retrodict.inference.samplers import METHODS
from retrodict.inference.threads import one_blas_thread
from retrodict.inference.transforms.choice import Coordinates
from retrodict.inference.transforms.rest_pose import RestPose
from retrodict.models import RUNGS
from retrodict.options import RunOptions
from retrodict.progress import Progress, silent
from retrodict.scene.own import own_of
from retrodict.scene.records import VEHICLES, Scene


@one_blas_thread()
def reconstruct(
    scene: Scene,
    options: RunOptions | None = None,
    *,
    asked: RunOptions | None = None,
    progress: Progress | None = None,
    resume: Path | None = None,
    pictured: bool = True,
    search: ModeSearch | None = None,
) -> Outcome:
    """The joint posterior of the speeds that are sought, e, e_m and mu, with its checks.

    Args:
        scene: scene to be reconstructed.
        options: options of the run; None for the defaults.
        asked: options as the user gave them, for the record; None for `options`.
        progress: callback that is called with (stage, done, of all) as the work goes on.
        resume: chains.npz of an interrupted run that is to be continued; None to begin anew.
        pictured: whether the prior and run-outs, which figures show, are recorded too.
        search: search for this scene's solutions by the same seed, shared by the models of a ladder;
            None for a new one.

    Returns:
        The outcome; marked incomplete when interrupted with some draws already kept.

    Raises:
        ValueError: no rung or method has that name, the method has no chains to resume, or `resume`
            is of another run.
        Unanswerable: a rest pose cannot be reached, the posterior has no finite mode, or the rung is no
            model of an impact with a barrier.
        Interrupted: stopped before any draw was kept.
    """
    begin, compiled_before = time.perf_counter(), COMPILATION.seconds
    options, report = options or RunOptions(), progress or silent
    model, search = options.model, search or ModeSearch(scene, options.seed)
    plan = planned(scene, options, resume)
    report("compiling", 0, 1)
    compile_search(scene, model)
    for slow in ("xarray", "arviz_stats"):  # imported while programs compile
        import_module(slow)

    def find(way: Way) -> PosteriorModes:
        report("finding where the posterior lies", 0, 1)
        coordinates = search.plainest(model, way.coordinates)
        compile_ahead(scene, model, way.method, coordinates, options.warmup)
        return search.on(model, coordinates, weighted=not METHODS[way.method].weighs)

    def draw(way: Way, where: PosteriorModes) -> Run:
        sampling = Sampling(where, search.reference(model), pictured, report)
        return sampling.by(way.method, options, resume if way is plan[0] else None)

    run = first_that_passes(plan, find, draw, quick=is_quick(options))
    report("predicting", 1, 1)
    run = replace(run, idata=pointwise(run.idata))  # its time is in the total
    seconds = {
        "total": time.perf_counter() - begin,
        "compile": COMPILATION.seconds - compiled_before,
        "sample": run.seconds,
    }
    return _outcome(run, options, asked or options, seconds)


def _outcome(
    run: Run, options: RunOptions, asked: RunOptions, seconds: dict[str, float]
) -> Outcome:
    """What a run has found, with the record of how it was done."""
    scene = run.found[0].scene
    outcome = Outcome(
        scene=scene,
        description=RUNGS[options.model].description(scene),
        idata=run.idata,
        checks=run.checks,
        seconds=seconds,
        versions=_versions(),
        seed=options.seed,
        settings=_settings(run, options),
        asked=asked,
        complete=run.complete,
        notes=(*run.notes, *_notes(run), *_notes_on_own(scene)),
        unfinished=run.unfinished,
        modes=tuple(solution.mode for solution in run.found),
    )
    outcome.idata.attrs.update(attributes_of(outcome))
    return outcome


def _settings(run: Run, options: RunOptions) -> dict[str, int | str]:
    """Method and numbers that the draws came from."""
    return {
        "method": run.method,
        "chains": options.chains,
        "draws": run.draws,
        "warmup": options.warmup,
    }


def _notes(run: Run) -> list[str]:
    """Remarks on a run that follow from its method and its modes."""
    notes = [_several_modes_note(run.found)] if len(run.found) > 1 else []
    method = METHODS[run.method]
    if not method.exact:
        notes.append(f"{method.title}: an approximation; compare it with the method nuts")
    return notes


def _notes_on_own(scene: Scene) -> list[str]:
    """Remarks on priors and likelihood terms that the user gave in Python."""
    if not (own := own_of(scene)):
        return []
    return [
        f"{', '.join(own)}: of the user's own, given in Python; the scene file does not have it, no "
        "check of this program judges it, and the run cannot be repeated without it"
    ]


def _several_modes_note(found: tuple[Solution, ...]) -> str:
    listed = "; ".join(
        f"{s.label()} (weight {s.mode.weight:.1%} ± {s.mode.error:.1%})" for s in found
    )
    note = f"the evidence fits several ways: {listed}; draws of each are mixed by their weights"
    if any(s.turns != found[0].turns for s in found):
        note += ": write each vehicle's rotation into its [vehicles.X.rest] where it is known"
    return note


def compile_search(scene: Scene, model: str) -> None:
    """Compile in the background what the search needs; arguments as of `compile_ahead`."""
    structure, data = RUNGS[model].of_scene(scene)
    crash = np.zeros((rows_of(structure), structure.deviates))
    programs_for(structure.without_transform).expect(CRASHES, data, crash)


def compile_ahead(
    scene: Scene, model: str, method: str, coordinates: Coordinates, warmup: int
) -> None:
    """Compile in the background what fitting coordinates and drawing need, in the order of the need.

    Args:
        scene: scene to be reconstructed.
        model: a name in `retrodict.models.RUNGS`.
        method: a name in METHODS.
        coordinates: coordinates of the draws; deviates need no more programs than the search does.
        warmup: iterations before the draws.
    """
    structure, data = RUNGS[model].of_scene(scene)
    if coordinates is Coordinates.DEVIATES or structure.in_deviates:
        return
    programs = programs_for(structure)
    transform = RestPose.example(structure)
    if structure.inverted != VEHICLES:  # regressions are fitted to run-outs
        separation = np.zeros((BATCH, len(structure.rest_components)))
        xi = np.zeros((BATCH, len(structure.uncertain)))
        programs.expect(INPUTS, data, xi)
        programs.expect(REACHED, data, separation, xi)
    if programs.target.rung.impact.levels:
        programs.expect(LEVELS, data, transform.regressions, transform.whitening.centre)
    rows = rows_of(structure)
    w = np.zeros((rows, transform.whitening.size))
    missed = np.zeros((rows, len(transform.surrogates(structure))))
    programs.expect(EVALUATE, data, transform, w, missed)
    METHODS[method].compile_ahead(programs, warmup, data, transform)


def _versions() -> dict[str, str]:
    names = ("retrodict", "jax", "jaxlib", "numpyro", "arviz", "numpy", "scipy")
    return {n: version(n) for n in names} | {
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "dtype": "float64",
    }
