"""Draws of a posterior by one way after the other, until some pass: draw, judge, take more, go on.

The reason why each way failed is noted in one place.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpyro.diagnostics import split_gelman_rubin
from scipy.special import logsumexp

from retrodict.inference import diagnostics
from retrodict.inference.datatree import tree_of
from retrodict.inference.density.compiled import COMPILATION, Stopwatch
from retrodict.inference.digits import rhat_text
from retrodict.inference.errors import Interrupted, Unanswerable
from retrodict.inference.modes import (
    SLIGHT,
    PosteriorModes,
    Solution,
    evidence_of,
    mixed,
    shares,
    weighted_by_evidence,
)
from retrodict.inference.outcome import Checks
from retrodict.inference.plan import WORTH_MORE, Way
from retrodict.inference.prior_check import Reference, refuted_evidence
from retrodict.inference.samplers import METHODS, Draws, Task
from retrodict.inference.samplers.importance import Evidence
from retrodict.options import RunOptions
from retrodict.progress import Progress
from retrodict.scene.quantities import describe

if TYPE_CHECKING:
    import xarray as xr

_NEARLY = 1.1  # R-hat up to which more draws may help
_REFUTED = 1e-6  # probability of the evidence at the mode below which no method's draws would count


def first_that_passes(
    ways: tuple[Way, ...],
    find: Callable[[Way], PosteriorModes],
    draw: Callable[[Way, PosteriorModes], Run],
    *,
    quick: bool = False,
) -> Run:
    """Draws by the first way whose draws pass; where none does, by the first that gave any.

    Methods with chains are passed over where several modes share a density, for chains may miss one.
    Where the solutions in a way's coordinates have faults, all other ways go first.

    Args:
        ways: methods with their coordinates, in the order of trying.
        find: function that finds the posterior's solutions in a way's coordinates.
        draw: function that draws by a way, and judges the draws.
        quick: whether the first draws are accepted, whatever they lack.

    Returns:
        The run, with notes of what else was tried; an interrupted run ends the work.

    Raises:
        Unanswerable: no posterior was found in any coordinates.
        Interrupted: stopped before any draw was kept.
    """
    queue, late = deque(ways), set[Way]()
    tried: list[tuple[str, str]] = []  # method, and why it was not accepted
    runs: list[Run] = []
    refusals: list[Unanswerable] = []
    done: set[tuple[str, int]] = set()  # method and place
    closed: set[int] = set()  # places where no further method helps
    while queue:
        way = queue.popleft()
        try:
            where = find(way)
        except Unanswerable as refusal:
            refusals.append(refusal)
            tried.append((way.method, str(refusal)))
            continue
        place = id(where)
        if place in closed or (way.method, place) in done:
            continue
        if METHODS[way.method].follows and queue and way not in late and len(where.found) > 1:
            tried.append((way.method, "the posterior has several modes, which chains may miss"))
            if not where.shared:  # each is a part of its own, of which chains take longest
                late.add(way)
                queue.append(way)
            continue
        missed = _missed(where.found)
        if where.faults and queue and way not in late and not missed:
            tried.append((way.method, most(where.faults)))
            late.add(way)
            queue.append(way)
            continue
        try:
            run = draw(way, where)
        except Interrupted as refusal:
            if not runs:
                raise
            tried.append((way.method, str(refusal)))
            runs[0] = replace(runs[0], complete=False)
            break
        runs.append(run)
        done.add((way.method, place))
        if not run.checks.reasons or quick:
            break
        tried.append((way.method, most(run.failed or run.checks.reasons)))
        if not run.complete:
            break
        if not run.failed:
            closed.add(place)
        elif missed:
            note = f"{missed}: no other method was tried"
            runs[0] = replace(runs[0], notes=(*runs[0].notes, note))
            break
    if not runs:
        raise refusals[0]
    return _noted(runs, tried)


@dataclass(frozen=True)
class Run:
    """Draws of all solutions by one method, with the verdict on them.

    Args:
        method: a name in METHODS.
        idata: the draws, mixed.
        checks: the verdict on them.
        failed: reasons in `checks` that are the draws' own, and not known before.
        draws: number of draws asked for of each chain.
        seconds: duration of sampling, without compilation, s.
        complete: False when interrupted.
        notes: remedies that the run applied by itself, and methods tried besides, in words.
        unfinished: content of a file of interrupted chains; None where there are none to continue.
        found: the solutions, by weight.
    """

    method: str
    idata: xr.DataTree
    checks: Checks
    failed: tuple[str, ...]
    draws: int
    seconds: float
    complete: bool
    notes: tuple[str, ...]
    unfinished: bytes | None
    found: tuple[Solution, ...]


@dataclass(frozen=True)
class Sampling:
    """A posterior that is to be sampled: its solutions, and the reference for its draws.

    Args:
        where: the solutions, in the coordinates of the draws, and faults known of them.
        reference: crashes of the prior, with which draws have to agree.
        pictured: whether the prior and run-outs, which figures show, are recorded too.
        report: callback that is called with (stage, done, of all) as the work goes on.
    """

    where: PosteriorModes
    reference: Reference
    pictured: bool
    report: Progress

    @property
    def found(self) -> list[Solution]:
        """The solutions."""
        return self.where.found

    def by(self, method: str, options: RunOptions, resume: Path | None = None) -> Run:
        """Draws of every solution by a method, which goes on to more where that may help.

        Args:
            method: a name in METHODS.
            options: options of the run; the method that was asked for makes as many draws as they say,
                another no fewer than by default.
            resume: file of interrupted chains to be continued; None to begin anew.
        """
        usual = METHODS[method].draws
        asked = usual if options.draws is None else options.draws
        task = Task(
            self.found[0].posterior,
            options.chains,
            asked if method == options.method else max(asked, usual),
            options.warmup,
            options.seed,
            partial(self.report, "sampling"),
            resume,
        )
        run = self._by(method, task)
        if run.failed and run.complete and self.where.standing:
            self.where.standing.clear()  # what stood by itself may not do beside the others
            again = self._by(method, task)
            run = replace(again, seconds=run.seconds + again.seconds)
        return run

    def _by(self, method: str, task: Task) -> Run:
        """Draws of every solution, including those kept from a method whose other draws failed."""
        sampling = Stopwatch()
        with self._sampling(sampling):
            drawn = self._of_each(method, task)
        notes = [note for each in drawn for note in each.notes]
        short: list[Checks] = []

        def more(_: list[Draws], times: int) -> list[Draws]:
            with self._sampling(sampling):
                return self._of_each(method, task, times)

        def judge(drawn: list[Draws], times: int) -> _Judged:
            # importance sampling keeps at most twice the draws asked for
            return self._judged(drawn, replace(task, draws=min(times, 2) * task.draws))

        def is_short(judged: _Judged, times: int) -> bool:
            short.append(judged.checks)
            return may_improve(judged.checks, task, times, method)

        drawn, judged, times = until_enough(drawn, judge, is_short, more)
        self._leave_standing(method, drawn)
        draws = min(times, 2) * task.draws
        complete = all(each.complete for each in drawn)
        if times > 1:
            lacking = self._lacking(short[0])
            notes.append(
                f"after {task.draws} draws a chain {most(tuple(lacking))}; the run reported here "
                f"went on to {'twice' if times == 2 else f'{times} times'} as many"
            )
        return Run(
            method=method,
            idata=judged.idata,
            checks=judged.checks,
            failed=judged.checks.reasons[len(self.where.faults) :],
            draws=draws,
            seconds=sampling.seconds,
            complete=complete,
            notes=tuple(notes),
            unfinished=drawn[0].unfinished if len(drawn) == 1 else None,
            found=tuple(judged.found),
        )

    def _lacking(self, checks: Checks) -> list[str]:
        """Shortcomings of draws that more draws may improve, in words."""
        lacking = [*checks.reasons[len(self.where.faults) :]]
        if checks.imprecise:
            names = ", ".join(describe(name)[0] for name in checks.imprecise)
            lacking.append(f"the 95 % limits of {names} had no reliable digit")
        return lacking

    @contextmanager
    def _sampling(self, stopwatch: Stopwatch) -> Iterator[None]:
        """A context in which draws are made; its duration, less compilation, is added to a stopwatch."""
        self.report("sampling", 0, 1)
        before = COMPILATION.seconds
        with stopwatch.running():
            yield
        stopwatch.seconds -= COMPILATION.seconds - before
        self.report("predicting", 0, 1)

    def _of_each(self, method: str, task: Task, times: int = 1) -> list[Draws]:
        """Draws of every solution, `times` as many as at first, up to one that was interrupted."""
        drawn: list[Draws] = []
        for i, solution in enumerate(self.found):
            if METHODS[method].weighs and i in self.where.standing:
                drawn.append(self.where.standing[i])
                continue
            place = i, method, task.chains, task.draws, task.warmup, task.seed
            known = self.where.drawn.get((*place, times))
            if known is None or task.resume:
                progress = partial(_one_of_several, task.progress, i, len(self.found))
                slight = solution.mode.weight < SLIGHT
                own = replace(task, posterior=solution.posterior, progress=progress, slight=slight)
                fewer = self.where.drawn.get((*place, times // 2))
                known = fewer.more() if fewer and fewer.more else METHODS[method].draw(own)
            drawn.append(known)
            several = METHODS[method].follows and len(self.found) > 1
            if several and known.complete and (rhat := split_gelman_rubin(known.w).max()) > _NEARLY:
                why = f"{solution.label()}: its chains do not mix (R-hat {rhat_text(rhat)})"
                drawn[-1] = replace(known, faults=(*known.faults, why))
                break  # one part that fails is enough
            if not known.complete:
                break
            self.where.drawn[*place, times] = known
        return drawn

    def _leave_standing(self, method: str, drawn: list[Draws]) -> None:
        """Keep a method's draws of the solutions where they have no faults, if others have."""
        if not (METHODS[method].weighs and len(drawn) == len(self.found) > 1):
            return
        weights = shares(np.array([each.attributes["log_evidence"] for each in drawn]))
        at_fault = [
            bool(each.faults or not each.enough) and weight >= SLIGHT
            for each, weight in zip(drawn, weights, strict=True)
        ]
        if any(at_fault) and not all(at_fault):
            self.where.standing.update(
                {i: replace(drawn[i], more=None) for i, bad in enumerate(at_fault) if not bad}
            )

    def _judged(self, drawn: list[Draws], task: Task) -> _Judged:
        """The draws mixed, and the verdict on them."""
        known = self.where.faults + self._refuted_evidence(drawn)
        found, drawn = self._weighted(drawn)
        trees = [
            tree_of(s, d, task.seed, self.reference if self.pictured else None)
            for s, d in zip(found, drawn, strict=False)
        ]
        # a chain that is stuck in one solution would be hidden by the others
        for solution, each, tree in zip(found, drawn, trees, strict=False):
            if solution.mode.weight < SLIGHT:
                continue
            known += each.faults
            if len(trees) > 1 and "diverging" in each.stats:
                own = diagnostics.judge(tree, solution.scene).reasons
                known += tuple(f"{solution.label()}: {reason}" for reason in own)
        if not all(each.complete for each in drawn):
            kept = min(each.w.shape[1] for each in drawn)
            known += (f"interrupted: {kept} of {task.draws} draws a chain were kept",)
        idata = mixed(trees, [s.mode for s in found], task.seed)
        checks = diagnostics.judge(idata, found[0].scene, known, self.reference)
        return _Judged(idata, checks, found)

    def _refuted_evidence(self, drawn: list[Draws]) -> tuple[str, ...]:
        """Faults of the evidence of all solutions together, where the method gives it."""
        if not (evidence := self._evidence(drawn)):
            return ()
        every = np.array([each.value for each in evidence])
        errors = np.array([each.error for each in evidence])
        error = float(np.sqrt(shares(every) ** 2 @ errors**2))
        return refuted_evidence(self.reference, float(logsumexp(every)), error)

    def _weighted(self, drawn: list[Draws]) -> tuple[list[Solution], list[Draws]]:
        """The solutions, weighted by the evidence that their draws give, and the draws of each."""
        evidence = self._evidence(drawn)
        if len(evidence) < 2:
            return self.found, drawn
        found, places, _ = weighted_by_evidence(self.found, evidence)
        return found, [drawn[i] for i in places]

    def _evidence(self, drawn: list[Draws]) -> list[Evidence]:
        """Log evidence of each solution, where all were drawn by a method that gives it; else empty."""
        known = [each for each in drawn if "log_evidence" in each.attributes]
        return [evidence_of(each) for each in known] if len(known) == len(self.found) else []


class _Judged(NamedTuple):
    """Draws of all solutions, mixed; the verdict on them; and the solutions, weighted."""

    idata: xr.DataTree
    checks: Checks
    found: list[Solution]


def _noted(runs: list[Run], tried: list[tuple[str, str]]) -> Run:
    """The run that counts, with notes of what else was tried, and the seconds of all.

    Args:
        runs: runs in the order of trying; the last one counts if it passed, else the first.
        tried: methods that were not accepted, with the reasons.
    """
    passed = not runs[-1].checks.reasons
    run = runs[-1] if passed else runs[0]
    if passed and tried:
        (first, why), *_ = tried
        notes = [
            f"the first sampler, {first}, was not accepted ({why}) and was replaced by {run.method}"
        ]
    else:
        others = [each for each in tried if each[0] != run.method]
        notes = [f"the method {method} was tried too, and failed: {why}" for method, why in others]
    return replace(run, notes=(*notes, *run.notes), seconds=sum(each.seconds for each in runs))


def most(reasons: tuple[str, ...]) -> str:
    """The first of several reasons, and how many more there are."""
    first, *more = reasons or ("",)
    return f"{first}; and {len(more)} more" if more else first


def _one_of_several(
    progress: Callable[[int, int], None], i: int, count: int, done: int, total: int
) -> None:
    """Report what is done of one of several equal parts as a share of them all."""
    progress(i * total + done, count * total)


def until_enough[J](
    drawn: list[Draws],
    judge: Callable[[list[Draws], int], J],
    short: Callable[[J, int], bool],
    more: Callable[[list[Draws], int], list[Draws]],
) -> tuple[list[Draws], J, int]:
    """Draws, doubled for as long as they are short of what more of them may improve.

    Args:
        drawn: first draws of each solution.
        judge: function that judges draws, given them and their number as a multiple of the first.
        short: function that tells, given a verdict and that multiple, whether more draws may improve it.
        more: function that doubles draws, given them and the multiple that they come to.

    Returns:
        The draws, the verdict on them, and their number as a multiple of the first.
    """
    times, verdict = 1, judge(drawn, 1)
    while all(each.complete and each.more for each in drawn) and short(verdict, times):
        drawn, times = more(drawn, 2 * times), 2 * times
        verdict = judge(drawn, times)
    return drawn, verdict, times


def doubled(drawn: list[Draws], _: int) -> list[Draws]:
    """Twice as many draws of each solution."""
    return [each.more() for each in drawn if each.more]


def may_improve(checks: Checks, task: Task, times: int, method: str) -> bool:
    """Whether more draws may improve what the present ones lack.

    Args:
        checks: verdict on the draws.
        task: task that the draws were made for.
        times: number of draws as a multiple of those asked for; for a digit alone they are doubled once.
        method: a name in METHODS; for one that weighs, R-hat need not be near its limit.
    """
    short = bool(checks.failed or (checks.imprecise and times == 1))
    if METHODS[method].weighs:  # R-hat says nothing of independent draws, and weights may settle
        return (short or bool(checks.reasons)) and task.draws >= WORTH_MORE
    return short and checks.max_rhat < _NEARLY and task.draws >= WORTH_MORE


def _missed(found: list[Solution]) -> str:
    """A sentence if the model misses the evidence even where the posterior is highest; else empty.

    At the mode, and with a degree of freedom for every item, the chi-square is the most lenient.
    """
    from scipy.stats import chi2

    if found[0].scene.robust:  # errors may be of any size
        return ""
    squares = []
    for solution in found:
        assert solution.peak is not None, "what is drawn from was sought"
        items = solution.peak.residuals.size
        squares.append(float(np.square(solution.peak.residuals).sum()))
    if not chi2.sf(min(squares), items) < _REFUTED:
        return ""
    return (
        "even where the posterior is highest the model misses the evidence (chi-square "
        f"{min(squares):.3g} of {items} items)"
    )
