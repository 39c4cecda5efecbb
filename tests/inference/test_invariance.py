"""How a crash is written down says nothing of it: the posterior is the same in any frame and order."""

import math
import re
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

from retrodict.inference.outcome import Outcome
from retrodict.inference.reconstruct import reconstruct
from retrodict.options import DEFAULT_RUNG, RunOptions
from retrodict.scene.load import load_scene, parse_scene
from retrodict.scene.records import Scene
from tests.shared.symmetry import exchanged, mirrored, shifted, turned

FOLDER = Path(__file__).parents[2] / "benchmarks" / "users" / "scenes"
SCENES = ("corner", "slow-side-22", "rear-end-delta-v")  # ordinary, slow, delta-v only
ROUND = {"m": (0.3048, "ft"), "m/s": (0.44704, "mph"), "kg": (0.45359237, "lb")}


def scene(name: str) -> Scene:
    """The scene, as somebody wrote it."""
    return load_scene(FOLDER / f"{name}.toml")


@cache
def usual(name: str) -> Outcome:
    return drawn(scene(name))


def drawn(scene: Scene) -> Outcome:
    found = reconstruct(scene, RunOptions(DEFAULT_RUNG, "importance", draws=2000), pictured=False)
    assert found.checks.passed, found.checks.reasons
    return found


def compare(one: Outcome, other: Outcome, names: dict[str, tuple[str, int]]) -> None:
    """Means within four standard errors of both, spreads within a tenth."""
    for name, (there, sign) in names.items():
        own = np.asarray(one.idata["posterior"][name]).ravel()
        its = sign * np.asarray(other.idata["posterior"][there]).ravel()
        worth = one.checks.min_ess_bulk, other.checks.min_ess_bulk
        error = math.hypot(own.std() / worth[0] ** 0.5, its.std() / worth[1] ** 0.5)
        assert abs(own.mean() - its.mean()) < 4 * error, name
        assert own.std() == pytest.approx(its.std(), rel=0.1), name


SAME = {name: (name, 1) for name in ("speed_b", "e", "e_m", "mu", "omega_b", "Omega_a")}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(
    "moved", [partial(turned, angle=math.radians(37)), partial(shifted, x=500.0, y=-300.0)]
)
def test_a_crash_is_the_same_in_another_frame(name: str, moved) -> None:
    compare(usual(name), drawn(moved(scene(name))), SAME)


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_a_crash_in_a_mirror_turns_and_slides_the_other_way(name: str) -> None:
    opposite = {key: (key, -1) for key in ("mu", "omega_b", "Omega_a")}
    compare(usual(name), drawn(mirrored(scene(name))), SAME | opposite)


# B may have slid any way in the last one
@pytest.mark.slow
@pytest.mark.parametrize("name", [*SCENES, "slow-side-24"])
def test_the_letters_of_the_vehicles_mean_nothing(name: str) -> None:
    other = {"speed_b": "speed_a", "omega_b": "omega_a", "Omega_a": "Omega_b"}
    names = {key: (other.get(key, key), 1) for key in SAME}
    compare(usual(name), drawn(exchanged(scene(name))), names)


@pytest.mark.parametrize("name", SCENES)
def test_units_and_order_of_the_file_mean_nothing(name: str) -> None:
    """The records are the same, and with them the posterior."""
    text = (FOLDER / f"{name}.toml").read_text(encoding="utf-8")
    read = parse_scene(text, name)
    number = r"(-?\d+(?:\.\d+)?)"

    def other(match: re.Match[str]) -> str:
        factor, unit = ROUND[match[3]]
        value = repr(float(match[1]) / factor)
        error = f" ± {float(match[2]) / factor!r}" if match[2] else ""
        return f'"{value}{error} {unit}"'

    converted = re.sub(rf'"{number}(?: ± {number})? (m/s|m|kg)"', other, text)
    assert converted != text
    _same(read, parse_scene(converted, name))
    backwards = replace(
        read,
        rest=dict(reversed(read.rest.items())),
        departure={v: dict(reversed(m.items())) for v, m in reversed(read.departure.items())},
    )
    assert list(backwards.evidence().items()) == list(read.evidence().items())


def _same(one: Scene, other: Scene) -> None:
    for own, its in ((one.inputs(), other.inputs()), (one.evidence(), other.evidence())):
        assert own.keys() == its.keys()
        for name, measured in own.items():
            numbers = (measured.value, measured.sd)
            assert (its[name].value, its[name].sd) == pytest.approx(numbers, abs=1e-9), name
    for name, prior in one.priors.items():
        assert other.priors[name].numbers == pytest.approx(prior.numbers)
