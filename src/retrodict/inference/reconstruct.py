"""From a scene to an outcome: coordinates, draws, checks, and the record of how it was done."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from retrodict.inference import gate
from retrodict.inference.methods import METHODS, Draws, Task
from retrodict.inference.methods.nuts import targets
from retrodict.inference.modes import Rival, Solution, beside, mixed, rivals_of, solutions, weighed
from retrodict.inference.outcome import Checks, Mode, Outcome
from retrodict.inference.posterior import RESOLVED, Posterior, blank_chart, run_outs_of
from retrodict.inference.programs import BATCH, CHUNK, Programs, programs_for
from retrodict.models import RUNGS
from retrodict.models.arrays import Data
from retrodict.models.evidence import FREEDOM
from retrodict.scene.quantities import describe, si_symbol
from retrodict.scene.records import Scene

if TYPE_CHECKING:
    import xarray as xr

DEFAULT_RUNG = "planar-moment+wheels"
PATHS = 60
_NEARLY = 1.1  # R-hat up to which more draws may help
_WORTH_MORE = 100  # draws a chain: who asks for fewer wants a quick look, not more of it
_REFUTED = 1e-6  # probability of the evidence at the mode below which no method's draws would count
_INSTEAD = {"nuts": "importance", "importance": "nuts"}  # what helps where a method fails

Progress = Callable[[str, int, int], None]  # stage, done, of all


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
) -> Outcome:
    """The joint posterior of B's approach, e, e_m and mu, with its checks.

    Args:
        scene: what was measured.
        model: a name in `retrodict.models.RUNGS`.
        method: a name in `retrodict.inference.methods.METHODS`.
        chains: of draws; independent replicates where a method has no chains.
        draws: kept of each; None for as many as the method takes by default.
        warmup: iterations before them, where a method has any.
        seed: of every random number.
        progress: called as the work goes on.
        resume: chains.npz of a run that was interrupted, to go on with.
        pictured: whether the prior and run-outs are told too, which figures show.

    Returns:
        The outcome; marked incomplete when interrupted with some draws already kept.

    Raises:
        ValueError: no rung or method has that name, the method has no chains to resume, or `resume`
            is of another run.
        Unanswerable: a rest pose cannot be reached, or the posterior has no finite mode.
        Interrupted: stopped before any draw was kept.
    """
    begin = time.perf_counter()
    tell = progress or (lambda stage, done, total: None)
    rung, chosen = _named(RUNGS, "model", model), _named(METHODS, "method", method)
    if resume is not None and not chosen.resumes:
        able = ", ".join(name for name, m in METHODS.items() if m.resumes)
        raise ValueError(
            f"{resume}: the method {method} has no chains to go on with: give the method that was "
            f"interrupted ({able}), or start anew"
        )
    draws = chosen.draws if draws is None else draws
    tell("finding where the posterior lies", 0, 1)
    structure, data = rung.of_scene(scene)
    programs = programs_for(structure)
    compiled_before = Programs.compile_seconds
    _compile_ahead(programs, data, method, warmup, pictured)
    found = solutions(scene, model)
    scene = found[0].scene
    faults = _unresolved(found)
    modes, unsettled = weighed(found, seed)
    faults += unsettled
    seeks = chosen.exact and method != "smc"  # which starts from everywhere
    rivals = rivals_of(found, modes, seed) if seeks else []
    tell("finding where the posterior lies", 1, 1)

    sampling = 0.0

    def timed(draw: Callable[[], list[Draws]]) -> list[Draws]:
        nonlocal sampling
        tell("sampling", 0, 1)
        start, before = time.perf_counter(), Programs.compile_seconds
        drawn = draw()
        sampling += time.perf_counter() - start - (Programs.compile_seconds - before)
        tell("predicting", 0, 1)
        return drawn

    def told(done: int, total: int) -> None:
        tell("sampling", done, total)

    task = Task(found[0].posterior, chains, draws, warmup, seed, told, resume)
    run = _run(method, found, modes, rivals, task, faults, timed, pictured)
    own = run.checks.reasons[len(faults) :]
    instead = _INSTEAD.get(method)
    if instead and own and run.complete and draws >= _WORTH_MORE:
        if missed := _missed(found):
            run.notes.append(f"{missed}: no other method was tried")
        else:
            tried = replace(task, draws=max(draws, METHODS[instead].draws), resume=None)
            # those draws say where the posterior lies, though they may not be told
            anew = [s.about(d.w) for s, d in zip(found, run.drawn, strict=True)]
            others = [rival.seen_from(found[rival.of], anew[rival.of]) for rival in rivals]
            tried = replace(tried, posterior=anew[0].posterior)
            other = _run(instead, anew, modes, others, tried, faults, timed, pictured)
            failed = "; ".join(other.checks.reasons[len(faults) :])
            if failed:
                run.notes.append(f"the method {instead} was tried too, and failed: {failed}")
            else:
                why = f"the method {method} failed: {'; '.join(own)}"
                other.notes.insert(0, f"{why}; the run told of here is by {instead}")
                run, method, found = other, instead, anew
    if len(found) > 1:
        run.notes.append(_told_several(found, modes))
    if not METHODS[method].exact:
        title = METHODS[method].title
        run.notes.append(f"{title}: an approximation; compare it with the method nuts")
    tell("predicting", 1, 1)
    return Outcome(
        scene=scene,
        card=rung.card(scene),
        idata=run.idata,
        checks=run.checks,
        seconds={
            "total": time.perf_counter() - begin,
            "compile": Programs.compile_seconds - compiled_before,
            "sample": sampling,
        },
        versions=_versions(),
        seed=seed,
        settings={"method": method, "chains": chains, "draws": run.draws, "warmup": warmup},
        complete=run.complete,
        notes=tuple(run.notes),
        unfinished=run.unfinished,
        modes=tuple(beside(found, modes, run.unreached)),
    )


@dataclass(frozen=True)
class _Run:
    """What a method made of all solutions.

    Args:
        idata: the draws, mixed.
        checks: the verdict on them.
        draws: asked for of each chain.
        complete: False when interrupted.
        notes: how it helped itself.
        unfinished: writes interrupted chains to a file.
        unreached: rivals that no draw holds.
        drawn: what the method drew of each solution.
    """

    idata: xr.DataTree
    checks: Checks
    draws: int
    complete: bool
    notes: list[str]
    unfinished: Callable[[Path], None] | None
    unreached: list[Rival]
    drawn: list[Draws]


def _run(
    method: str,
    found: list[Solution],
    modes: list[Mode],
    rivals: list[Rival],
    task: Task,
    faults: tuple[str, ...],
    timed: Callable[[Callable[[], list[Draws]]], list[Draws]],
    pictured: bool,
) -> _Run:
    """Draws of every solution by a method, which goes on to twice as many where that may help."""
    draws = task.draws

    def draw_all() -> list[Draws]:
        drawn: list[Draws] = []
        for solution in found:
            drawn.append(METHODS[method].draw(replace(task, posterior=solution.posterior)))
            if not drawn[-1].complete:
                break
        return drawn

    def judged(drawn: list[Draws]) -> tuple[xr.DataTree, Checks]:
        others = beside(found, modes, _unreached(rivals, drawn))[len(found) :]
        known = faults + tuple(_told_apart(mode, modes[0]) for mode in others)
        known += tuple(fault for each in drawn for fault in each.faults)
        trees = [_tree(s, d, task.seed, pictured) for s, d in zip(found, drawn, strict=False)]
        if len(trees) > 1:  # a chain that is stuck in one solution would be hidden by the others
            for solution, tree in zip(found, trees, strict=False):
                own = gate.judge(tree, solution.scene).reasons
                known += tuple(f"{solution.told()}: {reason}" for reason in own)
        if not all(each.complete for each in drawn):
            kept = min(each.w.shape[1] for each in drawn)
            known += (f"interrupted: {kept} of {draws} draws a chain were kept",)
        idata = mixed(trees, modes, task.seed)
        return idata, gate.judge(idata, found[0].scene, known)

    drawn = timed(draw_all)
    idata, checks = judged(drawn)
    notes = [note for each in drawn for note in each.notes]
    complete = all(each.complete for each in drawn)
    short = complete and checks.max_rhat < _NEARLY and (checks.failed or checks.coarse)
    if short and draws >= _WORTH_MORE and all(each.more for each in drawn):
        lacking = [*checks.reasons[len(faults) :]]
        if checks.coarse:
            names = ", ".join(describe(name)[0] for name in checks.coarse)
            lacking.append(f"not one digit of the 95 % limits was sure of {names}")
        notes.append(
            f"after {draws} draws a chain {'; '.join(lacking)}; the run told of here went on to "
            "twice as many"
        )
        draws *= 2
        drawn = timed(lambda: [each.more() for each in drawn if each.more])
        idata, checks = judged(drawn)
        complete = all(each.complete for each in drawn)
    unfinished = drawn[0].unfinished if len(found) == 1 else None
    unreached = _unreached(rivals, drawn)
    return _Run(idata, checks, draws, complete, notes, unfinished, unreached, drawn)


def _unreached(rivals: list[Rival], drawn: list[Draws]) -> list[Rival]:
    """Those rivals that no draw of their solution holds."""
    return [
        rival
        for rival in rivals
        if rival.of >= len(drawn) or not rival.reached(drawn[rival.of].w.reshape(-1, rival.w.size))
    ]


def _unresolved(found: list[Solution]) -> tuple[str, ...]:
    worst = max(solution.posterior.unresolved for solution in found)
    if worst <= RESOLVED:
        return ()
    return (
        f"the run-outs are resolved to {worst:.2f} standard deviations of the rest poses only, "
        f"{RESOLVED} is asked: a vehicle spins too long for its run-out to be followed",
    )


def _missed(found: list[Solution]) -> str:
    """By how much the model misses the evidence even where the posterior is highest; empty if hardly.

    At the mode, and with a degree of freedom for every item, the chi-square is the most lenient.
    """
    from scipy.stats import chi2

    if found[0].scene.robust:  # whose errors may be of any size
        return ""
    squares = []
    for solution in found:
        posterior, evidence = solution.posterior, solution.scene.evidence()
        at_mode = posterior.weighed(np.zeros((1, posterior.size)))[1]
        items = posterior.programs.structure.evidence
        off = [(at_mode[f"predicted/{k}"][0] - evidence[k].value) / evidence[k].sd for k in items]
        squares.append(float(np.square(off).sum()))
    if not chi2.sf(min(squares), len(items)) < _REFUTED:
        return ""
    return (
        "even where the posterior is highest the model misses the evidence (chi-square "
        f"{min(squares):.3g} of {len(items)} items)"
    )


def _told_apart(rival: Mode, sampled: Mode) -> str:
    speeds = (f"{mode.values['speed_b']:.3g}" for mode in (rival, sampled))
    return (
        f"the evidence fits another solution (weight {rival.weight:.1%}), with a speed of B of "
        f"{' m/s instead of '.join(speeds)} m/s, that was not sampled: measurements may conflict; "
        "the method smc looks for all solutions"
    )


def _told_several(found: list[Solution], modes: list[Mode]) -> str:
    listed = "; ".join(
        f"{s.told()} (weight {m.weight:.1%} ± {m.error:.1%})"
        for s, m in zip(found, modes, strict=False)
    )
    told = f"the evidence fits several ways: {listed}; draws of each are mixed by their weights"
    if any(s.turns != found[0].turns for s in found):
        told += ": write each vehicle's rotation into its [vehicles.X.rest] where it is known"
    return told


def _compile_ahead(
    programs: Programs, data: Data, method: str, warmup: int, pictured: bool
) -> None:
    """Have what will be needed compiled side by side, in the order it will be needed."""
    structure = programs.structure
    chart = blank_chart(structure)
    n = chart.spread.shape[1]
    if not structure.unpinned:
        separation = np.zeros((BATCH, len(structure.aims)))
        xi = np.zeros((BATCH, len(structure.uncertain)))
        programs.expect("inputs", data, xi)
        programs.expect("reached", data, separation, xi)
        if programs.rung.impact.levels:
            programs.expect("levels", data, chart, chart.centre)
    programs.expect("potential", np.zeros(n), data, chart)
    if method == "nuts":
        programs.sampler(warmup, targets(structure)[0], data, chart)
    programs.expect("weigh", data, chart, np.zeros((CHUNK, n)))
    if pictured:
        prior = (_prior_keys(0), data)
        programs.expect("prior", *prior)
        sites = partial(jax.eval_shape, programs.functions["prior"], *prior)
        programs.expect("simulate", data, sites)
    for slow in ("xarray", "arviz_stats"):  # imported while programs compile
        import_module(slow)


def _named(known: dict, what: str, name: str) -> Any:
    if name not in known:
        raise ValueError(f"{what} is one of {', '.join(known)}; not {name!r}")
    return known[name]


def _prior_keys(seed: int) -> jax.Array:
    # a generator whose program compiles in a third of the time; it only draws the prior's picture
    return jax.random.split(jax.random.key(seed, impl="unsafe_rbg"), CHUNK)


def _tree(solution: Solution, drawn: Draws, seed: int, pictured: bool) -> xr.DataTree:
    """Draws as an ArviZ DataTree, named, with units."""
    import xarray as xr

    posterior, scene = solution.posterior, solution.scene
    programs, data = posterior.programs, posterior.data
    rng = np.random.default_rng([seed, 1])

    told = drawn.known(posterior)

    def group(values: dict[str, np.ndarray], prefix: str, shape: tuple[int, int]) -> xr.Dataset:
        chosen = {
            k.removeprefix(prefix): np.asarray(v).reshape(shape)
            for k, v in values.items()
            if k.startswith(prefix) and (prefix or "/" not in k) and k != "measured"
        }
        return _labelled(chosen, ("chain", "draw"))

    every = scene.evidence()
    evidence = {name: every[name] for name in programs.structure.evidence}

    def noisy(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {
            f"predicted/{k}": values[f"predicted/{k}"]
            + m.sd * _errors(rng, np.shape(values[f"predicted/{k}"]), scene.robust)
            for k, m in evidence.items()
        }

    shape, once = drawn.w.shape[:2], (1, CHUNK)
    groups = {
        "posterior": group(told, "", shape),
        "posterior_predictive": group(noisy(told), "predicted/", shape),
        "log_likelihood": group(told, "log_likelihood/", shape),
        "sample_stats": xr.Dataset(
            {k: (("chain", "draw"), v) for k, v in drawn.stats.items()}, attrs=drawn.attributes
        ),
        "observed_data": _labelled({k: np.asarray(m.value) for k, m in evidence.items()}, ()),
        "constant_data": xr.Dataset({f"{k}_sd": m.sd for k, m in evidence.items()}),
    }
    if pictured:
        prior = programs("prior", _prior_keys(seed), data)
        prior |= programs("simulate", data, prior)
        groups["prior"] = group(prior, "", once)
        groups["prior_predictive"] = group(noisy(prior), "predicted/", once)
        groups["trajectories"] = _trajectories(posterior, told)
    return xr.DataTree.from_dict({f"/{k}": v for k, v in groups.items()})


def _errors(rng: np.random.Generator, shape: tuple[int, ...], robust: bool) -> np.ndarray:
    """Errors of measurement in standard deviations."""
    return rng.standard_t(FREEDOM, shape) if robust else rng.standard_normal(shape)


def _labelled(values: dict[str, np.ndarray], dims: tuple[str, ...]) -> xr.Dataset:
    import xarray as xr

    variables = {}
    for name, value in values.items():
        label, dimension = describe(name)
        variables[name] = (dims, value, {"unit": si_symbol(dimension), "label": label})
    coords = {d: np.arange(np.shape(next(iter(values.values())))[i]) for i, d in enumerate(dims)}
    return xr.Dataset(variables, coords=coords)


def _trajectories(posterior: Posterior, told: dict[str, np.ndarray]) -> xr.Dataset:
    """Run-outs of draws taken evenly along the chains."""
    import xarray as xr

    index = np.linspace(0, len(told["speed_b"]) - 1, PATHS).astype(int)
    V, xi = run_outs_of(told)
    path = posterior.programs("paths", posterior.data, V[index], xi[index])
    return xr.Dataset(
        {"path": (("run", "vehicle", "step", "pose"), np.asarray(path))},
        coords={"vehicle": ["a", "b"], "pose": ["x", "y", "heading"]},
    )


def _versions() -> dict[str, str]:
    names = ("retrodict", "jax", "jaxlib", "numpyro", "arviz", "numpy", "scipy")
    return {n: version(n) for n in names} | {
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "dtype": "float64",
    }
