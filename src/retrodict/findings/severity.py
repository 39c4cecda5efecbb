"""Delta-v and principal direction of force (PDOF) of each draw, in the vehicle's own axes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

    from retrodict.scene.records import Measured, Scene


def pdof(posterior: xr.Dataset, scene: Scene) -> dict[str, xr.DataArray]:
    """Principal direction of force on each vehicle: `pdof_a`, and `pdof_b` where there is a B.

    Args:
        posterior: posterior draws; without the velocities at the impact the result is empty.
        scene: the measured scene.

    Returns:
        Clockwise from straight ahead, rad, as SAE J224 has it: 0 is a force from the front, pi/2 from
        the right. Draws lie within half a turn of their circular mean, which lies in (-pi, pi].
    """
    import xarray as xr  # slow to import

    def drawn(name: str, measured: Measured | None) -> xr.DataArray:
        """Draws of a velocity of A before the impact, or what it is known to be."""
        known = xr.DataArray(measured.value if measured else np.nan)
        return posterior.data_vars.get(name, known)

    if scene.alone:
        return {}
    if scene.barrier and {"Vax", "Vay"} <= set(posterior.data_vars):
        speed = drawn("speed_a", scene.approach["a"].speed)
        course = drawn("direction_a", scene.approach["a"].direction)
        # the force acts along delta-v, and comes from the opposite direction
        y, x = speed * np.sin(course) - posterior["Vay"], speed * np.cos(course) - posterior["Vax"]
        sources = [np.arctan2(y, x)]
    elif {"Vbx", "Vby", "vbx", "vby"} <= set(posterior.data_vars):
        # the force on B comes from the opposite direction to that on A
        y, x = posterior["vby"] - posterior["Vby"], posterior["vbx"] - posterior["Vbx"]
        sources = [np.arctan2(y, x) + np.pi, np.arctan2(y, x)]
    else:
        return {}
    found = {}
    for v, source in zip(scene.vehicles, sources, strict=True):
        heading = xr.DataArray(scene.vehicles[v].heading.value)
        angle = posterior.data_vars.get(f"heading_{v}", heading) - source
        mean = float(np.angle(np.exp(1j * angle).mean()))
        found[f"pdof_{v}"] = mean + (angle - mean + np.pi) % (2 * np.pi) - np.pi
    return found


def hours(directions: np.ndarray) -> dict[int, float]:
    """Share of the draws at each hour of a clock laid on the vehicle, 12 straight ahead.

    Args:
        directions: PDOF, any shape, rad.

    Returns:
        Shares by hour, 1 to 12, the largest first; without hours that no draw has.
    """
    nearest = (np.round(directions[np.isfinite(directions)] * 6 / np.pi) - 1) % 12 + 1
    hour, count = np.unique(nearest.astype(int), return_counts=True)
    return {int(hour[i]): float(count[i] / nearest.size) for i in np.argsort(-count, kind="stable")}
