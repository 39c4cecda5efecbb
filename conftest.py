"""Code blocks of README.md and docs/ are tests: each page's run in order, in one folder.

Python runs as written. Of a block of `sh` the `retrodict` commands are run; one with a command that
takes long is a slow test, and so is every block of a page in `SLOW`. A block of `toml` is read; where
its first line is a comment with a name, it is that file. The folder has `examples` and, in
`out/brach-1977`, a result of the paper's scene. To be quick, `rd.reconstruct` runs `QUICK` where a
block does not say otherwise. `<!-- skip: next -->` before a block leaves it out.
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from sybil import Example, Sybil
from sybil.integration.pytest import SybilItem
from sybil.parsers.markdown import CodeBlockParser, PythonCodeBlockParser, SkipParser
from typer.testing import CliRunner

import retrodict as rd
from tests.shared.pages import LONG, ROOT, commands

SCENE = ROOT / "examples" / "brach-1977" / "scene.toml"
QUICK = {"model": "planar-moment+wheels", "method": "importance"}
# pages whose blocks compile programs of their own or draw figures and reports, ten seconds and more
SLOW = {
    "batch.md", "calculator.md", "export.md", "live.md", "own-evidence.md", "own-sampler.md",
    "reports.md", "results.md", "tutorial.md",
}  # fmt: skip
FEWER = {"calibrate": ["--simulations", "4"]}  # than a page asks for


def run_commands(example: Example) -> None:
    """Run the commands of a block of shell."""
    from retrodict.cli import app

    for name, *arguments in commands(example.parsed):
        if name in LONG:  # these start processes of their own
            command = [sys.executable, "-m", "retrodict", name, *arguments, *FEWER.get(name, [])]
            subprocess.run(command, check=True)
        else:
            done = CliRunner().invoke(app, [name, *arguments])
            assert done.exit_code == 0, (name, arguments, done.output)


def read_toml(example: Example) -> None:
    """See that a block is TOML."""
    tomllib.loads(example.parsed)


pytest_collect_file = Sybil(
    [
        PythonCodeBlockParser(),
        CodeBlockParser("sh", run_commands),
        CodeBlockParser("toml", read_toml),
        SkipParser(),
    ],
    patterns=["README.md", "docs/*.md", "docs/*/*.md"],
    fixtures=["in_a_folder_of_its_page"],
).pytest()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark blocks with commands that take long, and pages that do."""
    for item in items:
        if not isinstance(item, SybilItem):
            continue
        of_shell = item.example.region.evaluator is run_commands
        long = of_shell and any(name in LONG for name, *_ in commands(item.example.parsed))
        if long or item.path.name in SLOW:
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def paper_result(tmp_path_factory: pytest.TempPathFactory) -> Callable[[], Path]:
    """Gives a folder with a result of the paper's scene, made once by whichever process asks first."""
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    @cache
    def folder() -> Path:
        from retrodict.api import reconstruct

        with (base / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (base / "brach-1977").exists():
                reconstruct(rd.load_scene(SCENE), **QUICK).save(base / "brach-1977")
        return base / "brach-1977"

    return folder


@pytest.fixture(scope="session")
def page_folders(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path], Path]:
    """Gives the folder in which the blocks of a page run."""

    @cache
    def folder(page: Path) -> Path:
        made = tmp_path_factory.mktemp(page.stem)
        (made / "examples").symlink_to(ROOT / "examples")
        for block in re.finditer(
            r"```toml\n(# (\S+\.toml)\n.*?)```", page.read_text("utf-8"), re.S
        ):
            (made / block[2]).write_text(block[1], "utf-8")
        return made

    return folder


@pytest.fixture
def in_a_folder_of_its_page(
    request: pytest.FixtureRequest,
    monkeypatch: pytest.MonkeyPatch,
    paper_result: Callable[[], Path],
    page_folders: Callable[[Path], Path],
) -> None:
    """What the blocks of a page find: the module's docstring has it."""
    folder = page_folders(request.node.path)
    monkeypatch.chdir(folder)
    known, text = folder / "out" / "brach-1977", request.node.example.parsed
    if "brach-1977" in text and not known.exists():
        shutil.copytree(paper_result(), known)

    def reconstruct(scene: Any, **asked: Any) -> rd.Result:
        from retrodict.api import reconstruct

        if not asked and scene == rd.load_scene(SCENE):
            return rd.load_result(paper_result())
        return reconstruct(scene, **QUICK | asked)

    monkeypatch.setattr(rd, "reconstruct", reconstruct)
