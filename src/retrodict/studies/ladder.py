"""Climbs the ladder of models on one scene, and chooses the lowest rung that will do."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.errors import Interrupted, Unanswerable
from retrodict.inference.modes import ModeSearch
from retrodict.inference.reconstruct import compile_search, reconstruct
from retrodict.inference.samplers.psis import smoothed
from retrodict.inference.transforms.choice import size_of
from retrodict.models import RUNGS, Rung, rungs_for
from retrodict.models.runouts import roll
from retrodict.options import RunOptions
from retrodict.progress import Progress, prefixed, silent
from retrodict.scene.load import as_scene
from retrodict.scene.quantities import REPORTED
from retrodict.scene.records import Scene
from retrodict.studies.comparison import FACTOR, SHARE, Ladder, Reweighted, Step
from retrodict.studies.fit import fit, summary

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome

AUTO = "auto"  # the model that the ladder chooses, or the method that suits the scene
_PRIORS = {"halved": 0.5, "doubled": 2.0, "flat": np.inf}  # times the scale of the sought speed


def ladder(
    scene: Scene | str | Path,
    *,
    question: tuple[str, ...] | None = None,
    seed: int = 0,
    share: float = SHARE,
    factor: float = FACTOR,
    progress: Progress | None = None,
    search: ModeSearch | None = None,
) -> Ladder:
    """Reconstruct a scene on the rungs that it allows, and choose one.

    Chosen is the lowest rung that fits the evidence and is enough: no fuller rung that is enough
    itself moves its answer by more than `share` of the fuller rung's standard deviation, or makes it
    wider or narrower by more than `factor`. A rung fits where a chi-square as large as its own has a
    probability of `MIN_PROBABILITY` or more.

    Where wheels roll, the fullest rung runs first, and simpler ones only where it fails: none of them
    could be enough beside it, because their own errors include how far they miss it.

    Args:
        scene: the measured scene, or the path of a scene file.
        question: quantities asked for, among the speeds, e, e_m and mu; None for the scene's.
        seed: integer seed of all random numbers.
        share: limit on the shift of an answer by a fuller rung, in the fuller rung's standard
            deviations, above 0.
        factor: limit on the ratio of the standard deviations of the two answers, above 1.
        progress: called with (rung, done, of all), and with the stages within each rung.
        search: shared search for the posterior modes, as in `reconstruct`; None for a new one.

    Returns:
        The ladder; when interrupted, with the rungs that were finished.

    Raises:
        SceneError: the scene file cannot be used.
        ValueError: `share` or `factor` is out of range.
        Unanswerable: no rung answers the question from what was measured.

    Examples:
        >>> import retrodict as rd
        >>> found = rd.ladder("examples/brach-1977/scene.toml")
        >>> found.choice
        'planar-moment+spin'
        >>> found.choice in [step.name for step in found.steps]
        True
    """
    if not (0 < share < np.inf and 1 < factor < np.inf):
        raise ValueError(f"share is above 0 and factor above 1; not {share:g} and {factor:g}")
    scene = as_scene(scene)
    progress = progress or silent
    question = question or scene.question
    refused, complete = refusals(scene, question), True
    to_come = _left(refused)
    count = len(to_come)
    if scene.rolling:
        to_come.reverse()
    ran: dict[str, Step] = {}
    while to_come:
        name = to_come[0]
        place = f"{name} ({len(ran) + 1} of {count})"
        within = prefixed(progress, place)
        progress(place, 0, 1)
        try:
            within("compiling", 0, 1)
            # the next one's programs compile while this one's are at work
            for soon in to_come[: 1 if scene.rolling else 2]:
                with suppress(Unanswerable):  # its own run says why
                    compile_search(scene, soon)
            ran[name] = run_rung(scene, name, question, seed, search, within)
        except (KeyboardInterrupt, Interrupted):
            complete = False
            break
        progress(place, 1, 1)
        to_come.pop(0)
        if scene.rolling and ran[name].counts:
            refused |= dict.fromkeys(to_come, f"not run: {name} can be relied on, and is fuller")
            break
    done = set(ran) | {name for name, why in refused.items() if why}
    steps = [ran.get(name) or blank(name, refused[name]) for name in refused if name in done]
    if complete:
        judged, choice, reason = chosen(steps, question, share, factor)
    else:
        judged, choice, reason = tuple(steps), None, "Interrupted: no rung was chosen."
    return Ladder(scene, question, judged, choice, reason, seed, complete, share, factor)


def chosen_for(
    scene: Scene,
    *,
    seed: int,
    progress: Progress | None = None,
    search: ModeSearch | None = None,
) -> tuple[str, Ladder | None]:
    """The rung that the ladder chooses, or the fullest that the scene allows where it chooses none.

    Args:
        scene: the measured scene.
        seed, progress, search: arguments of `ladder`.

    Returns:
        Name of the rung, and the comparison; None in its place where the scene allows one rung only.

    Raises:
        Unanswerable: the scene allows none.
        Interrupted: stopped before a model was chosen.
    """
    rungs = allowed(scene)
    if len(rungs) == 1:
        return rungs[0], None
    comparison = ladder(scene, seed=seed, progress=progress, search=search)
    if not comparison.complete:
        raise Interrupted("stopped before a model was chosen")
    return comparison.choice or rungs[-1], comparison


def run_rung(
    scene: Scene,
    name: str,
    question: tuple[str, ...],
    seed: int,
    search: ModeSearch | None = None,
    progress: Progress | None = None,
) -> Step:
    """Reconstruct a scene on one rung, not yet compared with the others.

    Args:
        scene: the measured scene.
        name: name of the rung.
        question: quantities asked for.
        seed: integer seed of all random numbers.
        search, progress: arguments of `reconstruct`.

    Returns:
        The step; with the reason as its verdict where the rung has no posterior.

    Raises:
        Interrupted: stopped before any draw was kept.
    """
    step = blank(name, "")
    try:
        outcome = reconstruct(
            scene,
            RunOptions(model=name, method="importance", seed=seed),
            progress=progress,
            pictured=False,
            search=search,
        )
    except Unanswerable as error:
        return replace(step, verdict=str(error))
    return _with_answers(outcome, step, question)


def allowed(scene: Scene, question: tuple[str, ...] | None = None) -> list[str]:
    """Rungs that a scene and a question allow, from simplest to fullest.

    Args:
        scene: the measured scene.
        question: quantities asked for; None for the scene's.

    Returns:
        Their names.

    Raises:
        Unanswerable: there is none.
    """
    return _left(refusals(scene, question or scene.question))


def _left(refused: dict[str, str]) -> list[str]:
    """The rungs that were not refused."""
    names = [name for name, why in refused.items() if not why]
    if not names:
        raise Unanswerable(
            f"no model answers the question: the fullest {list(refused.values())[-1]}"
        )
    return names


def refusals(scene: Scene, question: tuple[str, ...]) -> dict[str, str]:
    """Why each rung is not for a scene and a question; empty where it is.

    Args:
        scene: the measured scene.
        question: quantities asked for.

    Returns:
        A reason for each rung of what happened in the scene, from simplest to fullest.
    """
    why = {}
    for name, rung in rungs_for(scene).items():
        mute = [REPORTED[q][0] for q in question if q not in rung.answers]
        if mute:
            why[name] = f"does not answer {', '.join(mute)}"
        elif not (any(map(rung.explains, scene.evidence())) or scene.alone):
            why[name] = "explains nothing of what was measured"
        elif unfit := rung.refusal(scene):
            why[name] = unfit
        else:
            twins = (n for n, no in why.items() if not no and _alike(rung, RUNGS[n], scene))
            twin = next(twins, None)
            why[name] = f"of this scene the same model as {twin}" if twin else ""
    left = [name for name, no in why.items() if not no]
    along = [name for name in left if RUNGS[name].run_out is roll.RUN_OUT]
    if along:  # wheels that roll: the others take long, and would be moved by these
        kept = {along[0], along[-1], left[-1]}
        stand_ins = ", ".join(name for name in left if name in kept)
        stand = f"skipped: slow for rolling wheels; represented by {stand_ins}"
        why |= {name: stand for name in left if name not in kept}
    return why


def _alike(rung: Rung, other: Rung, scene: Scene) -> bool:
    """Whether a scene has nothing of what sets two rungs apart, as one locked road of one friction."""

    def seen(rung: Rung) -> dict[str, tuple[float, float, str]]:
        inputs = rung.run_out.seen(scene).inputs()
        return {name: (m.value, m.sd, m.law if m.sd else "") for name, m in inputs.items()}

    if rung.impact is not other.impact:
        return False
    # nobody asks how they came to rest
    if not scene.followed:
        return rung.run_out.rests == other.run_out.rests
    same = rung.run_out.rest_poses is other.run_out.rest_poses
    return same and seen(rung) == seen(other)


def chosen(
    steps: Sequence[Step],
    question: tuple[str, ...],
    share: float = SHARE,
    factor: float = FACTOR,
) -> tuple[tuple[Step, ...], str | None, str]:
    """Choose among rungs that have run.

    Args:
        steps: steps of the rungs, from simplest to fullest.
        question: quantities asked for.
        share, factor: arguments of `ladder`.

    Returns:
        The steps with their verdicts, the name of the one chosen or None, and the reason.
    """
    most: dict[str, _Move | None] = {}  # what is done to a rung's answer at the most
    enough: list[Step] = []  # from the fullest down: a rung that is not has no say below it
    for step in reversed(steps):
        if not step.counts:
            continue
        above = (fuller for fuller in enough if step.name in fuller.below)
        moves = (_move(step, fuller, quantity) for fuller in above for quantity in question)
        worst = max(moves, default=None, key=lambda move: move.size(share, factor))
        most[step.name] = worst
        if worst is None or worst.size(share, factor) <= 1:
            enough.append(step)
    names = [step.name for step in enough]
    choice = names[-1] if names else None

    def verdict(step: Step) -> str:
        if step.fit is None:
            return step.verdict
        if step.reasons:
            return f"not to be relied on: {'; '.join(step.reasons)}"
        if not step.counts:
            return f"does not fit the evidence (p = {step.fit.probability:.2g})"
        if step.name not in names:
            return f"not enough: {most[step.name]}"
        return "chosen" if step.name == choice else f"would do too, but {choice} is simpler"

    judged = tuple(replace(s, verdict=verdict(s), enough=s.name in names) for s in steps)
    if choice is None:
        reason = "No rung fits the evidence with draws that can be relied on: none is chosen."
    else:
        fit, worst = enough[-1].fit, most[choice]
        assert fit is not None, "only a rung that ran is enough"
        compared = (
            f"and agrees with every more complete model that does, within {share:g} standard deviations "
            f"and a factor of {factor:g} in width. The largest change: {worst}."
            if worst
            else "and no more complete model does."
        )
        fits = f"fits the evidence (p = {fit.probability:.2g})"
        reason = f"{choice} is the simplest model that {fits} {compared}"
        reason += _in_doubt(steps, enough[-1], question)
    return judged, choice, reason


_HAPPENED = {"together": "gone on together", "impact": "parted"}


def _in_doubt(steps: Sequence[Step], choice: Step, question: tuple[str, ...]) -> str:
    """What it would change had the other thing happened, where a scene leaves it in doubt."""
    kinds = {name: rung.impact.kind for name, rung in RUNGS.items()}
    other = {kinds.get(step.name, "") for step in steps} - {kinds.get(choice.name, "")}
    others = [step for step in steps if kinds.get(step.name) in other and step.fit is not None]
    if not others:
        return ""
    had = _HAPPENED[kinds[others[-1].name]]
    fitting = [step for step in others if step.counts]
    if not fitting:
        return f" No model of vehicles that had {had} can be relied on and fits the evidence."
    moves = [_move(choice, fitting[-1], quantity) for quantity in question]
    return f" Had the vehicles {had}: {'; '.join(map(str, moves))}."


@dataclass(frozen=True, slots=True)
class _Move:
    """Change of an answer by a fuller rung: shift in the fuller rung's sd, and ratio of the sds."""

    rung: str
    quantity: str
    shift: float
    width: float

    def size(self, share: float, factor: float) -> float:
        """Size of the change relative to the limits; above 1 where it exceeds one of them."""
        return max(self.shift / share, abs(np.log(self.width)) / np.log(factor))

    def __str__(self) -> str:
        return (
            f"{self.rung} shifts the {REPORTED[self.quantity][0]} by {self.shift:.2f} standard "
            f"deviations, and its uncertainty is {self.width:.2f} times as large"
        )


def _move(step: Step, fuller: Step, quantity: str) -> _Move:
    low, high = step.answers[quantity], fuller.answers[quantity]
    shift = abs(high.median - low.median) / high.sd
    return _Move(fuller.name, quantity, shift, high.sd / low.sd)


def blank(name: str, why: str) -> Step:
    """The step of a rung that was not run, and why it was not."""
    rung = RUNGS[name]
    below = tuple(n for n, other in RUNGS.items() if n != name and rung.nests(other))
    return Step(name, below, verdict=why)


def _with_answers(outcome: Outcome, step: Step, question: tuple[str, ...]) -> Step:
    """The step, with what a run of its rung brought."""
    posterior = outcome.idata["posterior"].to_dataset()
    evidence, error = log_evidence(outcome)
    scene = outcome.scene
    unknown = [f"speed_{v}" for v in scene.vehicles if scene.approach[v].speed is None]
    speed = np.asarray(posterior[scene.sought]).ravel()
    squares = np.zeros(speed.size)
    unknown = [name for name in unknown if not scene.priors[name].family]  # half-normal ones
    for name in unknown:
        scale = scene.priors[name].numbers[0]
        squares += (np.asarray(posterior[name]).ravel() / scale) ** 2
    return replace(
        step,
        answers={name: summary(np.asarray(posterior[name]).ravel()) for name in question},
        fit=fit(outcome),
        log_evidence=evidence,
        log_evidence_sd=error,
        parameters=size_of(RUNGS[step.name].of_scene(scene)[0]),
        seconds=outcome.seconds["total"] - outcome.seconds["compile"],
        reasons=outcome.checks.reasons,
        priors=tuple(
            reweighted(speed, prior, squares / 2 * (1 - times**-2))
            for prior, times in _PRIORS.items()
            if unknown
        ),
    )


def log_evidence(outcome: Outcome) -> tuple[float | None, float | None]:
    """Log marginal likelihood and its standard error: of the mean importance weight, to first order.

    Args:
        outcome: a reconstruction.

    Returns:
        Both; None of draws that are not by importance sampling, or not of all solutions.
    """
    statistics = outcome.idata["sample_stats"].attrs  # of the first solution
    if "log_evidence" not in statistics:
        return None, None
    first = outcome.modes[0]
    error = float(np.hypot(statistics["log_evidence_sd"], first.error / first.weight))
    return statistics["log_evidence"] - float(np.log(first.weight)), error


def reweighted(speed: np.ndarray, prior: str, log_weight: np.ndarray) -> Reweighted:
    """The sought speed under another prior.

    Args:
        speed: draws, shape (any,), m/s.
        prior: name of the other prior.
        log_weight: log density of the other prior less that of the prior of the draws, shape (any,).

    Returns:
        Median and sd of the speed, and Pareto k of the weights.
    """
    weights, k = smoothed(log_weight)
    order = np.argsort(speed)
    middle = float(np.interp(0.5, np.cumsum(weights[order]), speed[order]))
    mean = float(weights @ speed)
    return Reweighted(prior, middle, float(np.sqrt(weights @ (speed - mean) ** 2)), k)
