"""Settings that all tests share."""

from hypothesis import HealthCheck, settings

import retrodict._precision  # noqa: F401

# a hundred examples of a law by default, a thousand with `--hypothesis-profile thorough`;
# compilation falls into the first example, so no deadline on one
for name, examples in (("retrodict", 100), ("thorough", 1000)):
    settings.register_profile(
        name,
        deadline=None,
        max_examples=examples,
        suppress_health_check=[HealthCheck.too_slow],
    )
settings.load_profile("retrodict")
