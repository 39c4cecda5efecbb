"""pyproject.toml lists all that the source tree holds: nothing is left out of a wheel."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
SETUPTOOLS = PROJECT["tool"]["setuptools"]
FOLDERS = {package: ROOT / folder for package, folder in SETUPTOOLS["package-dir"].items()}


def sources() -> list[Path]:
    """Files of the package that git knows or would add."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "src", "models"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    if listed.returncode:
        pytest.skip("not a git checkout")
    return [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).exists()]


def folder_of(package: str) -> Path:
    """Where a package lies, by the longest of the names in package-dir that it begins with."""
    home = max((p for p in FOLDERS if f"{package}.".startswith(f"{p}.")), key=len)
    return FOLDERS[home].joinpath(*package.removeprefix(home).split(".")[1:])


def test_every_file_is_in_the_wheel() -> None:
    included: set[Path] = set()
    for package in SETUPTOOLS["packages"]:
        folder = folder_of(package)
        assert (folder / "__init__.py").exists(), package
        for pattern in ["*.py", *SETUPTOOLS["package-data"].get(package, [])]:
            included |= set(folder.glob(pattern))
    assert {file.relative_to(ROOT).as_posix() for file in set(sources()) - included} == set()


def test_every_pattern_of_package_data_has_files() -> None:
    for package, patterns in SETUPTOOLS["package-data"].items():
        for pattern in patterns:
            assert [*folder_of(package).glob(pattern)], (package, pattern)


def test_the_module_is_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "retrodict", "--version"], capture_output=True, text=True
    )
    assert done.stdout == f"retrodict {PROJECT['project']['version']}\n", done.stderr
