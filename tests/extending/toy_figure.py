"""A toy figure: how many quantities are reported."""

from matplotlib.figure import Figure

from retrodict.findings import Findings
from retrodict.inference.outcome import Outcome
from retrodict.report.figures import drawing
from retrodict.scene.quantities import Units

CAPTION = "A bar as long as the list of quantities."


@drawing.styled
def toy_figure(findings: Findings, outcome: Outcome, units: Units = "si") -> Figure:
    """One bar."""
    figure = drawing.new_figure(3, 1)
    figure.subplots().barh(["quantities"], [len(findings.quantities)])
    return figure
