"""Times and distances of the vehicles before the impact, with their bands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from retrodict.report.figures import drawing
from retrodict.scene.quantities import Units, unit_of
from retrodict.studies.avoidability import TimeDistance

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome

CAPTION = (
    "Distance of each vehicle, along its path, from where it was at the impact: median of the draws "
    "and the band of 95 % of them. Speeds are constant but for a measured skid."
)


@drawing.styled
def timeline_figure(findings: Findings, outcome: Outcome, units: Units = "si") -> Figure:
    """Distance to the impact over the time before it."""
    figure = drawing.new_figure(6.4, 3.6)
    axes = figure.subplots()
    distances = next((q.numbers for q in findings.questions if q.kind == "time_distance"), None)
    if not isinstance(distances, TimeDistance):
        drawing.nothing_here(axes, "no times and distances were asked for")
        return figure
    unit = unit_of("length", units)
    before = -np.array(distances.times)
    for v in distances.distances:
        low, middle, high = np.array(distances.distances[v]).T / unit.worth
        colour = drawing.OF_VEHICLE[v]
        axes.fill_between(before, low, high, color=colour, alpha=0.2, linewidth=0)
        style = drawing.LINE_OF_VEHICLE[v]
        axes.plot(before, middle, color=colour, linestyle=style, label=f"vehicle {v.upper()}")
    axes.set_xlim(before[0], 0)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("time (s), 0 at the impact")
    axes.set_ylabel(f"distance to the impact ({unit.symbol})")
    axes.legend()
    return figure
