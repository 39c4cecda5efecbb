"""The content of a result's archive."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retrodict.findings.stored import DRAWS, stored
from retrodict.findings.summary import SUMMARY, summary_json
from retrodict.scene.load import parse_scene
from retrodict.scene.own import own_of
from retrodict.storage.archive import Archive, NotArchived

if TYPE_CHECKING:
    from retrodict.findings import Findings
    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Scene
    from retrodict.studies.comparison import Ladder

_ABOUT, _SCENE, _CASE = "about.json", "scene.toml", "case.toml"
_NAMED = ("model", "method")
_MOST = {"chains": 64, "draws": 1_000_000, "warmup": 100_000, "seed": 2**31 - 1}


@dataclass(frozen=True, slots=True)
class Recorded:
    """A run as an archive records it.

    Args:
        scene: scene that was reconstructed.
        asked: options of `reconstruct`, by name.
        summary: the findings, as in summary.json.
        draws: content of the file of draws.
        own: priors and terms of the user's own in Python that the run had, as by `own_of`.
    """

    scene: Scene
    asked: dict[str, Any]
    summary: dict[str, Any]
    draws: bytes
    own: tuple[str, ...] = ()


def archived(
    findings: Findings, outcome: Outcome, ladder: Ladder | None, case: Path | None = None
) -> dict[str, bytes]:
    """The files of a result's archive.

    Args:
        findings: findings of the reconstruction.
        outcome: outcome of the reconstruction, with its draws.
        ladder: results of every rung of the ladder, where the ladder chose the model; else None.
        case: path of a case file; None where nothing is stated.

    Returns:
        Content of each file by name, in the order of the chain.

    Raises:
        SceneError: the case file, or one of its attachments, cannot be used.
    """
    evidence, files = [], {_SCENE: findings.scene_text.text.encode()}
    if case is not None:
        from retrodict.scene.case import load_case

        evidence = [asdict(each) for each in load_case(case).attachments]
        files[_CASE] = case.read_bytes()
    about = {
        "title": findings.scene.title,
        "name": findings.scene.name,
        "asked": asdict(outcome.asked),
        "seed": findings.seed,
        "complete": findings.complete,
        "versions": findings.versions,
        "evidence": evidence,
        "own": list(own_of(outcome.scene)),
    }
    files |= stored(outcome, ladder)
    files[SUMMARY] = summary_json(findings, files)
    text = json.dumps(about, indent=2, ensure_ascii=False, allow_nan=False)
    return {_ABOUT: f"{text}\n".encode(), **files}


def recorded_in(archive: Archive, path: str) -> Recorded:
    """The run that an archive records.

    Args:
        archive: verified archive.
        path: path of the archive, for messages.

    Returns:
        The record.

    Raises:
        NotArchived: the archive is not of a result, or is of another version of retrodict.
        SceneError: this version cannot read the archived scene.
    """
    try:
        about = json.loads(archive.files[_ABOUT])
        asked = {"seed": about["seed"], **about["asked"]}
        summary = json.loads(archive.files[SUMMARY])
        if not (_may_be_asked(asked) and isinstance(summary["versions"], dict)):
            raise ValueError
        name, draws = str(about["name"]), archive.files[DRAWS]
        text = archive.files[_SCENE].decode()
        own = tuple(map(str, about.get("own", ())))
    except (KeyError, ValueError, TypeError, RecursionError):
        raise NotArchived(
            f"{path}: not the archive of a result, or of another version of retrodict"
        ) from None
    return Recorded(parse_scene(text, name), asked, summary, draws, own)


def _may_be_asked(asked: dict[str, Any]) -> bool:
    """Whether options are such as `reconstruct` takes; an archive is a stranger's file."""
    numbers = {name: value for name, value in asked.items() if name not in _NAMED}
    if numbers.get("draws", 0) is None:
        del numbers["draws"]
    return all(isinstance(asked[name], str) for name in _NAMED) and all(
        isinstance(value, int) and 0 <= value <= _MOST[name] for name, value in numbers.items()
    )
