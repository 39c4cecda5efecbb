"""An expert's statements on a case, apart from the measurements: the file case.toml."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidatorFunctionWrapHandler, WrapValidator

from retrodict.scene.entries.table import Note, Table, Title
from retrodict.scene.errors import Problem, SceneError, shown
from retrodict.scene.explain import entries_of
from retrodict.scene.kinds import fault
from retrodict.scene.load import read_text, toml_of
from retrodict.scene.quantities import Units


@dataclass(frozen=True, slots=True)
class Attachment:
    """A file that belongs to a case.

    Args:
        file: path of the file in the case's folder.
        sha256: SHA-256 of the file's content, hexadecimal.
        size: size of the file, bytes.
        title: title of the file; empty if not stated.
        by, method, date, source: author, method, date and origin of the file; empty if not stated.
    """

    file: str
    sha256: str
    size: int
    title: str = ""
    by: str = ""
    method: str = ""
    date: str = ""
    source: str = ""


@dataclass(frozen=True, slots=True)
class Case:
    """An expert's statements on a case; an empty attribute is not stated.

    Args:
        number: case number.
        examiner: name of the examiner; `position` and `organisation` are the examiner's, too.
        qualifications, publications, testimony: qualifications, publications and earlier testimony of
            the examiner, lines of text.
        compensation: compensation of the examiner.
        instructed_by: person or body that put the question; `instruction` is the question as put.
        dates: dates by the keys "collision", "inspection" and "report".
        place: place of the report.
        declaration: declaration of the examiner on the duty to the court.
        units: system of units that comes first in the report; None where the case names none.
        propositions: propositions that are to be compared.
        attachments: files of the case.
        questions: the table `[questions]` as it was written.
    """

    number: str = ""
    examiner: str = ""
    position: str = ""
    organisation: str = ""
    qualifications: tuple[str, ...] = ()
    publications: tuple[str, ...] = ()
    testimony: tuple[str, ...] = ()
    compensation: str = ""
    instructed_by: str = ""
    instruction: str = ""
    dates: dict[str, str] = field(default_factory=dict)
    place: str = ""
    declaration: str = ""
    units: Units | None = None
    propositions: tuple[str, ...] = ()
    attachments: tuple[Attachment, ...] = ()
    questions: dict[str, Any] = field(default_factory=dict)


def load_case(path: str | Path) -> Case:
    """A case from a case file.

    Args:
        path: a TOML file; its keys are described in docs/reports.md. Attachments lie in its folder.

    Returns:
        The case, with the SHA-256 of each attachment.

    Raises:
        SceneError: the file or an attachment cannot be read, an attachment lies outside the folder,
            or something is wrong.
    """
    entry = entries_of(_CaseEntry, toml_of(read_text(path), str(path)), str(path))
    attachments, problems = [], []
    for number, each in enumerate(entry.attachments):
        try:
            attachments.append(_attached(Path(path).parent, each))
        except _Refused as refusal:
            key = f"attachments[{number}].file"
            problems.append(Problem(key, shown(each.file), str(refusal)))
    if problems:
        raise SceneError(str(path), problems)
    examiner, instruction = entry.examiner, entry.instruction
    return Case(
        number=entry.number,
        examiner=examiner.name,
        position=examiner.position,
        organisation=examiner.organisation,
        qualifications=tuple(examiner.qualifications),
        publications=tuple(examiner.publications),
        testimony=tuple(examiner.testimony),
        compensation=examiner.compensation,
        instructed_by=instruction.by,
        instruction=instruction.question,
        dates=dict(entry.dates),
        place=entry.place,
        declaration=entry.declaration,
        units=entry.units,
        propositions=tuple(entry.propositions),
        attachments=tuple(attachments),
        questions=entry.questions,
    )


class _Refused(Exception):
    """An attachment that is not read; says what to write instead."""


def _attached(folder: Path, entry: _AttachmentEntry) -> Attachment:
    inside = "write the path of a file in the folder of the case file, or below it"
    try:
        home = folder.resolve(strict=True)
        # links are followed before it is asked where the file lies
        file = (home / entry.file).resolve(strict=True)
        if not file.is_relative_to(home):
            raise _Refused(f"lies outside the case's folder; {inside}")
        if not file.is_file():
            raise _Refused(f"is no file; {inside}")
        with file.open("rb") as content:
            sha256 = hashlib.file_digest(content, "sha256").hexdigest()
        size = file.stat().st_size
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        reason = getattr(error, "strerror", None) or "not a path"
        raise _Refused(f"cannot be read ({reason}); {inside}") from None
    of_it = {key: value for key, value in entry if key != "file"}
    return Attachment(file.relative_to(home).as_posix(), sha256, size, **of_it)


def _day(raw: object) -> object:
    return raw.isoformat() if isinstance(raw, date) else raw


def _may_be_empty(raw: object, read: ValidatorFunctionWrapHandler) -> Any:
    return "" if raw == "" else read(raw)


_Text = Annotated[Title, WrapValidator(_may_be_empty)]
_Long = Annotated[Note, WrapValidator(_may_be_empty)]
_TEXT = Field("", examples=['"…"'])
_LINES: Any = Field([], max_length=50, examples=['["one line", "another"]'])
_Day = Annotated[_Text, BeforeValidator(_day)]
_DAY = Field("", examples=['"2026-03-14"'])


class _ExaminerEntry(Table):
    name: _Text = _TEXT
    position: _Text = _TEXT
    organisation: _Text = _TEXT
    qualifications: list[Note] = _LINES
    publications: list[Note] = _LINES
    testimony: list[Note] = _LINES
    compensation: _Long = _TEXT


class _InstructionEntry(Table):
    by: _Text = _TEXT
    question: _Long = _TEXT


class _DatesEntry(Table):
    collision: _Day = _DAY
    inspection: _Day = _DAY
    report: _Day = _DAY


class _AttachmentEntry(Table):
    file: Title = Field(examples=['"photos/rest-of-b.jpg"'])
    title: _Text = _TEXT
    by: _Text = _TEXT
    method: _Text = _TEXT
    date: _Day = _DAY
    source: _Text = _TEXT


def _a_table(raw: object) -> object:
    if not isinstance(raw, dict):
        raise fault("write a table: [questions]")
    return raw


class _CaseEntry(Table):
    schema_version: int = Field(alias="schema", strict=True, ge=1, le=1, examples=["1"])
    number: _Text = _TEXT
    units: Literal["si", "us"] | None = Field(None, examples=['"si" or "us"'])
    place: _Text = _TEXT
    declaration: _Long = _TEXT
    propositions: list[Note] = _LINES
    examiner: _ExaminerEntry = Field(_ExaminerEntry(), examples=['{ name = "…" }'])
    instruction: _InstructionEntry = Field(_InstructionEntry(), examples=['{ by = "…" }'])
    dates: _DatesEntry = Field(_DatesEntry(), examples=['{ collision = "2026-03-14" }'])
    attachments: list[_AttachmentEntry] = Field(
        [], max_length=200, examples=['[{ file = "photos/rest-of-b.jpg" }]']
    )
    questions: Annotated[dict[str, Any], BeforeValidator(_a_table)] = Field({}, examples=["{ … }"])
