"""A reconstruction as files, and read from them: plain data, nothing that runs."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retrodict.findings.summary import SUMMARY, read_summary, strangers
from retrodict.inference.outcome import Checks, Mode, Outcome
from retrodict.inference.pointwise import pointwise
from retrodict.options import RunOptions
from retrodict.scene.own import without_code
from retrodict.scene.records import Scene

if TYPE_CHECKING:
    import xarray as xr
    from pydantic import TypeAdapter

    from retrodict.studies.comparison import Ladder

DRAWS, RUN = "posterior.nc", "run.json"
_SCHEMA = 1  # of run.json; raised when a reader has to change


class NotStored(ValueError):
    """There is no result that can be read; the message names the place and says what to do."""


def stored(outcome: Outcome, ladder: Ladder | None = None) -> dict[str, bytes]:
    """A reconstruction as the files that `load` reads.

    Args:
        outcome: the reconstruction.
        ladder: comparison of the models, where the ladder chose this one; None otherwise.

    Returns:
        Contents of the files, by name: the draws in netCDF, and everything else in JSON.
    """
    known = {each.name: getattr(outcome, each.name) for each in fields(outcome)}
    record = {name: known[name] for name in _record_types() if name in known}
    record |= {"schema": _SCHEMA, "ladder": ladder, "scene": without_code(outcome.scene)}
    if ladder is not None:
        record["ladder"] = replace(ladder, scene=without_code(ladder.scene))
    # netCDF in memory: where a disk is full, the library that writes it ends the process
    return {
        DRAWS: bytes(outcome.idata.to_netcdf()),
        RUN: _reader().dump_json(record, indent=1) + b"\n",
    }


def load(folder: Path) -> tuple[Outcome, Ladder | None]:
    """A reconstruction from a folder of results.

    Args:
        folder: folder in which a result was saved.

    Returns:
        The outcome, without what an interrupted run would go on from; and the comparison of the models.

    Raises:
        NotStored: there is no result, a file is not of the run that the summary is of, or it was
            saved by a version that this one does not read.
    """
    if not folder.is_dir():
        raise NotStored(f"{folder}: no such folder; give the folder of a result, like out/NAME")
    if (summary := read_summary(folder)) is None:
        raise NotStored(f"{folder}: holds no result: {SUMMARY} is missing or damaged")
    if not {DRAWS, RUN} <= set(summary["files"]):
        raise NotStored(f"{folder}: saved by an earlier version; reconstruct the scene again")
    if other := {DRAWS, RUN} & set(strangers(folder)):
        raise NotStored(
            f"{folder}: not of the run that {SUMMARY} is of: {', '.join(sorted(other))}; "
            "reconstruct the scene again"
        )
    return of_files({name: (folder / name).read_bytes() for name in (DRAWS, RUN)}, folder)


def of_files(files: Mapping[str, bytes], place: Path) -> tuple[Outcome, Ladder | None]:
    """A reconstruction from what its files hold.

    Args:
        files: contents of the files of `stored`, and of any others, by name.
        place: path that the files were read from, for messages.

    Returns:
        The outcome and the comparison of the models, as from `load`.

    Raises:
        NotStored: a file is missing, or was saved by a version that this one does not read.
    """
    from pydantic import ValidationError

    if missing := [name for name in (DRAWS, RUN) if name not in files]:
        raise NotStored(f"{place}: holds no result: {', '.join(missing)} is missing")
    try:
        record = dict(_reader().validate_json(files[RUN]))
    except ValidationError:
        raise NotStored(
            f"{place / RUN}: saved by another version; reconstruct the scene again"
        ) from None
    idata = draws_of(files[DRAWS])
    del record["schema"]
    ladder = record.pop("ladder")
    return Outcome(idata=idata, **record), ladder


def draws_of(content: bytes) -> xr.DataTree:
    """Draws from what their file holds."""
    import xarray as xr

    with xr.open_datatree(io.BytesIO(content), engine="h5netcdf") as tree:
        return pointwise(tree.load())  # earlier versions had a variable for each item


def _reader() -> TypeAdapter[Any]:
    """Reader of all but the draws; made here, because pydantic and JAX take a while to import."""
    from pydantic import ConfigDict, TypeAdapter
    from typing_extensions import TypedDict

    record = TypedDict("record", _record_types())  # type: ignore[misc]
    # strict JSON: what is not finite is a text
    record.__pydantic_config__ = ConfigDict(ser_json_inf_nan="strings")  # type: ignore[attr-defined]
    return TypeAdapter(record)


def _record_types() -> dict[str, Any]:
    from typing import Literal

    from retrodict.models.description import Description
    from retrodict.studies.comparison import Ladder

    return {
        "schema": Literal[1],
        "scene": Scene,
        "description": Description,
        "checks": Checks,
        "seconds": dict[str, float],
        "versions": dict[str, str],
        "seed": int,
        "settings": dict[str, int | str],
        "asked": RunOptions,
        "complete": bool,
        "notes": tuple[str, ...],
        "modes": tuple[Mode, ...],
        "ladder": Ladder | None,
    }
