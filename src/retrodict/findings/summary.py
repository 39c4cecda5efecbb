"""The findings as `summary.json`, and as a table of numbers; what the summary of a folder says."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retrodict.findings.sentences import NOT_TO_BE_RELIED_ON
from retrodict.findings.statistics import LEVELS, finite, scaled, scaled_interval
from retrodict.studies.avoidability import Avoidability, TimeDistance
from retrodict.studies.one_at_a_time import Effect
from retrodict.studies.probability import LikelihoodRatio, Probability

if TYPE_CHECKING:
    import pandas as pd

    from retrodict.findings.answers import Answered, Numbers
    from retrodict.findings.inputs import InputRow
    from retrodict.findings.record import Findings
    from retrodict.findings.schema import (
        BySlidingEntry,
        LadderEntry,
        LeftOutEntry,
        MeasuredEntry,
        ProbabilityEntry,
        QuantityEntry,
        QuestionEntry,
        SlidingEntry,
        Summary,
    )
    from retrodict.findings.statistics import Quantity
    from retrodict.scene.quantities import Units
    from retrodict.studies.comparison import Ladder
    from retrodict.studies.conflict import LeftOut
    from retrodict.studies.corners import Corner
    from retrodict.studies.fit import Summary as FitSummary
    from retrodict.studies.named_checks import NamedCheck
    from retrodict.studies.sliding import BySliding

SUMMARY = "summary.json"


def summarise(findings: Findings) -> Summary:
    """A reconstruction in numbers that are strict JSON, in SI units and radians.

    Args:
        findings: findings of the reconstruction.

    Returns:
        What `schema.Summary` describes; what is not finite is None.
    """
    checks = findings.checks
    return {
        "schema": findings.schema,
        "scene": {"title": findings.scene.title, "name": findings.scene.name},
        "model": findings.description.name,
        "assumptions": list(findings.assumptions),
        "parameters": {name: _quantity(each) for name, each in findings.quantities.items()},
        "derived": {name: _quantity(each) for name, each in findings.derived.items()},
        "hours": {
            v: {str(hour): share for hour, share in shares.items()}
            for v, shares in findings.hours.items()
        },
        "correlations": [
            {"of": one, "and": other, "value": r}
            for (one, other), r in findings.correlations.items()
        ],
        "measured": {row.name: _measured(row) for row in findings.measured},
        "checks": {
            "divergences": checks.divergences,
            "pareto_k": None if checks.pareto_k is None else finite(checks.pareto_k),
            "max_rhat": finite(checks.max_rhat),
            "min_ess_bulk": finite(checks.min_ess_bulk),
            "min_ess_tail": finite(checks.min_ess_tail),
            "passed": bool(checks.passed),
            "reasons": list(checks.reasons),
            "flags": list(checks.flags),
        },
        "verdict": findings.verdict,
        "question": findings.question,
        "answers": dict(findings.answers),
        "seconds": {name: finite(value) for name, value in findings.seconds.items()},
        "versions": dict(findings.versions),
        "seed": findings.seed,
        "settings": dict(findings.settings),
        "complete": findings.complete,
        "notes": list(findings.notes),
        "ladder": ladder_data(findings.ladder) if findings.ladder else None,
        "left_out": {
            item.name: _left_out(item, findings.scene.sought) for item in findings.left_out
        },
        "causes": {
            name: {each.name: each.share for each in causes}
            for name, causes in findings.causes.items()
        },
        "narrowing": {
            name: {each.name: each.sd for each in known}
            for name, known in findings.narrowing.items()
        },
        "questions": [_question(each) for each in findings.questions],
        "sliding": {each.name: _by_sliding(each) for each in findings.sliding},
    }


def _quantity(found: Quantity) -> QuantityEntry:
    low, middle, high = LEVELS
    return {
        "unit": found.unit,
        "label": found.label,
        "mean": found.mean,
        "sd": found.sd,
        "median": found.median,
        "interval_50": list(found.intervals[low]),
        "interval_90": list(found.intervals[middle]),
        "interval_95": list(found.intervals[high]),
        "ess_bulk": found.ess_bulk,
        "ess_tail": found.ess_tail,
        "rhat": found.rhat,
        "mcse_mean": found.mcse_mean,
        "error": found.error,
        "error_50": found.errors[low],
        "error_90": found.errors[middle],
        "error_95": found.errors[high],
        "passed": found.passed,
        "withheld": found.withheld,
        "printed": {
            units: {
                "unit": each.unit.symbol,
                "decimals": each.decimals,
                "decimals_50": each.of_level[low],
                "decimals_90": each.of_level[middle],
                "decimals_95": each.of_level[high],
            }
            for units, each in found.precision.items()
        },
    }


def _measured(row: InputRow) -> MeasuredEntry:
    quantiles = row.quantiles
    return {
        "kind": row.kind,
        "label": row.label,
        "value": row.measured.value,
        "sd": row.measured.sd,
        "law": row.measured.law,
        "source": row.source,
        "assumed": row.assumed,
        "mean": row.mean,
        "sd_found": row.sd,
        "shift": row.shift,
        "quantiles": None if quantiles is None else list(quantiles),
    }


def _left_out(item: LeftOut, sought: str) -> LeftOutEntry:
    speed, sd = finite(item.speed), finite(item.speed_sd)
    of_b = sought == "speed_b"
    return {
        "value": item.value,
        "sd": item.sd,
        "expected": finite(item.expected),
        "expected_sd": finite(item.expected_sd),
        "probability": finite(item.probability),
        "speed_a": None if of_b else speed,
        "speed_a_sd": None if of_b else sd,
        "speed_b": speed if of_b else None,
        "speed_b_sd": sd if of_b else None,
        "pareto_k": finite(item.pareto_k),
        "believed": finite(item.believed),
        "moved": finite(item.moved),
        "believed_error": finite(item.believed_error),
        "moved_error": finite(item.moved_error),
        "reliable": item.reliable,
        "told": item.reliable,
        "disagrees": item.disagrees,
    }


def _by_sliding(found: BySliding) -> BySlidingEntry:
    return {
        "ended": _of_sliding(found.ended),
        "went_on": _of_sliding(found.went_on),
        "effective": found.effective,
    }


def _of_sliding(found: FitSummary) -> SlidingEntry:
    low, middle, high = LEVELS
    return {
        "median": found.median,
        "sd": found.sd,
        "interval_50": list(found.intervals[low]),
        "interval_90": list(found.intervals[middle]),
        "interval_95": list(found.intervals[high]),
    }


def _question(asked: Answered) -> QuestionEntry:
    return {
        "kind": asked.kind,
        "title": asked.title,
        "quantity": asked.quantity,
        "sentences": list(asked.sentences),
        "header": list(asked.header),
        "rows": [list(row) for row in asked.rows],
        "figure": asked.figure,
        "numbers": None if asked.numbers is None else _numbers(asked.numbers),
    }


def _numbers(found: Numbers) -> Any:
    match found:
        case Probability():
            return _probability(found)
        case LikelihoodRatio():
            return {
                "first": _probability(found.first),
                "second": _probability(found.second),
                "prior_first": found.prior_first,
                "prior_second": found.prior_second,
                "prior": found.prior,
                "likelihood_ratio": found.value,
                "log_error": found.error,
                "bound": found.bound,
            }
        case Avoidability():
            numbers = strict(asdict(found))
            asked = numbers.pop("asked")
            return {"vehicle": asked["vehicle"], "limit": asked["limit"]} | numbers
        case TimeDistance():
            return strict(asdict(found))
    return [_record(each) for each in found]


def _probability(found: Probability) -> ProbabilityEntry:
    asked = found.proposition
    return {
        "quantity": asked.name,
        "low": finite(asked.low),
        "high": finite(asked.high),
        "probability": found.value,
        "error": found.error,
        "at_least": found.at_least,
        "at_most": found.at_most,
        "effective": finite(found.effective),
        "pareto_k": None if found.pareto_k is None else finite(found.pareto_k),
    }


def _record(each: Corner | Effect | NamedCheck) -> dict[str, Any]:
    if isinstance(each, Effect):
        return {"name": each.name, "moved": each.moved, "error": finite(each.error)}
    return {k: v for k, v in strict(asdict(each)).items() if k != "dimension"}


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


def ladder_data(ladder: Ladder) -> LadderEntry:
    """A ladder in strict JSON, in SI units; what is not finite is None."""
    return {
        "scene": {"title": ladder.scene.title, "name": ladder.scene.name},
        "question": list(ladder.question),
        "choice": ladder.choice,
        "reason": ladder.reason,
        "share": ladder.share,
        "factor": ladder.factor,
        "seed": ladder.seed,
        "complete": ladder.complete,
        "steps": [strict(asdict(step)) for step in ladder.steps],
    }


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
    """Plain data without NaN and infinity, which JSON lacks: null stands for them."""
    if isinstance(value, dict):
        return {str(key): strict(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [strict(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
