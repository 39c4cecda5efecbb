"""Photographs that are made for tests."""

from __future__ import annotations

import struct
import zlib


def png(width: int, height: int, shade: int = 160) -> bytes:
    """A photograph of one shade of grey, with a white line along its middle."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    rows = b"".join(
        b"\0" + bytes([255 if abs(y - height // 2) < 3 else shade]) * width for y in range(height)
    )
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    parts = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + parts
