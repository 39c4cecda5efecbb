"""What was found, as data: the summary that is saved as JSON, and the rows that are printed."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr

from retrodict.inference.digits import decimals_of, monte_carlo_error
from retrodict.report.rounding import told, told_with_sd
from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.quantities import Unit, Units, describe, unit_of
from retrodict.studies.conflict import conflicts
from retrodict.studies.narrowing import Narrowed, narrowing

if TYPE_CHECKING:
    import pandas as pd

    from retrodict.inference.outcome import Outcome
    from retrodict.scene.records import Measured
    from retrodict.studies.ladder import Ladder


SUMMARY = "summary.json"
LEVELS = (50, 90, 95)  # per cent; not those of studies.fit, which brings JAX
_ERRORS = ("error", *(f"error_{level}" for level in LEVELS))  # Monte Carlo; `error` is the middle's
NOT_TO_BE_RELIED_ON = "NOT TO BE RELIED ON"

# what follows from the same draws and is told beside the unknowns
DERIVED = (
    "delta_v_a",
    "delta_v_b",
    "energy_lost",
    "Vax",
    "Vay",
    "Omega_a",
    "Vbx",
    "Vby",
    "Omega_b",
)


def draws(outcome: Outcome, group: str, name: str) -> np.ndarray | None:
    """The finite draws of a variable in one row, or None where the group or variable is missing."""
    if group not in outcome.idata.children or name not in outcome.idata[group].data_vars:
        return None
    values = np.asarray(outcome.idata[group][name].values, dtype=float).ravel()
    values = values[np.isfinite(values)]
    return values if values.size else None


def told_as(name: str, units: Units) -> tuple[str, Unit]:
    """Label and unit of any quantity that is reported: unknown, derived, input or evidence.

    Args:
        name: its flat name.
        units: "si" or "us".

    Returns:
        (label, unit).

    Raises:
        KeyError: no quantity has that name.
    """
    label, dimension = describe(name)
    return label, unit_of(dimension, units)


def assumptions(outcome: Outcome) -> tuple[str, ...]:
    """What is taken for granted: by the model, and how far its run-out is taken to miss a car."""
    vehicles, found = outcome.scene.vehicles, list(outcome.description.assumptions)
    missing = {name for name, m in outcome.scene.evidence().items() if m.model_sd}
    for v in sorted({name[-1] for name in missing}):
        missed = vehicles[v].run_out_error
        long = f"{DEFAULTS['run_out_settled'].of(0.0):g} m"
        of_each = (
            (
                missed.position,
                False,
                f"each coordinate of {v.upper()}'s place",
                0.01,
                "% of its way",
            ),
            (
                missed.heading,
                True,
                f"{v.upper()}'s heading",
                math.radians(1),
                f"deg after {long} of it",
            ),
        )
        found += [
            f"beyond what its inputs explain, the run-out misses {what} by "
            f"{told(m.value / worth, decimals_of(m.value / worth))} {unit} from the impact (one "
            f"standard deviation; {m.source or 'source not given'})"
            for m, turns, what, worth, unit in of_each
            if any(n[-1] == v and ("heading" in n) == turns for n in missing)
        ]
    return tuple(found)


def narrowed(outcome: Outcome) -> dict[str, tuple[Narrowed, ...]]:
    """What would narrow each speed that was sought; nothing where checks failed."""
    if not outcome.checks.passed:
        return {}
    sought = [name for name in reported(outcome) if name in ("speed_a", "speed_b")]
    found = {name: narrowing(outcome, name) for name in sought}
    return {name: known for name, known in found.items() if known}


def reported(outcome: Outcome, names: Iterable[str] | None = None) -> tuple[str, ...]:
    """Which quantities a model tells of: a simpler one knows fewer.

    Args:
        outcome: the reconstruction.
        names: to choose from; None for those that its scene reports.

    Returns:
        Those that it has draws of, in their order.
    """
    names = outcome.scene.reported() if names is None else names
    if "posterior" not in outcome.idata.children:
        return tuple(names)
    return tuple(name for name in names if name in outcome.idata["posterior"].data_vars)


def summarise(outcome: Outcome, ladder: Ladder | None = None) -> dict[str, Any]:
    """A reconstruction in numbers that are strict JSON, in SI units and radians.

    Args:
        outcome: the reconstruction.
        ladder: what the other models say, where the ladder chose this one.

    Returns:
        scene, model, assumptions, parameters (statistics of each reported quantity, with `passed`
        for the checks of its own), checks, seconds, versions, seed, settings, complete, ladder,
        left_out: what all else says of each item of evidence, and narrowing: the sd of each speed
        that was sought, were a quantity known exactly. What is not finite is None.
    """
    checks = outcome.checks
    parameters = {}
    for name, numbers in statistics(outcome, reported(outcome)).items():
        label, unit = told_as(name, "si")
        whole = numbers["mean"] is not None
        passed = whole and name not in checks.failed
        parameters[name] = {"unit": unit.symbol, "label": label, **numbers, "passed": passed}
    return {
        "scene": {"title": outcome.scene.title, "name": outcome.scene.name},
        "model": outcome.description.name,
        "assumptions": list(assumptions(outcome)),
        "parameters": parameters,
        "checks": {
            "divergences": checks.divergences,
            "pareto_k": None if checks.pareto_k is None else _finite(checks.pareto_k),
            "max_rhat": _finite(checks.max_rhat),
            "min_ess_bulk": _finite(checks.min_ess_bulk),
            "min_ess_tail": _finite(checks.min_ess_tail),
            "passed": bool(checks.passed),
            "reasons": list(checks.reasons),
            "flags": list(checks.flags),
        },
        "seconds": {name: _finite(value) for name, value in outcome.seconds.items()},
        "versions": dict(outcome.versions),
        "seed": int(outcome.seed),
        "settings": dict(outcome.settings),
        "complete": bool(outcome.complete),
        "ladder": ladder_data(ladder) if ladder else None,
        "left_out": {
            item.name: {k: _finite(v) for k, v in asdict(item).items() if k != "name"}
            | {"told": item.told, "disagrees": item.disagrees}
            for item in conflicts(outcome)
        },
        "narrowing": {
            name: {each.name: each.sd for each in known}
            for name, known in narrowed(outcome).items()
        },
    }


def summary_json(
    outcome: Outcome, beside: Mapping[str, bytes], ladder: Ladder | None = None
) -> bytes:
    """`summarise` as a JSON file, with the digests of the files of the same result.

    Args:
        outcome: the reconstruction.
        beside: what these files hold, by path from where the summary is.
        ladder: as for `summarise`.

    Returns:
        What the file holds; its entry `files` has the SHA-256 of each of the others.
    """
    content = summarise(outcome, ladder) | {"files": {k: _digest(v) for k, v in beside.items()}}
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    return f"{text}\n".encode()


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
        directory: with a summary that `read_summary` can read.

    Returns:
        Their paths in the folder, those that are missing among them.
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


def ladder_data(ladder: Ladder) -> dict[str, Any]:
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
        "steps": [_strict(asdict(step)) for step in ladder.steps],
    }


def summary_frame(outcome: Outcome, units: Units = "si") -> pd.DataFrame:
    """The reported quantities in a table of numbers.

    Args:
        outcome: the reconstruction.
        units: "si" or "us".

    Returns:
        One row a quantity, one column a statistic. The column `checks` says what to make of the
        row; numbers of a quantity that failed a check of its own are NaN, its diagnostics are not.
    """
    import pandas as pd

    told = ["mean", "sd", "median", *(f"hdi_{level}" for level in LEVELS), "mcse_mean"]
    verdict = "passed" if outcome.checks.passed else NOT_TO_BE_RELIED_ON
    rows = {}
    for name, entry in summarise(outcome)["parameters"].items():
        unit = told_as(name, units)[1]
        row: dict[str, Any] = {"unit": unit.symbol}
        for key in told:
            value = scaled(entry[key], unit.worth) if entry["passed"] else None
            if key.startswith("hdi"):
                row[f"{key}_low"], row[f"{key}_high"] = value or (None, None)
            else:
                row[key] = value
        row |= {key: entry[key] for key in ("ess_bulk", "ess_tail", "rhat")}
        rows[name] = row | {"checks": verdict if entry["passed"] else "failed"}
    frame = pd.DataFrame.from_dict(rows, orient="index")
    numbers = frame.columns.drop(["unit", "checks"])
    return frame.astype(dict.fromkeys(numbers, float))


def statistics(outcome: Outcome, names: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    """Mean, sd, median, shortest intervals and diagnostics of the posterior draws of quantities.

    Args:
        outcome: the reconstruction.
        names: of variables in the posterior group.

    Returns:
        For each name: mean, sd, median, hdi_50, hdi_90, hdi_95, ess_bulk, ess_tail, rhat,
        mcse_mean, error (`monte_carlo_error` of mean and median), error_50, error_90 and error_95
        in SI units; None where not finite or where the variable is missing.
    """
    # arviz_stats takes a while to import, and a summary is not always asked for
    from arviz_stats import ess, hdi, mcse, rhat

    idata = outcome.idata
    posterior = idata["posterior"].to_dataset() if "posterior" in idata.children else xr.Dataset()
    there = [name for name in names if name in posterior.data_vars]
    blank = dict.fromkeys(("mean", "sd", "median"))
    blank_intervals = {f"hdi_{level}": [None, None] for level in LEVELS}
    blank_checks = dict.fromkeys(("ess_bulk", "ess_tail", "rhat", "mcse_mean", *_ERRORS))
    found: dict[str, dict[str, Any]] = {
        name: {**blank, **blank_intervals, **blank_checks} for name in names
    }
    if not there:
        return found
    data = posterior[there]
    with np.errstate(all="ignore"):
        measures = {
            "mean": data.mean(),
            "sd": data.std(ddof=1),
            "median": data.median(),
            "ess_bulk": ess(data, method="bulk"),
            "ess_tail": ess(data, method="tail"),
            "rhat": rhat(data, method="rank"),
            "mcse_mean": mcse(data, method="mean"),
            "error": monte_carlo_error(data, 0),
            **{f"error_{level}": monte_carlo_error(data, level / 100) for level in LEVELS},
        }
        intervals = {level: hdi(data, prob=level / 100, method="nearest") for level in LEVELS}
    for name in there:
        for key, measure in measures.items():
            found[name][key] = _finite(measure[name])
        for level, interval in intervals.items():
            found[name][f"hdi_{level}"] = [_finite(bound) for bound in interval[name].values]
    return found


@dataclass(frozen=True, slots=True)
class InputRow:
    """A measured quantity beside what the reconstruction made of it (SI units, radians).

    Args:
        name: its flat name.
        kind: "input" or "evidence".
        measured: as in the scene.
        mean: posterior mean of an input, posterior-predictive mean of an item of evidence.
        sd: likewise.
        shift: mean less measured, in standard deviations, the model's error included; None for an
            exact input.
    """

    name: str
    kind: Literal["input", "evidence"]
    measured: Measured
    mean: float | None
    sd: float | None
    shift: float | None

    @property
    def label(self) -> str:
        """What it is, in words."""
        return told_as(self.name, "si")[0]

    @property
    def source(self) -> str:
        """Who measured it and how."""
        return self.measured.source

    @property
    def assumed(self) -> str:
        """What of it is a default: "" (nothing), "sd" or "value"."""
        return self.measured.assumed

    def unit(self, units: Units) -> str:
        """Symbol of the unit it is told in."""
        return told_as(self.name, units)[1].symbol

    def told_measured(self, units: Units) -> str:
        """Measured value ± sd of the measurement, rounded."""
        worth = told_as(self.name, units)[1].worth
        return told_with_sd(self.measured.value / worth, self.measured.measured_sd / worth)

    def told_model(self, units: Units) -> str:
        """By how much the model is taken to miss it, one sd, rounded; empty for none."""
        sd = self.measured.model_sd / told_as(self.name, units)[1].worth
        return f"± {told(sd, decimals_of(sd))}" if sd else ""

    def told_found(self, units: Units) -> str:
        """Posterior or predictive mean ± sd, rounded."""
        worth = told_as(self.name, units)[1].worth
        return told_with_sd(scaled(self.mean, worth), scaled(self.sd, worth))

    def told_shift(self) -> str:
        """The shift with its sign, to a tenth of a standard deviation."""
        text = told(self.shift, 1)
        return f"+{text}" if self.shift is not None and round(self.shift, 1) > 0 else text


def inputs_table(outcome: Outcome) -> list[InputRow]:
    """Every measured input and item of evidence with what became of it.

    Args:
        outcome: the reconstruction.

    Returns:
        Rows: the inputs in the scene's order, then the evidence.
    """
    rows = []
    kinds: tuple[tuple[Literal["input", "evidence"], str, dict[str, Measured]], ...] = (
        ("input", "posterior", outcome.scene.inputs()),
        ("evidence", "posterior_predictive", outcome.scene.evidence()),
    )
    for kind, group, items in kinds:
        for name, measured in items.items():
            values = draws(outcome, group, name) if measured.sd > 0 else None
            mean = sd = shift = None
            if values is not None:
                mean, sd = float(values.mean()), float(values.std(ddof=min(1, values.size - 1)))
                shift = (mean - measured.value) / measured.sd
            rows.append(InputRow(name, kind, measured, mean, sd, shift))
    return rows


def scaled(value: Any, worth: float) -> Any:
    """A number, or a list of them, in a unit of that worth; None stays None."""
    if isinstance(value, list):
        return [scaled(each, worth) for each in value]
    return None if value is None else value / worth


def _strict(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _strict(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_strict(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _finite(value: Any) -> float | None:
    number = float(value)
    return number if math.isfinite(number) else None
