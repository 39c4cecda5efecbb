"""Statements on the kinetic energy lost in the impact, as found from crush."""

from __future__ import annotations

# key of `[impact]` -> label; an item of evidence under the name "impact_" and the key
ENERGY: dict[str, str] = {
    "energy_lost": "kinetic energy lost in the impact, as stated",
    "energy_lost_at_least": "kinetic energy lost in the impact, stated as at least",
    "energy_lost_at_most": "kinetic energy lost in the impact, stated as at most",
}
# relative error, root mean square, of energies from crush and stiffness by class against the measured
# loss of nine staged crashes; 39 % in six of them (tests/scene/test_energy.py)
CLASS_STIFFNESS_ERROR = 0.38
