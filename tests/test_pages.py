"""README.md and docs/: links lead somewhere, commands exist, public names are in the reference.

The code blocks themselves are run by `conftest.py` beside pyproject.toml.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
import typer

from retrodict import mechanics
from retrodict.cli import app
from tests.shared.pages import ROOT, commands, pages

LINKED = [*pages(), ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *ROOT.glob("examples/**/*.md")]
TWO_COMMANDS = """\
python3 -m pip install uv && python3 -m uv run retrodict reconstruct examples/brach-1977/scene.toml
python3 -m uv run --group test pytest
"""


def blocks(page: Path, language: str) -> list[str]:
    """The code blocks of a page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text("utf-8"), re.S | re.M)


def anchors(page: Path) -> set[str]:
    """Of a page's headings, as GitHub and MyST make them."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.S | re.M)
    headings = re.findall(r"^#+ (.*)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", LINKED, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.S | re.M)
    for target, heading in re.findall(r"\]\(([^)\s:#]*)#?([^)\s:]*)\)", text):
        path = Path(os.path.normpath(page.parent / target)) if target else page
        assert path.exists(), f"{page.name}: {target}"
        assert not heading or heading in anchors(path), f"{page.name}: {target}#{heading}"


def test_every_block_names_its_language() -> None:
    """So that none that could be run is passed over."""
    known = {"python", "sh", "text", "toml", "{toctree}", "{eval-rst}"}
    for page in pages():
        openings = re.findall(r"^```(.*)$", page.read_text("utf-8"), re.M)[::2]
        assert set(openings) <= known, (page, set(openings) - known)


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_command_and_option_exists(page: Path) -> None:
    """Those that take long are run by the slow tests only."""
    known = typer.main.get_command(app)
    for block in blocks(page, "sh"):
        for name, *arguments in commands(block):
            if not name.startswith("-") and "--help" not in arguments:
                known.commands[name].make_context(name, arguments)


def test_the_readme_has_the_two_commands() -> None:
    assert TWO_COMMANDS in blocks(ROOT / "README.md", "sh")


def test_every_public_name_of_mechanics_is_in_the_reference() -> None:
    page = (ROOT / "docs" / "reference" / "mechanics.md").read_text("utf-8")
    listed = re.findall(r"^\.\. auto(?:function|class|exception):: (\w+)$", page, re.M)
    assert sorted(listed) == sorted(mechanics.__all__)


def test_ci_runs_what_contributing_says() -> None:
    script = (ROOT / ".ci" / "run").read_text("utf-8")
    listed = blocks(ROOT / "CONTRIBUTING.md", "sh")[1].splitlines()
    assert len(listed) >= 8
    for line in listed:
        assert line.removeprefix("UV_PROJECT_ENVIRONMENT=.venv-lint ") in script, line
