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


WORDS = [
    "SNA", "Invalid", "N/A", "22 [35]", "22 [99]", "1 [SNA]", "[", "22 [", "47 mph", "1/2", "10+25.50",
    "10+2", "+", "10+25.50, 12.3 R", "12.3 R", "R", "12.3' L", "8' 9\" L", "-3 R", "L R", "١٢ R",
    "42°19'53.8\" N", "-83.04575", "83 62 1 W", "N", "°", "91", "42.33 E", "N S", "1e308 R",
    "9" * 30 + "+00", "km/h", "mph", "furlong", "Speed", "Event 1", "1",
]  # fmt: skip


def character_set(rng: random.Random) -> bytes:
    """Something like points as CSV, in any character set, or how a file of an instrument begins."""
    lines = [rng.choice(["Vermessung Süd; été", "110001+00000001 21.322", "JB,NM", "<?xml?><gpx "])]
    lines = [*rng.choice([[], [], [], lines]), rng.choice(HEADERS) + rng.choice(["", ",höhe"])]
    lines += ["7,1,2,Straße", *(rng.choice([*CELLS, "début", "°", "’", "ñ"]) for _ in range(4))]
    text = rng.choice(["\n", "\r\n"]).join(lines)
    names = [
        "cp1252",
        "cp1251",
        "cp1250",
        "mac-roman",
        "cp850",
        "shift_jis",
        "gb18030",
        "utf-16-le",
    ]
    return _damaged(rng, text.encode(rng.choice(names), errors="replace"))


def report(rng: random.Random) -> bytes:
    """Something like a recorder's table as copied from a report."""
    heading = rng.choice(["Speed (MPH [km/h])", "Speed (mph)", "Speed (km/h / mph)", "Speed ([(])"])
    lines = ["Report, of a recorder", "Event 1", f"Time,{heading}", "-1,45 [72]", "0,34 [55]"]
    for _ in range(rng.randrange(3)):
        at = rng.randrange(len(lines) + 1)
        lines[at:at] = [rng.choice([*lines, *WORDS, f"0,{rng.choice(WORDS)}", "Event 1"])]
    return _table(rng, lines, WORDS, ",")


def values_in_rows(rng: random.Random) -> bytes:
    """Something like a recorder's table with a row for each value."""
    lines = ["Event,What,Time,Value,Unit", "1,Speed,-1,20,m/s", "1,Speed,0,15,m/s"]
    lines += [
        ",".join(
            [rng.choice(["1", "2"]), rng.choice(["Speed", "Brake", "a"]), *rng.choices(WORDS, k=3)]
        )
        for _ in range(rng.randrange(3))
    ]
    rng.shuffle(lines) if rng.random() < 0.3 else None
    return _table(rng, lines, WORDS, ",")


def degrees(rng: random.Random) -> bytes:
    """Something like points by latitude and longitude."""
    lines = [rng.choice(["id,Latitude,Longitude", "id,x,y"]), "7,42.33141,-83.04575"]
    lines += [f"{rng.choice('789')},{rng.choice(WORDS)},{rng.choice(WORDS)}" for _ in range(3)]
    return _table(rng, lines, WORDS, ",")


def stations(rng: random.Random) -> bytes:
    """Something like points by stations and offsets."""
    lines = ["id,Station,Offset", rng.choice(["7,10+25.50,12.3 R", f"7,{rng.choice(WORDS)},1 L"])]
    lines += [f"8,{rng.choice(WORDS)},{rng.choice(WORDS)}" for _ in range(3)]
    return _table(rng, lines, WORDS, ",")


TAGS = [
    "<CgPoint>", "</CgPoint>", '<CgPoint name="7">', "<CgPoints>", "</CgPoints>", "1 2", "1e999 2 3",
    "<!DOCTYPE a [<!ENTITY b 'b'>]>", "<!DOCTYPE a SYSTEM 'file:///etc/hostname'>", "&b;", "&#0;",
    '<Units><Imperial linearUnit="foot"/></Units>', "<Metric linearUnit=''/>", "<![CDATA[1 2]]>",
    "<?a?>", "<!-- -->", "\x00", "<a:b/>", '<CgPoint name="9" code="">nan 1</CgPoint>', "<" * 40,
    "<a>" * 3000,
]  # fmt: skip


def landxml(rng: random.Random) -> bytes:
    """Something like LandXML."""
    lines = [
        rng.choice(['<?xml version="1.0"?>', '<?xml version="1.0" encoding="utf-7"?>', ""]),
        '<LandXML xmlns="http://www.landxml.org/schema/LandXML-1.2">',
        '<Units><Metric linearUnit="meter"/></Units><CgPoints>',
        '<CgPoint name="7" code="é">2.5 1.5 0</CgPoint>',
        "</CgPoints></LandXML>",
    ]
    for _ in range(rng.randrange(3)):
        at = rng.randrange(len(lines) + 1)
        lines[at : at + rng.randrange(2)] = [rng.choice(TAGS)]
    encoding = rng.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "cp1252"])
    return _damaged(rng, "\n".join(lines).encode(encoding, errors="replace"))


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


def _table(
    rng: random.Random, lines: list[str], cells: list[str] | None = None, separator: str = ""
) -> bytes:
    separator = separator or rng.choice(",;\t|")
    lines += [
        separator.join(rng.choice(cells or CELLS) for _ in range(rng.randrange(6)))
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
