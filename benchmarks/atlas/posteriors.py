"""The edges of inference: scenes and methods run over them, and what the checks said."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks import competitors
from benchmarks.atlas import Row
from benchmarks.atlas.maps import ASKED, draw, faults, off, sites
from benchmarks.atlas.scenes import made
from retrodict.inference import Unanswerable
from retrodict.inference.fitting.posterior import Posterior, prepare
from retrodict.inference.outcome import Outcome
from retrodict.inference.reconstruct import DEFAULT_RUNG, reconstruct
from retrodict.inference.samplers import METHODS, Task
from retrodict.scene.records import Scene
from retrodict.studies.conflict import conflicts

Array = np.ndarray


def verdict_of(scene: Scene, method: str = "importance") -> tuple[str, Outcome | None]:
    """What the checks of a reconstruction say, shortly."""
    try:
        outcome = reconstruct(scene, method=method)
    except Unanswerable as refusal:
        return f"refused ({str(refusal).split(';')[0]})", None
    checks = outcome.checks
    if not checks.passed:
        return f"withheld ({_short(checks.reasons[0])})", outcome
    flags = [_short(flag) for flag in checks.flags]
    return "passed" + (f", flagged: {'; '.join(flags)}" if flags else ""), outcome


def _short(reason: str) -> str:
    return textwrap.shorten(reason, 120, placeholder=" …")


def far_from_truth(outcome: Outcome | None, truth: dict[str, float]) -> float:
    """By how many posterior sd the mean misses the truth, the worst of four quantities."""
    if outcome is None:
        return np.nan
    draws = {name: outcome.idata["posterior"][name].values for name in ASKED}
    return max(float(abs(x.mean() - truth[name]) / x.std()) for name, x in draws.items())


def moved(scene: Scene, vehicle: str, metres: float) -> Scene:
    """The scene with a rest position written down so far off along x."""
    rest = scene.rest[vehicle]
    x = replace(rest.x, value=rest.x.value + metres)
    return replace(scene, rest=scene.rest | {vehicle: replace(rest, x=x)})


def vague(scene: Scene, factor: float) -> Scene:
    """The scene with rest poses so many times as uncertain."""

    def blurred(rest: object) -> object:
        names = ("x", "y", "heading")
        sds = {n: getattr(rest, n).sd * factor for n in names}
        return replace(rest, **{n: replace(getattr(rest, n), sd=sd) for n, sd in sds.items()})  # type: ignore[type-var]

    return replace(scene, rest={v: blurred(r) for v, r in scene.rest.items()})


def wrapped(scene: Scene) -> Scene:
    """The scene with B's rotation not written down."""
    rest, at = scene.rest["b"], scene.vehicles["b"].heading.value
    turn = (rest.heading.value - at + np.pi) % (2 * np.pi) - np.pi
    heading = replace(rest.heading, value=at + turn)
    return replace(
        scene, rest=scene.rest | {"b": replace(rest, heading=heading, turns_known=False)}
    )


def rows() -> Iterator[Row]:
    """All edges of inference."""
    row = partial(Row, "inference")
    parts = []
    for sds in (0.3, 0.1):
        scene, truth = made(sds=sds)
        said, outcome = verdict_of(scene, "importance")
        far = far_from_truth(outcome, truth)
        parts.append(f"{sds:g}: {said}, truth {far:.1f} sd off")
    yield row(
        "sd -> 0: a thin posterior",
        "importance, every sd of the scene times 0.3 and 0.1",
        "; ".join(parts),
        "steps of the run-out double till the rest poses are resolved; what is not is withheld",
        "fine",
        "test_posteriors.py::test_a_thin_posterior_is_right_or_withheld",
    )
    parts = []
    for factor in (3.0, 10.0, 100.0):
        scene, _ = made()
        parts.append(f"{factor:g}: {verdict_of(vague(scene, factor))[0]}")
    yield row(
        "sd -> infinity: the prior alone",
        "importance, rest poses 3, 10 and 100 times as uncertain",
        "; ".join(parts),
        "Pareto k and effective sample size; nuts has divergences and R-hat; where all is well with "
        "these, that the evidence is weak. A few per cent of the prior's tails may then be missing",
        "flagged",
        "test_posteriors.py::test_rest_poses_without_information_are_withheld_or_flagged",
    )
    parts = []
    for sds in (3, 10, 40):
        scene, truth = made()
        said, outcome = verdict_of(moved(scene, "b", sds * scene.rest["b"].x.sd))
        far = far_from_truth(outcome, truth)
        parts.append(f"{sds} sd: {said}" + (f", truth {far:.1f} sd off" if outcome else ""))
        if outcome:
            item = next(each for each in conflicts(outcome) if each.name == "rest_x_b")
            parts[-1] += (
                f"; in the report: of an error in it {item.believed:.0%} would be believed, and one "
                f"sd would move B's speed by {item.moved:.2f} m/s"
            )
    yield row(
        "an outlier",
        "importance, B's rest written down 3, 10, 40 of its sds off along x",
        "; ".join(parts),
        "flags where an item lies over 2.5 sd from all else; six items and seven unknowns leave few "
        "that others could contradict: which, and what an error would do, the report says of each",
        "flagged",
        "test_posteriors.py::test_an_outlier_is_believed",
    )
    scene, _ = made()
    parts = [f"{far:+g} m: {verdict_of(moved(scene, 'a', far))[0]}" for far in (-20.0, 15.0)]
    yield row(
        "contradictory evidence",
        "importance, A's rest written down 20 m farther on its way, and 15 m back",
        "; ".join(parts),
        "a rest that no impact leads to is refused or named; one that odd coefficients lead to only "
        "has these flagged",
        "flagged",
        "test_posteriors.py::test_contradictory_evidence_is_named",
    )
    said, _ = verdict_of(wrapped(scene))
    yield row(
        "two modes: turns not written down",
        "importance, B's rotation left out",
        said,
        "other numbers of turns are tried, and the run is withheld where a second one has weight",
        "fine",
        "test_posteriors.py::test_turns_that_are_not_written_down_are_found",
    )
    yield from _heavy(row)
    yield from _nuts(row)


def _heavy(row: partial[Row]) -> Iterator[Row]:
    scene, _ = made(friction_sd=0.6)
    posterior = prepare(scene, DEFAULT_RUNG)
    sure = sites(posterior, draw(posterior, "nuts"))
    parts = []
    for method in ("importance", "laplace"):
        drawn = draw(posterior, method)
        x = sites(posterior, drawn)
        k = drawn.attributes["pareto_k"]
        held = "withheld" if faults(posterior, drawn, x) else "passed"
        parts.append(f"{method}: Pareto k {k:.2f}, {held}, {off(x, sure):.2f} sd off nuts")
    yield row(
        "heavy tails",
        "friction known to 60 %",
        "; ".join(parts),
        "Pareto k above 0.7 fails the run",
        "flagged",
        "test_posteriors.py::test_heavy_tails_do_not_pass_unseen",
    )
    parts = []
    for method in ("linear", "monte-carlo"):
        drawn = draw(posterior, method)
        x = sites(posterior, drawn)
        held = "withheld" if faults(posterior, drawn, x) else "passed"
        parts.append(
            f"{method}: {np.mean(x['e'] < 0):.0%} of the draws have e < 0, "
            f"{np.mean(np.abs(x['e_m']) > 1):.0%} e_m beyond 1; {held}, {off(x, sure):.2g} sd off nuts"
        )
    yield row(
        "linear propagation past its reach",
        "linear and monte-carlo, friction known to 60 %",
        "; ".join(parts),
        "both are held against 2000 importance draws, and fail where mean or spread is off by a fifth "
        "of the sd, or these cannot decide",
        "flagged",
        "test_posteriors.py::test_what_leaves_the_bounds_is_withheld",
    )


def _nuts(row: partial[Row]) -> Iterator[Row]:
    scene, _ = made()
    posterior = prepare(scene, DEFAULT_RUNG)
    long = draw(posterior, "nuts", 2000)
    sure, w = sites(posterior, long), long.w.reshape(-1, long.w.shape[-1])
    parts = []
    for warmup in (5, 150):
        found = METHODS["nuts"].draw(Task(posterior, 4, 500, warmup, 0, lambda *_: None))
        x = sites(posterior, found)
        held = "; ".join(faults(posterior, found, x)) or "passed"
        parts.append(f"{warmup}: {held}, {off(x, sure):.2f} sd off")
    yield row(
        "NUTS with too little warm-up",
        "5 and 150 iterations, 500 draws",
        "; ".join(parts),
        "the target is nearly a sphere of known size; the command asks for 50 at least",
        "fine",
        "test_posteriors.py::test_too_little_warm_up_is_flagged_or_harmless",
    )
    parts = []
    for far in (3.0, 10.0):
        centre = np.asarray(posterior.transform.centre)
        shifted = centre + far * np.asarray(posterior.transform.spread).sum(1)
        elsewhere = replace(posterior, transform=posterior.transform._replace(centre=shifted))
        found = METHODS["nuts"].draw(Task(elsewhere, 4, 500, 150, 0, lambda *_: None))
        x = sites(elsewhere, found)
        held = "; ".join(faults(elsewhere, found, x)) or "passed"
        parts.append(f"{far:g}: {held}, {off(x, sure):.2f} sd off")
    yield row(
        "NUTS from a wrong start",
        "coordinates centred 3 and 10 sd off in every unknown",
        "; ".join(parts),
        "R-hat and effective sample size; the start itself comes from a search over 128 starts",
        "fine",
        "test_posteriors.py::test_a_wrong_start_is_overcome_or_flagged",
    )
    naive, ours = stiffness(posterior, w)
    yield row(
        "NUTS in naive coordinates",
        "correlations of the posterior in the model's own unknowns, unconstrained as NumPyro does it, "
        "and in ours",
        f"condition number {naive:,.0f} against {ours:.1f}; a diagonal mass matrix has to cross it in "
        "steps of the narrow side; docs/inference.md runs it",
        "the coordinates, which every method of ours works in",
        "fine",
        "test_posteriors.py::test_naive_coordinates_are_stiff",
    )


def stiffness(posterior: Posterior, w: Array) -> tuple[float, float]:
    """Condition numbers of the draws' correlations, in NumPyro's coordinates and in ours.

    Args:
        posterior: that was drawn from.
        w: draws in the sampled coordinates, shape (any, q).
    """
    quantities = posterior.evaluate(w)[1]
    forward = competitors.Forward(posterior.programs.structure, posterior.data, quantities)
    naive, ours = (np.linalg.cond(np.corrcoef(u.T)) for u in (forward.starts, w))
    return float(naive), float(ours)
