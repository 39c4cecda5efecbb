"""Interrupted chains on disk: where each stands and what it has drawn, as numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

if TYPE_CHECKING:
    from retrodict.inference.methods.chains import Chains

Records = list[list[dict[str, np.ndarray]]]


def save(chains: Chains, settings: dict[str, int | str], path: Path) -> None:
    """Write chains so that a later process can go on with them.

    Args:
        chains: interrupted.
        settings: that the run was made with, seed included, and a fingerprint of the scene.
        path: of the file (.npz).
    """
    arrays: dict[str, np.ndarray] = {f"setting/{k}": np.asarray(v) for k, v in settings.items()}
    for i, (state, record) in enumerate(zip(chains.states, chains.records, strict=True)):
        for j, leaf in enumerate(jax.tree.leaves(state)):
            key = jax.dtypes.issubdtype(leaf.dtype, jax.dtypes.prng_key)
            arrays[f"state/{i}/{j}"] = np.asarray(jax.random.key_data(leaf) if key else leaf)
        for name in record[0] if record else ():
            arrays[f"record/{i}/{name}"] = np.stack([block[name] for block in record])
    with path.open("wb") as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]  # its stub knows one keyword


def load(path: Path, settings: dict[str, int | str], fresh: list[Any]) -> tuple[list[Any], Records]:
    """Read chains back.

    Args:
        path: of a file that `save` wrote.
        settings: that the new run is made with.
        fresh: states of chains that have just begun, of which only the structure matters.

    Returns:
        Where each chain stands, and its records.

    Raises:
        ValueError: the file is of another run.
        OSError: it cannot be read.
    """
    with np.load(path, allow_pickle=False) as file:
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
            mine = [file[f"state/{i}/{j}"] for j in range(len(leaves))]
            states.append(jax.tree.unflatten(structure, _as(leaves, mine)))
            prefix = f"record/{i}/"
            stacked = {k.removeprefix(prefix): file[k] for k in file if k.startswith(prefix)}
            blocks = len(next(iter(stacked.values()))) if stacked else 0
            records.append([{k: v[b] for k, v in stacked.items()} for b in range(blocks)])
    return states, records


def _as(leaves: Sequence[Any], arrays: Sequence[np.ndarray]) -> list[Any]:
    """Arrays with the types of leaves; random keys are told apart by theirs."""
    return [
        jax.random.wrap_key_data(jax.numpy.asarray(array))
        if jax.dtypes.issubdtype(leaf.dtype, jax.dtypes.prng_key)
        else array.astype(leaf.dtype)
        for leaf, array in zip(leaves, arrays, strict=True)
    ]
