"""Scores over the rows of all scenes: the parts of docs/rolling.md, and its chart."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator
from scipy.stats import binomtest

from benchmarks import page
from benchmarks.machine import machine
from benchmarks.rolling import scenes
from benchmarks.rolling.runs import QUANTITIES, Row
from retrodict.report.figures import drawing

ANSWERED, COVERED, MEDIAN, WORST = 0.9, (0.84, 0.96), 15.0, 60.0  # targets; the last two in seconds
GROUPS = ((1, 2), (3, 4), (5, 6), (7, 8))  # of rolling wheels, both vehicles together
FAR = 4.0  # posterior sd
_COLOURS = {"answered": drawing.BLUE, "withheld": drawing.ORANGE}


def answered(row: Row) -> bool:
    """Whether a scene has an answer whose checks passed."""
    return row["status"] == "answered"


def covered(row: Row, quantity: str, level: str = "90") -> bool:
    """Whether the interval of that level, in per cent, holds the truth."""
    low, true, high = (
        float(row[f"{quantity}_{k}"]) for k in (f"low_{level}", "true", f"high_{level}")
    )
    return low <= true <= high


def deviation(row: Row, quantity: str) -> float:
    """How far the median lies from the truth, in posterior standard deviations."""
    median, true, sd = (float(row[f"{quantity}_{k}"]) for k in ("median", "true", "sd"))
    return (median - true) / sd


def wrong(row: Row, quantity: str) -> bool:
    """Whether an answer is wrong beyond what chance explains, though its checks passed."""
    off = abs(deviation(row, quantity)) > FAR
    return answered(row) and (off or not covered(row, quantity, "99.9"))


def parts(rows: Sequence[Row]) -> page.Parts:
    """What stands between the markers of docs/rolling.md."""
    return {
        "summary": list(_summary(rows)),
        "chart": ["![Error of B's speed, and seconds, by rolling wheels](charts/rolling.png)"],
        "groups": page.table(_GROUP_HEADING, _groups(rows)),
        "coverage": page.table(_COVERAGE_HEADING, _coverage(rows)),
        "models": page.table(["model", "method", "scenes", "answered"], _models(rows)),
        "unanswered": page.table(_UNANSWERED_HEADING, _unanswered(rows)),
    }


def share(hits: int, of: int) -> str:
    """A share with its 95 % limits (Clopper and Pearson)."""
    if not of:
        return "–"
    low, high = binomtest(hits, of).proportion_ci(0.95)
    return f"{hits} of {of} ({hits / of:.0%}; {low:.0%} to {high:.0%})"


def _asked(rows: Sequence[Row], quantity: str) -> list[Row]:
    """Scenes that ask for a quantity and have an answer."""
    return [row for row in rows if answered(row) and quantity in row["asked"].split()]


def _wrong(rows: Sequence[Row]) -> list[tuple[Row, str]]:
    return [(row, q) for q in QUANTITIES for row in _asked(rows, q) if wrong(row, q)]


def _seconds(rows: Sequence[Row]) -> np.ndarray:
    return np.array([float(row["seconds"]) for row in rows])


def _verdict(met: bool) -> str:
    return "met" if met else "MISSED"


def _summary(rows: Sequence[Row]) -> Iterator[str]:
    good = sum(map(answered, rows))
    yield (
        f"- Answered: {share(good, len(rows))}; the target is {ANSWERED:.0%}: "
        f"{_verdict(good >= ANSWERED * len(rows))}."
    )
    pairs = [(row, q) for q in QUANTITIES for row in _asked(rows, q)]
    hits = sum(covered(*pair) for pair in pairs)
    low, high = COVERED
    inside = bool(pairs) and low <= hits / len(pairs) <= high
    yield (
        f"- True value inside the 90 % interval, all quantities: {share(hits, len(pairs))}; the "
        f"target is {low:.0%} to {high:.0%}: {_verdict(inside)}. The limits take the quantities of a "
        "scene as independent, which they are not."
    )
    found = _wrong(rows)
    where = "; ".join(
        f"scene {row['scene']}, {q}: {deviation(row, q):+.1f} sd, where the true {name} is "
        f"{off:+.1f} sd from what was written"
        for row, q in found
        for name, off in [scenes.farthest(scenes.crash(int(row["scene"])))]
    )
    yield (
        f"- Wrong though the checks passed: {len(found)} of {len(pairs)} values"
        f"{f' ({where})' if where else ''}; {len(pairs) / 1000:.1f} are expected by chance; the target "
        f"is none: {_verdict(not found)}."
    )
    seconds = _seconds(rows)
    met = np.median(seconds) <= MEDIAN and seconds.max() <= WORST
    yield (
        f"- Seconds a scene with a warm cache: median {np.median(seconds):.1f}, worst "
        f"{seconds.max():.1f}; the targets are {MEDIAN:.0f} and {WORST:.0f}: {_verdict(bool(met))}."
    )
    yield f"- {machine()}"


_GROUP_HEADING = [
    "rolling wheels", "scenes", "answered", "withheld", "refused", "timed out or failed",
    "speed of B inside 50 %", "inside 90 %", "wrong, unflagged", "seconds, median", "worst",
]  # fmt: skip


def _groups(rows: Sequence[Row]) -> Iterator[list[str]]:
    for low, high in GROUPS:
        mine = [row for row in rows if low <= int(row["rolling"]) <= high]
        if not mine:
            continue
        counts = Counter(row["status"] for row in mine)
        of_b = _asked(mine, "speed_b")
        seconds = _seconds(mine)
        yield [
            f"{low} or {high}",
            str(len(mine)),
            *(str(counts[status]) for status in ("answered", "withheld", "refused")),
            str(counts["timed out"] + counts["failed"]),
            *(
                f"{sum(covered(r, 'speed_b', k) for r in of_b)} of {len(of_b)}"
                for k in ("50", "90")
            ),
            str(len(_wrong(mine))),
            f"{np.median(seconds):.1f}",
            f"{seconds.max():.1f}",
        ]


_COVERAGE_HEADING = [
    "quantity", "inside 50 %", "inside 90 %", "wrong, unflagged", "rms error, posterior sd",
]  # fmt: skip


def _coverage(rows: Sequence[Row]) -> Iterator[list[str]]:
    for quantity in QUANTITIES:
        mine = _asked(rows, quantity)
        if mine:
            error = np.array([deviation(row, quantity) for row in mine])
            yield [
                quantity,
                *(
                    share(sum(covered(r, quantity, k) for r in mine), len(mine))
                    for k in ("50", "90")
                ),
                str(sum(wrong(row, quantity) for row in mine)),
                f"{np.sqrt(np.mean(error**2)):.2f}",
            ]


def _models(rows: Sequence[Row]) -> Iterator[list[str]]:
    kinds = Counter((row["model"], row["method"]) for row in rows if row["model"])
    for (model, method), count in kinds.most_common():
        mine = [row for row in rows if (row["model"], row["method"]) == (model, method)]
        yield [model, method, str(count), str(sum(map(answered, mine)))]


_UNANSWERED_HEADING = ["scene", "wheels of A, B", "drag", "what became of it", "why", "seconds"]


def _unanswered(rows: Sequence[Row]) -> Iterator[list[str]]:
    for row in rows:
        if not answered(row):
            wheels = f"{row['wheels_a']}, {row['wheels_b']}"
            why = row["reason"].replace("|", "\\|")
            yield [row["scene"], wheels, row["drag"], row["status"], why, row["seconds"]]


def draw(rows: Sequence[Row], file: Path) -> None:
    """Error of B's speed with its 90 % interval, and seconds, a mark a scene by rolling wheels."""

    def colour(row: Row) -> str:
        return _COLOURS.get(row["status"], drawing.GREY)

    # scenes with as many rolling wheels stand beside one another
    at = _side_by_side(rows, lambda row: int(row["rolling"]))
    with mpl.rc_context(drawing.STYLE):
        figure = drawing.new_figure(7.2, 5.6)
        errors, seconds = figure.subplots(2, 1, sharex=True)
        for x, row in zip(at, rows, strict=True):
            seconds.plot(x, float(row["seconds"]), "o", ms=3, color=colour(row))
            if row["speed_b_median"]:
                low, middle, high = (
                    float(row[f"speed_b_{k}"]) - float(row["speed_b_true"])
                    for k in ("low_90", "median", "high_90")
                )
                errors.plot([x, x], [low, high], color=colour(row), lw=0.9)
                errors.plot(x, middle, "o", ms=3, color=colour(row))
        errors.axhline(0, color=drawing.INK, lw=0.7)
        errors.set_ylabel("B's speed less the truth (m/s)")
        errors.set_title("speed of B: median and 90 % interval")
        for target, style in ((MEDIAN, ":"), (WORST, "--")):
            seconds.axhline(target, color=drawing.GREY, lw=0.8, ls=style)
        seconds.set_yscale("log")
        seconds.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        seconds.yaxis.set_major_formatter("{x:g}")
        seconds.minorticks_off()
        seconds.set_ylabel("seconds, warm cache")
        seconds.set_title(
            f"dotted: {MEDIAN:.0f} s, for the median; dashed: {WORST:.0f} s, for the worst"
        )
        seconds.set_xlabel("rolling wheels, both vehicles together")
        seconds.set_xticks(sorted({int(row["rolling"]) for row in rows}))
        looks = _COLOURS | {"no result": drawing.GREY}
        handles = [Line2D([], [], marker="o", ls="", color=c, label=k) for k, c in looks.items()]
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
        figure.savefig(file)


def _side_by_side(rows: Sequence[Row], group: Callable[[Row], int]) -> list[float]:
    """Where each row stands: about the number of its group, an equal way apart."""
    sizes, seen = Counter(map(group, rows)), Counter[int]()
    at = []
    for row in rows:
        mine = group(row)
        seen[mine] += 1
        at.append(mine + 0.8 * (seen[mine] / (sizes[mine] + 1) - 0.5))
    return at
