"""From a scene to an outcome: coordinates, draws, checks, and the record of how it was done."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from retrodict.inference import gate
from retrodict.inference.errors import Unanswerable
from retrodict.inference.methods import METHODS, Draws, Task
from retrodict.inference.methods.nuts import FIRST_TRY
from retrodict.inference.outcome import Outcome
from retrodict.inference.posterior import RESOLVED, Posterior, blank_chart, prepare
from retrodict.inference.programs import BATCH, CHUNK, Programs, in_chunks, programs_for
from retrodict.models import RUNGS, parts
from retrodict.scene.quantities import describe, si_symbol
from retrodict.scene.records import VEHICLES, Scene

if TYPE_CHECKING:
    import xarray as xr

DEFAULT_RUNG = "planar-moment+wheels"
PATHS = 60
_OTHER_TURNS = 1e-3  # weight from which on another number of turns stands in the way of an answer
_TURNS = range(-4, 5)  # whole turns that a rest heading of unknown rotation may hide
_NEARLY = 1.1  # R-hat up to which more draws may help
_WORTH_MORE = 100  # draws a chain: who asks for fewer wants a quick look, not more of it

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

    Returns:
        The outcome; marked incomplete when interrupted with some draws already kept.

    Raises:
        ValueError: no rung or method has that name, or `resume` is of another run.
        Unanswerable: a rest pose cannot be reached, or the posterior has no finite mode.
        Interrupted: stopped before any draw was kept.
    """
    begin = time.perf_counter()
    tell = progress or (lambda stage, done, total: None)
    rung, chosen = _named(RUNGS, "model", model), _named(METHODS, "method", method)
    draws = chosen.draws if draws is None else draws
    tell("finding where the posterior lies", 0, 1)
    programs = programs_for(rung.of_scene(scene)[0])
    compiled_before = programs.compile_seconds
    _compile_ahead(programs, rung.of_scene(scene)[1], method, warmup)
    posterior, scene, faults = _settle_turns(scene, model)
    if not posterior.unresolved <= RESOLVED:
        faults = (
            *faults,
            f"the run-outs are resolved to {posterior.unresolved:.2f} standard deviations of the rest "
            f"poses only, {RESOLVED} is asked: a vehicle spins too long for its run-out to be followed",
        )
    tell("finding where the posterior lies", 1, 1)

    sampling = 0.0

    def timed(draw: Callable[[], Draws]) -> Draws:
        nonlocal sampling
        tell("sampling", 0, 1)
        start, before = time.perf_counter(), programs.compile_seconds
        drawn = draw()
        sampling += time.perf_counter() - start - (programs.compile_seconds - before)
        return drawn

    task = Task(
        posterior,
        chains,
        draws,
        warmup,
        seed,
        lambda done, total: tell("sampling", done, total),
        resume,
    )
    drawn = timed(lambda: chosen.draw(task))
    notes = [*drawn.notes]
    if not chosen.exact:
        notes.append(f"{chosen.title}: an approximation; compare it with the method nuts")

    tell("predicting", 0, 1)
    idata = _tree(posterior, scene, drawn, seed)
    checks = gate.judge(idata, scene, (*faults, *drawn.faults))
    again = drawn.complete and checks.max_rhat < _NEARLY and checks.failed
    if drawn.more and again and draws >= _WORTH_MORE:
        notes.append(
            f"after {draws} draws a chain {'; '.join(checks.reasons[len(faults) :])}; the run told of "
            "here went on to twice as many"
        )
        draws *= 2
        drawn = timed(drawn.more)
        idata = _tree(posterior, scene, drawn, seed)
    faults = (*faults, *drawn.faults)
    if not drawn.complete:
        faults = (*faults, f"interrupted: {drawn.w.shape[1]} of {draws} draws a chain were kept")
    tell("predicting", 1, 1)
    return Outcome(
        scene=scene,
        card=rung.card(scene),
        idata=idata,
        checks=gate.judge(idata, scene, faults),
        seconds={
            "total": time.perf_counter() - begin,
            "compile": programs.compile_seconds - compiled_before,
            "sample": sampling,
        },
        versions=_versions(),
        seed=seed,
        settings={"method": method, "chains": chains, "draws": draws, "warmup": warmup},
        complete=drawn.complete,
        notes=tuple(notes),
        unfinished=drawn.unfinished,
    )


def _compile_ahead(programs: Programs, data: parts.Data, method: str, warmup: int) -> None:
    """Have what will be needed compiled side by side, in the order it will be needed."""
    structure = programs.structure
    chart = blank_chart(structure)
    n = chart.spread.shape[1]
    separation = np.zeros((BATCH, len(structure.evidence)))
    xi = np.zeros((BATCH, len(structure.uncertain)))
    programs.expect("inputs", data, xi)
    programs.expect("rests", data, separation, xi)
    finer = programs_for(replace(structure, steps=4 * structure.steps))
    finer.expect("rests", data, separation, xi)
    programs.expect("potential", np.zeros(n), data, chart)
    if programs.rung.impact.levels:
        programs.expect("levels", data, chart, chart.centre)
    programs.expect("bent", data, chart, np.zeros(n))
    draws = np.zeros((CHUNK, n))
    programs.expect("locate", data, chart, draws)
    if method == "nuts":
        programs.sampler(warmup, FIRST_TRY, data, chart)
    elif METHODS[method].exact:
        programs.expect("weigh", data, chart, draws)
    programs.expect("simulate", data, lambda: programs.sites(data, chart, draws))
    programs.expect("prior", _prior_keys(0), data)
    for slow in ("xarray", "arviz_stats"):  # imported while programs compile
        import_module(slow)


def _named(known: dict, what: str, name: str) -> Any:
    if name not in known:
        raise ValueError(f"{what} is one of {', '.join(known)}; not {name!r}")
    return known[name]


def _prior_keys(seed: int) -> jax.Array:
    # a generator whose program compiles in a third of the time; it only draws the prior's picture
    return jax.random.split(jax.random.key(seed, impl="unsafe_rbg"), CHUNK)


def _settle_turns(scene: Scene, model: str) -> tuple[Posterior, Scene, tuple[str, ...]]:
    """The posterior at the number of turns that fits best; a fault where others fit too."""
    unknown = [v for v in VEHICLES if not scene.rest[v].turns_known]
    if not unknown:
        return prepare(scene, model), scene, ()
    tried: dict[tuple[int, ...], tuple[Posterior, Scene] | None] = {}

    def log_evidence(turns: tuple[int, ...]) -> float:
        if turns not in tried:
            turned = _turned(scene, dict(zip(unknown, turns, strict=True)))
            try:
                tried[turns] = prepare(turned, model), turned
            except Unanswerable:
                tried[turns] = None
        found = tried[turns]
        return -np.inf if found is None else found[0].log_evidence

    # one vehicle at a time, twice over: all pairs would take minutes
    best = (0,) * len(unknown)
    for i in [*range(len(unknown))] * len(unknown):
        best = max((_with(best, i, count) for count in _TURNS), key=log_evidence)
    if tried[best] is None:
        prepare(scene, model)  # raises the reason
    weights = {turns: float(np.exp(log_evidence(turns) - log_evidence(best))) for turns in tried}
    whole = sum(weights.values())
    rivals = sorted((-w / whole, turns) for turns, w in weights.items() if w / whole > _OTHER_TURNS)
    posterior, turned = tried[best]  # type: ignore[misc]  # not None: see above
    if len(rivals) == 1:
        return posterior, turned, ()

    def told(turns: tuple[int, ...]) -> str:
        rotations = []
        for v, count in zip(unknown, turns, strict=True):
            turn = scene.rest[v].heading.value - scene.vehicles[v].heading.value
            rotations.append(f"{v.upper()} {np.degrees(turn) + 360 * count:+.0f} deg")
        return ", ".join(rotations)

    listed = "; ".join(f"{told(turns)} (weight {-w:.1%})" for w, turns in rivals[:4])
    return (
        posterior,
        turned,
        (
            f"the rest headings fit several total rotations: {listed}; only the first was "
            "sampled: write each vehicle's rotation into its [vehicles.X.rest]",
        ),
    )


def _with(turns: tuple[int, ...], i: int, count: int) -> tuple[int, ...]:
    return (*turns[:i], count, *turns[i + 1 :])


def _turned(scene: Scene, turns: dict[str, int]) -> Scene:
    """The scene with whole turns added to rest headings."""
    rest = dict(scene.rest)
    for v, count in turns.items():
        heading = rest[v].heading
        heading = replace(heading, value=heading.value + 2 * np.pi * count)
        rest[v] = replace(rest[v], heading=heading)
    return replace(scene, rest=rest)


def _tree(posterior: Posterior, scene: Scene, drawn: Draws, seed: int) -> xr.DataTree:
    """Draws as an ArviZ DataTree, named, with units."""
    import xarray as xr

    programs, data = posterior.programs, posterior.data
    chains, draws, n = drawn.w.shape
    rng = np.random.default_rng([seed, 1])

    sites = in_chunks(
        lambda w: programs(drawn.way, data, posterior.chart, w)[0], drawn.w.reshape(-1, n)
    )
    told = in_chunks(lambda s: programs("simulate", data, s), sites)
    prior_sites = programs("prior", _prior_keys(seed), data)
    prior_told = programs("simulate", data, prior_sites)

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
            + m.sd * rng.standard_normal(np.shape(values[f"predicted/{k}"]))
            for k, m in evidence.items()
        }

    shape, once = (chains, draws), (1, CHUNK)
    groups = {
        "posterior": group(sites | told, "", shape),
        "prior": group(prior_sites | prior_told, "", once),
        "posterior_predictive": group(noisy(told), "predicted/", shape),
        "prior_predictive": group(noisy(prior_told), "predicted/", once),
        "log_likelihood": group(told, "log_likelihood/", shape),
        "sample_stats": xr.Dataset(
            {k: (("chain", "draw"), v) for k, v in drawn.stats.items()}, attrs=drawn.attributes
        ),
        "observed_data": _labelled({k: np.asarray(m.value) for k, m in evidence.items()}, ()),
        "constant_data": xr.Dataset({f"{k}_sd": m.sd for k, m in evidence.items()}),
        "trajectories": _trajectories(posterior, sites, told),
    }
    return xr.DataTree.from_dict({f"/{k}": v for k, v in groups.items()})


def _labelled(values: dict[str, np.ndarray], dims: tuple[str, ...]) -> xr.Dataset:
    import xarray as xr

    variables = {}
    for name, value in values.items():
        label, dimension = describe(name)
        variables[name] = (dims, value, {"unit": si_symbol(dimension), "label": label})
    coords = {d: np.arange(np.shape(next(iter(values.values())))[i]) for i, d in enumerate(dims)}
    return xr.Dataset(variables, coords=coords)


def _trajectories(posterior: Posterior, sites: dict, told: dict) -> xr.Dataset:
    """Run-outs of draws taken evenly along the chains."""
    import xarray as xr

    count = len(sites["speed_b"])
    index = np.linspace(0, count - 1, PATHS).astype(int)
    columns = ("Vax", "Vay", "Omega_a", "Vbx", "Vby", "Omega_b")
    known = sites | told
    V = np.stack([known[name][index] for name in columns if name in known], axis=1)
    chosen = {k: v[index] for k, v in sites.items()}
    path = posterior.programs("paths", posterior.data, chosen, V)
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
