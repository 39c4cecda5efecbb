"""Draws of all solutions by a method, judged; where they fall short, more of them or another method."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference import diagnostics
from retrodict.inference.datatree import tree_of
from retrodict.inference.density.compiled import COMPILATION, Stopwatch
from retrodict.inference.errors import Interrupted
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.modes import SLIGHT, Solution, UnsampledMode, all_modes, mixed
from retrodict.inference.outcome import Checks, Mode
from retrodict.inference.prior_check import Reference
from retrodict.inference.samplers import METHODS, Draws, Task
from retrodict.progress import Progress
from retrodict.scene.quantities import SHORT, describe

if TYPE_CHECKING:
    import xarray as xr

_NEARLY = 1.1  # R-hat up to which more draws may help
_WORTH_MORE = 100  # draws a chain: who asks for fewer wants a quick look, not more of it
_REFUTED = 1e-6  # probability of the evidence at the mode below which no method's draws would count
# methods that are tried where one fails, in order
_INSTEAD = {"nuts": ("importance", "smc"), "importance": ("smc",)}


@dataclass(frozen=True)
class Run:
    """What a method made of all solutions.

    Args:
        method: a name in METHODS.
        idata: the draws, mixed.
        checks: the verdict on them.
        failed: reasons in it that are the draws' own, and not known before.
        draws: asked for of each chain.
        seconds: of sampling, without compilation.
        complete: False when interrupted.
        notes: how it helped itself.
        unfinished: interrupted chains as a file holds them.
        modes: the solutions, then each unsampled mode that no draw holds.
        drawn: what the method drew of each solution.
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
    modes: tuple[Mode, ...]
    drawn: list[Draws]


@dataclass(frozen=True)
class Sampling:
    """What is known of a posterior before it is sampled.

    Args:
        found: its solutions.
        unsampled: other modes, which draws should reach.
        faults: for which no draws are to be relied on.
        reference: crashes of the prior, with which draws have to agree.
        pictured: whether the prior and run-outs are recorded too, which figures show.
        report: called as the work goes on.
    """

    found: list[Solution]
    unsampled: list[UnsampledMode]
    faults: tuple[str, ...]
    reference: Reference
    pictured: bool
    report: Progress

    def by(self, method: str, task: Task) -> Run:
        """Draws of every solution by a method, which goes on to more where that may help.

        Args:
            method: a name in METHODS.
            task: for the first solution's posterior.
        """
        sampling = Stopwatch()
        with self._sampling(sampling):
            drawn = self._of_each(method, task)
        notes = [note for each in drawn for note in each.notes]
        short: list[Checks] = []

        def more(drawn: list[Draws]) -> list[Draws]:
            with self._sampling(sampling):
                return doubled(drawn)

        def judge(drawn: list[Draws], times: int) -> tuple[xr.DataTree, Checks, list[Mode]]:
            # of what was evaluated importance sampling keeps no more than twice
            return self._judged(drawn, replace(task, draws=min(times, 2) * task.draws))

        def is_short(judged: tuple[xr.DataTree, Checks, list[Mode]], times: int) -> bool:
            short.append(judged[1])
            return may_improve(judged[1], task, times, method)

        drawn, judged, times = until_enough(drawn, judge, is_short, more)
        idata, checks, modes = judged
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
            idata=idata,
            checks=checks,
            failed=checks.reasons[len(self.faults) :],
            draws=draws,
            seconds=sampling.seconds,
            complete=complete,
            notes=tuple(notes),
            unfinished=drawn[0].unfinished if len(self.found) == 1 else None,
            modes=tuple(modes),
            drawn=drawn,
        )

    def _lacking(self, checks: Checks) -> list[str]:
        """What of draws more of them may improve."""
        lacking = [*checks.reasons[len(self.faults) :]]
        if checks.imprecise:
            names = ", ".join(describe(name)[0] for name in checks.imprecise)
            lacking.append(f"not one digit of the 95 % limits was sure of {names}")
        return lacking

    def of_several_modes(self, method: str, task: Task) -> Run | None:
        """Draws by populations that begin from the prior, where chains or a proposal would see one mode.

        Args:
            method: name in METHODS, that was asked for.
            task: for the first solution's posterior.

        Returns:
            The run; None where there is one mode, a quick look was asked for, or the draws failed.
        """
        if method not in _INSTEAD or not self.unsampled or task.draws < _WORTH_MORE:
            return None
        draws = max(task.draws, METHODS["smc"].draws)
        run = self.by("smc", replace(task, draws=draws, resume=None))
        if run.failed and run.complete:
            return None
        note = f"the posterior has several modes, which {method} may miss: it was drawn by smc"
        return replace(run, notes=(note, *run.notes))

    def or_by_another(self, run: Run, task: Task) -> Run:
        """The run; or, where its draws failed, one by the first other method that did not.

        Args:
            run: by the method that was asked for.
            task: for the first solution's posterior.
        """
        others = _INSTEAD.get(run.method, ())
        if not (others and run.failed and run.complete and task.draws >= _WORTH_MORE):
            return run
        if missed := _missed(self.found):
            return replace(run, notes=(*run.notes, f"{missed}: no other method was tried"))
        seconds, notes = run.seconds, run.notes
        for method in others:
            # the draws that failed say where the posterior lies, though they are not reported
            found = [s.whitened_by(d.w) for s, d in zip(self.found, run.drawn, strict=True)]
            unsampled = [
                other.converted_to(self.found[other.of], found[other.of])
                for other in self.unsampled
            ]
            draws = max(task.draws, METHODS[method].draws)
            again = replace(task, posterior=found[0].posterior, draws=draws, resume=None)
            try:
                other = replace(self, found=found, unsampled=unsampled).by(method, again)
            except Interrupted as refusal:
                notes = (*notes, f"the method {method} was tried too, and failed: {refusal}")
                return replace(run, notes=notes, seconds=seconds, complete=False)
            seconds += other.seconds
            if not other.failed:
                why = f"the first sampler, {run.method}, was not accepted ({most(run.failed)})"
                note = f"{why} and was replaced by {method}"
                return replace(other, notes=(note, *other.notes), seconds=seconds)
            notes = (*notes, f"the method {method} was tried too, and failed: {most(other.failed)}")
            if not other.complete:
                break
        return replace(run, notes=notes, seconds=seconds)

    @contextmanager
    def _sampling(self, stopwatch: Stopwatch) -> Iterator[None]:
        """A context in which draws are made: its seconds are added, but for compilation."""
        self.report("sampling", 0, 1)
        before = COMPILATION.seconds
        with stopwatch.running():
            yield
        stopwatch.seconds -= COMPILATION.seconds - before
        self.report("predicting", 0, 1)

    def _of_each(self, method: str, task: Task) -> list[Draws]:
        """Draws of every solution, up to one that was interrupted."""
        drawn: list[Draws] = []
        for i, solution in enumerate(self.found):
            progress = partial(_one_of_several, task.progress, i, len(self.found))
            posterior = solution.posterior
            # populations reach other modes too from the prior
            wide = method == "smc" and bool(solution.others)
            start = posterior.over_prior() if wide else posterior
            own = METHODS[method].draw(replace(task, posterior=start, progress=progress))
            drawn.append(_converted(own, start, posterior) if wide else own)
            if not drawn[-1].complete:
                break
        return drawn

    def _judged(self, drawn: list[Draws], task: Task) -> tuple[xr.DataTree, Checks, list[Mode]]:
        """The draws mixed, the verdict on them, and the modes in their light."""
        modes = self._modes(drawn)
        others = modes[len(self.found) :]
        known = self.faults + tuple(_conflicting(mode, self.found[0].mode) for mode in others)
        trees = [
            tree_of(s, d, task.seed, self.reference if self.pictured else None)
            for s, d in zip(self.found, drawn, strict=False)
        ]
        # a chain that is stuck in one solution would be hidden by the others
        for solution, each, tree in zip(self.found, drawn, trees, strict=False):
            if solution.mode.weight < SLIGHT:
                continue
            known += each.faults
            if len(trees) > 1 and "diverging" in each.stats:
                own = diagnostics.judge(tree, solution.scene).reasons
                known += tuple(f"{solution.label()}: {reason}" for reason in own)
        if not all(each.complete for each in drawn):
            kept = min(each.w.shape[1] for each in drawn)
            known += (f"interrupted: {kept} of {task.draws} draws a chain were kept",)
        idata = mixed(trees, [s.mode for s in self.found], task.seed)
        checks = diagnostics.judge(idata, self.found[0].scene, known, self.reference)
        return idata, checks, modes

    def _modes(self, drawn: list[Draws]) -> list[Mode]:
        """The solutions, then each unsampled mode that no draw of its solution holds."""
        unreached = [
            other
            for other in self.unsampled
            if other.of >= len(drawn)
            or not other.reached(drawn[other.of].w.reshape(-1, other.w.size))
        ]
        return all_modes(self.found, unreached)


def _converted(drawn: Draws, before: Posterior, after: Posterior) -> Draws:
    """Draws, and more of them, in other coordinates of the same posterior."""
    w = after.at_deviates(before.deviates(drawn.w.reshape(-1, drawn.w.shape[-1])))
    further = drawn.more
    more = (lambda: _converted(further(), before, after)) if further else None
    return replace(drawn, w=w.reshape(drawn.w.shape), more=more)


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
    more: Callable[[list[Draws]], list[Draws]],
) -> tuple[list[Draws], J, int]:
    """Draws, doubled for as long as they are short of what more of them may improve.

    Args:
        drawn: of each solution.
        judge: gives a verdict on draws that are so many times those at first.
        short: whether it lacks anything that more may improve.
        more: doubles them, as `doubled` does.

    Returns:
        The draws, the verdict on them, and how many times those at first they are.
    """
    times, verdict = 1, judge(drawn, 1)
    while all(each.complete and each.more for each in drawn) and short(verdict, times):
        drawn, times = more(drawn), 2 * times
        verdict = judge(drawn, times)
    return drawn, verdict, times


def doubled(drawn: list[Draws]) -> list[Draws]:
    """Twice as many draws of each solution."""
    return [each.more() for each in drawn if each.more]


def may_improve(checks: Checks, task: Task, times: int, method: str) -> bool:
    """Whether more draws may improve what these lack.

    Args:
        checks: of the draws.
        task: that asked for them.
        times: as many as it asked for were drawn already; for a digit alone they are doubled but once.
        method: a name in METHODS; populations of smc are all anew, so they need not be near.
    """
    short = bool(checks.failed or (checks.imprecise and times == 1))
    near = checks.max_rhat < _NEARLY or method == "smc"
    return short and near and task.draws >= _WORTH_MORE


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
        at_mode = posterior.evaluate(np.zeros((1, posterior.size)))[1]
        items = posterior.programs.structure.evidence
        off = [(at_mode[f"predicted/{k}"][0] - evidence[k].value) / evidence[k].sd for k in items]
        squares.append(float(np.square(off).sum()))
    if not chi2.sf(min(squares), len(items)) < _REFUTED:
        return ""
    return (
        "even where the posterior is highest the model misses the evidence (chi-square "
        f"{min(squares):.3g} of {len(items)} items)"
    )


def has_failed(run: Run | None, draws: int) -> bool:
    """Whether draws failed, of so many of each chain that they need not have; None is known to fail."""
    failed = run is None or (run.complete and bool(run.checks.reasons))
    return failed and draws >= _WORTH_MORE


def _conflicting(other: Mode, sampled: Mode) -> str:
    sought = "speed_b" if "speed_b" in sampled.values else "speed_a"
    speeds = (f"{mode.values[sought]:.3g}" for mode in (other, sampled))
    return (
        f"the evidence fits another solution (weight {other.weight:.1%}), with a {SHORT[sought]} of "
        f"{' m/s instead of '.join(speeds)} m/s, that was not sampled: measurements may conflict; "
        "the method smc looks for all solutions"
    )
