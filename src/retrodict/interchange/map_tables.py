"""What tables of a map file share: names of points and columns, units, and how a text table is read."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from retrodict.scene.entries.table import Table
from retrodict.scene.kinds import fault
from retrodict.scene.units import Dimension, QuantityError, factor


def point_name(raw: object) -> object:
    """A point's name: text, or a whole number as many instruments count them."""
    if isinstance(raw, int) and not isinstance(raw, bool) and raw.bit_length() < 64:
        return str(raw)
    if not isinstance(raw, str) or not raw.strip() or len(raw) > 100 or not raw.isprintable():
        raise fault('write the name of a point, like "12"')
    return raw.strip()


def _column(raw: object) -> object:
    if isinstance(raw, int) and not isinstance(raw, bool):
        if not 1 <= raw <= 200:
            raise fault("write the number of a column, from 1, or its name in the header")
        return raw
    return point_name(raw)


def unit_factor(raw: object, dimension: Dimension, key: str = "") -> float:
    """Factor from a written unit to the SI unit.

    Args:
        raw: the unit, as a map file has it.
        dimension: dimension of the quantity.
        key: key of the unit below that of the validator, for the message.

    Raises:
        PydanticCustomError: it is no unit of that dimension; says what to write.
    """
    try:
        if not isinstance(raw, str):
            raise QuantityError(f'write a unit in quotes, like "{dimension.units[0]}"')
        return factor(raw, dimension)
    except QuantityError as error:
        raise fault(error.fix, key) from None


def all_alike(columns: Iterable[tuple[str, object]]) -> None:
    """Refuse columns of which some are given by name and some by number."""
    if len({type(column) for _, column in columns if column is not None}) > 1:
        raise fault("write all columns by name, or all by number where there is no header")


Name = Annotated[str, BeforeValidator(point_name)]
Column = Annotated[int | str, BeforeValidator(_column)]


BLANKS = (" ", "  ")  # one or more, or two or more


def _only(raw: object) -> object:
    """What cells of a column must be, by the column; a number is written as text or as a number."""
    if not isinstance(raw, dict) or not 0 < len(raw) <= 10:
        raise fault('write a column and the cell that its rows have: { Event = "1" }')
    return {point_name(column): point_name(cell) for column, cell in raw.items()}


class TableEntry(Table):
    """What `[survey]` and `[recorder]` say of a table in a text file."""

    encoding: (
        Literal[
            "utf-8", "utf-16", "utf-16-le", "cp1252", "latin-1", "cp1250", "cp1251", "cp1253",
            "cp1254", "cp437", "cp850", "mac-roman", "shift_jis", "gb18030", "euc_kr", "big5",
        ] | None
    ) = Field(None, examples=['"cp1252"'])  # fmt: skip
    separator: Literal[",", ";", "\t", "|", " ", "  "] | None = Field(None, examples=['";"'])
    decimal: Literal[".", ","] = Field(".", examples=['","'])
    below: Name | None = Field(None, examples=['"Event Record 2" (a line above the table)'])
    only: Annotated[dict[str, str], BeforeValidator(_only)] = Field(
        {}, examples=['{ Event = "1" } (the cell that all rows have in this column)']
    )

    @model_validator(mode="after")
    def _only_as_columns(self) -> TableEntry:
        by_number = any(isinstance(each, int) for _, each in getattr(self, "columns", ()))
        if by_number and not all(re.fullmatch("[1-9][0-9]{0,2}", column) for column in self.only):
            raise fault('write numbers of columns, as in columns: { 1 = "2" }', "only")
        return self
