"""What a part of the evidence still determines: the paper's scene with this and that not measured.

python3 -m uv run --group bench python -m benchmarks.subsets [part ...]

Each is reconstructed by the fullest model as a user does, stand-ins included; the table stands in
docs/evidence.md. With parts named: these alone, printed only.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks import page
from benchmarks.__main__ import DOCS
from benchmarks.inference.cost import SCENES
from benchmarks.machine import machine
from retrodict import load_scene, reconstruct
from retrodict.options import DEFAULT_RUNG
from retrodict.scene.records import Items, Mark, Measured, Scene, Wheels

# about what the posterior of the whole scene says of them, with errors as recorders have
_DELTA_V = {"a": Measured(13.3, 0.7), "b": Measured(13.9, 0.7)}  # m/s
_COURSE = Measured(np.radians(-11), np.radians(5))
_DRAGS = (0.9, 0.3, 0.2, 0.2)  # of the wheels of a car hit at its front left


def parts_of(whole: Scene) -> dict[str, Scene]:
    """A scene with less measured, or with something else in its place, by what is said of it."""
    rest = whole.rest
    a, b = ({v: rest[v]} for v in "ab")
    at = {v: replace(rest[v], heading=None, turns_known=False) for v in "ab"}
    b_bound = whole.approach | {"b": replace(whole.approach["b"], direction=_COURSE)}
    unknown = whole.approach | {"a": replace(whole.approach["a"], speed=None)}
    unread = {v: replace(rest[v], turns_known=False) for v in "ab"}

    def only(**evidence: object) -> Scene:
        return replace(whole, **({"rest": {}} | evidence))

    def change(v: str) -> dict[str, Items]:
        return {v: {"delta_v": _DELTA_V[v]}}

    def rolls(v: str) -> Scene:
        wheels = Wheels(*(Measured(d, 0.05, "logitnormal") for d in _DRAGS), Measured(0.0, 0.05))
        car = replace(whole.vehicles[v], wheels=wheels)
        return replace(whole, vehicles=whole.vehicles | {v: car})

    return {
        "all of the scene": whole,
        "and B's course to 5 deg": replace(whole, approach=b_bound),
        "and B's delta-v to 5 %": replace(whole, departure=change("b")),
        "without A's approach speed": replace(whole, approach=unknown),
        "without the numbers of turns": replace(whole, rest=unread),
        "both positions, no headings": only(rest=at),
        "A's rest, B's position": only(rest=a | {"b": at["b"]}),
        "B's rest, A's position": only(rest=b | {"a": at["a"]}),
        "A's rest": only(rest=a),
        "A's rest, B's course": only(rest=a, approach=b_bound),
        "A's rest, B's delta-v": only(rest=a, departure=change("b")),
        "A's rest, a point of B's path": only(
            rest=a, marks={"b": (Mark(4.0, -6.0, 0.3, "centre"),)}
        ),
        "B's rest": only(rest=b),
        "B's rest, B's course": only(rest=b, approach=b_bound),
        "B's rest, A's delta-v": only(rest=b, departure=change("a")),
        "both delta-v": only(departure=change("a") | change("b")),
        "B's delta-v": only(departure=change("b")),
        "all, but A's wheels rolled": rolls("a"),
        "all, but B's wheels rolled": rolls("b"),
    }


def rows(scenes: dict[str, Scene]) -> Iterator[list[str]]:
    """A row of the table for each, printed as it comes."""
    for name, scene in scenes.items():
        found = reconstruct(scene, model=DEFAULT_RUNG)
        speed = found.idata["posterior"]["speed_b"].to_numpy().ravel()
        low, high = np.quantile(speed, [0.05, 0.95])
        row = [
            name,
            f"{np.median(speed):.1f} ± {speed.std():.1f}",
            f"{low:.1f} to {high:.1f}",
            found.outcome.settings["method"],
            "passed" if found.checks.passed else "withheld",
            f"{found.outcome.seconds['total']:.0f}",
        ]
        print("  ".join(row), flush=True)
        yield row


def main(*named: str) -> None:
    """Reconstruct all and write the page, or those named alone."""
    scenes = parts_of(load_scene(SCENES["paper"]))
    found = list(rows({name: scenes[name] for name in named or scenes}))
    if not named:
        heading = ["measured", "B's speed, m/s", "from 5 to 95 %", "by", "checks", "seconds"]
        table = [*page.table(heading, found), "", f"Machine: {machine()}."]
        page.refresh(DOCS / "evidence.md", {"subsets": table})


if __name__ == "__main__":
    main(*sys.argv[1:])
