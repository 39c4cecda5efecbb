"""Mechanics: pure JAX functions and small records, usable alone; no probability, no files."""

import retrodict._precision  # noqa: F401
from retrodict.mechanics.contact import (
    Bodies,
    against_barrier,
    axes,
    closing_speed,
    contact_velocity,
    either_side,
    lever_arms,
    towards_b,
)
from retrodict.mechanics.end_of_rotation import end_of_rotation
from retrodict.mechanics.impact import (
    Capped,
    Coefficients,
    Undone,
    approach_and_coefficients,
    capped,
    critical_mu,
    friction_impulse,
    impulse,
    inverse_log_det,
    normal_impulse,
    printed_e_m,
    restitution,
    separation,
    undo,
)
from retrodict.mechanics.motion import Car, Ground, Incline
from retrodict.mechanics.rigid_bodies import CentralImpact, central_impact
from retrodict.mechanics.rollout import Way, drag_factor, rolled, rolled_back, way_taken
from retrodict.mechanics.runout import Path, rest, run_out, step_error, wheel_paths
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
    "Incline",
    "NotDetermined",
    "Path",
    "Severity",
    "Solution",
    "Undone",
    "Way",
    "Wheels",
    "Zone",
    "against_barrier",
    "approach_and_coefficients",
    "audit",
    "axes",
    "capped",
    "central_impact",
    "clock",
    "closing_speed",
    "contact_velocity",
    "critical_mu",
    "departures",
    "drag_factor",
    "either_side",
    "end_of_rotation",
    "feeding_term",
    "friction_impulse",
    "gains_energy",
    "impulse",
    "inverse_log_det",
    "lever_arms",
    "normal_impulse",
    "printed_e_m",
    "pulls",
    "rest",
    "restitution",
    "reverses_sliding",
    "rolled",
    "rolled_back",
    "run_out",
    "separation",
    "severity",
    "solve",
    "step_error",
    "towards_b",
    "undo",
    "way_taken",
    "wheel_paths",
]
