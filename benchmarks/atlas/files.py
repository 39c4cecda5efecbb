"""Scene files at random: every one ends in a scene or in lines that name the place."""

from __future__ import annotations

import tempfile
from collections import Counter
from pathlib import Path

from hypothesis import HealthCheck, given, settings

from tests.shared.fuzz import texts, verdict


def count(number: int) -> Counter[str]:
    """How many files the command `check` accepts and refuses; it fails where one does neither.

    Args:
        number: of files.

    Returns:
        Files by verdict: "a scene" or "refused".
    """
    counts: Counter[str] = Counter()

    with tempfile.TemporaryDirectory() as folder:

        @settings(
            max_examples=number,
            database=None,
            deadline=None,
            derandomize=True,
            suppress_health_check=list(HealthCheck),
        )
        @given(texts)
        def look(text: str) -> None:
            counts[verdict(text, Path(folder))] += 1

        look()
    return counts
