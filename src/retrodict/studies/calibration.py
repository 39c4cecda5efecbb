"""Simulation-based calibration: crashes drawn from a model's own prior, reconstructed and ranked."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import resources
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from retrodict.inference import diagnostics
from retrodict.inference.attempt import doubled, may_improve, until_enough
from retrodict.inference.density.compiled import Programs, programs_for
from retrodict.inference.density.kernels import CHUNK, PRIOR, SIMULATE
from retrodict.inference.errors import Interrupted, Unanswerable
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.modes import SLIGHT, ModeSearch, PosteriorModes, Solution, shares
from retrodict.inference.outcome import Checks
from retrodict.inference.plan import ways
from retrodict.inference.samplers import METHODS, Draws, Task
from retrodict.mechanics import closing_speed
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure
from retrodict.progress import Progress, silent
from retrodict.scene import load_scene
from retrodict.scene.fields import AFTER
from retrodict.scene.names import parsed
from retrodict.scene.quantities import REPORTED
from retrodict.scene.records import RunOutError, Scene
from retrodict.studies.engine import engine

_FOLLOWS = ("travelling_speed_a", "travelling_speed_b")  # follow from what is ranked or measured
QUANTITIES = (*(name for name in REPORTED if name not in _FOLLOWS), "log_likelihood")
EXACT = tuple(name for name, method in METHODS.items() if method.exact)
DRAWS = 99  # draws that a truth is ranked among: few enough to be independent if the checks passed
MOST_WITHHELD = 0.05  # share of withheld simulations beyond which it is part of the verdict
DRIVING, CLOSING, SPIN, FAR = 3.0, 0.3, 12.0, 50.0  # what is plausible: m/s, m/s, rad/s, m
SLOWLY = 3.0  # m/s: vehicles that close in more slowly are judged by themselves too

_BATCH = 5  # simulations of a process at a time
_CHAINS, _WARMUP = 4, 150
_MOST_CHUNKS = 40  # of candidates for a batch

Values = dict[str, np.ndarray]  # unknowns and what follows from them, a row each


@dataclass(frozen=True, slots=True)
class Row:
    """One simulation.

    Args:
        simulation: number of the simulation, from 0.
        ranks: rank of the true value of each quantity among `DRAWS` draws, from 0; empty where there
            is none.
        reason: reason why there are no ranks; empty where there are.
        closing: closing speed along the normal, m/s: the median of the plausible draws, because rows
            selected by the truth would not have uniform ranks; the true one where there are no ranks.
    """

    simulation: int
    ranks: dict[str, int] = field(default_factory=dict)
    reason: str = ""
    closing: float = math.nan


@dataclass(frozen=True)
class Calibration:
    """Ranks of many simulations of one model by one method.

    Args:
        scene: the design: what is measured of every crash, and how well.
        model: name of the rung.
        method: name of the method that drew from the posteriors.
        seed: integer seed of all random numbers.
        simulations: number of simulations asked for.
        rows: finished simulations, in order.
    """

    scene: Scene
    model: str
    method: str
    seed: int
    simulations: int
    rows: tuple[Row, ...] = ()

    def __repr__(self) -> str:
        done = f"{len(self.rows)} of {self.simulations} simulations, {len(self.ranked)} ranked"
        return f"<Calibration of {self.model} by {self.method}: {done}>"

    @property
    def complete(self) -> bool:
        """Whether all simulations that were asked for are done."""
        return len(self.rows) >= self.simulations

    @property
    def ranked(self) -> tuple[Row, ...]:
        """The simulations that have ranks: their draws passed the checks."""
        return tuple(row for row in self.rows if row.ranks)

    @property
    def slow(self) -> Calibration:
        """The calibration of only the crashes whose closing speed is below `SLOWLY`."""
        return replace(self, rows=tuple(row for row in self.rows if row.closing < SLOWLY))

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the ranked quantities."""
        return tuple(self.ranked[0].ranks) if self.ranked else ()

    @property
    def withheld(self) -> float:
        """Share of simulations without ranks."""
        count = len(self.rows)  # 1 - 190 / 200 is above 0.05
        return (count - len(self.ranked)) / count if count else 0.0


def calibrate(
    scene: Scene,
    *,
    model: str,
    method: str = "importance",
    simulations: int = 1000,
    seed: int = 0,
    known: Sequence[Row] = (),
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    keep: Callable[[Calibration], None] | None = None,
) -> Calibration:
    """Draw crashes from a model's prior, reconstruct each, rank the truth among posterior draws.

    If model, sampler and checks are right, the ranks are uniform (Talts et al. 2018; with the log
    likelihood as a quantity that depends on the data, Modrák et al. 2023). Prior and posterior are
    both cut to plausible crashes, by the unknowns alone.

    Args:
        scene: the design, whose measured inputs are the priors of the inputs; of its rest poses, and of
            what was measured just after the impact, only the errors count.
        model: a name in `retrodict.models.RUNGS`.
        method: name of a method in `EXACT`.
        simulations: number of simulations.
        seed: integer seed of all random numbers.
        known: rows of an earlier run with the same arguments, which are not done again.
        workers, scheduler: arguments of `retrodict.studies.engine.engine`.
        progress: called with (stage, done, of all).
        keep: called with the calibration so far, whenever further simulations are done.

    Returns:
        The calibration; when interrupted, with the rows that were finished.

    Raises:
        WorkerDied: the worker of a simulation was killed, again and again.
        ValueError: no rung or exact method has that name, the scene has evidence on the way to rest or
            errors that are not normal, or its priors hold hardly a plausible crash.
    """
    for what, name, names in (("model", model, tuple(RUNGS)), ("method", method, EXACT)):
        if name not in names:
            raise ValueError(f"{what} is one of {', '.join(names)}; not {name!r}")
    others = [name for name in scene.evidence() if parsed(name).on_way or not parsed(name).vehicle]
    if others or scene.robust:
        raise ValueError(
            "only rest poses and the motion just after the impact are simulated, with normal errors: "
            f"leave {', '.join(others) or 'robust'} out of the design"
        )
    done = {row.simulation: row for row in known if row.simulation < simulations}
    missing = [i for i in range(simulations) if i not in done]
    batches: dict[int, list[int]] = {}
    for i in missing:
        batches.setdefault(i // _BATCH, []).append(i)
    calibration = Calibration(scene, model, method, seed, simulations)
    job = partial(_batch, calibration)

    def so_far() -> Calibration:
        return replace(calibration, rows=tuple(done[i] for i in sorted(done)))

    report = progress or silent
    report("simulating", len(done), simulations)
    # the first alone: it keeps the compiled programs that the others load
    numbers = list(batches.values())
    later = {numbers[0][0]: numbers[1:]} if numbers else {}
    try:
        with engine(workers, scheduler) as running:
            found = running.results(job, numbers[:1], lambda some, _: later.pop(some[0], ()))
            for rows in found:
                done |= {row.simulation: row for row in rows}
                if keep:
                    keep(so_far())
                report("simulating", len(done), simulations)
    except (KeyboardInterrupt, Interrupted):
        pass
    return so_far()


def design() -> Scene:
    """The scene that is used where none is given: two cars of middling size, one struck in its side."""
    with resources.as_file(resources.files(__package__).joinpath("calibration.toml")) as file:
        return load_scene(file)


def _batch(calibration: Calibration, numbers: list[int]) -> list[Row]:
    """Some simulations of one batch, whose truths are drawn together."""
    structure, data = RUNGS[calibration.model].of_scene(calibration.scene)
    programs = programs_for(structure)
    sites, quantities = _truths(
        programs, data, np.random.default_rng([calibration.seed, numbers[0] // _BATCH])
    )
    closing = _closing_speeds(structure, data, sites, quantities)
    rows = []
    for number in numbers:
        i, rng = number % _BATCH, np.random.default_rng([calibration.seed, number, 1])
        scene = _measured(
            calibration.scene, structure, {k: v[i] for k, v in quantities.items()}, rng
        )
        truth = {k: v[i] for k, v in sites.items()}
        seed = int(rng.integers(2**31))
        way, *_ = ways(calibration.method, scene)
        try:
            # as in a reconstruction: a method that gives the evidence weights solutions by its own draws
            where = ModeSearch(scene, seed).on(
                calibration.model,
                way.coordinates,
                weighted=not METHODS[calibration.method].weighs,
            )
        except Unanswerable as error:
            rows.append(Row(number, {}, f"refused: {error}", closing[i]))
            continue
        rows.append(
            _ranked(where, calibration.method, seed, truth, rng, Row(number, closing=closing[i]))
        )
    return rows


def digest(scene: Scene, model: str) -> str:
    """Digest of the numbers that a design and a rung compute with, in twelve characters; no words count.

    Args:
        scene: the design.
        model: name of the rung.
    """
    s, data = RUNGS[model].of_scene(scene)
    fixed: tuple[object, ...] = (
        s.uncertain,
        s.known_of_b,
        s.surfaces,
        s.rolling,
        s.robust,
        s.interlocked,
        s.marks,
    )
    fixed += (s.families,) if s.families else ()
    print_ = hashlib.sha256(repr(fixed).encode())
    for numbers in (data.inputs, data.evidence, data.marks, data.priors, data.ways, data.records):
        for name in sorted(numbers):
            leaves = jax.tree.leaves(numbers[name])  # a prior given in Python has several
            print_.update(name.encode() + b"".join(np.asarray(x, float).tobytes() for x in leaves))
    for corners in (np.concatenate([*data.edges], axis=1), *data.outlines):
        print_.update(np.asarray(corners).tobytes())
    return print_.hexdigest()[:12]


def _truths(programs: Programs, data: Data, rng: np.random.Generator) -> tuple[Values, Values]:
    """The first `_BATCH` plausible crashes from the prior: their unknowns, and what follows."""
    found: list[tuple[Values, Values]] = []
    count = 0
    for _ in range(_MOST_CHUNKS):
        # as inference draws the prior, whose compiled program this shares
        sites = jax.tree.map(np.asarray, programs(PRIOR, int(rng.integers(2**31)), data))
        quantities = _simulated(programs, data, sites)
        good = np.flatnonzero(plausible(programs.structure, data, sites, quantities))
        found.append(jax.tree.map(lambda v, good=good: np.asarray(v)[good], (sites, quantities)))
        count += good.size
        if count >= _BATCH:
            return jax.tree.map(lambda *v: np.concatenate(v)[:_BATCH], *found)
    raise ValueError(
        f"of {_MOST_CHUNKS * CHUNK} crashes drawn from the priors {count} are plausible: check the "
        "design's directions, headings and impact centres"
    )


def _simulated(programs: Programs, data: Data, sites: Values) -> Values:
    """What follows from the unknowns, predictions included."""
    return jax.tree.map(np.asarray, programs(SIMULATE, data, sites))


def plausible(
    structure: Structure, data: Data, sites: Values, quantities: Values
) -> Bool[np.ndarray, " draws"]:
    """Which crashes have B (or what strikes a barrier) driving, close in, lose energy, stay near.

    The test uses the unknowns alone: with the evidence in it, the ranks would not be uniform.

    Args:
        structure: static structure of the scene, which says what unknowns there are.
        data: the scene's numbers, of which only those of the inputs and priors count.
        sites: values of the unknowns by name, a row for each crash.
        quantities: values of what follows from the unknowns, by name, a row for each crash.
    """
    known = sites | quantities
    good = _closing_speeds(structure, data, sites, quantities) > CLOSING
    none = np.zeros(len(good))
    driven = "speed_a" if structure.single else "speed_b"
    good &= np.asarray(known.get(driven, none + np.inf)) > DRIVING
    good &= np.asarray(known.get("energy_lost", none + 1)) > 0
    good &= np.asarray(known.get(f"condition/{parts.CLOSE_IN}", none)) == 0
    for v in structure.vehicles:
        good &= np.abs(known.get(f"Omega_{v}", none)) < SPIN
        for part in ("x", "y"):
            good &= np.abs(known.get(f"predicted/rest_{part}_{v}", none)) < FAR
    return good


def _closing_speeds(
    structure: Structure, data: Data, sites: Values, quantities: Values
) -> Float[np.ndarray, " draws"]:
    """How fast the vehicles of crashes come together, m/s."""
    known = sites | quantities
    none = np.zeros(len(known["Vax"]))
    xi = known.get("measured", none[:, None][:, :0])
    # a barrier stands still
    motion = jnp.stack([known.get(name, none) for name in ("vbx", "vby", "omega_b")], axis=1)
    return np.asarray(_closing(structure, data, xi, motion))


@partial(jax.jit, static_argnums=0)
def _closing(
    structure: Structure,
    data: Data,
    xi: Float[Array, "draws inputs"],
    motion: Float[Array, "draws 3"],
) -> Float[Array, " draws"]:
    """How fast the vehicles come together at the contact, from where each stands, m/s."""

    def one(xi: Array, of_b: Array) -> Array:
        x = parts.from_standard(structure, data, xi)
        return closing_speed(jnp.append(parts.approach_of_a(x), of_b), parts.bodies(x))

    return jax.vmap(one)(xi, motion)


def _measured(
    scene: Scene, structure: Structure, quantities: Values, rng: np.random.Generator
) -> Scene:
    """The design with the rest poses of a crash and the motion before them, read off with errors."""
    rest, evidence = dict(scene.rest), scene.evidence()
    after: dict[str, Any] = {name: dict(getattr(scene, name)) for name in AFTER}
    for name in structure.evidence:
        kind, v, _ = parsed(name)
        part = kind.removeprefix("rest_")
        sd = evidence[name].sd
        value = float(quantities[f"predicted/{name}"]) + sd * rng.standard_normal()
        if of_table := next((name for name, own in AFTER.items() if kind in own.kinds), None):
            items, item = after[of_table], kind.removeprefix(AFTER[of_table].prefix)
            items[v] = items[v] | {item: replace(items[v][item], value=value)}
            continue
        m = replace(getattr(rest[v], part), value=value, sd=sd)
        rest[v] = replace(rest[v], **{part: m}, turns_known=True)
    # the design's errors stand, however far a crash's way is: the run-out's is in them by now
    vehicles = {v: replace(own, run_out_error=RunOutError()) for v, own in scene.vehicles.items()}
    return replace(scene, rest=rest, vehicles=vehicles, **after)


def _ranked(
    where: PosteriorModes,
    method: str,
    seed: int,
    truth: Values,
    rng: np.random.Generator,
    row: Row,
) -> Row:
    """A row with ranks of the truth among draws of a scene's solutions; or none, and why."""
    found = where.found
    every, reasons, evidence = zip(*(_draws(s, method, seed) for s in found), strict=True)
    if METHODS[method].weighs:
        weights = shares(np.array(evidence))
    else:
        weights = np.array([solution.mode.weight for solution in found])
        weights /= weights.sum()  # of solutions that were left out some had a little
    judged = [own for w, own in zip(weights, reasons, strict=True) if w >= SLIGHT]
    if faults := sum(judged, where.faults):
        return replace(row, reason=f"checks failed: {'; '.join(faults)}")
    drawn, truth = _plausible_draws(found, every, weights, truth, rng)
    count = len(drawn["closing"])
    if count < DRAWS:
        few = f"implausible: {count} of the draws are plausible, not {DRAWS}"
        return replace(row, reason=few)
    kept = np.linspace(0, count - 1, DRAWS).round().astype(int)
    ranks, given = {}, found[0].scene.inputs()  # what is measured is not ranked
    for name in QUANTITIES:
        if name in drawn and not (name == "speed_a" and name in given):
            others, own = drawn[name][kept], truth[name]
            ties = rng.integers(np.sum(others == own) + 1)
            ranks[name] = int(np.sum(others < own) + ties)
    return replace(row, ranks=ranks, closing=float(np.median(drawn["closing"])))


def _plausible_draws(
    found: list[Solution],
    every: Sequence[Values],
    weights: Float[np.ndarray, " solutions"],
    truth: Values,
    rng: np.random.Generator,
) -> tuple[Values, Values]:
    """What is known of plausible draws of a scene's solutions, and of the truth.

    Draws are taken evenly along the chains, in as many calls as give `DRAWS`, or all that there are.

    Args:
        found: the scene's solutions.
        every: the unknowns at the draws of each solution.
        weights: weight of each solution.
        truth: the true unknowns.
        rng: random number generator.
    """
    programs, data = found[0].posterior.programs, found[0].posterior.data
    each = CHUNK - 1  # the truth is the last row of a call
    calls = max(1, min(len(own["Vax"]) for own in every) // each)
    structure = programs.structure
    parted: list[Values] = []
    for call in range(calls):
        which = rng.choice(len(found), each, p=weights) if len(found) > 1 else 0
        along = [np.linspace(call, len(s["Vax"]) - calls + call, each).astype(int) for s in every]
        chosen = {}
        for name, true in truth.items():
            taken = [np.asarray(s[name])[place] for s, place in zip(every, along, strict=True)]
            mixed = np.stack(taken)[which, np.arange(each)]
            chosen[name] = np.concatenate([mixed, np.asarray(true)[None]])
        quantities = _simulated(programs, data, chosen)
        known = chosen | quantities
        known["closing"] = _closing_speeds(structure, data, chosen, quantities)
        known["log_likelihood"] = np.sum(
            [v for k, v in quantities.items() if k.startswith("log_likelihood/")], axis=0
        )
        good = np.flatnonzero(plausible(structure, data, chosen, quantities)[:-1])
        parted.append({name: values[good] for name, values in known.items()})
        if sum(len(of_call["closing"]) for of_call in parted) >= DRAWS:
            break
    drawn = {name: np.concatenate([of_call[name] for of_call in parted]) for name in known}
    return drawn, {name: values[-1] for name, values in known.items()}


def _draws(solution: Solution, method: str, seed: int) -> tuple[Values, tuple[str, ...], float]:
    """The unknowns at draws of a solution, why they would be withheld, and their log evidence.

    Where the method gives no evidence, this is not a number.
    """
    posterior, scene = solution.posterior, solution.scene
    draws = METHODS[method].draws
    task = Task(posterior, _CHAINS, draws, _WARMUP, seed, lambda *_: None)

    def judge(drawn: list[Draws], _: int) -> tuple[Values, Checks]:
        return _checked(posterior, drawn[0], scene)

    def short(judged: tuple[Values, Checks], times: int) -> bool:
        # as of a reconstruction, but that a digit matters to no rank
        return bool(judged[1].reasons) and may_improve(judged[1], task, times, method)

    first = [METHODS[method].draw(task)]
    (drawn,), (sites, checks), _ = until_enough(first, judge, short, doubled)
    if not drawn.complete:
        raise KeyboardInterrupt
    return sites, checks.reasons, drawn.attributes.get("log_evidence", np.nan)


def _checked(posterior: Posterior, drawn: Draws, scene: Scene) -> tuple[Values, Checks]:
    """The unknowns at the draws, and the verdict on them."""
    import xarray as xr

    known = drawn.known(posterior)
    shape, dims = drawn.w.shape[:2], ("chain", "draw")
    judged = {k: v for k, v in known.items() if k in REPORTED or k == "mu_critical"}
    idata = xr.DataTree.from_dict(
        {
            "/posterior": xr.Dataset({k: (dims, v.reshape(shape)) for k, v in judged.items()}),
            "/posterior_predictive": xr.Dataset(),
            "/sample_stats": xr.Dataset(
                {k: (dims, v) for k, v in drawn.stats.items()}, attrs=drawn.attributes
            ),
        }
    )
    return known, diagnostics.judge(idata, scene, drawn.faults)
