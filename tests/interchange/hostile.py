"""Hostile files, from a seed: what a table, a drawing or a map might hold at worst."""

from __future__ import annotations

import io
import random

import ezdxf

CELLS = [
    "7", "id", "x", "y", "Time", "Speed", "1.5", "-2", "1,5", "1e999", "-1e308", "9" * 400, "nan",
    "inf", "-inf", "0x10", "1_000", "١٢", "=1+1", "=cmd|' /C calc'!A0", "@SUM(A1)", "+1", "−3", "",
    " ", "\t", '"', "'", "\x1b[2J", "\x07", "\u202e", "\ufeff", "[red]x[/red]", "a" * 1200, "é",
    "\ud7ff", "\r", "\n", '"a\nb"', "<script>", "../../x", "NULL", "1.5.2", "--1", "%s%n", "{0}",
]  # fmt: skip
HEADERS = ["id,x,y", "id;x;y", "id\tx\ty", "ID,X,Y,x", "x,y", "", "id,x,y,h", "Time,Speed"]
TEXTS = [
    "m", "furlong", "0.02 m", "-1 m", "1 ± 1 m", "east", "7", "", "\\u0000", "x" * 300, "GOUGE", "mph",
    "0 s", "\x1b[2J", "survey", "at_least", "[red]", "deg", "A", "front_left", "vehicles.A.mass", "é",
]  # fmt: skip
CODES = [
    "0",
    "2",
    "5",
    "8",
    "10",
    "20",
    "30",
    "40",
    "50",
    "62",
    "66",
    "70",
    "100",
    "210",
    "230",
    "330",
]
VALUES = [
    "SECTION", "ENDSEC", "ENTITIES", "BLOCKS", "HEADER", "TABLES", "EOF", "POINT", "LINE", "INSERT",
    "LWPOLYLINE", "POLYLINE", "VERTEX", "SEQEND", "CIRCLE", "BLOCK", "ENDBLK", "$INSUNITS", "$ACADVER",
    "AC1009", "AC1024", "GOUGE", "CAR", "*Model_Space", "nan", "inf", "-1e308", "1e999", "abc", "",
    "9" * 300, "-1", "0", "FFFFFFFFFFFFFFFF", "\x00", "\x1b[2J",
]  # fmt: skip


def survey(rng: random.Random) -> bytes:
    """Something like points as CSV."""
    return _table(rng, [rng.choice(HEADERS), "7,1,2"])


def recorder(rng: random.Random) -> bytes:
    """Something like a recorder's table as CSV."""
    return _table(rng, [rng.choice(["Time,Speed", "Time;Speed"]), "-1,20", "0,15"])


def map_text(rng: random.Random, text: str) -> bytes:
    """A map with some lines or values of another."""
    lines = text.split("\n")
    for _ in range(rng.randrange(3)):
        at = rng.randrange(len(lines))
        key, equals, _ = lines[at].partition(" = ")
        value = rng.choice([
            f'"{rng.choice(TEXTS)}"', rng.choice(TEXTS), "1", "-1e999", "nan", "true", "[]", "{}",
            "[[1]]", "{ value = 1 }", "1979-05-27", '["east", "east"]', '["a", 1]', "9" * 60,
        ])  # fmt: skip
        lines[at] = rng.choice([f"{key}{equals}{value}", "", value, f"{key}x{equals}{value}"])
    return _damaged(rng, "\n".join(lines).encode("utf-8", "replace"))


def _table(rng: random.Random, lines: list[str]) -> bytes:
    separator = rng.choice(",;\t|")
    lines += [
        separator.join(rng.choice(CELLS) for _ in range(rng.randrange(6)))
        for _ in range(rng.randrange(8))
    ]
    text = rng.choice(["\n", "\r\n", "\r"]).join(lines)
    encoding = rng.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "cp1252", "utf-32"])
    return _damaged(rng, text.encode(encoding, errors="replace"))


def drawing(rng: random.Random) -> bytes:
    """Something like DXF: tags at random, or a sound drawing with places damaged."""
    if rng.random() < 0.4:
        tags = [(rng.choice(CODES), rng.choice(VALUES)) for _ in range(rng.randrange(60))]
        lines = ["0", "SECTION", "2", rng.choice(["ENTITIES", "BLOCKS", "HEADER"])]
        lines += [each for tag in tags for each in tag] + ["0", "ENDSEC", "0", "EOF"]
        return _damaged(rng, "\n".join(lines).encode())
    lines = rng.choice(_SOUND).split("\n")
    for _ in range(rng.randrange(1, 6)):
        at = rng.randrange(len(lines))
        action = rng.random()
        if action < 0.6:
            lines[at] = rng.choice(VALUES + CODES)
        elif action < 0.8:
            del lines[at : at + rng.randrange(1, 5)]
        else:
            lines[at:at] = rng.sample(lines, 4)
    return _damaged(rng, "\n".join(lines).encode("utf-8", "replace"))


def _damaged(rng: random.Random, content: bytes) -> bytes:
    action = rng.random()
    if action < 0.1:
        return rng.randbytes(rng.randrange(400))
    if action < 0.3:
        at = rng.randrange(len(content) + 1)
        return content[:at] + rng.randbytes(rng.randrange(1, 9)) + content[at:]
    if action < 0.4:
        return content[: rng.randrange(len(content) + 1)]
    return content


def _sound(version: str) -> str:
    document = ezdxf.new(version)
    space = document.modelspace()
    space.add_point((0.4, 0.3), dxfattribs={"layer": "GOUGE"})
    space.add_polyline2d([(3, -1), (5, -4)], dxfattribs={"layer": "SKID"})
    space.add_circle((3, -1), 1, dxfattribs={"layer": "SKID"})
    car = document.blocks.new("CAR")
    car.add_blockref("TWIN", (0, 0))
    document.blocks.new("TWIN").add_blockref("CAR", (0, 0))  # a circle of blocks
    space.add_blockref("CAR", (-4, 2), dxfattribs={"layer": "CAR_A", "rotation": 215})
    text = io.StringIO()
    document.write(text)
    return text.getvalue()


_SOUND = [_sound("R12"), _sound("R2010")]
