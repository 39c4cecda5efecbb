"""Answers to the questions of docs/questions.md, and rewrites that page.

python -m benchmarks.questions
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from benchmarks import page
from retrodict import load_scene, reconstruct
from retrodict.findings.answers import Answered
from retrodict.options import DEFAULT_RUNG
from retrodict.scene.questions import questions_from

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "questions.md"
SCENE = ROOT / "examples" / "brach-1977" / "scene.toml"


def asked() -> dict:
    """The table `[questions]` of the page."""
    found = re.search(r"```toml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert found, "the page has the questions"
    return tomllib.loads(found[1])["questions"]


def lines(answer: Answered) -> Iterator[str]:
    """A question and its answer in Markdown."""
    yield f"> **{answer.title}**"
    for sentence in answer.sentences:
        yield from (">", f"> {sentence}")
    if answer.rows:
        yield ""
        yield from page.table(answer.header, map(list, answer.rows))
    yield ""


def main() -> None:
    """Reconstruct the paper's collision, print the answers, and write them."""
    scene = replace(load_scene(SCENE), questions=questions_from(asked(), PAGE.name))
    result = reconstruct(scene, model=DEFAULT_RUNG)
    parts: dict[str, list[str]] = {}
    for answer in result.findings.questions:
        parts.setdefault(answer.kind, []).extend(lines(answer))
    print("\n".join(line for part in parts.values() for line in part))
    page.refresh(PAGE, parts)


if __name__ == "__main__":
    main()
