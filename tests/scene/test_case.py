"""A case file: what it says is kept, what is empty stays so, and nothing outside its folder is read."""

import hashlib
import re
import tomllib
from pathlib import Path

import pytest

from retrodict.scene.case import (
    Case,
    _AttachmentEntry,
    _CaseEntry,
    _DatesEntry,
    _ExaminerEntry,
    _InstructionEntry,
    load_case,
)
from retrodict.scene.errors import SceneError

FULL = """
schema = 1
number = "2026-117"
units = "us"
propositions = ["B at most 45 mph", "B at least 55 mph"]
[examiner]
name = "A. Examiner"
qualifications = ["MSc", "ACTAR 1234"]
[instruction]
by = "the district court"
[dates]
collision = 2026-03-14
[[attachments]]
file = "photos/b.jpg"
by = "B. Officer"
date = "2026-03-15"
[questions]
exceeds = "speed_b > 45 mph"
"""


@pytest.fixture
def folder(tmp_path):
    home = tmp_path / "case"
    (home / "photos").mkdir(parents=True)
    (home / "photos" / "b.jpg").write_bytes(b"a photograph")
    (tmp_path / "secret.txt").write_text("secret")
    return home


def case(folder, text):
    (folder / "case.toml").write_text(text, encoding="utf-8")
    return load_case(folder / "case.toml")


def refusal(folder, text):
    with pytest.raises(SceneError) as found:
        case(folder, text)
    return str(found.value)


def test_what_is_written_is_kept_and_files_have_their_digest(folder):
    found = case(folder, FULL)
    assert (found.number, found.examiner, found.units) == ("2026-117", "A. Examiner", "us")
    assert found.dates["collision"] == "2026-03-14"
    assert found.questions == {"exceeds": "speed_b > 45 mph"}
    (photo,) = found.attachments
    assert photo.sha256 == hashlib.sha256(b"a photograph").hexdigest()
    assert (photo.file, photo.size, photo.by, photo.method) == (
        "photos/b.jpg",
        12,
        "B. Officer",
        "",
    )


def test_nothing_is_invented(folder):
    empty = {"collision": "", "inspection": "", "report": ""}
    assert case(folder, "schema = 1\n") == Case(dates=empty)
    assert case(folder, 'schema = 1\nnumber = ""\n[examiner]\nname = ""\n') == Case(dates=empty)


@pytest.mark.parametrize(
    "path",
    ["../secret.txt", "photos/../../secret.txt", "{home}/../secret.txt", "link", "/etc/passwd"],
)
def test_nothing_outside_the_folder_is_read(folder, path):
    (folder / "link").symlink_to(folder.parent / "secret.txt")
    said = refusal(folder, f'schema = 1\nattachments = [{{ file = "{path.format(home=folder)}" }}]')
    assert "attachments[0].file" in said
    assert "outside the case's folder" in said


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ('attachments = [{ file = "none.jpg" }]', "cannot be read (No such file"),
        ('attachments = [{ file = "photos" }]', "is no file"),
        ("attachments = [{}]", "attachments[0].file: missing"),
        ('examiner = { names = "x" }', 'did you mean "name"?'),
        ('number = "a\\u001b[2J"', "printable characters"),
        ("questions = 3", "write a table: [questions]"),
        ('units = "metric"', 'units = "si" or "us"'),
    ],
)
def test_a_fault_is_reported_with_its_place_in_a_line(folder, text, wanted):
    said = refusal(folder, f"schema = 1\n{text}\n")
    assert wanted in said
    assert "\x1b" not in said
    assert len(said.splitlines()) == 1


def test_the_documented_example_and_keys_are_the_code_s(folder):
    """docs/reports.md shows every key."""
    page = Path(__file__).parents[2].joinpath("docs", "reports.md").read_text("utf-8")
    example = re.search(r"```toml\n(.*?)```", page, re.DOTALL)[1]
    (folder / "photos" / "rest-of-b.jpg").write_bytes(b"")
    found = case(folder, example)
    assert found.dates["report"] == "2026-06-01"
    written = tomllib.loads(example)
    parts = {"examiner": _ExaminerEntry, "instruction": _InstructionEntry, "dates": _DatesEntry}
    assert set(written) == {f.alias or n for n, f in _CaseEntry.model_fields.items()}
    for name, entry in parts.items():
        assert set(written[name]) == set(entry.model_fields)
    assert set(written["attachments"][0]) == set(_AttachmentEntry.model_fields)
