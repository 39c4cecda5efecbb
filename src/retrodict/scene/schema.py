"""The scene file as it may be written: its tables, and the conditions between them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo, model_validator

from retrodict.scene.entries.impact import (
    BarrierEntry,
    ImpactEntry,
    SlopeEntry,
    SurfaceEntry,
    SurfaceName,
)
from retrodict.scene.entries.priors import PriorsEntry
from retrodict.scene.entries.questions import QuestionsEntry
from retrodict.scene.entries.table import Note, Table, Title
from retrodict.scene.entries.vehicle import VehiclesEntry
from retrodict.scene.errors import shown
from retrodict.scene.kinds import fault
from retrodict.scene.names import vehicle_of
from retrodict.scene.quantities import UNKNOWNS


def _asked(raw: object) -> tuple[str, ...]:
    names = ", ".join(f'"{name}"' for name in UNKNOWNS)
    if not isinstance(raw, list) or not raw:
        raise fault(f'write a list of what is asked, like ["speed_b"], of {names}')
    for name in raw:
        if name not in UNKNOWNS:
            raise fault(f"{shown(name)} cannot be asked; write one or more of {names}")
    return tuple(name for name in UNKNOWNS if name in raw)


_ROAD = '{ road = { friction = "0.50 ± 0.03" } }'


def _one_without_end(
    surfaces: dict[str, SurfaceEntry], info: ValidationInfo
) -> dict[str, SurfaceEntry]:
    """Check that there is one road; a surface of a skid up to the impact need not lie anywhere."""
    slid_on = (info.context or {}).get("slid_on", set())
    bare = [name for name, surface in surfaces.items() if not (surface.edge or surface.outline)]
    if len([name for name in bare if name not in slid_on] or bare[:1]) != 1:
        found = f"{', '.join(bare)} have none" if bare else "here none is without"
        raise fault(f"write an edge or outline for every surface but one, the road; {found}")
    return surfaces


class SceneEntry(Table):
    """The whole scene file."""

    schema_version: int = Field(alias="schema", strict=True, ge=1, le=1, examples=["1"])
    title: Title = Field(examples=['"Two cars on a bend"'])
    notes: list[Note] = Field([], max_length=50, examples=['["one remark", "another"]'])
    question: Annotated[tuple[str, ...], BeforeValidator(_asked)] = Field(
        (), examples=['["speed_b"]']
    )
    errors: Literal["normal", "robust"] = Field("normal", examples=['"robust", or "normal"'])
    vehicles: VehiclesEntry = Field(examples=["{ A = { … }, B = { … } }"])
    barrier: BarrierEntry | None = Field(None, examples=['{ kind = "wall" }'])
    alone: bool = Field(default=False, strict=True, examples=["true"])
    impact: ImpactEntry = Field(
        ImpactEntry.model_validate({}),
        examples=['{ point = ["0 ± 0.3 m", "0 ± 0.3 m"], contact_line = "-8.9 ± 3 deg" }'],
    )
    surfaces: Annotated[dict[SurfaceName, SurfaceEntry], AfterValidator(_one_without_end)] = Field(
        {}, max_length=20, examples=[_ROAD]
    )
    slope: SlopeEntry | None = Field(
        None, examples=['{ grade = "4 ± 0.5 %", uphill = "90 ± 5 deg" }']
    )
    priors: PriorsEntry = Field(PriorsEntry(), examples=["{ speed_b = { … } }"])
    questions: QuestionsEntry = Field(
        QuestionsEntry(), examples=['{ exceeds = "speed_b > 45 mph" }']
    )

    @model_validator(mode="after")
    def _what_slid_slid_on_something(self) -> SceneEntry:
        slid = any(
            v.rest or v.on_way or v.approach.marked for v in self.vehicles.by_letter.values()
        )
        if slid and not self.surfaces:
            raise fault(f"missing; write surfaces = {_ROAD}", "surfaces")
        return self

    @model_validator(mode="after")
    def _one_alone_strikes_nothing(self) -> SceneEntry:
        if not self.alone:
            return self
        if self.barrier:
            raise fault("the vehicle struck a barrier, or nothing; leave one of them out", "alone")
        if "impact" in self.model_fields_set:
            raise fault("a vehicle that struck nothing has none; leave it out, or alone", "impact")
        own = self.vehicles.A
        if own.departure or own.impact_centre:
            key = "departure" if own.departure else "impact_centre"
            raise fault("there was no impact; leave it out, or alone", f"vehicles.A.{key}")
        if wrong := [name for name in self.question if name != "speed_a"]:
            raise fault(f'{wrong[0]} has no meaning; write question = ["speed_a"]', "question")
        return self

    @model_validator(mode="after")
    def _a_barrier_is_asked_nothing(self) -> SceneEntry:
        if self.vehicles.B is not None:
            return self
        still = f"a scene with {'a barrier' if self.barrier else 'one vehicle'} has no vehicle B"
        if "speed_b" in self.question:
            raise fault(f'{still}; write question = ["speed_a"]', "question")
        for prior in ("speed_b", "omega_b"):
            if getattr(self.priors, prior) is not None:
                raise fault(f"{still}; leave this prior out", f"priors.{prior}")
        asked = self.questions
        for key, propositions in (
            ("exceeds", asked.exceeds),
            ("between", asked.between),
            ("likelihood_ratio", [each.first for each in asked.likelihood_ratio]),
        ):
            if any(vehicle_of(name) == "b" for each in propositions for name in each.names):
                raise fault(f"{still}; ask it of A, as in speed_a", f"questions.{key}")
        if any(each.vehicle == "B" for each in asked.avoidable):
            raise fault(f'{still}; write vehicle = "A"', "questions.avoidable")
        if any(each.clear for each in asked.avoidable):
            raise fault("nothing clears the way; leave clear out", "questions.avoidable")
        if asked.corners:
            fix = f"the corner range is of B's speed, and {still}; leave it out"
            raise fault(fix, "questions.corners")
        return self


def validated(document: Mapping[str, Any]) -> SceneEntry:
    """The tables and keys of a scene file, validated; its vehicles know whether there is a barrier.

    Args:
        document: tables and keys of the file, as TOML reads them.

    Raises:
        ValidationError: something in it is wrong.
    """
    return SceneEntry.model_validate(
        document,
        context={
            "barrier": document.get("barrier") is not None,
            "alone": document.get("alone") is True,
            "slid_on": _slid_on(document),
        },
    )


def _slid_on(document: Mapping[str, Any]) -> set[str]:
    """Names of the surfaces that skids and yaw marks state, in a file not yet validated."""
    found: set[str] = set()

    def look(part: object, key: str) -> None:
        if isinstance(part, Mapping):
            for name, each in part.items():
                look(each, str(name))
        elif isinstance(part, list):
            for each in part:
                look(each, key)
        elif key == "surface" and isinstance(part, str):
            found.add(part)

    look(document.get("vehicles"), "vehicles")
    return found
