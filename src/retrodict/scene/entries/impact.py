"""The entries of the impact and its surroundings: barrier, contact, surfaces, slope."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from retrodict.scene import units
from retrodict.scene.defaults import DEFAULTS, FRICTION
from retrodict.scene.energy import CLASS_STIFFNESS_ERROR
from retrodict.scene.entries.table import (
    FOR_DRAWING,
    FROM_ORIGIN,
    IS_AN_SD,
    Table,
    one_line,
    with_fields,
)
from retrodict.scene.fields import COEFFICIENTS, IMPACT, SLOPE, SURFACE
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.measured import Measured
from retrodict.scene.outlines import outline_fault

_EDGE = "that of the edge goes into its key uncertainty"
_OF_CORNERS = "that of the outline goes into its key uncertainty"
PoleDiameter = Annotated[
    Measured, Kind(units.LENGTH, 0.02, 10, "0.3 m", uncertainty="refused", advice=FOR_DRAWING)
]
ImpactCoordinate = Annotated[
    Measured,
    Kind(
        units.LENGTH, -1000, 1000, "0 ± 0.3 m", default=DEFAULTS["impact_point"], advice=FROM_ORIGIN
    ),
]
EnergyLost = Annotated[
    Measured,
    Kind(
        units.ENERGY,
        0,
        1e8,
        "60 ± 25 kJ",
        uncertainty="required",
        advice=f"from crush and stiffness by class it is {CLASS_STIFFNESS_ERROR:.0%} or more",
    ),
]
EdgeCoordinate = Annotated[
    Measured,
    Kind(units.LENGTH, -1000, 1000, "4 m", uncertainty="refused", advice=_EDGE),
]
EdgeDirection = Annotated[
    Measured,
    Kind(units.DIRECTION, -360, 360, "0 deg", uncertainty="refused", advice=_EDGE),
]
OutlineCoordinate = Annotated[
    Measured,
    Kind(units.LENGTH, -1000, 1000, "4 m", uncertainty="refused", advice=_OF_CORNERS),
]
EdgeUncertainty = Annotated[
    Measured,
    Kind(
        units.LENGTH,
        0.0001,
        100,
        "0.2 m",
        uncertainty="refused",
        advice=IS_AN_SD,
    ),
]


def _pattern_name(raw: object) -> str:
    name = str(raw)
    plain = name.isascii() and name.replace("_", "a").isalnum() and name.islower()
    if not plain or not name[0].isalpha() or len(name) > 40:
        raise fault("write a surface's name in lower case: letters, digits and _, a letter first")
    return name


def _known_surface(raw: object) -> object:
    if not isinstance(raw, str) or raw not in FRICTION:
        kinds = ", ".join(f'"{kind}"' for kind in FRICTION)
        raise fault(f"no friction is known for it; write one of {kinds}, or friction")
    return raw


def _together(raw: object) -> object:
    if not isinstance(raw, bool) and raw != "perhaps":
        raise fault('write true, false, or "perhaps" where nobody knows')
    return raw


SurfaceName = Annotated[str, BeforeValidator(_pattern_name)]


class BarrierEntry(Table):
    """`[barrier]`: the rigid and immovable barrier that vehicle A struck in place of a vehicle B."""

    kind: Literal["wall", "pole"] = Field(examples=['"wall" or "pole"'])
    name: Annotated[str, one_line(60)] | None = Field(None, examples=['"concrete wall"'])
    diameter: PoleDiameter | None = None

    @model_validator(mode="after")
    def _a_pole_is_round(self) -> BarrierEntry:
        if self.kind == "pole" and self.diameter is None:
            raise fault('missing; write diameter = "0.3 m"', "diameter")
        if self.kind == "wall" and self.diameter is not None:
            raise fault('a wall has none; leave it out, or write kind = "pole"', "diameter")
        return self


@with_fields(IMPACT | COEFFICIENTS)
class ImpactEntry(Table):
    """`[impact]`: where and along which line the vehicles touched, what was measured of the impact."""

    instead: ClassVar = {"energy_lost": ("energy_lost_at_least", "energy_lost_at_most")}
    point: tuple[ImpactCoordinate, ImpactCoordinate] | None = Field(
        None, examples=['["0 ± 0.3 m", "0 ± 0.3 m"]']
    )
    contact_line: Annotated[Measured, IMPACT["contact_line"]] | None = None
    interlocked: bool = Field(default=False, strict=True, examples=["true"])
    together: Annotated[bool | Literal["perhaps"], BeforeValidator(_together)] = Field(
        default=False, examples=['true, or "perhaps"']
    )
    energy_lost: EnergyLost | None = None
    energy_lost_at_least: EnergyLost | None = None
    energy_lost_at_most: EnergyLost | None = None

    @model_validator(mode="after")
    def _bounds_of_energy_are_in_order(self) -> ImpactEntry:
        least, most = self.energy_lost_at_least, self.energy_lost_at_most
        if least and most and least.value >= most.value:
            raise fault("not above energy_lost_at_least; exchange them", "energy_lost_at_most")
        return self


class EdgeEntry(Table):
    """`edge` of a surface: the straight line beyond which it lies."""

    point: tuple[EdgeCoordinate, EdgeCoordinate] = Field(examples=['["0 m", "4 m"]'])
    direction: EdgeDirection
    side: Literal["left", "right"] = Field(examples=['"left" or "right"'])
    uncertainty: EdgeUncertainty | None = None


def _around(corners: list[tuple[Measured, Measured]]) -> list[tuple[Measured, Measured]]:
    if wrong := outline_fault([(x.value, y.value) for x, y in corners]):
        raise fault(wrong)
    return corners


_CORNERS = '[["2 m", "-3 m"], ["6 m", "-3 m"], ["6 m", "1 m"]]'


class OutlineEntry(Table):
    """`outline` of a surface: the corners that it lies between."""

    corners: Annotated[
        list[tuple[OutlineCoordinate, OutlineCoordinate]], AfterValidator(_around)
    ] = Field(examples=[_CORNERS])
    uncertainty: EdgeUncertainty | None = None


@with_fields(SURFACE)
class SurfaceEntry(Table):
    """`[surfaces.NAME]`: a surface that the vehicles slid over."""

    kind: Annotated[str, BeforeValidator(_known_surface)] | None = Field(
        None, examples=['"dry asphalt"']
    )
    friction: Annotated[Measured, SURFACE["friction"]] | None = None
    edge: EdgeEntry | None = Field(
        default=None, examples=['{ point = ["0 m", "4 m"], direction = "0 deg", side = "left" }']
    )
    outline: OutlineEntry | None = Field(default=None, examples=[f"{{ corners = {_CORNERS} }}"])

    @model_validator(mode="after")
    def _friction_is_known(self) -> SurfaceEntry:
        if self.friction is None and self.kind is None:
            fix = 'missing; write friction = "0.50 ± 0.03", or kind = "dry asphalt"'
            raise fault(fix, "friction")
        return self

    @model_validator(mode="after")
    def _ends_in_one_way(self) -> SurfaceEntry:
        if self.edge and self.outline:
            raise fault("the surface ends twice; keep it, or edge", "outline")
        return self


@with_fields(SLOPE)
class SlopeEntry(Table):
    """`[slope]`: how steeply the whole ground rises, and in which direction."""
