"""An archive: a result and its inputs in one file, with a chain of hashes over the content.

A zip file, nothing in it compressed and no time in it, so that the same result gives the same bytes.
The last entry, manifest.json, lists the others in their order: each with its SHA-256 and a link, the
SHA-256 of the link before, this SHA-256 and the name. Whoever has noted the last link elsewhere can
tell whether anything was altered since.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import stat
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

MANIFEST = "manifest.json"
SUFFIX = ".retrodict.zip"
_SCHEMA = 1  # of the manifest; raised when a reader has to change
_FIRST = hashlib.sha256(b"retrodict archive 1").hexdigest()  # link before the first entry
_MOST_BYTES, _MOST_ENTRIES = 512_000_000, 100
_TIME = (1980, 1, 1, 0, 0, 0)  # the earliest that a zip file can say
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,99}")  # no folder, no drive, no hidden file


class NotArchived(ValueError):
    """A file is no archive that can be read, or was altered; the message says which part."""


@dataclass(frozen=True)
class Archive:
    """The verified content of an archive.

    Args:
        files: content of each file by name, in the order of the chain.
        link: last link of the chain, in hexadecimal digits.
    """

    files: dict[str, bytes]
    link: str

    def __repr__(self) -> str:
        return f"<Archive of {', '.join(self.files)}; link {self.link[:16]}…>"


def archive_bytes(files: Mapping[str, bytes]) -> bytes:
    """Files as an archive.

    Args:
        files: content of each file by name, in the order of the chain; names of at most 100 letters,
            digits, underscores, dots and dashes, the first no dot or dash.

    Returns:
        Content of the archive file.

    Raises:
        ValueError: a name is not allowed.
    """
    for name in files:
        if not _NAME.fullmatch(name) or name == MANIFEST:
            raise ValueError(f"{name!r} is no name of an entry")
    entries = _chain(files)
    manifest = {
        "schema": _SCHEMA,
        "chain": "link = SHA-256 of: link before, space, SHA-256 of the entry, space, name",
        "first": _FIRST,
        "entries": entries,
    }
    text = json.dumps(manifest, indent=2).encode() + b"\n"
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, content in {**files, MANIFEST: text}.items():
            info = zipfile.ZipInfo(name, _TIME)
            info.create_system = 3  # the same on every system
            info.external_attr = (stat.S_IFREG | 0o644) << 16
            archive.writestr(info, content)
    return buffer.getvalue()


def read_archive(path: Path) -> Archive:
    """Read an archive and verify its chain; nothing is unpacked onto the disk.

    Args:
        path: path of the archive file.

    Returns:
        The verified content.

    Raises:
        NotArchived: the file is no archive, has an entry that no archive has, or was altered: the
            message names each entry whose content, place or presence is not that of the manifest.
        OSError: the file cannot be read.
    """
    if path.is_file() and path.stat().st_size > _MOST_BYTES:
        raise NotArchived(f"{path}: larger than {_MOST_BYTES // 1_000_000} MB; no archive is")
    content = path.read_bytes()
    try:
        found = _entries(path, content)
    except NotArchived:
        raise
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, ValueError, EOFError) as error:
        raise NotArchived(f"{path}: no archive that can be read: {error}") from None
    if MANIFEST not in found:
        raise NotArchived(f"{path}: no archive of retrodict: it holds no {MANIFEST}")
    listed = _listed(path, found.pop(MANIFEST))
    altered = [
        f"{name} {'is not listed in ' + MANIFEST if name in found else 'is missing'}"
        for name in listed.keys() ^ found.keys()
    ]
    altered += [
        f"{name} was altered"
        for name, each in listed.items()
        if name in found and _sha256(found[name]) != each["sha256"]
    ]
    if altered:
        raise NotArchived(f"{path}: {'; '.join(sorted(altered))}")
    entries = _chain({name: found[name] for name in listed})
    if broken := [a["name"] for a, b in zip(entries, listed.values(), strict=True) if a != b]:
        raise NotArchived(f"{path}: {MANIFEST} was altered: its chain breaks at {broken[0]}")
    return Archive({name: found[name] for name in listed}, entries[-1]["link"])


def _chain(files: Mapping[str, bytes]) -> list[dict[str, Any]]:
    entries, link = [], _FIRST
    for name, content in files.items():
        sha256 = _sha256(content)
        link = _sha256(f"{link} {sha256} {name}".encode())
        entries.append({"name": name, "size": len(content), "sha256": sha256, "link": link})
    return entries


def _entries(path: Path, content: bytes) -> dict[str, bytes]:
    """Content of a zip file by name; refused where an entry is such as no archive has."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = archive.infolist()
        if len(members) > _MOST_ENTRIES:
            raise NotArchived(f"{path}: more than {_MOST_ENTRIES} entries; no archive has so many")
        for member in members:
            if not _NAME.fullmatch(member.filename):
                raise NotArchived(
                    f"{path}: entry {member.filename[:80]!r}: no archive has such a name"
                )
            # what is not compressed cannot be larger than the file
            if member.compress_type != zipfile.ZIP_STORED or member.flag_bits & 1:
                raise NotArchived(f"{path}: entry {member.filename}: compressed or encrypted")
        names = [member.filename for member in members]
        if twice := {name for name in names if names.count(name) > 1}:
            raise NotArchived(f"{path}: entry {min(twice)}: there twice")
        if sum(member.file_size for member in members) > len(content):
            raise NotArchived(f"{path}: its entries claim more than it holds")
        found = {}
        for member in members:
            try:
                found[member.filename] = archive.read(member)
            except zipfile.BadZipFile:  # by the zip file's own check sum
                raise NotArchived(f"{path}: {member.filename} was altered") from None
        return found


def _listed(path: Path, manifest: bytes) -> dict[str, dict[str, Any]]:
    """The manifest's entries by name."""
    try:
        read = json.loads(manifest)
        if read["schema"] != _SCHEMA:
            raise NotArchived(
                f"{path}: of another version of retrodict (schema {read['schema']!r})"
            )
        return {str(entry["name"]): dict(entry) for entry in read["entries"]}
    except NotArchived:
        raise
    except (ValueError, KeyError, TypeError, RecursionError):
        raise NotArchived(f"{path}: {MANIFEST} was altered: it cannot be read") from None


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
