"""Do all methods reach the far end of a long tail? Prints means, sds and limits beside a reference.

python3 -m uv run python -m benchmarks.tails [scene.toml ...]

The reference has no coordinates and no proposal: ten million crashes of the prior, weighted by the
likelihood. By default two cars against a barrier are taken whose recorders were read, and no rest pose.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from benchmarks.__main__ import DOCS
from retrodict.api import reconstruct
from retrodict.inference.fitting.about_peak import crashes_of
from retrodict.inference.samplers.psis import effective
from retrodict.live import session
from retrodict.scene.load import load_scene

MODEL = "planar-moment+spin"
CASES = DOCS.parent / "benchmarks" / "staged" / "cases"
SCENES = [str(CASES / name / "scene.toml") for name in ("iihs-cf10001", "iihs-cf11002")]
LIMITS = (0.025, 0.5, 0.975)
CRASHES, AT_ONCE = 10_000_000, 100_000
FAR = 60.0  # below the highest log likelihood: counts for nothing
METHODS = ("importance", "smc", "nuts")


def main(scenes: list[str]) -> None:
    """Print a row for the reference, each method and a session."""
    for path in scenes:
        scene = load_scene(path)
        speed = scene.question[0]
        print(Path(path).parent.name, speed, "m/s")
        crashes, rng = crashes_of(scene, MODEL), np.random.default_rng(1)
        parts = []
        for _ in range(CRASHES // AT_ONCE):
            height, quantities = crashes.at(rng.standard_normal((AT_ONCE, crashes.size)))
            near = height > height.max() - FAR
            parts.append((height[near], quantities[speed][near]))
        heights, values = (np.concatenate(own) for own in zip(*parts, strict=True))
        weights = np.exp(heights - heights.max())
        weights /= weights.sum()
        _print("prior", values, weights)
        for method in METHODS:
            found = reconstruct(scene, model=MODEL, method=method)
            draws = found.idata["posterior"][speed].to_numpy().ravel()
            said = f"{method}, {'passed' if found.checks.passed else 'withheld'}"
            if found.outcome.settings["method"] != method:
                said += " by another"
            _print(said, draws)
        answer = session(scene, model=MODEL).answer
        _print(f"session, {'passed' if answer.checks.passed else 'withheld'}", answer.draws[speed])


def _print(name: str, values: np.ndarray, weights: np.ndarray | None = None) -> None:
    """Print mean, sd and limits of weighted values."""
    values = np.ravel(values)
    weights = np.full(values.size, 1 / values.size) if weights is None else weights
    mean = weights @ values
    sd = np.sqrt(weights @ (values - mean) ** 2)
    limits = np.quantile(values, LIMITS, weights=weights, method="inverted_cdf")
    numbers = " ".join(f"{number:8.2f}" for number in (mean, sd, *limits))
    print(f"  {name:36} {numbers}  ({effective(weights):.0f} effective)")


if __name__ == "__main__":
    print("  mean, sd, limits at", *LIMITS)
    main(sys.argv[1:] or SCENES)
