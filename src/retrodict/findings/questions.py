"""Questions that were put, with their answers as they are printed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Answered:
    """A question and its answer; every number in it is formatted already.

    Args:
        title: the question, in words.
        sentences: the answer; the first of them is printed on the first page.
        header: of the columns of `rows`.
        rows: a table that belongs to the answer; none where there is none.
        figure: name in the report's `FIGURES` of the figure that shows it; None where none does.
    """

    title: str
    sentences: tuple[str, ...]
    header: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    figure: str | None = None
