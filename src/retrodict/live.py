"""Answers while numbers change: a warm session, and a sweep over variants of a scene."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from retrodict.api import AUTO, reconstruct
from retrodict.inference.errors import Unanswerable
from retrodict.inference.outcome import Checks
from retrodict.inference.own import Priors, Terms, with_own
from retrodict.inference.points import Estimate
from retrodict.inference.warm import Warm
from retrodict.progress import Progress, prefixed, shown_in_notebooks, silent
from retrodict.result import Result
from retrodict.scene.asked import read_proposition
from retrodict.scene.edit import change
from retrodict.scene.load import as_scene
from retrodict.scene.quantities import Units, describe, unit_of
from retrodict.scene.records import Scene
from retrodict.studies.ladder import allowed, chosen_for, refusals
from retrodict.studies.short import of_points

if TYPE_CHECKING:
    import pandas as pd

    from retrodict.findings.answers import Answered

_INEFFICIENT = (
    0.2  # effective share of the points below which coordinates are fitted anew, meanwhile
)


@dataclass(frozen=True, repr=False)
class Answer:
    """What a scene's posterior says, by weighted points: no chains, no predictions, no figures.

    Args:
        estimate: the points, their weights and the verdict on them.
        model: name of the rung.
    """

    estimate: Estimate
    model: str

    @property
    def scene(self) -> Scene:
        """The scene with its measurements."""
        return self.estimate.scene

    @property
    def checks(self) -> Checks:
        """The verdict on the numbers. Other solutions were looked for where coordinates were fitted."""
        return self.estimate.checks

    @property
    def seconds(self) -> float:
        """Time that the answer took, s."""
        return self.estimate.seconds

    @property
    def draws(self) -> dict[str, np.ndarray]:
        """Draws of equal weight by name, in SI units and radians, each of shape (draws,)."""
        return self.estimate.draws

    def summary(self, units: Units = "si") -> pd.DataFrame:
        """The reported quantities in a table.

        Args:
            units: units of the table, "si" or "us".

        Returns:
            One row a quantity, one column a statistic: mean, sd, median and limits of the central 95 %,
            the Monte Carlo error of the mean, and the independent draws that would leave the same.
            Numbers that failed the checks are NaN.
        """
        import pandas as pd

        verdict = "passed" if self.checks.passed else "failed"
        rows = {}
        for name, found in of_points(self.estimate).items():
            unit = unit_of(describe(name)[1], units)
            scaled = {key: value / unit.worth for key, value in found.items()}
            same = (found["sd"] / found["mcse_mean"]) ** 2 if found["mcse_mean"] > 0 else np.inf
            if not self.checks.passed:
                scaled = dict.fromkeys(scaled, np.nan)
            rows[name] = {"unit": unit.symbol, **scaled, "as_many_draws": same, "checks": verdict}
        return pd.DataFrame.from_dict(rows, orient="index")

    def probability(self, proposition: str) -> Answered:
        """How probable a proposition about a reported quantity is, given the evidence.

        Args:
            proposition: text such as "speed_b > 45 mph", as in `Result.probability`.

        Returns:
            The answer, as from `Result.probability`.

        Raises:
            ValueError: the text is no such proposition.
        """
        from retrodict.findings.questions import probability_by_points

        return probability_by_points(self.estimate, read_proposition(proposition))

    def __repr__(self) -> str:
        verdict = "passed" if self.checks.passed else "FAILED"
        return f"<Answer to {self.scene.name!r}: {self.model}, checks {verdict}>"


class Session:
    """A scene kept warm: change its numbers, and its posterior follows in a fraction of a second.

    Compiled programs and coordinates are kept. The density is exact. Where measurements were added or
    left out, or the coordinates no longer fit, these are fitted anew, which takes as long as at the
    beginning.

    Args:
        scene: scene with the measurements, or the path of a scene file.
        model: name of a rung; "auto" for the one that the ladder chooses for this scene, and keeps.
        seed: integer seed of all random numbers.
        progress: progress callback, as in `reconstruct`.
        priors, extra: priors and likelihood terms of your own, as in `reconstruct`.

    Raises:
        SceneError: the scene file cannot be used.
        ValueError: no model has that name.
        Unanswerable: the scene has no posterior that could be sampled.
    """

    def __init__(
        self,
        scene: Scene | str | Path,
        model: str = AUTO,
        seed: int = 0,
        progress: Progress | None = None,
        priors: Priors | None = None,
        extra: Terms | None = None,
    ) -> None:
        self.scene = with_own(as_scene(scene), priors, extra)
        self.seed = seed
        self._progress = progress or silent
        if model == AUTO:
            model, _ = chosen_for(self.scene, seed=seed, progress=self._progress)
        self.model = model
        if self.model not in allowed(self.scene):
            why = refusals(self.scene, self.scene.question).get(
                self.model, "no model has that name"
            )
            known = ", ".join(allowed(self.scene))
            raise ValueError(f"model {self.model!r}: {why}; the scene allows the models {known}")
        self._refitting: Future[Warm] | None = None
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="refit")
        self._warm = self._fitted(self.scene)
        self.answer = self._answered(self.scene)

    def update(self, changes: Mapping[str, object] | Scene) -> Answer:
        """Change the scene, and answer it.

        Args:
            changes: new values by dotted key of the scene file, as in `Scene.change`; or the changed
                scene itself.

        Returns:
            The answer, which `answer` keeps; `scene` is the changed scene.

        Raises:
            SceneError: a key or value cannot be used; the session stays as it was.
            Unanswerable: the changed scene has no posterior that could be sampled; the session stays as
                it was.
        """
        scene = changes if isinstance(changes, Scene) else change(self.scene, changes)
        self.answer = self._answered(scene)
        self.scene = scene
        return self.answer

    def confirm(self, method: str = "nuts", progress: Progress | None = None) -> Result:
        """The scene as it now is, reconstructed with all checks, predictions and figures.

        Args:
            method: sampling method, as in `reconstruct`.
            progress: progress callback, as in `reconstruct`.
        """
        return reconstruct(
            self.scene, model=self.model, method=method, seed=self.seed, progress=progress
        )

    def _fitted(self, scene: Scene) -> Warm:
        return Warm(scene, self.model, self.seed, prefixed(self._progress, self.model))

    def _answered(self, scene: Scene) -> Answer:
        self._take_refitted()
        refitted = not self._warm.fits(scene)
        if refitted:
            self._warm = self._fitted(scene)
        found = self._warm.estimate(scene)
        if not found.checks.passed and self._warm.scene != scene:
            self._warm, refitted = self._fitted(scene), True
            found = self._warm.estimate(scene)
        if found.share < _INEFFICIENT and self._warm.scene != scene and not self._refitting:
            self._refitting = self._worker.submit(Warm, scene, self.model, self.seed)
        return Answer(replace(found, refitted=refitted), self.model)

    def _take_refitted(self) -> None:
        """Take over coordinates that were fitted in the background, if they are ready."""
        if self._refitting is None or not self._refitting.done():
            return
        done, self._refitting = self._refitting, None
        if done.exception() is None:
            self._warm = done.result()

    def __repr__(self) -> str:
        return f"<Session of {self.scene.name!r}: {self.model}>"


@shown_in_notebooks
def session(
    scene: Scene | str | Path,
    *,
    model: str = AUTO,
    seed: int = 0,
    progress: Progress | None = None,
    priors: Priors | None = None,
    extra: Terms | None = None,
) -> Session:
    """A scene kept warm; arguments and errors as in `Session`.

    Examples:
        >>> import retrodict as rd
        >>> kept = rd.session("examples/brach-1977/scene.toml", model="planar-moment+spin")
        >>> before = kept.answer.summary().loc["speed_b", "mean"]
        >>> answer = kept.update({"vehicles.A.approach.speed": "50 ± 1 mph"})
        >>> bool(answer.summary().loc["speed_b", "mean"] > before)
        True
    """
    return Session(scene, model, seed, progress, priors, extra)


@shown_in_notebooks
def sweep(
    scene: Scene | str | Path,
    values: Mapping[str, Iterable[object]],
    *,
    model: str = AUTO,
    units: Units = "si",
    seed: int = 0,
    progress: Progress | None = None,
    priors: Priors | None = None,
    extra: Terms | None = None,
) -> pd.DataFrame:
    """Answers to variants of a scene: every combination of the values of some of its keys.

    Args:
        scene: scene with the measurements, or the path of a scene file.
        values: values to write in turn, by dotted key of the scene file.
        model: name of a rung, or "auto", as in `session`: one model for all variants.
        units: units of the table, "si" or "us".
        seed: integer seed of all random numbers.
        progress: progress callback, as in `reconstruct`.
        priors, extra: priors and likelihood terms of your own in every variant, as in `reconstruct`.

    Returns:
        One row a variant: the values of its keys, then mean, sd and limits of the central 95 % of each
        reported quantity, and in `checks` the verdict, or why there is no answer; such numbers are NaN.
        When interrupted, the variants that were done.

    Raises:
        SceneError: a variant cannot be used; no variant was begun.
        ValueError, Unanswerable: as in `session`.

    Examples:
        >>> import retrodict as rd
        >>> speeds = {"vehicles.A.approach.speed": ["40 ± 1 mph", "50 ± 1 mph"]}
        >>> scene = rd.load_scene("examples/brach-1977/scene.toml")
        >>> table = rd.sweep(scene, speeds, model="planar-moment+spin", units="us")
        >>> bool(table["speed_b_mean"].is_monotonic_increasing)
        True
    """
    import pandas as pd

    known = with_own(as_scene(scene), priors, extra)
    listed = {key: list(each) for key, each in values.items()}
    variants = [dict(zip(listed, each, strict=True)) for each in product(*listed.values())]
    scenes = [change(known, variant) for variant in variants]
    kept = Session(known, model, seed, progress)
    report = partial(prefixed(progress or silent, kept.model), "variants")
    rows: list[dict[str, Any]] = []
    try:
        for variant, each in zip(variants, scenes, strict=True):
            report(len(rows), len(variants))
            rows.append(variant | _row(kept, each, units))
    except KeyboardInterrupt:
        pass
    report(len(rows), len(variants))
    return pd.DataFrame(rows)


def _row(kept: Session, scene: Scene, units: Units) -> dict[str, Any]:
    try:
        answer = kept.update(scene)
    except Unanswerable as refusal:
        return {"checks": str(refusal)}
    row: dict[str, Any] = {}
    for name, found in answer.summary(units).iterrows():
        row |= {f"{name}_{key}": found[key] for key in ("mean", "sd", "low_95", "high_95")}
    checks = answer.checks
    return row | {"checks": "passed" if checks.passed else "; ".join(checks.reasons)}
