"""What would narrow an answer: its standard deviation if one more quantity were known exactly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retrodict.inference.pointwise import by_item
from retrodict.scene.quantities import describe
from retrodict.scene.records import FREEDOM, VEHICLES

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Measured

# what of the motion recorders, marks and witnesses could provide, where a model has it
_OF_MOTION = (
    *("speed_a", "speed_b", "direction_b", "omega_b"),
    *(f"departure_{part}_{v}" for v in VEHICLES for part in ("direction", "speed")),
    *(f"{name}_{v}" for v in VEHICLES for name in ("Omega", "delta_v")),
)
_AS_EVIDENCE = {
    f"{kind}_{v}": f"{measured}_{v}"
    for v in VEHICLES
    for kind, measured in (("Omega", "departure_yaw_rate"), ("delta_v", "departure_delta_v"))
}


@dataclass(frozen=True, slots=True)
class Narrowed:
    """An answer, were one more quantity known exactly (SI units).

    Args:
        name: flat name of the quantity.
        measured: measured value and its sd; None where the quantity was not measured.
        sd: standard deviation of the answer if the quantity were known exactly.
    """

    name: str
    measured: Measured | None
    sd: float


def narrowing(outcome: Outcome, sought: str) -> tuple[Narrowed, ...]:
    """How sure an answer would be, were each quantity in turn known exactly.

    To first order: of the answer's variance stays what a straight line through the draws, answer
    against quantity, leaves. The effect of two quantities together is not computed.

    Args:
        outcome: the reconstruction.
        sought: the answer's flat name.

    Returns:
        One record a quantity, the one that narrows the most first: uncertain inputs, evidence, and
        what of the motion could have been measured; none of draws without predictions.

    Source:
        Conditional variance of a joint normal distribution; for its use as a first-order index of
        sensitivity, Saltelli et al., Global Sensitivity Analysis (2008), 1.2.
    """
    tree, scene = outcome.idata, outcome.scene
    predictive = by_item(tree, "posterior_predictive")
    if "posterior" not in tree.children or not predictive.data_vars:
        return ()
    quantities = {str(name): np.asarray(draws).ravel() for name, draws in tree["posterior"].items()}
    for v in VEHICLES:
        if f"V{v}x" not in quantities:
            continue
        along, across = quantities[f"V{v}x"], quantities[f"V{v}y"]
        quantities[f"departure_speed_{v}"] = np.hypot(along, across)
        quantities[f"departure_direction_{v}"] = np.arctan2(across, along)
    answer = quantities[sought]

    def left(x: np.ndarray, error: float = 0.0) -> float | None:
        """Sd of the answer that knowing x, of which draws may have an error on them, would leave."""
        (of_x, shared), (_, of_answer) = np.cov(x, answer)
        of_x -= error**2
        if of_x <= 0:
            return None
        return float(np.sqrt(of_answer * max(0.0, 1 - shared**2 / (of_x * of_answer))))

    inputs, evidence = scene.inputs(), scene.evidence()
    found: dict[str, tuple[Measured | None, float | None]] = {}
    for name in (*inputs, *_OF_MOTION):
        if name not in quantities or name == sought:
            continue
        x = quantities[name]
        if describe(name)[1] == "angle":  # about its middle, for it may pass half a turn
            x = np.angle(np.exp(1j * x) / np.exp(1j * x).mean())
        as_evidence = _AS_EVIDENCE.get(name, name)
        found[name] = inputs.get(name) or evidence.pop(as_evidence, None), left(x)
    noise = np.sqrt(FREEDOM / (FREEDOM - 2)) if scene.robust else 1.0
    for name, m in evidence.items():  # what is left of it
        if name in predictive:
            predicted = np.asarray(predictive[name]).ravel()
            found[name] = m, left(predicted, noise * m.sd)
    narrowed = (Narrowed(name, m, sd) for name, (m, sd) in found.items() if sd is not None)
    return tuple(sorted(narrowed, key=lambda each: each.sd))
