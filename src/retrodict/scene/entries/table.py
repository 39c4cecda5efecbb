"""Base of all tables of a scene file: declared quantities, texts of one line, and no other keys."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar

import pydantic
from pydantic import BaseModel, BeforeValidator, ConfigDict, create_model, model_validator

from retrodict.scene.fields import Evidence, Field
from retrodict.scene.kinds import fault
from retrodict.scene.measured import Measured

# advice of several quantities
FOR_DRAWING = "it is for drawing"
FROM_ORIGIN = "count from an origin near the impact"
IS_AN_SD = "it is itself one standard deviation"


class Table(BaseModel):
    """A table of a scene file, with these keys and no others."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    needs: ClassVar[dict[str, str]] = {}  # key -> key without which the first says nothing
    instead: ClassVar[dict[str, tuple[str, ...]]] = {}  # key -> keys that say the same

    @model_validator(mode="after")
    def _nothing_stands_alone(self) -> Table:
        for key, needed in self.needs.items():
            if getattr(self, key) is not None and getattr(self, needed) is None:
                raise fault(
                    f"it says something of {needed} alone; leave it out, or add {needed}", key
                )
        return self

    @model_validator(mode="after")
    def _nothing_stands_twice(self) -> Table:
        for key, others in self.instead.items():
            if getattr(self, key) and any(getattr(self, other) for other in others):
                raise fault(f"the same twice; keep it, or {' and '.join(others)}", key)
        return self


def with_fields[T: Table](fields: Mapping[str, Field]) -> Callable[[type[T]], type[T]]:
    """A decorator that adds to a table the quantities of `scene.fields` that the table does not declare.

    Args:
        fields: quantities by key.
    """

    def complete(table: type[T]) -> type[T]:
        further: dict[str, Any] = {}
        for key, field in fields.items():
            if key not in table.model_fields:
                accepted = Annotated[Measured, field]
                further[key] = (accepted, ...) if field.required else (accepted | None, None)
        name, module = table.__name__, table.__module__
        whole = create_model(
            name, __base__=table, __doc__=table.__doc__, __module__=module, **further
        )
        whole.needs = {key: field.needs for key, field in fields.items() if field.needs}
        return whole

    return complete


def with_tables[T: Table](tables: Mapping[str, Evidence]) -> Callable[[type[T]], type[T]]:
    """A decorator that adds to a table the tables of evidence that it does not declare.

    Args:
        tables: tables of evidence, as in `fields.AFTER`.
    """

    def complete(table: type[T]) -> type[T]:
        further: dict[str, Any] = {}
        for own in tables.values():
            if own.table not in table.model_fields:
                name = "".join(map(str.capitalize, own.table.split("_"))) + "Entry"
                what = {"__doc__": f"`{own.table}` of a vehicle: {own.what}."}
                empty = type(name, (_SomethingWritten,), {"__module__": __name__} | what)
                parts = (f'{key} = "{field.example}"' for key, field in own.fields.items())
                example = f"{{ {', '.join(parts)} }}"
                entry: Any = with_fields(own.fields)(empty)
                further[own.table] = (entry | None, pydantic.Field(None, examples=[example]))
        name, module = table.__name__, table.__module__
        return create_model(
            name, __base__=table, __doc__=table.__doc__, __module__=module, **further
        )

    return complete


class _SomethingWritten(Table):
    """A table in which something is written."""

    @model_validator(mode="after")
    def _has_a_part(self) -> _SomethingWritten:
        not_empty(self)
        return self


def not_empty(table: Table) -> None:
    """Refuse a table in which nothing is written."""
    keys = list(type(table).model_fields)
    if all(getattr(table, key) is None for key in keys):
        raise fault(f"is empty; write one or more of {', '.join(keys)}")


def one_line(limit: int) -> BeforeValidator:
    """The validator that reads a text of one line.

    Args:
        limit: largest number of characters accepted.
    """

    def read(raw: object) -> str:
        # characters that do not print could forge lines in a terminal or a report
        if not isinstance(raw, str) or not raw.strip():
            raise fault("write some text in quotes")
        if len(raw) > limit or not raw.replace("\N{NO-BREAK SPACE}", " ").isprintable():
            raise fault(f"write one line of at most {limit} printable characters")
        return raw

    return BeforeValidator(read)


Title = Annotated[str, one_line(200)]
Note = Annotated[str, one_line(1000)]
