"""Where nobody wrote B's direction of travel: is its speed right if it kept its heading, or slid?

python3 -m uv run --group bench python -m benchmarks.directions

Crashes at random, of which nothing is known of how B came: its direction is then assumed along its
heading, and its yaw rate zero, each with the default error. In half of them that is true, within 2 deg.
In the other half B slid, by 20 to 160 deg, to either side. Prints in how many the 90 % interval of B's
speed holds the truth, how many answers are withheld, and in how many it is said that the model does not
explain the measurements together.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from retrodict.inference.errors import Unanswerable
from retrodict.inference.misfit import UNEXPLAINED, UNSUPPORTED
from retrodict.inference.reconstruct import reconstruct
from retrodict.options import RunOptions
from retrodict.scene.build_motion import along, without_yaw
from retrodict.scene.records import Approach
from tests.shared import random_scenes

CRASHES = 50
_FIRST = 4000  # seed


def kept(rng: np.random.Generator) -> float:
    """How far off its heading a vehicle travels that kept it, rad."""
    return float(np.radians(rng.normal(0, 2)))


def slid(rng: np.random.Generator) -> float:
    """How far off one travels that slid, rad."""
    return float(np.radians(rng.uniform(20, 160)) * rng.choice([-1, 1]))


def answered(seed: int, slip: float) -> str:
    """What comes of a crash in which B travelled so far off its heading."""
    scene, truth = random_scenes.scene(np.random.default_rng(seed), off=slip)
    own = Approach(None, along(scene.vehicles["b"].heading), without_yaw())
    scene = replace(scene, approach=scene.approach | {"b": own})
    try:
        outcome = reconstruct(scene, RunOptions(method="importance", seed=seed), pictured=False)
    except Unanswerable:
        return "withheld"
    if not outcome.checks.passed:
        return "withheld"
    draws = outcome.idata["posterior"]["speed_b"].values
    low, high = np.quantile(draws, [0.05, 0.95])
    found = "holds" if low <= truth["speed_b"] <= high else "misses"
    flagged = any(UNEXPLAINED in flag or UNSUPPORTED in flag for flag in outcome.checks.flags)
    return f"{found}, flagged" if flagged else found


def main() -> None:
    """Reconstruct all, and print the counts."""
    for name, slip in (("kept its heading", kept), ("slid", slid)):
        chance = np.random.default_rng(_FIRST)
        found = Counter(answered(_FIRST + i, slip(chance)) for i in range(CRASHES))
        print(f"B {name}: {dict(sorted(found.items()))} of {CRASHES}", flush=True)


if __name__ == "__main__":
    main()
