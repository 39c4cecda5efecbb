"""Does the ladder choose well? Crashes at random, the truth of each on one rung in turn.

python3 -m uv run --group bench python -m benchmarks.ladder [scenes] [folder]

Asked is B's speed, which every rung answers. Rows are kept as they come in ladder.csv, and a run
goes on where the last one stopped; a folder, for a trial, leaves the page alone.
"""

from __future__ import annotations

import csv
import gc
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from retrodict.models import RUNGS as OF_ALL_KINDS
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure

from benchmarks import page
from benchmarks.__main__ import DOCS
from retrodict.inference.density.compiled import programs_for
from retrodict.inference.density.kernels import PRIOR, SIMULATE
from retrodict.mechanics import closing_speed
from retrodict.scene.records import VEHICLES, Measured, Rest, Scene, Surface
from retrodict.studies.comparison import FACTOR, MIN_PROBABILITY, SHARE, Step
from retrodict.studies.engine import engine
from retrodict.studies.fit import Fit, Summary
from retrodict.studies.ladder import blank, chosen, run_rung
from tests.shared import random_scenes

RUNGS = {name: rung for name, rung in OF_ALL_KINDS.items() if rung.impact.kind == "impact"}

NUMBER = 220
BATCH = 11  # scenes of a process at a time
QUESTION = ("speed_b",)
SLIDE = "momentum+slide"
SIMPLEST = "planar-common"  # impact whose impulse is taken where momentum leaves it open
# rungs whose crashes are drawn alike
ALIKE = tuple((f"momentum+{run_out}", f"{SIMPLEST}+{run_out}") for run_out in ("spin", "wheels"))
# other settings of the rule
SHARES, FACTORS = (0.1, 0.25, 0.5, 1.0, 1.5, 2.0), (1.25, 1.5, 2.0)
POSITION, HEADING = 0.2, 4 * random_scenes.DEGREE  # sd of a rest pose
COLUMNS = (
    "scene", "truth", "rung", "speed_b", "chosen", "counts", "fit_probability",
    "median", "sd", "low", "high", "log_evidence", "seconds",
)  # fmt: skip
Row = dict[str, str]


def crash(rung: str, rng: np.random.Generator) -> tuple[Scene, float]:
    """A plausible crash that went as a rung says, and B's true speed (m/s).

    The vehicles and what was measured of them are those of `synthetic`. Their true properties lie
    about what was measured as its errors say, B's approach and the coefficients come from the rung's
    priors, and the rest poses from its mechanics. What a rung leaves out is so that the fuller rungs
    are true as well, but for a straight slide: momentum alone leaves the impulse open, and it is that
    of the simplest planar impact; a road of one friction has the same on its second surface.
    """
    impact, _, run_out = rung.partition("+")
    full = rung if impact != "momentum" else f"{SIMPLEST}+{run_out.replace('slide', 'spin')}"
    while True:
        scene = random_scenes.scene(rng)[0]
        structure, data = RUNGS[full].of_scene(scene)
        programs = programs_for(structure)
        # as inference draws the prior, whose compiled program this shares
        sites = programs(PRIOR, int(rng.integers(2**31)), data)
        simulated = programs(SIMULATE, data, sites)
        found = np.flatnonzero(_plausible(structure, data, sites, simulated))
        if not found.size:
            continue
        first = found[0]
        if run_out != "wheels":
            road, berm = scene.surfaces
            friction = float(simulated[f"friction_{road.name}"][first])
            scene = replace(scene, surfaces=(road, _of_friction(berm, friction, rng)))
        if full != rung:
            structure, data = RUNGS[rung].of_scene(scene)
            sites = (
                {k: sites[k] for k in ("measured", "speed_b", "direction_b")}
                | {
                    "impulse_x": simulated["mass_b"] * (simulated["vbx"] - simulated["Vbx"]),
                    "impulse_y": simulated["mass_b"] * (simulated["vby"] - simulated["Vby"]),
                }
                | ({k: simulated[k] for k in ("Omega_a", "Omega_b")} if run_out != "slide" else {})
            )
            simulated = programs_for(structure)(SIMULATE, data, sites)
        rest = {v: _measured(simulated, v, first, rng) for v in VEHICLES}
        return replace(scene, rest=rest), float(sites["speed_b"][first])


def _of_friction(surface: Surface, friction: float, rng: np.random.Generator) -> Surface:
    """The surface, had its friction been this when it was measured."""
    m = surface.friction
    value = friction * np.exp(m.sd / m.value * rng.standard_normal())
    return replace(surface, friction=replace(m, value=value, sd=m.sd / m.value * value))


def _plausible(structure: Structure, data: Data, sites: dict, simulated: dict) -> np.ndarray:
    """Which of the candidates drive and close in, lose energy, and neither spin nor travel too far."""

    def closing(xi: jax.Array, velocity: jax.Array) -> jax.Array:
        x = parts.from_standard(structure, data, xi)
        approach = jnp.concatenate([parts.approach_of_a(x), velocity, jnp.zeros(1)])
        return closing_speed(approach, parts.bodies(x))

    velocity = jnp.stack([simulated["vbx"], simulated["vby"]], axis=1)
    good = np.asarray(jax.vmap(closing)(sites["measured"], velocity)) > 3
    good &= (np.asarray(sites["speed_b"]) > 3) & (np.asarray(sites["speed_b"]) < 30)
    good &= np.asarray(simulated["energy_lost"]) > 0
    for v in VEHICLES:
        good &= np.abs(simulated[f"Omega_{v}"]) < 12
        for part in ("x", "y"):
            good &= np.abs(simulated[f"predicted/rest_{part}_{v}"]) < 50
    return good


def _measured(simulated: dict, v: str, i: int, rng: np.random.Generator) -> Rest:
    # a straight slide predicts no heading: that of the impact is kept
    heading = simulated.get(f"predicted/rest_heading_{v}", simulated[f"heading_{v}"])[i]
    x, y = (simulated[f"predicted/rest_{part}_{v}"][i] for part in ("x", "y"))
    noisy = (
        Measured(float(value) + sd * rng.standard_normal(), sd)
        for value, sd in ((x, POSITION), (y, POSITION), (heading, HEADING))
    )
    return Rest(*noisy, turns_known=True)


def rows_of(
    index: int, truth: str, speed_b: float, steps: tuple[Step, ...], choice: str | None
) -> Iterator[dict[str, object]]:
    """What each rung said of a scene, for the table."""
    for step in steps:
        row: dict[str, object] = {"scene": index, "truth": truth, "rung": step.name}
        row |= {"speed_b": f"{speed_b:.4f}", "chosen": int(step.name == choice)}
        row |= {"counts": int(step.counts), "seconds": f"{step.seconds or 0:.2f}"}
        if step.fit:
            answer = step.answers["speed_b"]
            low, high = answer.intervals[90]
            numbers = {"median": answer.median, "sd": answer.sd, "low": low, "high": high}
            row |= {k: f"{v:.4f}" for k, v in numbers.items()}
            row["fit_probability"] = f"{step.fit.probability:.3g}"
            if step.log_evidence is not None:
                row["log_evidence"] = f"{step.log_evidence:.3f}"
        yield row


def same_answer(mine: Row, other: Row, share: float, factor: float) -> bool:
    """Whether an answer is that of the other, by the ladder's own measure."""
    shift = abs(float(mine["median"]) - float(other["median"])) / float(other["sd"])
    width = float(mine["sd"]) / float(other["sd"])
    return shift <= share and 1 / factor <= width <= factor


def covered(row: Row) -> bool:
    """Whether the 90 % interval holds the truth."""
    return float(row["low"]) <= float(row["speed_b"]) <= float(row["high"])


def kind_of(rows: list[Row], share: float = SHARE, factor: float = FACTOR) -> str:
    """What the choice on one scene is beside its truth; the same answer is so by share and factor."""
    truth = rows[0]["truth"]
    mine = next((row for row in rows if row["rung"] == truth), None)
    choice = next((row for row in rows if row["chosen"] == "1"), None)
    if choice is None:
        return "none"
    if choice["rung"] == truth:
        return "true"
    same = bool(mine and mine["median"]) and same_answer(choice, mine, share, factor)
    true, taken = RUNGS[truth], RUNGS[choice["rung"]]
    side = "lower" if true.nests(taken) else "fuller" if taken.nests(true) else "beside"
    return f"{side}, {'same' if same else 'other'} answer"


KINDS = (
    "true", "lower, same answer", "lower, other answer", "fuller, same answer",
    "fuller, other answer", "beside, same answer", "beside, other answer", "none",
)  # fmt: skip


def tables(rows: list[Row]) -> page.Parts:
    """What stands between the markers of docs/ladder.md."""
    scenes: dict[str, list[Row]] = {}
    for row in rows:
        scenes.setdefault(row["scene"], []).append(row)
    kinds = {index: kind_of(mine) for index, mine in scenes.items()}
    choices = [row for row in rows if row["chosen"] == "1"]
    good = sum(kind in KINDS[:2] for kind in kinds.values())
    hits = sum(map(covered, choices))
    seconds = [sum(float(row["seconds"]) for row in mine) for mine in scenes.values()]
    true = [row for row in rows if row["rung"] == row["truth"] and row["median"]]
    moves = np.array(list(_moves_of_truth(rows, true)))
    beside = [index for index, kind in kinds.items() if kind.startswith(("fuller", "beside"))]
    moved = [any(m > SHARE for m in _moves_of_truth(scenes[index], true)) for index in beside]
    summary = [
        f"- Scenes: {len(scenes)}.",
        f"- The true rung, or a lower one with the same answer, was chosen in {good} of "
        f"{len(scenes)} ({good / len(scenes):.0%}); the target is 90 %.",
        f"- The 90 % interval of the rung chosen holds B's true speed in {hits} of {len(choices)} "
        f"({hits / max(1, len(choices)):.0%}); the target is 85 to 95 %.",
        f"- That of the true rung holds it in {sum(map(covered, true))} of {len(true)}.",
        f"- {moves.size} pairs of a true rung and a fuller one, which both fit: the fuller moves the "
        f"answer by {np.sqrt(np.mean(moves**2)):.2f} of its sd in the root mean square, by more than "
        f"{SHARE:g} in {np.mean(moves > SHARE):.0%}.",
        f"- Of the {len(beside)} scenes whose choice lies beside or above the truth, a fuller rung "
        f"moved the true one's answer so far in {sum(moved)}.",
        _bound(scenes),
        _by_evidence(scenes),
        f"- Seconds a scene, all rungs, without compilation: median {np.median(seconds):.1f}. Of each "
        f"rung: {', '.join(_seconds(rows))}.",
    ]
    heading = ["true rung", "scenes", *KINDS, "chosen covers"]
    choice = page.table(heading, _choices(scenes, kinds))
    heading = ["chosen, beside the true rung", "scenes", "90 % covers", "that of the true rung"]
    heading += ["rms error, m/s", "that of the true rung", "width, of the true rung's"]
    cost = page.table(heading, _costs(scenes, kinds))
    heading = ["rung", "scenes", "mean error, m/s", "rms error, m/s", "rms error, its sd"]
    heading += ["90 % covers", "refused by its fit", "left out: checks failed"]
    bias = page.table(heading, _biases(rows))
    settings = [(share, factor) for factor in FACTORS for share in SHARES]
    heading = ["share", "factor", "true, or lower with the same answer"]
    heading += [
        "the same by that share and factor",
        "chosen covers",
        "rms error, m/s",
        "width, of the fullest's",
    ]
    others = page.table(heading, (_setting(scenes, *setting) for setting in settings))
    return {
        "summary": summary,
        "choices": choice,
        "costs": cost,
        "settings": others,
        "biases": bias,
    }


def _seconds(rows: list[Row]) -> Iterator[str]:
    """Each rung and what it takes in the median."""
    for rung in RUNGS:
        taken = [float(row["seconds"]) for row in rows if row["rung"] == rung and row["median"]]
        yield f"{rung} {np.median(taken or [np.nan]):.2f}"


def _bound(scenes: dict[str, list[Row]]) -> str:
    """What no rule does better than: crashes on momentum and on `SIMPLEST` are drawn alike.

    Of two crashes that cannot be distinguished a rule is right about one, unless one choice is right for
    both; it can be no better than right about all others.
    """
    mine = [(p, rows) for p in ALIKE for rows in scenes.values() if rows[0]["truth"] in p]
    both = sum(_one_is_right_for(pair, rows) for pair, rows in mine)
    best = (len(mine) + both) / 2
    return (
        f"- Of {len(mine)} crashes on {', '.join(name for pair in ALIKE for name in pair)}, drawn alike "
        f"for either impact, one choice is right for both in {both}. So a rule that sees only the scene "
        f"can be right in at most {best / max(1, len(mine)):.0%} of them, and in at most "
        f"{(len(scenes) - len(mine) + best) / len(scenes):.0%} of all crashes if it is right about "
        "every other one."
    )


def _one_is_right_for(truths: tuple[str, ...], rows: list[Row]) -> bool:
    """Whether one rung would be a right choice were any of these the truth."""
    return any(all(_right(rows, name, truth) for truth in truths) for name in _with_answer(rows))


def _right(rows: list[Row], name: str, truth: str) -> bool:
    """Whether a choice would be right were this the truth."""
    return kind_of([row | {"truth": truth} for row in _chosen(rows, name)]) in KINDS[:2]


def _chosen(rows: list[Row], name: str | None) -> list[Row]:
    """The rows of a scene, had this rung been chosen."""
    return [row | {"chosen": str(int(row["rung"] == name))} for row in rows]


def _with_answer(rows: list[Row]) -> list[str]:
    """Rungs that have an answer."""
    return [row["rung"] for row in rows if _answered(row)]


def _answered(row: Row) -> bool:
    return row["median"] not in ("", "nan")


def _by_evidence(scenes: dict[str, list[Row]]) -> str:
    """How often a rule is right that knows how the crashes are made, and goes by the log evidence."""
    kinds, expected = [], 0.0
    for rows in scenes.values():
        truths = _probable(rows)
        hopes = {
            name: sum(p for truth, p in truths.items() if _right(rows, name, truth))
            for name in _with_answer(rows)
        }
        best = max(hopes, key=hopes.__getitem__)
        kinds.append(kind_of(_chosen(rows, best)))
        expected += hopes[best]
    right = sum(kind in KINDS[:2] for kind in kinds)
    return (
        "- A rule that knows how these crashes are made, every rung as likely as another, and takes "
        "what by the log evidence is most probably right expects to be right in "
        f"{expected / len(scenes):.0%}, and is in {right} of {len(scenes)} ({right / len(scenes):.0%}); "
        f"it takes a lower rung with another answer in {kinds.count(KINDS[2])}."
    )


def _probable(rows: list[Row]) -> dict[str, float]:
    """How probable each rung is as the truth of a scene, if one is as likely as another beforehand."""
    if rows[0]["truth"] == SLIDE:  # given away by rest headings, which are those of the impact
        return {SLIDE: 1.0}
    evidences = {row["rung"]: float(row["log_evidence"]) for row in rows if row["log_evidence"]}
    evidences.pop(SLIDE, None)
    evidences |= {
        a: evidences[b] for a, b in ALIKE if b in evidences
    }  # whose crashes are drawn from b's priors
    most = max(evidences.values())
    weights = {name: np.exp(value - most) for name, value in evidences.items()}
    return {name: weight / sum(weights.values()) for name, weight in weights.items()}


def _moves_of_truth(rows: list[Row], true: list[Row]) -> Iterator[float]:
    """How far each fuller rung moves the true one's answer, in its own sd, where both fit."""
    for mine in true:
        for row in rows:
            fuller = RUNGS[row["rung"]].nests(RUNGS[mine["rung"]])
            if fuller and row["scene"] == mine["scene"] and row["counts"] == mine["counts"] == "1":
                yield abs(float(row["median"]) - float(mine["median"])) / float(row["sd"])


def _choices(scenes: dict[str, list[Row]], kinds: dict[str, str]) -> Iterator[list[str]]:
    for truth in RUNGS:
        mine = [index for index, rows in scenes.items() if rows[0]["truth"] == truth]
        chosen = [row for index in mine for row in scenes[index] if row["chosen"] == "1"]
        counts = [str(sum(kinds[index] == kind for index in mine)) for kind in KINDS]
        yield [truth, str(len(mine)), *counts, f"{sum(map(covered, chosen))} of {len(chosen)}"]


def _costs(scenes: dict[str, list[Row]], kinds: dict[str, str]) -> Iterator[list[str]]:
    """Of each kind of choice: whether its answers are worse than the true rung's of the same scenes.

    Without crashes on a straight slide, of which the fuller rungs are not true.
    """
    for kind in KINDS[:-1]:
        pairs = []
        for index, rows in scenes.items():
            choice = [row for row in rows if row["chosen"] == "1"]
            mine = [row for row in rows if row["rung"] == row["truth"] and _answered(row)]
            if kinds[index] == kind and choice and mine and mine[0]["truth"] != SLIDE:
                pairs.append((choice[0], mine[0]))
        if pairs:
            hits = [
                f"{sum(map(covered, each))} of {len(pairs)}" for each in zip(*pairs, strict=True)
            ]
            errors = [f"{_rms_error(each):.2f}" for each in zip(*pairs, strict=True)]
            width = np.median([float(one["sd"]) / float(other["sd"]) for one, other in pairs])
            yield [kind, str(len(pairs)), *hits, *errors, f"{width:.2f}"]


def _rms_error(rows: Iterable[Row]) -> float:
    """Of medians, m/s."""
    error = [float(row["median"]) - float(row["speed_b"]) for row in rows]
    return float(np.sqrt(np.mean(np.square(error))))


def _setting(scenes: dict[str, list[Row]], share: float, factor: float) -> list[str]:
    """What the rule would choose with another share and factor."""
    again = {index: rechosen(rows, share, factor) for index, rows in scenes.items()}
    rights = [
        sum(kind_of(rows, *same) in KINDS[:2] for rows in again.values())
        for same in ((SHARE, FACTOR), (share, factor))
    ]
    choices = [row for rows in again.values() for row in rows if row["chosen"] == "1"]
    width = []
    for rows in again.values():
        mine = [row for row in rows if row["chosen"] == "1"]
        if mine:
            fullest = [row for row in rows if row["counts"] == "1"][-1]
            width.append(float(mine[0]["sd"]) / float(fullest["sd"]))
    return [
        f"{share:g}",
        f"{factor:g}",
        *(f"{right} of {len(scenes)} ({right / len(scenes):.0%})" for right in rights),
        f"{sum(map(covered, choices))} of {len(choices)} "
        f"({sum(map(covered, choices)) / max(1, len(choices)):.0%})",
        f"{_rms_error(choices):.2f}",
        f"{np.median(width):.2f}",
    ]


def rechosen(rows: list[Row], share: float, factor: float) -> list[Row]:
    """The rows of a scene, had the rule had this share and factor."""
    steps = []
    for row in rows:
        step = blank(row["rung"], "")
        if row["median"]:
            answer = Summary(float(row["median"]), float(row["sd"]), {})
            fit = Fit((), 0.0, 1.0, float(row["fit_probability"]))
            reasons = () if row["counts"] == "1" else ("does not count",)
            step = replace(step, answers={"speed_b": answer}, fit=fit, reasons=reasons)
        steps.append(step)
    return _chosen(rows, chosen(steps, QUESTION, share, factor)[1])


def _biases(rows: list[Row]) -> Iterator[list[str]]:
    """Of each rung, where the truth stands on a fuller one."""
    for rung in RUNGS:
        below = [row for row in rows if RUNGS[row["truth"]].nests(RUNGS[rung])]
        answered = [row for row in below if row["rung"] == rung and _answered(row)]
        mine = [row for row in answered if row["counts"] == "1" or _misfit(row)]
        if mine:
            error = np.array([float(row["median"]) - float(row["speed_b"]) for row in mine])
            in_sd = error / [float(row["sd"]) for row in mine]
            yield [
                rung,
                str(len(mine)),
                f"{error.mean():+.2f}",
                f"{np.sqrt(np.mean(error**2)):.2f}",
                f"{np.sqrt(np.mean(in_sd**2)):.1f}",
                f"{sum(map(covered, mine))} of {len(mine)}",
                str(sum(map(_misfit, mine))),
                str(len(answered) - len(mine)),
            ]


def _misfit(row: Row) -> bool:
    """Whether a rung that has an answer does not fit."""
    return float(row["fit_probability"]) < MIN_PROBABILITY


def main(count: int = NUMBER, charts: Path = DOCS / "charts") -> None:
    """Go on with the table until so many scenes stand in it, then write the results."""
    charts.mkdir(parents=True, exist_ok=True)
    file = charts / "ladder.csv"
    new = not file.exists() or not file.stat().st_size
    done = set() if new else {int(row["scene"]) for row in _read(file)}
    with file.open("a", newline="") as kept:
        writer = csv.DictWriter(kept, COLUMNS, lineterminator="\n")
        if new:
            writer.writeheader()
            kept.flush()
        missing = [i for i in range(count) if i not in done]
        batches = [missing[i : i + BATCH] for i in range(0, len(missing), BATCH)]
        with engine() as running:
            for rows in running.results(_on_scenes, batches):
                writer.writerows(rows)
                kept.flush()
                for row in rows:
                    if row["chosen"]:
                        print(f"{row['scene']:4d}  {row['truth']}: {row['rung']}", flush=True)
    parts_of_page = tables(_read(file))
    if charts == DOCS / "charts":
        page.refresh(DOCS / "ladder.md", parts_of_page)
    print("\n".join(line for lines in parts_of_page.values() for line in [*lines, ""]))


def _on_scenes(indices: list[int]) -> list[dict[str, object]]:
    """The rows of some scenes, rung by rung: the programs of all rungs are too many to be kept."""
    truths = {i: list(RUNGS)[i % len(RUNGS)] for i in indices}
    in_turn = sorted(indices, key=truths.__getitem__)
    made = {i: crash(truths[i], np.random.default_rng(i)) for i in in_turn}
    steps: dict[int, list[Step]] = {i: [] for i in indices}
    for name in RUNGS:
        for i in indices:
            steps[i].append(run_rung(made[i][0], name, QUESTION, i))
        gc.collect()
    return [
        row
        for i in indices
        for row in rows_of(i, truths[i], made[i][1], *chosen(steps[i], QUESTION)[:2])
    ]


def _read(file: Path) -> list[Row]:
    with file.open(newline="") as kept:
        return list(csv.DictReader(kept))


if __name__ == "__main__":
    from benchmarks.ladder import main  # whose jobs workers can import

    main(*map(int, sys.argv[1:2]), *map(Path, sys.argv[2:3]))
