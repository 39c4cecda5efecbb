"""The pages of the documentation, and the commands in their code blocks."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
# one of these takes from ten seconds to minutes
LONG = {"batch", "calibrate", "ladder", "reconstruct", "replay", "validate"}


def pages() -> list[Path]:
    """README.md and every page of docs/."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def commands(block: str) -> Iterator[list[str]]:
    """The arguments of each `retrodict` command in a block of shell, of whatever starts it."""
    for line in block.replace("\\\n", " ").splitlines():
        words: list[str] = []
        for word in [*shlex.split(line, comments=True), "&&"]:
            if word != "&&":
                words.append(word)
                continue
            for i, name in enumerate(words):
                if name == "retrodict" and (i == 0 or words[:2] == ["python3", "-m"]):
                    yield words[i + 1 :]
                    break
            words = []
