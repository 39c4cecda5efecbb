"""The study of the ladder: which of its crashes no rule can distinguish."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks import ladder


@pytest.mark.slow
@pytest.mark.parametrize("rungs", ladder.ALIKE)
def test_momentum_alone_and_the_simplest_planar_impact_make_the_same_crashes(
    rungs: tuple[str, str],
) -> None:
    (one, speed), (other, same_speed) = (
        ladder.crash(rung, np.random.default_rng(3)) for rung in rungs
    )
    assert speed == same_speed
    assert one.inputs() == other.inputs()
    evidence, same = (scene.evidence() for scene in (one, other))
    assert list(evidence) == list(same)
    for name, item in evidence.items():
        assert_allclose(item.value, same[name].value, atol=1e-9)
        assert item.sd == same[name].sd
