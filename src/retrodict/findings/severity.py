"""Delta-v and principal direction of force (PDOF) of each draw, in the vehicle's own axes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from retrodict.scene.records import VEHICLES

if TYPE_CHECKING:
    import xarray as xr

    from retrodict.scene.records import Scene


def pdof(posterior: xr.Dataset, scene: Scene) -> dict[str, xr.DataArray]:
    """Principal direction of force on each vehicle: `pdof_a` and `pdof_b`.

    Args:
        posterior: draws; those of a model without B's velocity give nothing.
        scene: what was measured.

    Returns:
        Clockwise from straight ahead, rad, as SAE J224 has it: 0 is a force from the front, pi/2 from
        the right. Draws lie within half a turn of their circular mean, which lies in (-pi, pi].
    """
    if not {"Vbx", "Vby", "vbx", "vby"} <= set(posterior.data_vars):
        return {}
    import xarray as xr  # slow to import

    # the force on B acts along its delta-v, and comes from the opposite direction: that on A
    towards_a = np.arctan2(posterior["vby"] - posterior["Vby"], posterior["vbx"] - posterior["Vbx"])
    found = {}
    for v, source in zip(VEHICLES, (towards_a + np.pi, towards_a), strict=True):
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
    at = (np.round(directions[np.isfinite(directions)] * 6 / np.pi) - 1) % 12 + 1
    hour, count = np.unique(at.astype(int), return_counts=True)
    return {int(hour[i]): float(count[i] / at.size) for i in np.argsort(-count, kind="stable")}
