"""GeoTIFF photographs: the pixels for a browser, and where they lie by the tags of the file.

Only what places an image without a projection of its own is read: size of a pixel, and whether the unit
of the coordinates is the metre or a foot.
"""

from __future__ import annotations

import io
from dataclasses import dataclass

from retrodict.explore.board.arguments import refused

# tags of TIFF 6.0 as OGC GeoTIFF 1.1 has them
_PIXEL_SCALE, _TRANSFORMATION, _KEYS = 33550, 34264, 34735
_MODEL_TYPE, _LINEAR_UNIT = 1024, 3076
_GEOGRAPHIC = 2
_METRES = {9001: 1.0, 9002: 0.3048, 9003: 1200 / 3937}  # by EPSG code of the unit
_PIXELS = 120_000_000  # of an image that is decoded: beyond, 500 MB of memory would not do


@dataclass(frozen=True, slots=True)
class Decoded:
    """A TIFF image.

    Args:
        image: the same image as JPEG, or as PNG where it has transparent parts.
        across: step of a pixel to the right, m: x and y as a complex number; None without georeference.
        down: step of a pixel downwards, m.
    """

    image: bytes
    across: complex | None
    down: complex | None


def is_tiff(content: bytes) -> bool:
    """Whether a file begins as a TIFF does."""
    return content[:4] in (b"II*\0", b"MM\0*")


def decoded(content: bytes) -> Decoded:
    """A TIFF image for a browser, with the steps of its pixels on the ground.

    Args:
        content: bytes of the file.

    Raises:
        SceneError: it cannot be read, is too large, or counts its coordinates in degrees.
    """
    from PIL import Image

    try:
        with Image.open(io.BytesIO(content), formats=("TIFF",)) as image:
            width, height = image.size
            if width * height > _PIXELS:
                raise refused(f"the image is {width} x {height} pixels: make it smaller")
            written = getattr(image, "tag_v2", {})  # which all images of that format have
            tags = {key: written.get(key) for key in (_PIXEL_SCALE, _TRANSFORMATION, _KEYS)}
            steps = _steps(tags)
            made = io.BytesIO()
            if image.mode in ("RGBA", "LA", "PA"):
                image.convert("RGBA").save(made, "PNG", compress_level=1)
            else:
                image.convert("RGB").save(made, "JPEG", quality=92)
    except (OSError, ValueError, SyntaxError, TypeError, Image.DecompressionBombError):
        raise refused("a TIFF that cannot be read: export it as PNG with a world file") from None
    return Decoded(made.getvalue(), *steps)


def _steps(tags: dict[int, object]) -> tuple[complex | None, complex | None]:
    keys = tags[_KEYS]
    known: dict[int, int] = {}
    if isinstance(keys, tuple):  # four numbers a key; the second says that the fourth is its value
        for i in range(4, len(keys) - 3, 4):
            if keys[i + 1] == 0:
                known[int(keys[i])] = int(keys[i + 3])
    scale, matrix = tags[_PIXEL_SCALE], tags[_TRANSFORMATION]
    if isinstance(scale, tuple) and len(scale) >= 2:
        across, down = complex(float(scale[0]), 0.0), complex(0.0, -float(scale[1]))
    elif isinstance(matrix, tuple) and len(matrix) == 16:
        a, b, d, e = (float(matrix[i]) for i in (0, 1, 4, 5))
        across, down = complex(a, d), complex(b, e)
    else:
        return None, None
    if known.get(_MODEL_TYPE) == _GEOGRAPHIC:
        raise refused(
            "its coordinates are degrees: export it in a projection with metres, such as UTM"
        )
    metre = _METRES.get(known.get(_LINEAR_UNIT, 9001))
    if metre is None:
        raise refused("its unit is neither the metre nor the foot: export it in metres")
    return metre * across, metre * down
