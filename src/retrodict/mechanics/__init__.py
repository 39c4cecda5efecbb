"""What physics says: pure JAX functions and small records, usable alone; no probability, no files."""

import retrodict._precision  # noqa: F401
from retrodict.mechanics.impact import (
    Audit,
    Bodies,
    Coefficients,
    approach_and_coefficients,
    audit,
    contact_velocity,
    critical_mu,
    impulse,
    inverse_log_det,
    lever_arms,
    separation,
)
from retrodict.mechanics.runout import Car, Ground, Path, rest, run_out
from retrodict.mechanics.surface import Zone

__all__ = [
    "Audit",
    "Bodies",
    "Car",
    "Coefficients",
    "Ground",
    "Path",
    "Zone",
    "approach_and_coefficients",
    "audit",
    "contact_velocity",
    "critical_mu",
    "impulse",
    "inverse_log_det",
    "lever_arms",
    "rest",
    "run_out",
    "separation",
]
