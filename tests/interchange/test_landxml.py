"""Coordinate points of LandXML."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.interchange.test_survey import imported, refusal

# as office programs write it: northing before easting
FILE = """\
<?xml version="1.0" encoding="UTF-8"?>
<LandXML xmlns="http://www.landxml.org/schema/LandXML-1.2" version="1.2" date="2024-05-03">
  <Units><Imperial areaUnit="squareFoot" linearUnit="USSurveyFoot" volumeUnit="cubicYard"/></Units>
  <CgPoints>
    <CgPoint name="1" code="ORIGIN">642755.000 1482310.000 131.40</CgPoint>
    <CgPoint name="7" code="GOUGE" desc="gouge &amp; scratch">642757.500 1482311.500 131.40</CgPoint>
    <CgPoint name="8" code="SKID">642750 1482300</CgPoint>
    <CgPoint name="9" code="SKID">642740 1482300 131</CgPoint>
    <CgPoint name="10">642740</CgPoint>
  </CgPoints>
  <PlanFeatures><PlanFeature><CoordGeom><Line><Start pntRef="1"/></Line></CoordGeom>
    <CgPoint pntRef="7"/></PlanFeature></PlanFeatures>
  <Surfaces><Surface><Definition><Pnts><P id="1">1 2 3</P><P id="2">1 2 3</P></Pnts></Definition>
  </Surface></Surfaces>
</LandXML>
"""
MAP = """
[landxml]
unit = "ftUS"
precision = "0.02 m"
origin = "ORIGIN"
[impact_point]
point = "GOUGE"
uncertainty = "0.1 m"
[[marks.A]]
points = ["SKID"]
of = "rear_left"
uncertainty = "0.1 m"
"""
FOOT = 1200 / 3937


def test_points_are_taken_by_name_and_code(tmp_path: Path) -> None:
    found = imported(tmp_path, FILE, MAP, "points.xml")
    contact = found.scene.contact
    assert (contact.x.value, contact.y.value) == pytest.approx((1.5 * FOOT, 2.5 * FOOT), abs=1e-4)
    assert contact.x.source.startswith("points.xml, point 7, CgPoint 2; SHA-256 ")
    assert [(mark.x, mark.y) for mark in found.scene.marks["a"]] == [
        pytest.approx((-10 * FOOT, -5 * FOOT), abs=1e-4),
        pytest.approx((-10 * FOOT, -15 * FOOT), abs=1e-4),
    ]
    assert "2 P: places are taken of CgPoint" in found.left
    assert 'point "10", CgPoint 5: has no northing and easting' in found.left


def test_other_versions_and_axes_are_read(tmp_path: Path) -> None:
    old = FILE.replace("LandXML-1.2", "LandXML-1.0")
    turned = MAP.replace('"ftUS"', '"ftUS"\naxes = ["south", "east"]')
    contact = imported(tmp_path, old, turned, "points.xml").scene.contact
    assert (contact.x.value, contact.y.value) == pytest.approx((2.5 * FOOT, -1.5 * FOOT), abs=1e-4)


@pytest.mark.parametrize(
    ("content", "map_text", "said"),
    [
        (FILE, MAP.replace("ftUS", "ft"), 'linearUnit = "USSurveyFoot": its unit is not that of the '
            'map; write unit = "ftUS"'),
        (FILE.replace("</CgPoints>", ""), MAP, "line 15: not XML that can be read"),
        (FILE.replace("LandXML", "Other"), MAP, "is XML, but not LandXML"),
        (FILE.replace("CgPoint ", "Point ").replace("/CgPoint>", "/Point>"), MAP, "has no CgPoint"),
        ("id,x,y\n7,1,2\n", MAP, "line 1: not XML that can be read"),
        (FILE.replace('encoding="UTF-8"', 'encoding="klingon"'), MAP, "points.xml: "),
        (FILE, MAP.replace("[landxml]", "[survey]\naxes = [\"east\", \"north\"]\ncolumns = "
            '{ id = "id", x = "x", y = "y" }'), "is LandXML; write its table in the map as [landxml]"),
    ],
)  # fmt: skip
def test_what_is_not_landxml_is_refused(
    tmp_path: Path, content: str, map_text: str, said: str
) -> None:
    assert said in refusal(tmp_path, content, map_text, "points.xml")


@pytest.mark.parametrize(
    "declared",
    [
        '<!DOCTYPE LandXML [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>',
        '<!DOCTYPE LandXML [<!ENTITY a SYSTEM "file:///etc/hostname">]>',
        '<!DOCTYPE LandXML SYSTEM "http://127.0.0.1/LandXML.dtd">',
    ],
)
def test_no_entity_is_declared_and_nothing_fetched(tmp_path: Path, declared: str) -> None:
    content = FILE.replace("<LandXML", f"{declared}<LandXML", 1).replace("ORIGIN", "&a;", 1)
    assert "its document type" in refusal(tmp_path, content, MAP, "points.xml")
