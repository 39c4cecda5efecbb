"""From a scene to an outcome: coordinates, draws, checks, and the record of how it was done."""

from __future__ import annotations

import platform
import time
from dataclasses import replace
from functools import partial
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from retrodict.inference.density.compiled import COMPILATION, Programs, programs_for
from retrodict.inference.density.kernels import (
    BATCH,
    CRASHES,
    EVALUATE,
    INPUTS,
    LEVELS,
    REACHED,
    ROWS,
)
from retrodict.inference.errors import Interrupted, Unanswerable
from retrodict.inference.fitting import rolling
from retrodict.inference.modes import ModeSearch, PosteriorModes, Solution
from retrodict.inference.outcome import Outcome, attributes_of
from retrodict.inference.retry import Run, Sampling, has_failed, most
from retrodict.inference.samplers import METHODS, Task
from retrodict.inference.threads import one_blas_thread
from retrodict.inference.transforms.choice import transform_of
from retrodict.models import RUNGS
from retrodict.models.arrays import Data
from retrodict.progress import Progress, silent
from retrodict.scene.records import VEHICLES, Scene

DEFAULT_RUNG = "planar-moment+wheels"


@one_blas_thread()
def reconstruct(
    scene: Scene,
    *,
    model: str = DEFAULT_RUNG,
    method: str = "nuts",
    chains: int = 4,
    draws: int | None = None,
    warmup: int = 150,
    seed: int = 0,
    progress: Progress | None = None,
    resume: Path | None = None,
    pictured: bool = True,
    search: ModeSearch | None = None,
    asked: dict[str, int | str | None] | None = None,
) -> Outcome:
    """The joint posterior of the speeds that are sought, e, e_m and mu, with its checks.

    Args:
        scene: what was measured.
        model: a name in `retrodict.models.RUNGS`.
        method: a name in `retrodict.inference.samplers.METHODS`.
        chains: of draws; independent replicates where a method has no chains.
        draws: kept of each; None for as many as the method takes by default.
        warmup: iterations before them, where a method has any.
        seed: of every random number.
        progress: called with (stage, done, of all) as the work goes on.
        resume: chains.npz of a run that was interrupted, to go on with.
        pictured: whether the prior and run-outs are recorded too, which figures show.
        search: for where this scene's posteriors lie, by this seed; shared by the models of a ladder.
        asked: the same options as a user gave them, for the record; None for these.

    Returns:
        The outcome; marked incomplete when interrupted with some draws already kept.

    Raises:
        ValueError: no rung or method has that name, the method has no chains to resume, or `resume`
            is of another run.
        Unanswerable: a rest pose cannot be reached, the posterior has no finite mode, or the rung is no
            model of an impact with a barrier.
        Interrupted: stopped before any draw was kept.
    """
    begin = time.perf_counter()
    report = progress or silent
    rung, chosen = _named(RUNGS, "model", model), _named(METHODS, "method", method)
    if resume is not None and not chosen.resumes:
        able = ", ".join(name for name, m in METHODS.items() if m.resumes)
        raise ValueError(
            f"{resume}: the method {method} has no chains to go on with: give the method that was "
            f"interrupted ({able}), or start anew"
        )
    if asked is None:
        asked = {"model": model, "method": method, "chains": chains, "draws": draws}
        asked |= {"warmup": warmup, "seed": seed}
    if scene.barrier and (unfit := rung.refusal(scene)):
        raise Unanswerable(f"the model {model} {unfit}")
    draws = chosen.draws if draws is None else draws
    compiled_before = COMPILATION.seconds
    search = search or ModeSearch(scene, seed)

    def find(method: str) -> PosteriorModes:
        report("compiling", 0, 1)
        compile_ahead(scene, model, method, warmup)
        report("finding where the posterior lies", 0, 1)
        return search.on(model, method)

    def draw(method: str, where: PosteriorModes, draws: int, resume: Path | None = None) -> Run:
        unsampled = where.unsampled if METHODS[method].exact else []
        sampling = Sampling(where.found, unsampled, where.faults, where.reference, pictured, report)
        progress = partial(report, "sampling")
        task = Task(where.found[0].posterior, chains, draws, warmup, seed, progress, resume)
        run = sampling.of_several_modes(method, task) or sampling.by(method, task)
        return sampling.or_by_another(run, task)

    # tempering needs neither modes nor slopes, but takes longer: it stands in where these do not do
    stands_in = chosen.exact and method != "smc" and rolling.tempered(scene, model, "smc")
    where = run = None
    try:
        where = find(method)
    except Unanswerable as refusal:
        if not stands_in:
            raise
        failed = str(refusal)
    else:
        if not stands_in or not where.faults:
            run = draw(method, where, draws, resume)
        # though the mode that was found may miss the evidence: it need not be the best
        stands_in = stands_in and has_failed(run, draws)
        failed = most(where.faults if run is None else run.checks.reasons)
    notes = []
    if stands_in:
        try:
            elsewhere = find("smc")
            other = draw("smc", elsewhere, max(draws, METHODS["smc"].draws))
        except Interrupted as refusal:
            if run is None:  # nothing was drawn: no other method is begun
                raise
            notes.append(f"the method smc was tried too, and failed: {refusal}")
            run = replace(run, complete=False)
        except Unanswerable as refusal:
            if where is None:
                raise
            notes.append(f"the method smc was tried too, and failed: {refusal}")
        else:
            if other.checks.passed or where is None:
                notes.append(
                    f"the first sampler, {method}, was not accepted ({failed}) and was replaced by smc"
                )
                where, run = elsewhere, other
            else:
                lacking = most(other.checks.reasons)
                notes.append(f"the method smc was tried too, and failed: {lacking}")
    assert where is not None, "what cannot be found was refused"
    run = run or draw(method, where, draws, resume)
    found = where.found
    notes = [*notes, *run.notes]
    if len(found) > 1:
        notes.append(_several_modes_note(found))
    if not METHODS[run.method].exact:
        title = METHODS[run.method].title
        notes.append(f"{title}: an approximation; compare it with the method nuts")
    report("predicting", 1, 1)
    outcome = Outcome(
        scene=found[0].scene,
        description=rung.description(found[0].scene),
        idata=run.idata,
        checks=run.checks,
        seconds={
            "total": time.perf_counter() - begin,
            "compile": COMPILATION.seconds - compiled_before,
            "sample": run.seconds,
        },
        versions=_versions(),
        seed=seed,
        settings={"method": run.method, "chains": chains, "draws": run.draws, "warmup": warmup},
        asked=asked,
        complete=run.complete,
        notes=tuple(notes),
        unfinished=run.unfinished,
        modes=run.modes,
    )
    outcome.idata.attrs.update(attributes_of(outcome))
    return outcome


def _several_modes_note(found: list[Solution]) -> str:
    listed = "; ".join(
        f"{s.label()} (weight {s.mode.weight:.1%} ± {s.mode.error:.1%})" for s in found
    )
    note = f"the evidence fits several ways: {listed}; draws of each are mixed by their weights"
    if any(s.turns != found[0].turns for s in found):
        note += ": write each vehicle's rotation into its [vehicles.X.rest] where it is known"
    return note


def compile_ahead(
    scene: Scene,
    model: str,
    method: str,
    warmup: int = 0,
) -> None:
    """Have what `reconstruct` will need compiled side by side, in the order it will be needed.

    Args:
        scene: as of `reconstruct`, and so are the others.
        model: a name in `retrodict.models.RUNGS`.
        method: a name in `retrodict.inference.samplers.METHODS`.
        warmup: iterations before the draws.
    """
    structure, data = RUNGS[model].of_scene(scene)
    programs_for(structure.without_transform).expect(
        CRASHES, data, np.zeros((ROWS, structure.deviates))
    )
    if rolling.tempered(scene, model, method):
        fitted, structure, data, _ = rolling.seen(scene, model)
        _expect_run_outs(programs_for(fitted), data)
    programs = programs_for(structure)
    kind = transform_of(structure)
    transform = kind.example(structure)
    if kind.by_regressions:
        _expect_run_outs(programs, data)
        if programs.target.rung.impact.levels:
            programs.expect(LEVELS, data, transform, transform.centre)
    if transform.flattening is None:
        w = np.zeros((ROWS, transform.spread.shape[1]))
        missed = np.zeros((ROWS, len(kind.surrogates(structure))))
        programs.expect(EVALUATE, data, transform, w, missed)
    METHODS[method].compile_ahead(programs, warmup, data, transform)
    for slow in ("xarray", "arviz_stats"):  # imported while programs compile
        import_module(slow)


def _expect_run_outs(programs: Programs, data: Data) -> None:
    """What regressions are fitted by."""
    structure = programs.structure
    if structure.inverted == VEHICLES:
        return
    separation = np.zeros((BATCH, len(structure.rest_components)))
    xi = np.zeros((BATCH, len(structure.uncertain)))
    programs.expect(INPUTS, data, xi)
    programs.expect(REACHED, data, separation, xi)


def _named(known: dict, what: str, name: str) -> Any:
    if name not in known:
        raise ValueError(f"{what} is one of {', '.join(known)}; not {name!r}")
    return known[name]


def _versions() -> dict[str, str]:
    names = ("retrodict", "jax", "jaxlib", "numpyro", "arviz", "numpy", "scipy")
    return {n: version(n) for n in names} | {
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "dtype": "float64",
    }
