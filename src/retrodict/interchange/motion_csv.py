"""A vehicle's motion as CSV with the columns that animation programs read."""

from __future__ import annotations

import csv
import io
import math

import numpy as np
from jaxtyping import Float

COLUMNS = ("Time", "X", "Y", "Z", "Roll", "Pitch", "Yaw")
UNITS = ("s", "m", "m", "m", "deg", "deg", "deg")
_TICK = 1e-6  # s, worth of the last digit of a time


def frame_times(rate: float, count: int) -> Float[np.ndarray, "count"]:
    """The times of frames as a file holds them, s.

    Args:
        rate: frame rate, frames a second.
        count: number of frames.

    Returns:
        Times from 0, to the microsecond, s. Programs find the frame by `int(time * rate)`, in which
        0.29 s at 100 frames a second is frame 28: such a time is a microsecond later.
    """
    number = np.arange(count)
    times = np.ceil(np.round(number / rate / _TICK, 3)) * _TICK
    return np.round(times + _TICK * ((times * rate).astype(int) < number), 6)


def motion_csv(time: Float[np.ndarray, "rows"], pose: Float[np.ndarray, "rows 3"]) -> bytes:
    """A motion in the road plane, in which a vehicle neither heaves nor rolls nor pitches.

    Args:
        time: times, s.
        pose: x, y (m) and heading (rad, counter-clockwise from the x axis, not cut at whole turns).

    Returns:
        The file: one header, which readers match or skip, and rows in s, m and deg, to 1 µs, 0.1 mm and
        0.0001 deg. It has no comments: a reader that expects none would fail.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    for moment, (x, y, heading) in zip(time, pose, strict=True):
        numbers = (x, y, 0.0, 0.0, 0.0, math.degrees(heading))
        writer.writerow([f"{moment:.6f}", *(f"{round(float(n), 4) + 0.0:.4f}" for n in numbers)])
    return text.getvalue().encode("ascii")
