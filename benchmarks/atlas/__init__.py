"""The atlas of failure: every option run over the edge, and scenes at random by the thousand."""

from __future__ import annotations

from typing import Literal, NamedTuple

Verdict = Literal["fine", "flagged", "wrong"]


class Row(NamedTuple):
    """An edge and what happens there.

    Args:
        part: of the package.
        edge: what goes over it.
        tried: what was run.
        seen: what a user sees, with what was measured.
        saved: what saves them.
        verdict: fine: right; flagged: not right and said so; wrong: not right and not said.
        test: that pins it, file and name.
    """

    part: str
    edge: str
    tried: str
    seen: str
    saved: str
    verdict: Verdict
    test: str
