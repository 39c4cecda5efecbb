"""Draws as a Parquet table, with their units in the schema's metadata."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping

import numpy as np
from jaxtyping import Shaped


def parquet(
    columns: Mapping[str, Shaped[np.ndarray, "rows"]],
    attributes: Mapping[str, Mapping[str, str]],
    about: Mapping[str, object],
) -> bytes:
    """A table of draws as a Parquet file.

    Args:
        columns: values of each column, by name.
        attributes: attributes of each column, by name: "unit" (empty for a number) and "label".
        about: description of the run, in plain data.

    Returns:
        The file. Each field has its attributes as metadata; the schema has all of them once more in JSON
        under "columns", for readers that do not see the fields' metadata, and the run under "run".

    Raises:
        ImportError: pyarrow is not installed.
    """
    import pyarrow as pa
    from pyarrow.parquet import write_table

    arrays = {name: pa.array(values) for name, values in columns.items()}
    fields = [
        pa.field(name, array.type, metadata=dict(attributes.get(name, {})))
        for name, array in arrays.items()
    ]
    metadata = {"columns": json.dumps(attributes), "run": json.dumps(about, allow_nan=False)}
    stream = io.BytesIO()
    write_table(pa.table(list(arrays.values()), schema=pa.schema(fields, metadata)), stream)
    return stream.getvalue()
