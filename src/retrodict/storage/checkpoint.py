"""Interrupted chains on disk: the state of each chain and its draws so far, as numbers only."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np

Records = list[list[dict[str, np.ndarray]]]


def packed(states: Sequence[Any], records: Records, settings: dict[str, int | str]) -> bytes:
    """Chains as a file (.npz) from which a later process can continue them.

    Args:
        states: last state of each interrupted chain.
        records: arrays of every block of every chain, by name.
        settings: settings of the run, seed included, and a fingerprint of the data and coordinates.
    """
    arrays: dict[str, np.ndarray] = {f"setting/{k}": np.asarray(v) for k, v in settings.items()}
    for i, (state, record) in enumerate(zip(states, records, strict=True)):
        for j, leaf in enumerate(jax.tree.leaves(state)):
            arrays[f"state/{i}/{j}"] = _numbers(leaf)
        for name in record[0] if record else ():
            arrays[f"record/{i}/{name}"] = np.stack([block[name] for block in record])
    file = io.BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]  # its stub knows one keyword
    return file.getvalue()


def read(path: Path) -> dict[str, np.ndarray]:
    """Arrays of a file that `packed` made, by name.

    Args:
        path: path of the file.

    Raises:
        ValueError: the file is damaged, or was not made by `packed`.
        OSError: the file cannot be read.
    """
    content = path.read_bytes()
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            found = {name: file[name] for name in file.files}
    except Exception as error:  # bad archive or header, or no memory for what it claims
        raise _damaged(path) from error
    if not any(name.startswith("setting/") for name in found):
        raise _damaged(path)
    return found


def load(path: Path, settings: dict[str, int | str], fresh: list[Any]) -> tuple[list[Any], Records]:
    """Read chains back.

    Args:
        path: path of a file that `packed` made.
        settings: settings of the new run, as of `packed`; they must be the same.
        fresh: states of chains that have just begun, of which only the structure matters.

    Returns:
        The last state of each chain, and its records.

    Raises:
        ValueError: the file is of another run, or damaged.
        OSError: the file cannot be read.
    """
    file = read(path)
    for name, value in settings.items():
        found = file[f"setting/{name}"].item() if f"setting/{name}" in file else None
        if found != value:
            raise ValueError(
                f"{path}: made with {name} {found}, not {value}: give the options, the scene and "
                "the version that were interrupted, or start anew"
            )
    leaves, structure = jax.tree.flatten(fresh[0])
    states, records = [], []
    for i in range(len(fresh)):
        mine = [file.get(f"state/{i}/{j}", np.empty(0)) for j in range(len(leaves))]
        if not all(_alike(_numbers(leaf), own) for leaf, own in zip(leaves, mine, strict=True)):
            raise _damaged(path)
        states.append(jax.tree.unflatten(structure, _as(leaves, mine)))
        prefix = f"record/{i}/"
        stacked = {k.removeprefix(prefix): v for k, v in file.items() if k.startswith(prefix)}
        w = stacked.get("w", np.zeros(1))
        if len({len(v) for v in stacked.values()}) > 1 or not np.isfinite(w).all():
            raise _damaged(path)
        blocks = len(next(iter(stacked.values()))) if stacked else 0
        records.append([{k: v[b] for k, v in stacked.items()} for b in range(blocks)])
    return states, records


def _damaged(path: Path) -> ValueError:
    return ValueError(f"{path} is damaged, or is not of an interrupted run: leave --resume out")


def _alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether shape and kind are the same, and the second array has no NaN that the first has not."""
    if one.shape != other.shape or one.dtype.kind != other.dtype.kind:
        return False
    return other.dtype.kind != "f" or not (np.isnan(other) & ~np.isnan(one)).any()


def _numbers(leaf: Any) -> np.ndarray:
    """A leaf of a state as numbers; a random key is replaced by its data."""
    key = jax.dtypes.issubdtype(leaf.dtype, jax.dtypes.prng_key)
    return np.asarray(jax.random.key_data(leaf) if key else leaf)


def _as(leaves: Sequence[Any], arrays: Sequence[np.ndarray]) -> list[Any]:
    """Arrays converted to the types of the leaves, random keys included."""
    return [
        jax.random.wrap_key_data(jax.numpy.asarray(array))
        if jax.dtypes.issubdtype(leaf.dtype, jax.dtypes.prng_key)
        else array.astype(leaf.dtype)
        for leaf, array in zip(leaves, arrays, strict=True)
    ]
