"""What physics says: pure JAX functions and small records, usable alone; no probability, no files."""

import retrodict._precision  # noqa: F401
from retrodict.mechanics.impact import (
    Bodies,
    Capped,
    Coefficients,
    Undone,
    against_barrier,
    approach_and_coefficients,
    axes,
    capped,
    contact_velocity,
    critical_mu,
    impulse,
    inverse_log_det,
    lever_arms,
    printed_e_m,
    separation,
    undo,
)
from retrodict.mechanics.rigid_bodies import CentralImpact, central_impact
from retrodict.mechanics.runout import Car, Ground, Path, rest, run_out, step_error, wheel_paths
from retrodict.mechanics.severity import (
    Audit,
    Severity,
    audit,
    clock,
    feeding_term,
    gains_energy,
    pulls,
    reverses_sliding,
    severity,
)
from retrodict.mechanics.shooting import Departures, departures
from retrodict.mechanics.solve import NotDetermined, Solution, solve
from retrodict.mechanics.surface import Zone
from retrodict.mechanics.tyre import Wheels

__all__ = [
    "Audit",
    "Bodies",
    "Capped",
    "Car",
    "CentralImpact",
    "Coefficients",
    "Departures",
    "Ground",
    "NotDetermined",
    "Path",
    "Severity",
    "Solution",
    "Undone",
    "Wheels",
    "Zone",
    "against_barrier",
    "approach_and_coefficients",
    "audit",
    "axes",
    "capped",
    "central_impact",
    "clock",
    "contact_velocity",
    "critical_mu",
    "departures",
    "feeding_term",
    "gains_energy",
    "impulse",
    "inverse_log_det",
    "lever_arms",
    "printed_e_m",
    "pulls",
    "rest",
    "reverses_sliding",
    "run_out",
    "separation",
    "severity",
    "solve",
    "step_error",
    "undo",
    "wheel_paths",
]
