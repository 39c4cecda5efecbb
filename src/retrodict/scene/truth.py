"""True values of a staged collision, and reconstructions of it by others: the file truth.toml."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, Field, model_validator

from retrodict.scene import units
from retrodict.scene.entries.table import Note, Table, Title, one_line
from retrodict.scene.explain import entries_of
from retrodict.scene.kinds import Kind, fault
from retrodict.scene.load import read_text, toml_of
from retrodict.scene.records import Measured

SPEEDS = ("speed_a", "speed_b")


@dataclass(frozen=True, slots=True)
class Published:
    """Published result of somebody else's reconstruction of the collision.

    Args:
        name: name of the program or the author.
        speeds: reconstructed speeds, m/s, by name, speed_a or speed_b.
        source: publication that has the result.
    """

    name: str
    speeds: dict[str, float]
    source: str


@dataclass(frozen=True, slots=True)
class Truth:
    """True values that a reconstruction is scored by and must not know.

    Args:
        speeds: true speeds before impact, by name, m/s, each with its source.
        published: reconstructions of others.
        note: a remark; empty where there is none.
        groups: groups that the case is counted with: a label by the group's name.
    """

    speeds: dict[str, Measured]
    published: tuple[Published, ...] = ()
    note: str = ""
    groups: dict[str, str] = field(default_factory=dict)


def load_truth(path: str | Path) -> Truth:
    """The truth from a truth file.

    Args:
        path: a TOML file; its keys are described in docs/validation.md.

    Returns:
        The truth in SI units.

    Raises:
        SceneError: the file cannot be read, or something in it is wrong.
    """
    entry = entries_of(_TruthEntry, toml_of(read_text(path), str(path)), str(path))
    published = tuple(
        Published(each.name, {k: m.value for k, m in each.speeds().items()}, each.source)
        for each in entry.published
    )
    return Truth(entry.speeds(), published, entry.note, dict(entry.groups))


def _sourced(speed: Measured) -> Measured:
    if not speed.source:
        raise fault(f"no source is given; write {_EXAMPLE}")
    return speed


_EXAMPLE = '{ value = 9.6, unit = "m/s", source = "…" }'
_SPEED = Kind(
    units.SPEED, 0, 150, "9.6 m/s", uncertainty="refused", advice="it is compared with, as it is"
)
_MOST_GROUPS = 8
_OWN = ("kind", "wheels")  # groups that follow from the scene
_Label = Annotated[str, one_line(40)]


def _few(groups: dict[str, str]) -> dict[str, str]:
    if len(groups) > _MOST_GROUPS:
        raise fault(f"{len(groups)} groups; write at most {_MOST_GROUPS}")
    for name in _OWN:
        if name in groups:
            raise fault("it follows from the scene; leave it out", name)
    return groups


_TrueSpeed = Annotated[Measured, _SPEED, AfterValidator(_sourced)]
_Speed = Annotated[Measured, _SPEED]


class _Entry(Table):
    @model_validator(mode="after")
    def _has_a_speed(self) -> _Entry:
        if not self.speeds():
            raise fault(f"no speed is given; write {_EXAMPLE}", "speed_b")
        return self

    def speeds(self) -> dict[str, Measured]:
        """The speeds that are written, by name."""
        found = {name: getattr(self, name) for name in SPEEDS}
        return {name: speed for name, speed in found.items() if speed is not None}


class _PublishedEntry(_Entry):
    """An entry of `published`."""

    name: Title = Field(examples=['"a program"'])
    speed_a: _Speed | None = None
    speed_b: _Speed | None = None
    source: Title = Field(examples=['"author, year, table"'])


class _TruthEntry(_Entry):
    """The whole truth file."""

    speed_a: _TrueSpeed | None = Field(None, examples=[_EXAMPLE])
    speed_b: _TrueSpeed | None = Field(None, examples=[_EXAMPLE])
    published: list[_PublishedEntry] = Field(
        [], examples=['[{ name = "a program", speed_a = "10.7 m/s", source = "…" }]']
    )
    note: Note = Field("", examples=['"one line"'])
    groups: Annotated[dict[_Label, _Label], AfterValidator(_few)] = Field(
        {}, examples=['{ face = "rigid" }']
    )
