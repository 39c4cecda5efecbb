"""Reconstructs crashes whose truth is known: does the posterior cover it, and do the checks hold?

python3 -m uv run python -m benchmarks.synthetic [scenes] [first seed]

Geometry, coefficients and measurement errors are drawn at random; the scenes' structure is one, so
only the first compiles. Prints a row a scene and what all of them come to.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from retrodict.inference import Unanswerable
from retrodict.inference.reconstruct import reconstruct
from retrodict.options import RunOptions
from tests.shared.random_scenes import ASKED, scene


def main(count: int = 20, first: int = 0) -> None:
    """Print a row a scene, then coverage and failures."""
    inside: dict[str, list[bool]] = {name: [] for name in ASKED}
    withheld, seconds = [], []
    for seed in range(first, first + count):
        made, truth = scene(np.random.default_rng(seed))
        begin = time.perf_counter()
        try:
            found = reconstruct(made, RunOptions(seed=seed))
        except Unanswerable as refusal:
            withheld.append(seed)
            print(f"{seed:4d}  refused: {refusal}", flush=True)
            continue
        seconds.append(time.perf_counter() - begin)
        row = []
        for name in ASKED:
            low, middle, high = np.quantile(found.idata["posterior"][name], [0.05, 0.5, 0.95])
            if found.checks.passed:
                inside[name].append(bool(low <= truth[name] <= high))
            row.append(f"{name} {truth[name]:.2f} in [{low:.2f} {middle:.2f} {high:.2f}]")
        checks = found.checks
        print(
            f"{seed:4d}  {seconds[-1]:5.1f} s  {'passed' if checks.passed else 'FAILED'}"
            f"  div {checks.divergences} R-hat {checks.max_rhat:.3f} ESS {checks.min_ess_bulk:.0f}"
            f" {checks.min_ess_tail:.0f}  {'; '.join(row)}",
            *(f"      {line}" for line in (*found.notes, *checks.reasons)),
            sep="\n",
            flush=True,
        )
        if not checks.passed:
            withheld.append(seed)
    answered = len(inside["speed_b"])
    print(f"{answered} of {count} answered; withheld or refused: {withheld}")
    for name, hits in inside.items():
        print(f"{name:8s} true value inside the 90 % interval in {sum(hits)} of {answered}")
    print(f"seconds a scene: median {np.median(seconds):.1f}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
