"""The findings as `summary.json`, and as a table of numbers; what the summary of a folder says."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retrodict.findings import schema
from retrodict.findings.sentences import NOT_TO_BE_RELIED_ON
from retrodict.findings.statistics import scaled, scaled_interval
from retrodict.studies.avoidability import Avoidability, TimeDistance
from retrodict.studies.corners import Corner
from retrodict.studies.fit import LEVELS
from retrodict.studies.named_checks import NamedCheck
from retrodict.studies.one_at_a_time import Effect
from retrodict.studies.probability import LikelihoodRatio, Probability

if TYPE_CHECKING:
    import pandas as pd

    from retrodict.findings.answers import Numbers
    from retrodict.findings.inputs import InputRow
    from retrodict.findings.record import Findings
    from retrodict.findings.statistics import Quantity
    from retrodict.scene.quantities import Units
    from retrodict.studies.comparison import Ladder
    from retrodict.studies.conflict import LeftOut
    from retrodict.studies.fit import Summary as FitSummary
    from retrodict.studies.sliding import BySliding

_KINDS: dict[type, Any] = {
    Corner: schema.CornerEntry,
    Effect: schema.EffectEntry,
    NamedCheck: schema.NamedCheckEntry,
}
SUMMARY = "summary.json"


def summarise(findings: Findings) -> schema.Summary:
    """A reconstruction in numbers that are strict JSON, in SI units and radians.

    Args:
        findings: findings of the reconstruction.

    Returns:
        What `schema.Summary` describes; what is not finite is None.
    """
    return _entry(
        schema.Summary,
        findings,
        scene=_entry(schema.SceneEntry, findings.scene),
        model=findings.description.name,
        parameters={name: _quantity(each) for name, each in findings.quantities.items()},
        derived={name: _quantity(each) for name, each in findings.derived.items()},
        correlations=[
            {"of": one, "and": other, "value": r}
            for (one, other), r in findings.correlations.items()
        ],
        measured={row.name: _measured(row) for row in findings.measured},
        checks=_entry(schema.ChecksEntry, findings.checks),
        ladder=ladder_data(findings.ladder) if findings.ladder else None,
        left_out={item.name: _left_out(item, findings.scene.sought) for item in findings.left_out},
        causes={
            name: {each.name: each.share for each in causes}
            for name, causes in findings.causes.items()
        },
        narrowing={
            name: {each.name: each.sd for each in narrowed}
            for name, narrowed in findings.narrowing.items()
        },
        questions=[
            _entry(schema.QuestionEntry, each, numbers=_numbers(each.numbers))
            for each in findings.questions
        ],
        sliding={each.name: _by_sliding(each) for each in findings.sliding},
    )


def _entry(kind: Any, record: object, **other: Any) -> Any:
    """The entry that a record makes, by the keys of its type in `schema`.

    Args:
        kind: type of the entry.
        record: record with attributes of these names.
        other: values of keys for which the record has no attribute, or another one.

    Returns:
        The entry, in strict JSON, without keys that neither has.
    """
    return {
        key: strict(other[key] if key in other else getattr(record, key))
        for key in kind.__annotations__
        if key in other or hasattr(record, key)
    }


def _quantity(found: Quantity) -> schema.QuantityEntry:
    printed = {
        units: _entry(
            schema.PrecisionEntry,
            each,
            unit=each.unit.symbol,
            **{f"decimals_{level}": digits for level, digits in each.of_level.items()},
        )
        for units, each in found.precision.items()
    }
    intervals = {f"interval_{level}": limits for level, limits in found.intervals.items()}
    errors = {f"error_{level}": error for level, error in found.errors.items()}
    return _entry(schema.QuantityEntry, found, **intervals, **errors, printed=printed)


def _measured(row: InputRow) -> schema.MeasuredEntry:
    known = row.measured
    as_measured = {"value": known.value, "sd": known.sd, "law": known.law}
    return _entry(schema.MeasuredEntry, row, **as_measured, sd_found=row.sd)


def _left_out(item: LeftOut, sought: str) -> schema.LeftOutEntry:
    speeds = dict.fromkeys(("speed_a", "speed_a_sd", "speed_b", "speed_b_sd"))
    speeds |= {sought: item.speed, f"{sought}_sd": item.speed_sd}
    return _entry(schema.LeftOutEntry, item, **speeds, told=item.reliable)


def _by_sliding(found: BySliding) -> schema.BySlidingEntry:
    ended, went_on = _of_sliding(found.ended), _of_sliding(found.went_on)
    return _entry(schema.BySlidingEntry, found, ended=ended, went_on=went_on)


def _of_sliding(found: FitSummary) -> schema.SlidingEntry:
    intervals = {f"interval_{level}": found.intervals[level] for level in LEVELS}
    return _entry(schema.SlidingEntry, found, **intervals)


def _numbers(found: Numbers | None) -> Any:
    match found:
        case Probability(proposition=asked, value=value):
            limits: dict[str, float | None] = {"low": None, "high": None}
            quantity = ", ".join(asked.names)
            if not asked.joined:
                limits = {"low": asked.low, "high": asked.high}
                quantity = f" {'+' if asked.sign == 1 else '-'} ".join(asked.names)
            named = {"proposition": asked.text, "quantity": quantity, **limits}
            return _entry(schema.ProbabilityEntry, found, **named, probability=value)
        case LikelihoodRatio():
            return _entry(
                schema.LikelihoodRatioEntry,
                found,
                first=_numbers(found.first),
                second=_numbers(found.second),
                likelihood_ratio=found.value,
                log_error=found.error,
            )
        case Avoidability(asked=asked):
            of_asked = {"vehicle": asked.vehicle, "limit": asked.limit}
            return _entry(schema.AvoidabilityEntry, found, **of_asked)
        case TimeDistance():
            return _entry(schema.TimeDistanceEntry, found)
        case None:
            return None
    return [_entry(_KINDS[type(each)], each) for each in found]


def summary_json(findings: Findings, files: Mapping[str, bytes]) -> bytes:
    """`summarise` as a JSON file, with the digests of the files of the same result.

    Args:
        findings: findings of the reconstruction.
        files: contents of these files, by path relative to the summary.

    Returns:
        What the file holds; its entry `files` has the SHA-256 of each of the others.
    """
    content = {**summarise(findings), "files": {k: _digest(v) for k, v in files.items()}}
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    return f"{text}\n".encode()


def summary_frame(findings: Findings, units: Units = "si") -> pd.DataFrame:
    """The reported quantities, and what follows from the same draws, in a table of numbers.

    Args:
        findings: findings of the reconstruction.
        units: "si" or "us".

    Returns:
        One row a quantity, delta-v and PDOF among them, one column a statistic. The column `checks`
        says what to make of the row; numbers of a quantity that failed a check of its own, or follows
        from one that did, are NaN, its diagnostics are not.
    """
    import pandas as pd

    verdict = "passed" if findings.checks.passed else NOT_TO_BE_RELIED_ON
    rows = {}
    for name, found in (findings.quantities | findings.derived).items():
        unit = found.precision[units].unit
        usable = found.passed and not found.withheld
        row: dict[str, Any] = {"unit": unit.symbol}
        for key in ("mean", "sd", "median"):
            row[key] = scaled(getattr(found, key), unit.worth)
        for level, bounds in found.intervals.items():
            low, high = scaled_interval(bounds, unit.worth)
            row |= {f"interval_{level}_low": low, f"interval_{level}_high": high}
        row["mcse_mean"] = scaled(found.mcse_mean, unit.worth)
        if not usable:
            row = dict.fromkeys(row) | {"unit": unit.symbol}
        row |= {key: getattr(found, key) for key in ("ess_bulk", "ess_tail", "rhat")}
        rows[name] = row | {"checks": verdict if usable else "failed"}
    frame = pd.DataFrame.from_dict(rows, orient="index")
    numbers = frame.columns.drop(["unit", "checks"])
    return frame.astype(dict.fromkeys(numbers, float))


def ladder_data(ladder: Ladder) -> schema.LadderEntry:
    """A ladder in strict JSON, in SI units; what is not finite is None."""
    scene = _entry(schema.SceneEntry, ladder.scene)
    return _entry(schema.LadderEntry, ladder, scene=scene)


def read_summary(directory: Path) -> dict[str, Any] | None:
    """What a summary in a folder of results says; None where there is none that can be read."""
    try:
        found = json.loads((directory / SUMMARY).read_text("utf-8"))
        return found if isinstance(found, dict) and isinstance(found["files"], dict) else None
    except (OSError, ValueError, KeyError):
        return None


def holds_answer(directory: Path) -> bool:
    """Whether a folder holds the result of a run that was finished and whose checks passed."""
    found = read_summary(directory) or {}
    return bool(found.get("complete") and found.get("checks", {}).get("passed"))


def strangers(directory: Path) -> tuple[str, ...]:
    """Which files of a folder of results are not those that its summary was written with.

    Args:
        directory: folder with a summary that `read_summary` can read.

    Returns:
        Paths in the folder of files that are missing or differ from their digest.
    """
    found = read_summary(directory) or {"files": {}}
    other = []
    for name, digest in found["files"].items():
        try:
            same = _digest((directory / name).read_bytes()) == digest
        except OSError:
            same = False
        if not same:
            other.append(name)
    return tuple(other)


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def strict(value: Any) -> Any:
    """Plain data and records without NaN and infinity, which JSON lacks: null stands for them."""
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, dict):
        return {str(key): strict(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [strict(each) for each in value]
    if isinstance(value, float):  # NumPy's too
        return float(value) if math.isfinite(value) else None
    return value
