"""Outcome of a reconstruction: draws, checks and the record of how they were made."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from retrodict.options import RunOptions
from retrodict.scene.records import Scene

if TYPE_CHECKING:
    import xarray as xr

    from retrodict.models.description import Description


__all__ = ["Checks", "Mode", "Outcome", "attributes_of"]


@dataclass(frozen=True, slots=True)
class Checks:
    """The verdict on the draws' numerical quality.

    Args:
        divergences: number of divergent transitions after warm-up; None for a method without any.
        pareto_k: Pareto k of the importance weights; None for a method without any.
        max_rhat: largest R-hat of a reported quantity.
        min_ess_bulk: smallest bulk effective sample size of a reported quantity.
        min_ess_tail: smallest tail effective sample size of a reported quantity.
        passed: whether every check held.
        reasons: sentences, one for each check that failed.
        failed: reported quantities that failed a check of their own.
        flags: findings about the scene (energy gained, reversed sliding, a surprising item of
            evidence), which do not fail the draws.
        imprecise: reported quantities whose draws do not support one whole digit of the standard
            deviation: more draws would allow more digits.
    """

    divergences: int | None
    max_rhat: float
    min_ess_bulk: float
    min_ess_tail: float
    passed: bool
    reasons: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()
    pareto_k: float | None = None
    imprecise: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Mode:
    """A solution that the draws were mixed from.

    Args:
        weight: share of the posterior, from 0 to 1.
        error: standard error of the weight; NaN for a weight by the Laplace approximation.
        values: the reported quantities at its mode, SI units and radians.
        turns: whole turns added to the rest heading of each vehicle of unknown rotation.
    """

    weight: float
    error: float
    values: dict[str, float]
    turns: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """All that findings are computed from: plain data, which can be pickled.

    Args:
        scene: scene that was reconstructed, with the whole turns of the first of `modes`.
        description: the model, in words.
        idata: groups posterior, prior, posterior_predictive, prior_predictive, log_likelihood,
            log_prior, sample_stats, observed_data, constant_data and trajectories; each variable has
            attributes `unit` (SI) and `label`. The evidence is one variable of all items, as of
            `inference.pointwise.pointwise`. Draws of no posterior have no log_likelihood and log_prior;
            a quick run has no log_prior, prior and trajectories. trajectories/path has dimensions
            (run, vehicle, step, pose), pose = x, y, heading: run-outs of posterior draws; `time` (s
            after the impact) and `before` (velocity before it, axis = x, y) are of the same draws.
            Its own attributes are those of `attributes_of`.
        checks: the verdict on the draws.
        seconds: durations by name: total, compile and sample, s.
        versions: versions of retrodict, Python and the libraries that made the numbers, by name.
        seed: integer seed of all random numbers.
        settings: settings by name: method, chains, draws, warmup.
        asked: options as the user gave them, by which the run can be repeated.
        complete: False when the run was interrupted.
        notes: remedies that the run applied by itself, and other remarks on it, in words.
        unfinished: content of the file that an interrupted run goes on from; None where there is none.
        modes: the solutions found, the first of them that of `scene`; where the draws are of several,
            `mode` in sample_stats is the index of each draw's.
    """

    scene: Scene
    description: Description
    idata: xr.DataTree
    checks: Checks
    seconds: dict[str, float]
    versions: dict[str, str]
    seed: int
    settings: dict[str, int | str]
    asked: RunOptions = field(default_factory=RunOptions)
    complete: bool = True
    notes: tuple[str, ...] = field(default=())
    unfinished: bytes | None = field(default=None, repr=False)
    modes: tuple[Mode, ...] = ()

    def __repr__(self) -> str:
        verdict = "passed" if self.checks.passed else "FAILED"
        groups = ", ".join(self.idata.children)
        return (
            f"<Outcome of {self.scene.name!r}: {self.description.name}, seed {self.seed}, checks "
            f"{verdict}; groups {groups}>"
        )


def attributes_of(outcome: Outcome) -> dict[str, str | int]:
    """Attributes for the DataTree of the draws: their scene, and how they were made.

    Args:
        outcome: the reconstruction.

    Returns:
        Texts and whole numbers, which netCDF keeps: scene, its SHA-256 (of the scene file's text),
        model, method, seed, chains, draws and warmup, versions as JSON, and whether the run was
        complete (1) or interrupted (0).
    """
    from retrodict.scene.write import scene_text  # which brings the schema

    versions = outcome.versions
    return {
        "creation_library": "retrodict",  # ArviZ's names
        "creation_library_version": versions.get("retrodict", ""),
        "scene": outcome.scene.name,
        "scene_sha256": scene_text(outcome.scene).sha256,
        "model": outcome.description.name,
        **outcome.settings,
        "seed": int(outcome.seed),
        "complete": int(outcome.complete),
        "versions": json.dumps(versions, ensure_ascii=False),
    }
