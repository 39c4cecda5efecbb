"""Motion CSV: the columns that animation programs match, and times that fall into their own frames."""

import csv
import io

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retrodict.interchange.motion_csv import COLUMNS, frame_times, motion_csv


@given(rate=st.sampled_from([1, 10, 24, 25, 29.97, 30, 50, 59.94, 60, 100, 120, 240, 1000]))
def test_every_row_has_a_frame_of_its_own_where_programs_cut_decimals(rate):
    times = [float(f"{t:.6f}") for t in frame_times(rate, 2000)]
    # as the Motion Data Importer of EDC's tools for Blender has it
    assert [int(t * rate) for t in times] == list(range(2000))
    assert times == pytest.approx(np.arange(2000) / rate, abs=2e-6)


def test_plain_readers_get_the_numbers_back():
    time = frame_times(30, 3)
    pose = np.array([[1.23456, -2.0, 0.1], [0.0, -1e-9, 4.0], [7e3, 0.5, -12.0]])
    content = motion_csv(time, pose)
    header, *rows = csv.reader(io.StringIO(content.decode("ascii")))
    assert header == ["Time", "X", "Y", "Z", "Roll", "Pitch", "Yaw"]
    assert {len(row) for row in rows} == {7}
    assert "-0.0000" not in rows[1]
    frame = pd.read_csv(io.BytesIO(content))
    assert tuple(frame.columns) == COLUMNS
    assert frame["Time"].to_numpy() == pytest.approx(time, abs=5e-7)
    assert frame[["X", "Y"]].to_numpy() == pytest.approx(pose[:, :2], abs=5.1e-5)
    assert np.radians(frame["Yaw"]).to_numpy() == pytest.approx(pose[:, 2], abs=1e-6)
    assert not frame[["Z", "Roll", "Pitch"]].to_numpy().any()
