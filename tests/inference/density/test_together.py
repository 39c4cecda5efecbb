"""Crashes of many scenes that one call answers are those of each scene alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from threading import Barrier

import numpy as np
import pytest
from retrodict.models import standard_normal

from retrodict.inference.density.together import Calls, Together, room
from retrodict.inference.fitting.about_peak import crashes_of
from retrodict.inference.fitting.deviates import Crashes
from retrodict.scene.records import Scene
from tests.shared.random_scenes import scene

CALLS = partial(Calls, 128, 64)
QUICK = "momentum+slide"  # to compile, where any rung would do


def crashes(seed: int, rung: str = "planar-moment+spin") -> Crashes:
    return crashes_of(scene(np.random.default_rng(seed))[0], rung)


def asked(own: Crashes, count: int) -> np.ndarray:
    return np.random.default_rng(count).standard_normal((count, own.size))


@pytest.mark.slow
def test_every_scene_is_answered_as_if_it_were_alone() -> None:
    """Scenes of two structures, one in more integration steps; more rows than a call takes."""
    every = [crashes(0), crashes(1), crashes(2).in_steps(24), crashes(0, "momentum+spin")]
    counts = [100, 1, 300, 17]
    calls = CALLS()
    jobs = [partial(own.at, asked(own, count)) for own, count in zip(every, counts, strict=True)]
    found = Together(calls).results(jobs)
    for own, count, (heights, quantities) in zip(every, counts, found, strict=True):
        alone, alone_quantities = own.at(asked(own, count))
        np.testing.assert_allclose(heights, alone, rtol=1e-9)
        assert quantities.keys() == alone_quantities.keys()
        for name, values in alone_quantities.items():
            assert quantities[name].shape == values.shape, name
            np.testing.assert_allclose(quantities[name], values, rtol=1e-7, atol=1e-9, err_msg=name)
    assert calls.crashes[0] == sum(counts)


def test_requests_that_wait_share_a_call() -> None:
    every = [crashes(seed, QUICK) for seed in range(8)]
    barrier, calls = Barrier(len(every)), CALLS()

    def job(own: Crashes) -> None:
        barrier.wait()
        for _ in range(4):
            own.at(asked(own, 8))

    Together(calls).results([partial(job, own) for own in every])
    assert calls.crashes[0] == 8 * 8 * 4
    assert 4 <= calls.made[0] <= 16  # half of the scenes at a time; alone it would be 32


def test_an_error_of_one_scene_is_raised_and_the_others_come_to_their_ends() -> None:
    own, ended = crashes(0, QUICK), []

    def fails() -> None:
        raise ArithmeticError("no")

    def works() -> None:
        own.at(asked(own, 8))
        ended.append(True)

    with pytest.raises(ArithmeticError):
        Together(CALLS()).results([fails, works])
    assert ended == [True]
    assert room() is None


def test_a_call_that_fails_fails_those_who_wait_for_it() -> None:
    good, bad = crashes(0, QUICK), crashes(1, QUICK)
    bad = replace(bad, data=bad.data._replace(evidence={}))

    def caught(own: Crashes) -> str:
        try:
            own.at(asked(own, 8))
        except Exception as error:
            return type(error).__name__
        return "answered"

    jobs: list[Callable[[], str]] = [partial(caught, bad)]
    assert Together(CALLS()).results(jobs) == ["TypeError"]
    assert Together(CALLS()).results([partial(caught, good)]) == ["answered"]


@pytest.mark.slow
def test_models_are_traced_by_one_thread_at_a_time() -> None:
    """NumPyro has one stack of handlers for all threads of a process."""
    scenes = [scene(np.random.default_rng(seed))[0] for seed in range(6)]
    rungs = ["planar-moment+spin", "momentum+spin", "planar+spin"] * 2
    barrier = Barrier(len(scenes))

    def job(own: Scene, rung: str) -> int:
        barrier.wait()
        return crashes_of(own, rung).size

    for _ in range(5):
        standard_normal._sizes.cache_clear()
        jobs = [partial(job, own, rung) for own, rung in zip(scenes, rungs, strict=True)]
        found = Together(CALLS()).results(jobs)
        assert found[:3] == found[3:]
