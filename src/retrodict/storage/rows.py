"""Rows of an unfinished batch on disk, each under its key: an answer known stays known."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from retrodict.storage.files import write_whole

_ROWS, _LOCK = "rows", ".lock"


class InUse(OSError):
    """Another process works in a folder."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """A context in which no other process writes rows to a folder.

    The lock ends with the process, however it ends. Where a system has no such locks nothing is
    refused; nothing is lost either, for each file of rows is written whole and named after its keys.

    Args:
        folder: folder of the rows, made where missing.

    Raises:
        InUse: another process has locked the folder.
        OSError: nothing can be written to the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / _LOCK).open("w") as file:
        try:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InUse(
                f"{folder}: another command answers scenes there; wait for it, or choose another folder"
            ) from None
        except (ImportError, OSError):
            pass
        yield


def write_rows(rows: Mapping[str, Mapping[str, Any]], folder: Path) -> None:
    """Store some rows in a file of their own.

    Args:
        rows: values for strict JSON, by key.
        folder: folder of the rows.

    Raises:
        OSError: the file could not be written; then there is no such file.
    """
    lines = [
        json.dumps({"key": key, **row}, ensure_ascii=False, allow_nan=False)
        for key, row in rows.items()
    ]
    name = hashlib.sha256(" ".join(rows).encode()).hexdigest()[:32]
    write_whole(folder / _ROWS / f"{name}.jsonl", "".join(f"{line}\n" for line in lines).encode())


def read_rows(folder: Path) -> Iterator[list[tuple[str, dict[str, Any]]]]:
    """The rows that were stored, each with its key, file by file; a damaged file is left out."""
    for file in sorted((folder / _ROWS).glob("*.jsonl")):
        try:
            rows = [json.loads(line) for line in file.read_text("utf-8").splitlines()]
            yield [(row.pop("key"), row) for row in rows]
        except (ValueError, KeyError, TypeError, AttributeError):
            continue
