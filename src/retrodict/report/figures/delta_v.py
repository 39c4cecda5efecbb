"""Delta-v and principal direction of force of each vehicle, with their clouds of draws."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import MaxNLocator

from retrodict.findings.statistics import posterior_of
from retrodict.report.figures import drawing
from retrodict.report.results import marked, result_rows
from retrodict.scene.quantities import Unit, Units, unit_of
from retrodict.scene.records import Items, Measured

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome

CAPTION = (
    "The change of velocity (delta-v) and the principal direction of force (PDOF) of each vehicle, in "
    "its own axes, seen from above, its front up. Upper row: delta-v of posterior draws (dots; "
    "thinned) from the origin (+), and the smallest regions that hold 50 % (solid line) and 90 % "
    "(dashed line) of them; hatched: what was measured, within two standard deviations. Lower row: "
    "the same draws on a clock laid on the vehicle, at the direction that the force came from (12 is "
    "straight ahead, 3 the right) and at their delta-v from the centre; the arrow shows the mean "
    "direction of force. Below: the share of the draws at each hour."
)
_DOTS, _MOST_HOURS, _LEAST_SHARE = 400, 3, 0.005


@drawing.styled
def delta_v_figure(findings: Findings, outcome: Outcome, units: Units = "si") -> Figure:
    """Delta-v in each vehicle's axes, and the clock of its force."""
    unit = unit_of("speed", units)
    figure = drawing.new_figure(7.2, 7.4)
    upper, lower = figure.subfigures(2, 1, squeeze=False, height_ratios=(1, 1.05))[:, 0]
    vehicles = findings.scene.vehicles
    grid: dict[str, Any] = {"ncols": len(vehicles), "squeeze": False}
    plane = upper.subplots(**grid)[0]
    clocks = lower.subplots(**grid, subplot_kw={"projection": "polar"})[0]
    posterior, boxes, measured = posterior_of(outcome), {}, False
    for v, axes, clock in zip(vehicles, plane, clocks, strict=True):
        if not {f"pdof_{v}", f"delta_v_{v}"} <= set(posterior.data_vars):
            for empty in (axes, clock):
                drawing.nothing_here(empty, f"no draws of the delta-v of {v.upper()}")
            continue
        pdof, size = (posterior[f"{name}_{v}"].values.ravel() for name in ("pdof", "delta_v"))
        finite = np.isfinite(pdof) & np.isfinite(size)
        pdof, size = pdof[finite], size[finite] / unit.worth
        axes.set_title(f"{v.upper()}: {_in_words(findings, f'delta_v_{v}', units)}")
        # the force comes from `pdof`, so delta-v points the other way
        across, along = -size * np.sin(pdof), -size * np.cos(pdof)
        drawing.cloud(axes, across, along, drawing.OF_VEHICLE[v])
        axes.plot([0, across.mean()], [0, along.mean()], color=drawing.INK, lw=0.8, zorder=1)
        boxes[v] = np.array([[min(each.min(), 0), max(each.max(), 0)] for each in (across, along)])
        departure = findings.scene.departure.get(v, {})
        measured |= _measured(axes, departure, unit)
        _clock(clock, findings, v, pdof, size, units)
    side = 1.2 * max((np.ptp(box, axis=1).max() for box in boxes.values()), default=1.0)
    for v, axes in zip(vehicles, plane, strict=True):
        if v in boxes:
            _frame(axes, boxes[v].mean(axis=1), side, unit)
    handles: list[Any] = [
        Line2D([], [], ls="", marker=".", color=drawing.GREY, label="draws"),
        Line2D([], [], color=drawing.INK, lw=1.6, label="50 % of the draws"),
        Line2D([], [], color=drawing.INK, lw=1.2, ls="--", label="90 % of the draws"),
    ]
    if measured:
        handles.append(Patch(label="measured ± 2 sd", **_MEASURED))
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


_MEASURED: dict[str, Any] = {"fc": "none", "ec": drawing.GREY, "hatch": "////", "lw": 0.8}


def _in_words(findings: Findings, name: str, units: Units) -> str:
    (row,) = result_rows(findings, units, [findings.derived[name]])
    return f"{'PDOF' if 'pdof' in name else 'delta-v'} {row.mean} {row.unit}"


def _frame(axes: Axes, middle: np.ndarray, side: float, unit: Unit) -> None:
    """A square that holds the origin and the draws, as large for each vehicle."""
    axes.set_aspect("equal")
    axes.set_xlim(middle[0] - side / 2, middle[0] + side / 2)
    axes.set_ylim(middle[1] - side / 2, middle[1] + side / 2)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=drawing.STEPS))
    axes.plot(0, 0, "+", color=drawing.INK, ms=8, mew=1.2, zorder=5)
    axes.axhline(0, color=drawing.PALE, lw=0.7, zorder=0)
    axes.axvline(0, color=drawing.PALE, lw=0.7, zorder=0)
    axes.set_xlabel(f"← left    delta-v across ({unit.symbol})    right →")
    axes.set_ylabel(f"← back    delta-v along ({unit.symbol})    forward →")


def _measured(axes: Axes, departure: Items, unit: Unit) -> bool:
    """The bands that recorders leave; whether there are any."""

    def limits(m: Measured, sign: float = 1.0) -> tuple[float, float]:
        middle, reach = sign * m.value / unit.worth, 2 * m.sd / unit.worth
        return middle - reach, middle + reach

    along, left, size = (departure.get(f"delta_v{part}") for part in ("_forward", "_left", ""))
    if along:
        axes.axhspan(*limits(along), zorder=0.5, **_MEASURED)
    if left:
        axes.axvspan(*limits(left, -1.0), zorder=0.5, **_MEASURED)
    if size:
        for radius in limits(size):
            if radius > 0:
                circle = Circle((0, 0), radius, fill=False, ec=drawing.GREY, ls=":", lw=1.0)
                axes.add_patch(circle)
    return any((along, left, size))


def _clock(
    axes: PolarAxes, findings: Findings, v: str, pdof: np.ndarray, size: np.ndarray, units: Units
) -> None:
    colour, vehicle = drawing.OF_VEHICLE[v], findings.scene.vehicles[v]
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_thetagrids(range(0, 360, 30), [str(hour or 12) for hour in range(12)])
    axes.grid(color=drawing.PALE, lw=0.6)
    axes.set_axisbelow(True)
    thin = np.linspace(0, pdof.size - 1, min(_DOTS, pdof.size)).astype(int)
    axes.plot(pdof[thin], size[thin], ".", color=colour, ms=2.6, alpha=0.5, mew=0)
    reach = 1.35 * float(size.max(initial=1.0))
    axes.set_ylim(0, reach)
    axes.yaxis.set_major_locator(MaxNLocator(3, steps=drawing.STEPS, prune="lower"))
    axes.yaxis.set_major_formatter(f"{{x:g}} {unit_of('speed', units).symbol}")
    axes.set_rlabel_position(165)  # degrees: where no force of a crash often comes from
    axes.tick_params(axis="y", labelsize=8, labelcolor=drawing.GREY)
    mean = findings.derived[f"pdof_{v}"].mean
    if mean is not None and not findings.derived[f"pdof_{v}"].withheld:
        look = {"arrowstyle": "-|>", "color": drawing.INK, "lw": 1.6, "mutation_scale": 12}
        tail = max(0.5 * reach, 0.97 * float(np.quantile(size, 0.01)))  # short of the cloud
        axes.annotate("", (mean, 0.22 * reach), (mean, tail), arrowprops=look, zorder=6)
    # half a length is 0.09 of the clock's width, whatever its unit
    half, side = 0.09, 0.09 * vehicle.width / vehicle.length
    body = np.array([[-side, half], [-side, -half], [side, -half], [side, half]]) + 0.5
    front = np.array([[0, half], [-0.6 * side, 0.4 * half], [0.6 * side, 0.4 * half]]) + 0.5
    on_clock: dict[str, Any] = {"transform": axes.transAxes, "zorder": 5}
    axes.add_patch(Polygon(body, fc="white", ec=colour, lw=1.4, **on_clock))
    axes.add_patch(Polygon(front, fc=colour, ec="none", **on_clock))
    axes.set_title(f"{v.upper()}: {_in_words(findings, f'pdof_{v}', units)}", pad=12)
    shares = [each for each in findings.hours[v].items() if each[1] >= _LEAST_SHARE]
    texts = [f"{hour} o'clock {100 * share:.0f} %" for hour, share in shares[:_MOST_HOURS]]
    text = marked(findings, ", ".join(texts), findings.derived[f"pdof_{v}"].withheld)
    axes.set_xlabel(text, labelpad=4)
