"""Parquet, read back by pyarrow and pandas: the numbers to the bit, and their units in the schema."""

import io
import json

import numpy as np
import pandas as pd
import pyarrow.parquet as pq

from retrodict.interchange.parquet import parquet


def test_numbers_units_and_run_come_back():
    columns = {"draw": np.arange(3), "speed_b": np.array([1 / 3, np.nan, -0.0])}
    attributes = {"speed_b": {"unit": "m/s", "label": "speed of B"}}
    content = parquet(columns, attributes, {"seed": 3})
    schema = pq.read_schema(io.BytesIO(content))
    assert schema.field("speed_b").metadata[b"unit"] == b"m/s"
    assert json.loads(schema.metadata[b"columns"]) == attributes
    assert json.loads(schema.metadata[b"run"]) == {"seed": 3}
    frame = pd.read_parquet(io.BytesIO(content))
    assert list(frame.columns) == list(columns)
    for name, values in columns.items():
        assert frame[name].to_numpy().tobytes() == values.tobytes()
