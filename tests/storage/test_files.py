"""Files of one result: all of them or none, and no signal between them."""

import os
import signal
from pathlib import Path

import pytest

from retrodict.storage import files
from retrodict.storage.files import write_together

OLD, NEW = {"a.txt": b"old", "deep/b.txt": b"old"}, {"a.txt": b"new", "deep/b.txt": b"new"}


def content(folder: Path) -> dict[str, bytes]:
    found = (p for p in folder.rglob("*") if p.is_file())
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in found}


def test_files_take_their_places_in_order_beside_others(tmp_path: Path, monkeypatch) -> None:
    write_together(tmp_path, OLD | {"other.txt": b"kept"})
    placed, replace = [], os.replace

    def watched(source: Path, target: Path) -> None:
        if not target.name.endswith(".tmp") and target.parent.name in (tmp_path.name, "deep"):
            placed.append(target.name)
        replace(source, target)

    monkeypatch.setattr(files.os, "replace", watched)
    write_together(tmp_path, NEW)
    assert placed[-2:] == ["a.txt", "b.txt"]
    assert content(tmp_path) == NEW | {"other.txt": b"kept"}


@pytest.mark.parametrize("fails_at", range(2))
def test_a_full_disk_changes_nothing(tmp_path: Path, monkeypatch, fails_at: int) -> None:
    write_together(tmp_path / "old", OLD)
    done = iter(range(9))

    def full(*_: object) -> None:
        if next(done) >= fails_at:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full)
    for folder in ("old", "new"):
        with pytest.raises(OSError, match="No space left"):
            write_together(tmp_path / folder, NEW)
    assert content(tmp_path / "old") == OLD
    assert [p.name for p in tmp_path.iterdir()] == ["old"]


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_waits_until_all_are_in_place(tmp_path: Path, monkeypatch, name: str) -> None:
    replace, arrived = os.replace, []

    def interrupted(source: Path, target: Path) -> None:
        replace(source, target)
        if target == tmp_path / "a.txt":
            signal.raise_signal(getattr(signal, name))

    monkeypatch.setattr(files.os, "replace", interrupted)
    before = signal.signal(getattr(signal, name), lambda number, _: arrived.append(number))
    try:
        write_together(tmp_path, NEW)
    finally:
        signal.signal(getattr(signal, name), before)
    assert arrived == [getattr(signal, name)]
    assert content(tmp_path) == NEW


def test_what_a_killed_process_left_is_cleared_and_what_another_is_at_is_not(
    tmp_path: Path,
) -> None:
    left, present = tmp_path / ".retrodict-left", tmp_path / ".retrodict-now"
    for folder in (left, present):
        folder.mkdir()
        (folder / "figure.png").write_bytes(b"half")
    os.utime(left, (0, 0))
    write_together(tmp_path, {"summary.json": b"{}"})
    assert not left.exists()
    assert present.exists()
    assert (tmp_path / "summary.json").read_bytes() == b"{}"
