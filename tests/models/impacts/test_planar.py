"""The four variants of the planar impact: what each samples, and that its inverse finds it again."""

import jax
import numpy as np
import pytest
from numpyro import handlers
from retrodict.models import RUNGS, parts

from tests.shared.scenes import collision

VARIANTS = {
    "planar-common": (),
    "planar": ("mu",),
    "planar-moment-common": ("e_m",),
    "planar-moment": ("e_m", "mu"),
}


@pytest.mark.parametrize(
    ("name", "free"),
    [
        pytest.param(*each, marks=() if each[0] == "planar-moment" else pytest.mark.slow)
        for each in VARIANTS.items()
    ],
)
def test_a_variant_samples_what_is_free_and_its_inverse_finds_it(
    name: str, free: tuple[str, ...]
) -> None:
    rung = RUNGS[f"{name}+spin"]
    structure, data = rung.of_scene(collision(share=0.0, berm=False))
    x = parts.from_standard(structure, data, np.zeros(len(structure.uncertain)))
    model = handlers.trace(handlers.seed(rung.impact.forward_model, jax.random.key(0)))
    trace = model.get_trace(structure, data, x)
    samples = {k: s for k, s in trace.items() if s["type"] == "sample" and not s["is_observed"]}
    sampled = {k: float(s["value"]) for k, s in samples.items()}
    assert tuple(sampled) == ("speed_b", "direction_b", "omega_b", "e", *free)

    after = [trace[name]["value"] for vehicle in parts.AFTER for name in vehicle]
    found, _ = rung.impact.unknowns(np.stack(after), x)
    v_bx, v_by = found.pop("velocity_b")
    assert np.isclose(np.hypot(v_bx, v_by), sampled.pop("speed_b"))
    assert np.isclose(np.arctan2(v_by, v_bx), sampled.pop("direction_b"))
    np.testing.assert_allclose([*found.values()], [*sampled.values()], rtol=1e-8)
