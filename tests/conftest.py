"""Settings that all tests share."""

from hypothesis import HealthCheck, settings

import retrodict._precision  # noqa: F401

# compilation falls into the first example, so no deadline on one
settings.register_profile(
    "retrodict", deadline=None, max_examples=300, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("retrodict")
