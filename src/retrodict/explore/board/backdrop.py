"""Photographs that are put under the drawing: read as far as their size, never executed."""

from __future__ import annotations

import cmath
import hashlib
import struct
from dataclasses import replace
from pathlib import Path

from retrodict.explore.board.arguments import refused
from retrodict.explore.board.backdrop_tiff import decoded, is_tiff
from retrodict.explore.board.state import Backdrop
from retrodict.storage.files import write_whole

LARGEST = 64 * 1024 * 1024  # bytes of a photograph
_TOO_LARGE = f"the photograph is larger than {LARGEST // 2**20} MiB: make it smaller"
_ACROSS = 60.0  # m: width of the ground in a photograph, until somebody sets its scale
_PIXELS = 30_000  # at most, along a side
_SUFFIX = {"image/png": ".png", "image/jpeg": ".jpg"}
_PNG = b"\x89PNG\r\n\x1a\n"


def kept(content: bytes, folder: Path, stem: str) -> Backdrop:
    """Keep a photograph beside the scene file, under a name of its own.

    Args:
        content: bytes of a PNG, JPEG or TIFF file; a TIFF is kept too, and shown as JPEG,
            or as PNG where it has transparent parts.
        folder: folder of the scene file.
        stem: name of the scene file, without its suffix.

    Returns:
        The photograph, its middle at the origin; its scale is a guess where no tags of a GeoTIFF have
        it. Its SHA-256 is that of the file that was brought.

    Raises:
        SceneError: it is no such file, or too large.
        OSError: it cannot be written.
    """
    digest = hashlib.sha256(content).hexdigest()
    name = f"{stem}.ground-{digest[:8]}"
    if not is_tiff(content):
        return _written(content, folder, name, digest)
    if len(content) > LARGEST:
        raise refused(_TOO_LARGE)
    tiff = decoded(content)
    backdrop = _written(tiff.image, folder, name, digest)
    if not (folder / f"{name}.tif").exists():
        write_whole(folder / f"{name}.tif", content)
    backdrop = replace(backdrop, original=f"{name}.tif")
    return backdrop if tiff.across is None else _by_steps(backdrop, tiff.across, tiff.down)


def _written(content: bytes, folder: Path, name: str, digest: str) -> Backdrop:
    kind, width, height = size_of(content)
    path = folder / f"{name}{_SUFFIX[kind]}"
    if not path.exists():
        write_whole(path, content)
    metres = _ACROSS / width
    return Backdrop(
        file=path.name,
        sha256=digest,
        width=width,
        height=height,
        metres=metres,
        x=-metres * width / 2,
        y=metres * height / 2,
    )


def by_world_file(backdrop: Backdrop, text: str) -> Backdrop:
    """A photograph placed as its world file says, its middle at the origin of the scene.

    Args:
        backdrop: photograph.
        text: six numbers, a line each: metres along a pixel in x, two rotations, metres in -y, and the
            position of the upper left pixel's middle.

    Raises:
        SceneError: it is no world file, or one that shears or stretches.
    """
    try:
        a, d, b, e, _, _ = (float(line) for line in text.split())
    except ValueError:
        raise refused("a world file has six numbers, a line each") from None
    return _by_steps(backdrop, complex(a, d), complex(b, e))


def _by_steps(backdrop: Backdrop, across: complex, down: complex | None) -> Backdrop:
    """A photograph by the steps of a pixel to the right and downwards, m."""
    if down is None or not 1e-5 < abs(across) < 10 or abs(down + 1j * across) > 1e-3 * abs(across):
        raise refused(
            "its georeference stretches the photograph, or its unit is no metre: export it in a "
            "metric projection, with square pixels"
        )
    corner = -(backdrop.width * across + backdrop.height * down) / 2
    turn = cmath.phase(across)
    return replace(
        backdrop, metres=abs(across), x=corner.real, y=corner.imag, turn=turn, scaled=True
    )


def size_of(content: bytes) -> tuple[str, int, int]:
    """Kind and size of a photograph.

    Args:
        content: bytes of the file.

    Returns:
        "image/png" or "image/jpeg"; width and height in pixels.

    Raises:
        SceneError: it is neither, or too large.
    """
    if len(content) > LARGEST:
        raise refused(_TOO_LARGE)
    found = _png(content) or _jpeg(content)
    if found is None:
        raise refused("no PNG or JPEG photograph, nor a TIFF: export it as one of these")
    _, width, height = found
    if not (0 < width <= _PIXELS and 0 < height <= _PIXELS):
        raise refused(f"the photograph is {width} x {height} pixels: make it smaller")
    return found


def image_at(folder: Path, backdrop: Backdrop | None) -> tuple[Path, str] | None:
    """Path and kind of the photograph; None where there is none that may be shown.

    Args:
        folder: folder of the scene file, beside which it lies.
        backdrop: photograph, whose name a journal may have from anybody.
    """
    if backdrop is None or Path(backdrop.file).name != backdrop.file or "\\" in backdrop.file:
        return None
    path = folder / backdrop.file
    kinds = {suffix: kind for kind, suffix in _SUFFIX.items()}
    if path.suffix not in kinds or path.is_symlink() or not path.is_file():
        return None
    return path, kinds[path.suffix]


def _png(content: bytes) -> tuple[str, int, int] | None:
    if not content.startswith(_PNG) or content[12:16] != b"IHDR" or len(content) < 24:
        return None
    width, height = struct.unpack(">II", content[16:24])
    return "image/png", width, height


def _jpeg(content: bytes) -> tuple[str, int, int] | None:
    """Size of a JPEG: from its first frame header."""
    if not content.startswith(b"\xff\xd8"):
        return None
    at = 2
    while at + 9 <= len(content):
        if content[at] != 0xFF:
            return None
        marker = content[at + 1]
        if marker == 0xFF:  # padding
            at += 1
            continue
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", content[at + 5 : at + 9])
            return "image/jpeg", width, height
        if 0xD0 <= marker <= 0xD9 or marker == 0x01:  # without a length
            at += 2
            continue
        at += 2 + int(struct.unpack(">H", content[at + 2 : at + 4])[0])
    return None
