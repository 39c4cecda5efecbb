"""Second contacts that one impact explains by a moment impulse: yaw rates without it, and the rule."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from retrodict.findings import suspected_contact as module
from retrodict.findings.run_outs import Motion
from retrodict.findings.second_contact import SecondContact
from retrodict.findings.sentences import simplifications
from retrodict.findings.suspected_contact import (
    SuspectedContact,
    _gained,
    _turned,
    suspected_contact,
)
from retrodict.mechanics import Bodies, Coefficients, impulse, lever_arms, separation
from tests.studies.gaussian import outcome as made_outcome

SHAPE = (2, 3)


def test_without_the_moment_impulse_the_force_alone_turns_the_vehicles() -> None:
    """Omega' - Omega is -M / I_a of A and M / I_b of B."""
    rng = np.random.default_rng(2)
    draws: dict[str, list[float]] = {}
    moments = []
    for _ in range(6):
        x = {"mass_b": 1400.0, "yaw_inertia_a": rng.uniform(2e3, 3e3), "yaw_inertia_b": 2350.0}
        for v in "ab":
            x |= {f"heading_{v}": rng.normal(), f"impact_angle_{v}": rng.normal()}
            x[f"impact_distance_{v}"] = rng.uniform(1, 2.5)
        levers = [
            x[f"impact_distance_{v}"] * np.array([np.cos(angle), np.sin(angle)])
            for v in "ab"
            for angle in [x[f"heading_{v}"] + x[f"impact_angle_{v}"]]
        ]
        bodies = Bodies(
            1600.0, 1400.0, x["yaw_inertia_a"], 2350.0, *lever_arms(*levers), rng.normal()
        )
        before = rng.normal(0, [8, 8, 1, 8, 8, 1])
        coefficients = Coefficients(0.1, 0.3, 0.4)
        after = np.asarray(separation(before, bodies, coefficients))
        moments.append(float(impulse(before, bodies, coefficients)[1]))
        x |= dict(zip(("omega_a", "vbx", "vby", "omega_b"), before[2:], strict=True))
        x |= dict(zip(("Omega_a", "Vbx", "Vby", "Omega_b"), after[2:], strict=True))
        for name, value in x.items():
            draws.setdefault(name, []).append(float(value))
    arrays = {name: np.reshape(each, SHAPE) for name, each in draws.items()}
    found = _gained(made_outcome(**arrays))
    M = np.reshape(moments, SHAPE)
    assert found["a"] == pytest.approx(-M / arrays["yaw_inertia_a"])
    assert found["b"] == pytest.approx(M / arrays["yaw_inertia_b"])


def test_a_motion_is_turned_on_at_the_yaw_rate_that_is_added() -> None:
    clock, pose = np.array([0.0, 2.0]), np.array([[0.0, 0, 0.1], [4.0, 2, 0.5]])
    speeds = dict.fromkeys("ab", 0.0)
    still = Motion(1, dict.fromkeys("ab", np.zeros(2)), speeds, dict.fromkeys("ab", clock),
                   dict.fromkeys("ab", pose))  # fmt: skip
    found = _turned(still, {"a": 0.0, "b": -3.0})
    assert found.pose_at("a", 0.5) == pytest.approx((1.0, 0.5, 0.2))
    assert found.pose_at("b", 0.5) == pytest.approx((1.0, 0.5, 0.2 - 1.5))


def test_where_e_m_is_near_one_nothing_is_suspected(outcome) -> None:
    tree = outcome.idata.copy()
    tree["posterior"] = tree["posterior"].to_dataset().assign(
        e_m=lambda known: 0 * known["e_m"] + 0.95
    )  # fmt: skip
    assert suspected_contact(replace(outcome, idata=tree), None) is None


def test_it_is_suspected_where_the_moment_impulse_alone_keeps_the_outlines_apart(
    outcome, monkeypatch
) -> None:
    """With e_m of 0.2 in all draws, unless nearly all motions touch again as they are."""
    tree = outcome.idata.copy()
    tree["posterior"] = tree["posterior"].to_dataset().assign(
        e_m=lambda known: 0 * known["e_m"] + 0.2
    )  # fmt: skip
    made = replace(outcome, idata=tree)
    monkeypatch.setattr(module, "place_of", lambda *_: (0, 0))  # motions are made up, not of draws
    monkeypatch.setattr(module, "touched_again", lambda *_: (0.3, 5.0, (0.0, 0.0)))
    found = suspected_contact(made, None)
    assert found is not None
    assert (found.share, found.small, found.after) == (1.0, 1.0, 0.3)
    said = SecondContact(0.9, 60, 0.3, 0.4, 5.0)
    assert suspected_contact(made, said) is None


def test_the_sentence_says_what_is_not_modelled() -> None:
    said = SuspectedContact(0.8, 0.95, 0.75, 0.31).sentence
    assert said.startswith("In 95% of the draws one impact explains what was measured by a moment")
    assert "80% of the motions, about 0.3 s after the impact" in said


def test_a_barrier_has_no_second_contact(outcome) -> None:
    alone = replace(outcome.scene, vehicles={"a": outcome.scene.vehicles["a"]})
    assert suspected_contact(replace(outcome, scene=alone), None) is None
    assert simplifications(outcome)
