"""One run-out from above: path of the centre of gravity, wheel paths, and outlines along the path."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from retrodict.mechanics.runout import wheel_paths
from retrodict.report.figures import drawing
from retrodict.scene.quantities import Units, unit_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

    from retrodict.mechanics.motion import Car
    from retrodict.mechanics.runout import Path

_OUTLINES = 6  # between the start and rest, at most
_INTERVALS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # s, between outlines
_AROUND = (0, 1, 3, 2)  # wheels in the order of an outline


def plot_path(path: Path, car: Car | None = None, units: Units = "si") -> Figure:
    """Draw a run-out from above, to scale.

    Args:
        path: run-out of one vehicle, from `retrodict.mechanics.run_out`.
        car: vehicle whose axles and track give the wheel paths and the outlines through the wheels;
            None for the path of the centre of gravity alone.
        units: "si" or "us".

    Returns:
        The figure.

    Raises:
        ValueError: the path holds several run-outs, or does not reach rest.

    Examples:
        >>> import retrodict as rd
        >>> from retrodict.mechanics import Car, Ground, run_out
        >>> car = Car(k2=1.8, front_axle=1.3, rear_axle=1.5, track=1.5)
        >>> path = run_out([0, 0, 0.3], [12, 3, 4], car, Ground(0.7))
        >>> rd.plot_path(path, car).savefig("path.png")
    """
    pose, time = np.asarray(path.pose, float), np.asarray(path.time, float)
    if pose.ndim != 2:
        raise ValueError(f"a path of one run-out is drawn, of shape (steps, 3); not {pose.shape}")
    if not np.isfinite(pose).all():
        raise ValueError("the run-out did not reach rest: its path has no last pose to draw")
    unit = unit_of("length", units)
    x, y = pose[:, :2].T / unit.worth
    with mpl.rc_context(drawing.STYLE):
        figure = drawing.new_figure(6.0, 4.2)
        axes = figure.add_subplot()
        axes.set_aspect("equal", adjustable="datalim")
        handles: list[Artist] = []
        if car is not None:
            wheels = np.asarray(wheel_paths(pose, car)) / unit.worth
            axes.plot(*wheels.transpose(2, 0, 1), color=drawing.INK, ls=(0, (1, 1.6)), lw=0.7)
            handles.append(Line2D([], [], color=drawing.INK, ls=(0, (1, 1.6)), label="wheels"))
            interval, times = _times(float(time[-1]))
            shown = np.stack([np.interp(times, time, column) for column in pose.T], axis=1)
            corners = np.asarray(wheel_paths(shown, car))[:, _AROUND] / unit.worth
            axes.add_collection(PolyCollection(list(corners), fc="none", ec=drawing.BLUE, lw=1.0))
            front = corners[:, :2].transpose(2, 1, 0)
            axes.plot(*front, color=drawing.BLUE, lw=2.4, solid_capstyle="butt")
            label = f"the wheels' outline every {interval:.2g} s, front in bold"
            handles.append(Patch(fill=False, ec=drawing.BLUE, label=label))
        axes.plot(x, y, color=drawing.ORANGE, lw=1.6)
        axes.plot(x[0], y[0], "o", color=drawing.ORANGE, mfc="white", ms=5)
        axes.plot(x[-1], y[-1], "o", color=drawing.ORANGE, ms=5)
        length = float(np.hypot(np.diff(x), np.diff(y)).sum())
        label = f"centre of gravity: {length:.3g} {unit.symbol} to rest (dot), in {time[-1]:.3g} s"
        handles.insert(0, Line2D([], [], color=drawing.ORANGE, lw=1.6, label=label))
        axes.set_xlabel(f"x ({unit.symbol})")
        axes.set_ylabel(f"y ({unit.symbol})")
        figure.legend(handles=handles, loc="outside lower center", ncols=1)
    return figure


def _times(last: float) -> tuple[float, np.ndarray]:
    """An interval, and times of outlines from the start to rest, s."""
    wanted = (each for each in _INTERVALS if last / each <= _OUTLINES + 1)
    interval = next(wanted, last / (_OUTLINES + 1))
    return interval, np.append(np.arange(0.0, last - interval / 4, interval), last)
