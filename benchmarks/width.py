"""Why is an answer so wide? Takes the sd of impact-only and barrier cases apart; writes docs/width.md.

python3 -m uv run python -m benchmarks.width [folders]

The collisions are those of benchmarks.validation without whole scenes, by its model, method and seed.
What was computed is kept in out/benchmarks/width.json, and a run goes on from there: after a change of
the program delete that file.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from retrodict.models import parts

from benchmarks import page
from benchmarks.__main__ import DOCS
from benchmarks.validation import FOLDERS, METHOD, MODEL, ROOT
from retrodict.api import reconstruct
from retrodict.inference.outcome import Outcome
from retrodict.mechanics import Coefficients, critical_mu, separation
from retrodict.scene.load import load_scene
from retrodict.scene.records import Measured, Scene
from retrodict.scene.truth import load_truth
from retrodict.storage.files import write_whole
from retrodict.studies.fit import Summary, summary
from retrodict.studies.sliding import LEFT, left_of_sliding, log_ratio_of_ended, weighted
from retrodict.studies.validation import SCENE, TRUTH, cases, digest, kind_of

KEPT = ROOT / "out" / "benchmarks" / "width.json"
KINDS = ("impact only", "barrier")
# e and μ/μ_c of the 21 tests that the package's priors cite (SAE 2014-01-0469): mean and sd
PUBLISHED_E, PUBLISHED_SHARE = (0.091, 0.100), (0.953, 0.078)
FASTEST = 100.0  # m/s: no car is faster
SHARES_OF_ENDED = {"even": 0.5, "most": 0.83}  # the rule in docs/validation.md

# what is taken as known, and the prefixes of its flat names in the posterior
GROUPS: dict[str, tuple[str, ...]] = {
    "sliding left": ("left",),
    "e": ("e",),
    "e_m": ("e_m",),
    "contact line": ("Gamma",),
    "impact centre": ("impact_distance", "impact_angle"),
    "delta-v": ("change_x", "change_y"),
    "yaw rates": ("Omega", "omega"),
    "yaw inertia, mass": ("yaw_inertia", "mass"),
    "directions": ("heading", "direction"),
}
# the same of the inputs of the closed form
INPUTS = {
    "contact line": ("Gamma",),
    "impact centre": ("impact_distance", "impact_angle"),
    "delta-v": ("delta_v",),
    "yaw inertia, mass": ("yaw_inertia", "mass"),
    "e": ("e",),
    "μ/μ_c": ("share",),
}


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """The speed that a delta-v leads to with given e and μ/μ_c, no moment impulse (m/s).

    Args:
        speed: at the means of all inputs.
        sd: standard deviation propagated to first order.
        parts: contributions to it, by group of inputs.
    """

    speed: float
    sd: float
    parts: dict[str, float]


@dataclass(frozen=True, slots=True)
class Case:
    """A case, taken apart (SI units).

    Args:
        name: name of the case's folder.
        quantity: speed that was sought.
        truth: measured speed.
        groups: groups that the case is counted with.
        answer: the answer of the fullest model.
        known: sd of the answer were a group of quantities known exactly, by group.
        published: closed form with e and μ/μ_c at their published means and spread; None without a
            delta-v.
        ended: the same where μ = μ_c.
        by_prior: answers if sliding ended, if it went on, and under other priors of μ.
        effective: effective number of draws behind each of these.
    """

    name: str
    quantity: str
    truth: float
    groups: dict[str, str]
    answer: Summary
    known: dict[str, float]
    published: ClosedForm | None
    ended: ClosedForm | None
    by_prior: dict[str, Summary]
    effective: dict[str, float]


def main(*folders: Path) -> None:
    """Take apart every case that was not yet, then write the page."""
    kept = json.loads(KEPT.read_text("utf-8")) if KEPT.is_file() else {}
    found: list[Case] = []
    for folder in cases(*(folders or FOLDERS)):
        scene = load_scene(folder / SCENE)
        if kind_of(scene)["kind"] not in KINDS:
            continue
        key = " ".join(digest(folder / name) for name in (SCENE, TRUTH))
        if key not in kept:
            print(folder.name, flush=True)
            kept[key] = asdict(taken_apart(folder, scene))
            write_whole(KEPT, json.dumps(kept, indent=1, ensure_ascii=False).encode())
        found.append(case_of(kept[key]))
    tables = {"parts": parts_lines(found), "width": width_lines(found)}
    tables |= {"sliding": sliding_lines(found), "scores": score_lines(found)}
    page.refresh(DOCS / "width.md", tables)


def taken_apart(folder: Path, scene: Scene) -> Case:
    """A case's answer, and what makes its width; its truth is read last."""
    outcome = reconstruct(scene, model=MODEL, method=METHOD).outcome
    name = scene.sought
    draws = np.asarray(outcome.idata["posterior"][name]).ravel()
    other, effective = under_priors(outcome, draws)
    truth = load_truth(folder / TRUTH)
    speed = truth.speeds[name]
    return Case(
        name=folder.name,
        quantity=name,
        truth=speed.value,
        groups=kind_of(scene) | truth.groups,
        answer=summary(draws),
        known=known_sd(outcome, draws),
        published=closed_form(scene, PUBLISHED_SHARE),
        ended=closed_form(scene, (1.0, 0.0)),
        by_prior=other,
        effective=effective,
    )


def known_sd(outcome: Outcome, draws: np.ndarray) -> dict[str, float]:
    """Sd of an answer, were a group of quantities known exactly: what a quadratic in them leaves."""
    tree = outcome.idata["posterior"]
    values = {str(name): np.asarray(x).ravel() for name, x in tree.data_vars.items()}
    values["left"] = left_of_sliding(outcome)
    for v in outcome.scene.vehicles:
        for axis in "xy":
            values[f"change_{axis}_{v}"] = values[f"V{v}{axis}"] - before(outcome, values, v, axis)
    left = {}
    for group, prefixes in GROUPS.items():
        columns = [x for name, x in values.items() if _of(name, prefixes) and np.ptp(x) > 1e-12]
        if columns:
            left[group] = float(draws.std(ddof=1) * math.sqrt(unexplained(draws, columns)))
    return left


def _of(name: str, prefixes: tuple[str, ...]) -> bool:
    return any(name in (prefix, f"{prefix}_a", f"{prefix}_b") for prefix in prefixes)


def before(outcome: Outcome, values: Mapping[str, np.ndarray], v: str, axis: str) -> np.ndarray:
    """A vehicle's velocity before the impact along an axis, m/s."""
    inputs = outcome.scene.inputs()
    speed, direction = (
        values[name] if name in values else np.asarray(inputs[name].value)
        for name in (f"speed_{v}", f"direction_{v}")
    )
    return np.asarray(speed * (np.cos(direction) if axis == "x" else np.sin(direction)))


def unexplained(y: np.ndarray, columns: list[np.ndarray]) -> float:
    """Share of a variance that a quadratic in some quantities, fitted by least squares, leaves."""
    z = [(x - x.mean()) / x.std() for x in columns]
    squares = [a * b for a, b in combinations_with_replacement(z, 2)]
    design = np.stack([np.ones_like(y), *z, *squares], axis=1)
    fitted = design @ np.linalg.lstsq(design, y, rcond=None)[0]
    return float(np.var(y - fitted) / np.var(y))


def under_priors(
    outcome: Outcome, draws: np.ndarray
) -> tuple[dict[str, Summary], dict[str, float]]:
    """The answer if sliding ended, if it went on, and if it ends with a given probability."""
    log_ratio = log_ratio_of_ended(outcome)
    assert log_ratio is not None, "the fullest model has a free μ"
    ratio = np.exp(log_ratio)
    went_on = (left_of_sliding(outcome) > LEFT).astype(float)
    weights = {"ended": ratio, "went on": went_on}
    weights |= {name: w * ratio + 1 - w for name, w in SHARES_OF_ENDED.items()}
    answers = {name: weighted(draws, weight) for name, weight in weights.items()}
    effective = {name: float(w.sum() ** 2 / (w**2).sum()) for name, w in weights.items()}
    return answers, effective


def closed_form(scene: Scene, share: tuple[float, float]) -> ClosedForm | None:
    """The published method: the speed whose impact has the measured delta-v, and its propagated error.

    Args:
        scene: an impact with a measured delta-v and directions.
        share: mean and sd of μ/μ_c.

    Returns:
        Speed and sd, with e at its published mean and spread and e_m = 1; None without a delta-v.

    Source:
        SAE 770014 eqs 19-24; propagation to first order, JCGM 100:2008, 5.1.
    """
    sought = scene.sought[-1]
    measured = {
        v: each for v in (sought, *scene.vehicles) if (each := delta_v(scene, v)) is not None
    }
    if not measured:
        return None
    v = next(iter(measured))
    inputs = {name: m for name, m in scene.inputs().items() if name != scene.sought}
    inputs |= {"e": Measured(*PUBLISHED_E), "share": Measured(*share), "delta_v": measured[v]}
    if len(scene.vehicles) == 2 and f"direction_{sought}" not in inputs:
        return None
    at = {name: m.value for name, m in inputs.items()}
    size = _delta_v_of(scene.sought, tuple(at), "ab".index(v))

    def speed_of(x: Mapping[str, float]) -> float | None:
        row = jnp.array([x[name] for name in at])
        low, high = 0.0, FASTEST
        for _ in range(3):  # looks at ever shorter pieces
            grid = np.linspace(low, high, 201)
            off = np.asarray(size(row, grid)) - x["delta_v"]
            (turns,) = np.nonzero(np.diff(np.sign(off)))
            if not turns.size:
                return None
            last = turns[-1]  # the faster solution, where the other car's speed allows two
            low, high = float(grid[last]), float(grid[last + 1])
        below, above = off[last], off[last + 1]
        return float(low - below * (high - low) / (above - below))

    middle = speed_of(at)
    if middle is None:
        return None
    moved: dict[str, float] = {}
    for name, m in inputs.items():
        ends = [speed_of(at | {name: m.value + sign * m.sd}) for sign in (-1, 1)]
        low, high = (middle if end is None else end for end in ends)
        moved[name] = (high - low) / 2
    parts_of = {
        group: math.hypot(*(d for name, d in moved.items() if _of(name, prefixes)), 0.0)
        for group, prefixes in INPUTS.items()
    }
    return ClosedForm(middle, math.hypot(*moved.values()), parts_of)


def delta_v(scene: Scene, v: str) -> Measured | None:
    """A vehicle's measured delta-v, as its resultant; None where none was measured."""
    evidence = scene.evidence()
    if whole := evidence.get(f"departure_delta_v_{v}"):
        return whole
    both = [evidence.get(f"departure_delta_v_{part}_{v}") for part in ("forward", "left")]
    x, y = both
    if x is None or y is None:
        return None
    size = math.hypot(x.value, y.value)
    return Measured(size, math.hypot(x.value * x.sd, y.value * y.sd) / size)


def _delta_v_of(sought: str, names: tuple[str, ...], vehicle: int) -> Callable[..., Any]:
    """A vehicle's delta-v as a compiled function of the inputs and of sought speeds."""

    def size(row: jax.Array, speed: jax.Array) -> jax.Array:
        x = dict(zip(names, row, strict=True)) | {sought: speed}
        bodies = parts.bodies(x)
        of_a = parts.approach_of_a(x)
        if "mass_b" in x:
            spin = x.get("omega_b", jnp.zeros(()))
            to = x["direction_b"]
            of_b = jnp.stack([x["speed_b"] * jnp.cos(to), x["speed_b"] * jnp.sin(to), spin])
        else:
            of_b = jnp.zeros(3)
        start = jnp.concatenate([of_a, of_b])
        one = jnp.ones(())
        mu = x["share"] * critical_mu(start, bodies, x["e"], one)
        end = separation(start, bodies, Coefficients(x["e"], mu, one))
        return jnp.linalg.norm((end - start)[3 * vehicle : 3 * vehicle + 2])

    return jax.jit(jax.vmap(size, (None, 0)))


def case_of(row: Mapping[str, Any]) -> Case:
    """The case that a row of JSON was made of."""
    closed = {name: row[name] and ClosedForm(**row[name]) for name in ("published", "ended")}
    others = {name: _summary(each) for name, each in row["by_prior"].items()}
    return Case(**{**row, **closed, "answer": _summary(row["answer"]), "by_prior": others})


def _summary(row: Mapping[str, Any]) -> Summary:
    intervals = {int(level): tuple(bounds) for level, bounds in row["intervals"].items()}
    return Summary(row["median"], row["sd"], intervals)


def width_lines(found: Iterable[Case]) -> list[str]:
    """A row a case: its sd, what is left of it, and the closed form's."""

    def rows() -> Iterator[list[str]]:
        for case in found:
            median = case.answer.median
            yield [
                case.name,
                _percent(case.answer.sd / median),
                *(
                    _percent(case.known[group] / median) if group in case.known else "–"
                    for group in GROUPS
                ),
                _closed(case.published),
                _closed(case.ended),
            ]

    headings = ("case", "sd", *(f"{group} known" for group in GROUPS))
    return page.table((*headings, "closed form", "closed form, μ = μ_c"), rows())


def parts_lines(found: list[Case]) -> list[str]:
    """Medians over the cases of each kind of contact."""

    def rows() -> Iterator[list[str]]:
        for name, mine in groups_of(found):
            of_answer = [case.answer.sd / case.answer.median for case in mine]
            left = [
                [case.known[g] / case.answer.median for case in mine if g in case.known]
                for g in GROUPS
            ]
            yield [name, str(len(mine)), *map(_middle, (of_answer, *left))]

    return page.table(("group", "speeds", "median sd", *(f"{g} known" for g in GROUPS)), rows())


def groups_of(found: list[Case]) -> Iterator[tuple[str, list[Case]]]:
    """All cases, and those of each kind and contact."""
    yield "all", found
    for key in ("kind", "contact"):
        for label in dict.fromkeys(case.groups[key] for case in found if key in case.groups):
            yield f"{key}: {label}", [case for case in found if case.groups.get(key) == label]


ANSWERS = ("default", "ended", "went on", "by contact", *SHARES_OF_ENDED)


def answer_of(case: Case, which: str) -> Summary | None:
    """One of the answers that the rule names; None where it does not apply."""
    if which == "default":
        return case.answer
    if which == "by contact":
        of_group = {"non-sideswipe": "ended", "sideswipe": "went on"}
        which = of_group.get(case.groups.get("contact", ""), "")
    return case.by_prior.get(which)


def sliding_lines(found: Iterable[Case]) -> list[str]:
    """A row a case: the answers under each assumption, with a mark where 90 % holds the truth."""

    def cell(case: Case, which: str) -> str:
        if (each := answer_of(case, which)) is None:
            return "–"
        low, high = each.intervals[90]
        inside = "\\*" if low <= case.truth <= high else ""
        return f"{each.median:.1f}, {low:.1f} to {high:.1f}{inside}"

    shown = [name for name in ANSWERS if name != "by contact"]
    rows = (
        [
            case.name,
            case.groups.get("contact", "–"),
            f"{case.truth:.2f}",
            *(cell(case, which) for which in shown),
            f"{min(case.effective.values()):.0f}",
        ]
        for case in found
    )
    return page.table(("case", "contact", "true, m/s", *shown, "fewest effective draws"), rows)


def score_lines(found: list[Case]) -> list[str]:
    """How many intervals hold the truth, by group and answer."""

    def rows() -> Iterator[list[str]]:
        for name, mine in groups_of(found):
            for which in ANSWERS:
                known = [(c, each) for c in mine if (each := answer_of(c, which)) is not None]
                if not known:
                    continue
                inside = [
                    sum(
                        each.intervals[n][0] <= c.truth <= each.intervals[n][1] for c, each in known
                    )
                    for n in (50, 90, 95)
                ]
                errors = [each.median / c.truth - 1 for c, each in known]
                yield [
                    name,
                    which,
                    str(len(known)),
                    *map(str, inside),
                    _middle([each.sd / each.median for _, each in known]),
                    _middle(errors),
                ]

    headings = ("group", "answer", "speeds", "50 %", "90 %", "95 %", "median sd", "median error")
    return page.table(headings, rows())


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %".replace("-", "\N{MINUS SIGN}")


def _middle(shares: list[float]) -> str:
    return _percent(float(np.median(shares))) if shares else "–"


def _closed(found: ClosedForm | None) -> str:
    if found is None:
        return "–"
    name, size = max(found.parts.items(), key=lambda part: part[1])
    return f"{_percent(found.sd / found.speed)} ({name} {_percent(size / found.speed)})"


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
