"""One impact from above: centres of gravity, contact line, velocities before and after, impulse."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.lines import Line2D

from retrodict.mechanics.contact import axes as contact_axes
from retrodict.mechanics.impact import impulse, separation
from retrodict.report.figures import drawing
from retrodict.scene.quantities import Units, unit_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from retrodict.mechanics.contact import Bodies, SixNumbers
    from retrodict.mechanics.impact import Coefficients

_LINE: dict[str, Any] = {"color": drawing.GREY, "ls": (0, (4, 2)), "lw": 1.0}
_LEAST = 2.0  # m, between a centre of gravity and the impact centre, by which arrows are scaled


def plot_impact(
    approach: SixNumbers, bodies: Bodies, coefficients: Coefficients, units: Units = "si"
) -> Figure:
    """Draw an impact from above: positions to scale, and velocities as arrows.

    Args:
        approach: velocities before, (v_ax, v_ay, omega_a, v_bx, v_by, omega_b), m/s and rad/s.
        bodies: masses, inertias, lever arms and Gamma, as from `retrodict.mechanics.Bodies`.
        coefficients: e, mu and e_m, as from `retrodict.mechanics.Coefficients`.
        units: "si" or "us".

    Returns:
        The figure. Arrows from the centres of gravity are the velocities, pale before the impact and
        full after it; the arrow at the impact centre has the direction of the impulse on A.

    Raises:
        ValueError: the numbers are those of several impacts, or give no finite velocities.

    Examples:
        >>> import retrodict as rd
        >>> from retrodict.mechanics import Bodies, Coefficients
        >>> bodies = Bodies(1857, 1778, 3374, 3007, 1.636, 0.653, 0.205, 2.079, Gamma=-0.155)
        >>> approach = [-20.1, 0, 0, 18.9, -3.6, -0.3]
        >>> figure = rd.plot_impact(approach, bodies, Coefficients(e=0.1, mu=0.35, e_m=0.7))
        >>> figure.savefig("impact.png")
    """
    before = np.asarray(approach, float)
    if before.shape != (6,) or any(np.ndim(each) for each in (*bodies, *coefficients)):
        raise ValueError("one impact is drawn: six velocities, and single numbers for all else")
    after = np.asarray(separation(approach, bodies, coefficients), float)
    if not np.isfinite(after).all():
        raise ValueError("these numbers give no finite velocities after the impact")
    length = unit_of("length", units)
    _, _, _, _, d1, d2, d3, d4, _ = (float(each) for each in bodies)
    centres = {"a": np.array([d4, d3]), "b": np.array([-d2, -d1])}
    if np.isinf(float(bodies.m_b)):  # a barrier has no centre of gravity
        del centres["b"]
    states = {v: np.stack([before[i : i + 3], after[i : i + 3]]) for v, i in (("a", 0), ("b", 3))}
    reach = max(_LEAST, *(float(np.hypot(*centre)) for centre in centres.values()))
    fastest = max(float(np.hypot(*states[v][:, :2].T).max()) for v in centres)
    scale = 1.5 * reach / (fastest or 1.0)
    P = np.asarray(impulse(approach, bodies, coefficients)[0], float)
    with mpl.rc_context(drawing.STYLE):
        figure = drawing.new_figure(6.0, 4.6)
        axes = figure.add_subplot()
        axes.set_aspect("equal", adjustable="datalim")
        tangent = np.asarray(contact_axes(bodies)[1]) * reach / length.worth
        handles: list[Artist] = [
            *axes.plot(*np.stack([-tangent, tangent]).T, label="contact line", **_LINE)
        ]
        for v, centre in centres.items():
            handles.append(_vehicle(axes, v, centre, scale, states[v], units))
        if size := float(np.hypot(*P)):
            _arrow(axes, np.zeros(2), reach * P / size / length.worth, drawing.INK, 1.0)
            force = unit_of("impulse", units)
            label = f"impulse on A: {_three_digits(size / force.worth)} {force.symbol}"
            handles.append(Line2D([], [], color=drawing.INK, lw=1.8, label=label))
        axes.plot(0, 0, "x", color=drawing.INK, ms=7, mew=1.5)
        axes.set_xlabel(f"x from the impact centre ({length.symbol})")
        axes.set_ylabel(f"y ({length.symbol})")
        figure.legend(handles=handles, loc="outside lower center", ncols=1)
    return figure


def _vehicle(
    axes: Axes, v: str, centre: np.ndarray, scale: float, states: np.ndarray, units: Units
) -> Line2D:
    """Draw a vehicle's velocities before and after the impact; return its line of the legend."""
    length, speed, spin = (unit_of(each, units) for each in ("length", "speed", "yaw rate"))
    place, colour = centre / length.worth, drawing.OF_VEHICLE[v]
    axes.plot(*np.stack([place, 0 * place]).T, color=colour, lw=0.6)
    for state, alpha in zip(states, (0.4, 1.0), strict=True):
        _arrow(axes, place, place + scale * state[:2] / length.worth, colour, alpha)
    axes.plot(*place, "o", color=colour, ms=5)
    change = np.hypot(*(states[1] - states[0])[:2])
    v_0, v_1, delta_v = (
        _three_digits(each / speed.worth) for each in (*np.hypot(*states[:, :2].T), change)
    )
    w_0, w_1 = (_three_digits(each / spin.worth) for each in states[:, 2])
    label = (
        f"{v.upper()}: {v_0} → {v_1} {speed.symbol} (before pale), delta-v {delta_v} "
        f"{speed.symbol}; yaw rate {w_0} → {w_1} {spin.symbol}"
    )
    return Line2D([], [], color=colour, marker="o", lw=1.8, label=label)


def _arrow(axes: Axes, start: np.ndarray, end: np.ndarray, colour: str, alpha: float) -> None:
    """Draw an arrow between two points."""
    if not np.any(end - start):
        return
    style = {
        "arrowstyle": "-|>",
        "color": colour,
        "alpha": alpha,
        "lw": 1.8,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    axes.annotate("", tuple(end), tuple(start), arrowprops=style)
    axes.update_datalim([start, end])  # an annotation does not widen the axes
    axes.autoscale_view()


def _three_digits(value: float) -> str:
    """A number to three digits, without an exponent."""
    return f"{float(f'{value:.3g}'):.10g}".replace("-", "−")
