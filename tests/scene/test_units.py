"""Quantities as people write them, against numbers known from elsewhere."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retrodict.scene import units
from retrodict.scene.units import QuantityError, read_quantity

# NIST SP 811 appendix B, and the mile, pound and foot as defined in 1959
CONVERSIONS = [
    ("45 mph", units.SPEED, 20.1168),
    ("63.2 ft/s", units.SPEED, 19.26336),
    ("63.2 fps", units.SPEED, 19.26336),
    ("72 km/h", units.SPEED, 20.0),
    ("72 kph", units.SPEED, 20.0),
    ("36 kmph", units.SPEED, 10.0),  # to pint a kilo-mph
    ("36 KM/H", units.SPEED, 10.0),
    ("5' 1.5\"", units.LENGTH, 1.5621),
    ("5′ 1.5″", units.LENGTH, 1.5621),
    ("5 ft 1.5 in", units.LENGTH, 1.5621),
    ("5 ft 1.5 in ± 1 in", units.LENGTH, 1.5621),
    ("5' 1 1/2\"", units.LENGTH, 1.5621),
    ("9 1/2 ft", units.LENGTH, 2.8956),
    ("3937 ftUS", units.LENGTH, 1200.0),  # by definition
    ("3937 US survey ft", units.LENGTH, 1200.0),
    ("–0.155\u00a0rad", units.ANGLE, -0.155),
    ("45°30'", units.ANGLE, math.radians(45.5)),
    ("-45° 30' 36\"", units.ANGLE, -math.radians(45.51)),
    ("12 deg 15' ± 1 deg", units.ANGLE, math.radians(12.25)),
    ("0.5 rad s-1", units.YAW_RATE, 0.5),
    ("1e-5 m", units.LENGTH, 1e-5),
    ("19.3 m/s", units.SPEED, 19.3),
    ("4094 lb", units.MASS, 1857.00716),
    ("2 lbs", units.MASS, 0.90718474),
    ("1857 kg", units.MASS, 1857.0),
    ("9 ft", units.LENGTH, 2.7432),
    ("60.6 in", units.LENGTH, 1.53924),
    ("180 deg", units.ANGLE, math.pi),
    ("180°", units.ANGLE, math.pi),
    ("-0.155 rad", units.ANGLE, -0.155),
    ("565 deg/s", units.YAW_RATE, 9.861110),
    ("60 rpm", units.YAW_RATE, 2 * math.pi),
    ("2000 lb ft s^2", units.INERTIA, 2711.6359),
    ("2000 lb·ft·s²", units.INERTIA, 2711.6359),
    ("2000 lb-ft-s^2", units.INERTIA, 2711.6359),
    ("2000 lbf*ft*s**2", units.INERTIA, 2711.6359),
    ("2000 slug ft^2", units.INERTIA, 2711.6359),
    ("80000 lb ft^2", units.INERTIA, 3371.2088),  # here a pound of mass
    ("3374 kg·m²", units.INERTIA, 3374.0),
    ("3374 kg m2", units.INERTIA, 3374.0),
    ("0.002 s/m", units.INVERSE_SPEED, 0.002),
    ("0.001 1/mph", units.INVERSE_SPEED, 0.0022369363),
    ("1.5 s", units.TIME, 1.5),
    ("0.7 g", units.DECELERATION, 6.864655),
    ("20 ft/s²", units.DECELERATION, 6.096),
    ("100 kJ", units.ENERGY, 1e5),
    ("1000 ft lbf", units.ENERGY, 1355.8179),
    ("1000 ft lb", units.ENERGY, 1355.8179),  # here a pound of force
    ("1000 ft-lb", units.ENERGY, 1355.8179),
    ("0.5", units.NUMBER, 0.5),
]


@pytest.mark.parametrize(("text", "dimension", "si"), CONVERSIONS)
def test_units_are_worth_what_the_standards_say(text, dimension, si):
    assert read_quantity(text, dimension, "").value == pytest.approx(si, rel=1e-7)


@pytest.mark.parametrize(
    "text",
    [
        "21 to 24 mph",
        "21 mph to 24 mph",
        "21–24 mph",
        "21 mph – 24 mph",
        "21-24 mph",
        "21 mph - 24 mph",
    ],
)
def test_a_range_is_uniform_in_between_and_says_so(text):
    found = read_quantity(text, units.SPEED, "")
    assert found.value == pytest.approx(22.5 * 0.44704)
    assert found.sd == pytest.approx(3 / math.sqrt(12) * 0.44704)
    assert "read as uniform in between" in found.source


@pytest.mark.parametrize("text", ["24 to 21 mph", "24-21 mph", "21 to 24", "21-24", "21 to 24 kg"])
def test_a_range_that_is_none_is_refused(text):
    with pytest.raises(QuantityError):
        read_quantity(text, units.SPEED, "")


def test_suggested_units_are_worth_what_pint_says():
    dimensions = [d for d in vars(units).values() if isinstance(d, units.Dimension)]
    assert {unit for d in dimensions for unit in d.units} == set(units._WORTH)
    for dimension in dimensions:
        for unit in dimension.units:
            # there a force, and the acceleration of gravity
            name = unit.replace("lb ft s", "lbf ft s").replace("%", "percent")
            by_pint, base = units._base("gravity" if unit == "g" else name)
            assert units._WORTH[unit] == pytest.approx(by_pint, rel=1e-15), unit
            assert base == units._base(dimension.units[0].replace("%", "percent"))[1], unit


def test_a_share_is_per_cent():
    assert read_quantity("4 %", units.SHARE, "").value == pytest.approx(0.04)
    both = read_quantity("4 ± 1 %", units.SHARE, "")
    assert (both.value, both.sd) == pytest.approx((0.04, 0.01))
    with pytest.raises(units.QuantityError, match=r'write "4 %"$'):
        read_quantity(4, units.SHARE, "")


@pytest.mark.parametrize(
    ("text", "dimension"),
    [("45 mph", units.SPEED), ("3374 kg m²", units.INERTIA), ("180°", units.ANGLE)],
)
def test_suggested_units_do_not_wait_for_pint(text, dimension, monkeypatch):
    monkeypatch.setattr(units, "_base", None)
    read_quantity(text, dimension, "")


SPELLINGS = [
    ("45 ± 2 mph", 45, 2),
    ("45±2mph", 45, 2),
    ("45 +/- 2 mph", 45, 2),
    ("45 +- 2 mph", 45, 2),
    ("45 mph ± 2 mph", 45, 2),
    ("45 mph ± 2", 45, 2),
    ("45 mph ± 1.7600 ft/s", 45, 1.2),
    ("45 mph ± 10 %", 45, 4.5),
    ("45 ± 10% mph", 45, 4.5),
    ("  45\u00a0±  2\tmph ", 45, 2),
    ("−45 ± 2 mph", -45, 2),
    ("-45 mph ± 10 %", -45, 4.5),
    ("4.5e1 ± .2E1 mph", 45, 2),
    ("45. mph", 45, None),
    ({"value": 45, "sd": 2, "unit": "mph"}, 45, 2),
    ({"value": 45.0, "unit": "mph"}, 45, None),
]


@pytest.mark.parametrize(("raw", "value", "sd"), SPELLINGS)
def test_every_spelling_reads_alike(raw, value, sd):
    reading = read_quantity(raw, units.SPEED, "")
    assert reading.value == pytest.approx(value * 0.44704)
    assert reading.sd == (None if sd is None else pytest.approx(sd * 0.44704))


def test_a_table_keeps_its_source():
    raw = {"value": 0.5, "sd": 0.03, "source": "skid tests"}
    assert read_quantity(raw, units.NUMBER, "") == units.Reading(0.5, 0.03, "skid tests")


@pytest.mark.parametrize(
    ("text", "angle", "sd"),
    [
        ("N 45° E", 45, None),
        ("N 30 E ± 2 deg", 60, 2),
        ("N 30° W", 120, None),
        ("s 30 deg e", -60, None),
        ("S30W", -120, None),
        ("SW", -135, None),
        ("due north ± 3 deg", 90, 3),
        ("West", 180, None),
        ("bearing 135°", -45, None),
        ("bearing 350 deg ± 5 deg", 100, 5),
        ("45 ± 2 deg", 45, 2),
    ],
)
def test_directions_may_be_compass_bearings_where_y_is_north(text, angle, sd):
    reading = read_quantity(text, units.DIRECTION, "")
    assert reading.value == pytest.approx(math.radians(angle))
    assert reading.sd == (None if sd is None else pytest.approx(math.radians(sd)))


WORDS = ["45", "-2.5", "1e400", "±", "5 %", "mph", "deg", "to", "at most", "about", "N"]
WORDS += ["bearing", "north", "\x1b[2J", "\n", "\u2028", "\x9b", "°", "²", "{0}", "__class__"]
DIMENSIONS = [units.SPEED, units.ANGLE, units.DIRECTION, units.NUMBER, units.SHARE]


@settings(max_examples=2000, deadline=None)
@given(
    st.lists(st.sampled_from(WORDS) | st.text(max_size=4), max_size=8).map(" ".join),
    st.sampled_from(DIMENSIONS),
)
def test_any_text_is_a_quantity_or_refused_in_one_line(text, dimension):
    try:
        said = read_quantity(text, dimension, "45 ± 2 mph").source
    except QuantityError as error:
        said = error.fix
    assert said.isprintable()


REFUSED = [
    ("45", units.SPEED, 'write "45 m/s"'),
    ("45 ± 2", units.SPEED, 'write "45 ± 2 m/s"'),
    (45, units.SPEED, 'write "45 m/s" (or in km/h, mph or ft/s)'),
    ("45 kg", units.SPEED, '"kg" does not measure a speed'),
    ("20 degC", units.SPEED, "does not measure a speed"),
    ("45 mhp", units.SPEED, 'did you mean "mph"'),
    ("45 wibble", units.SPEED, "unknown unit"),
    ("45 ± 2 mph ± 3 mph", units.SPEED, "not a quantity"),
    ("45 mph ± 2 kg", units.SPEED, '"kg" does not measure a speed'),
    ("45 - 2 mph", units.SPEED, "a range begins with its smaller end"),
    ("45 mph - 2", units.SPEED, "a range begins with its smaller end"),
    ("N 45° E", units.ANGLE, "a compass bearing, where an angle counter-clockwise from something"),
    ("N 95 E", units.DIRECTION, "at most 90 deg from north or south"),
    ("bearing of 90 deg", units.DIRECTION, "not a quantity"),
    ("north-east", units.DIRECTION, "not a quantity"),
    ("NE", units.SPEED, "not a quantity"),
    ("at most 40 mph", units.SPEED, 'a bound; write it as a range, like "0 to 40 mph"'),
    ("> 40 mph", units.SPEED, "a range with its upper end"),
    ("about 40 mph", units.SPEED, 'one standard deviation: "40 mph ± …"'),
    ("some 40 mph", units.SPEED, "not a quantity"),
    ("at least 40 \x1b[2J", units.SPEED, "not a quantity"),
    ("0.7 g", units.NUMBER, "without a unit"),
    ("1,35 m", units.LENGTH, "decimal point"),
    ("1,857 kg", units.MASS, "decimal point"),
    ("nan mph", units.SPEED, "not a quantity"),
    ("1e999 mph", units.SPEED, "not a finite number"),
    ("45 ± 1e999 mph", units.SPEED, "above 0"),
    ("45 ± 0 mph", units.SPEED, "above 0"),
    ("45 ± -2 mph", units.SPEED, "above 0"),
    ("0 ± 5 % mph", units.SPEED, "above 0"),
    ("45 mph mph mph mph mph mph mph mph mph mph mph", units.SPEED, "not a quantity"),
    ("4" * 5000 + " mph", units.SPEED, "not a quantity"),
    ("٤٥ mph", units.SPEED, "not a quantity"),
    ("", units.SPEED, "not a quantity"),
    (True, units.NUMBER, "not a quantity"),
    ([45], units.SPEED, "not a quantity"),
    (10**400, units.NUMBER, "not a finite number"),
    ("0.5 m", units.NUMBER, "without a unit"),
    ("4000 lbf", units.MASS, 'pounds of mass are "lb"'),
    ("10 percent", units.ANGLE, "does not measure an angle"),
    ("1 Hz", units.YAW_RATE, "does not measure a yaw rate"),
    ("1 1/s", units.YAW_RATE, "does not measure a yaw rate"),
    ("5 kg rad", units.MASS, "does not measure a mass"),
    ("3374 kg m s^2", units.INERTIA, "does not measure a yaw inertia"),
    ({"value": 45}, units.SPEED, 'add unit = "m/s"'),
    ({"sd": 45}, units.SPEED, "no value"),
    ({"value": "45 mph"}, units.SPEED, "without quotes"),
    ({"value": 45, "unit": "mph", "sigma": 2}, units.SPEED, 'one standard deviation is "sd"'),
    ({"value": 45, "unit": "mph", "vlaue": 2}, units.SPEED, 'did you mean "value"'),
    ({"value": 45, "unit": "mph", "source": "a\x1b[2J"}, units.SPEED, "one short line"),
    ({"value": math.nan, "unit": "mph"}, units.SPEED, "not a finite number"),
    ({"value": 45, "sd": math.nan, "unit": "mph"}, units.SPEED, "above 0"),
]


@pytest.mark.parametrize(("raw", "dimension", "fix"), REFUSED)
def test_what_cannot_be_read_says_what_to_write(raw, dimension, fix):
    with pytest.raises(QuantityError) as caught:
        read_quantity(raw, dimension, "45 ± 2 mph")
    assert fix in caught.value.fix


DANGEROUS = [
    "9**9**9**9 m",
    "1 m^9999999999",
    "1 m**2**2**2**2",
    "1 (m)",
    "1 m.__class__",
    "1 __import__",
    "1 9**9",
    "1 m; import os",
    "1 [length]",
    "1 m m m m m m m m m m m m m m m m m m m m m",
]


@pytest.mark.parametrize("text", DANGEROUS)
def test_nothing_but_a_plain_unit_reaches_pint(text, monkeypatch):
    def reached() -> None:
        raise AssertionError("pint was asked")

    monkeypatch.setattr(units, "_registry", reached)
    with pytest.raises(QuantityError):
        read_quantity(text, units.LENGTH, "1 m")
