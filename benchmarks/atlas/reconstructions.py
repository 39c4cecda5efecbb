"""Crashes at random reconstructed by every method: what passes its checks and is wrong all the same?

The crashes are those of `tests.shared.random_scenes`, whose truth is known: of five one closes in
slowly, in one a lorry meets a car, and one is grazing. Rows are written as crashes are done, so that a
study that was stopped goes on where it was; one begun anew needs the table deleted.
"""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binomtest

from benchmarks.atlas.maps import ASKED, WRONG
from retrodict.inference import Unanswerable
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers import METHODS
from retrodict.options import RunOptions
from retrodict.studies.engine import engine
from tests.shared import random_scenes

EXACT, APPROXIMATE = ("nuts", "importance"), ("laplace", "monte-carlo", "linear")
ALL = (*EXACT, *APPROXIMATE)
KINDS = ("ordinary", "ordinary", "slow", "lorry", "grazing")  # of crashes, in turn
PROCESSES = 2
LEVEL = 0.999  # of the interval that is to hold the truth of B's speed
CHANCE = 0.01  # below which more misses are not put down to chance
ERRORS = 4  # Monte Carlo errors by which two methods may differ
MORE = 10  # times as many draws as by default, for crashes in which they do
NUMBERS = tuple(f"{n} {what}" for n in ASKED for what in ("mean", "sd", "mean error", "sd error"))
COLUMNS = ("seed", "method", "by", "state", "why", "seconds", "truth", "low", "high", *NUMBERS)

Row = dict[str, Any]


def reconstructed(methods: Iterable[str], seed: int) -> list[Row]:
    """A crash by each method, as a user gets it: what the checks say, and the numbers."""
    scene, truth = _crash(seed)
    rows = []
    for method in methods:
        begin = time.perf_counter()
        row: Row = {"seed": seed, "method": method, "by": method, "truth": truth["speed_b"]}
        try:
            row |= _reconstruction(scene, method, seed)
        except Unanswerable as refusal:
            row |= {"state": "refused", "why": str(refusal)}
        except Exception as error:  # any other is what this study looks for
            row |= {"state": "raised", "why": f"{type(error).__name__}: {error}"}
        rows.append(row | {"seconds": time.perf_counter() - begin})
    return rows


def _crash(seed: int) -> tuple[Any, dict[str, float]]:
    """The scene of a crash at random, and its truth."""
    return random_scenes.scene(np.random.default_rng(seed), KINDS[seed % len(KINDS)])


def _reconstruction(scene: Any, method: str, seed: int, draws: int | None = None) -> Row:
    import arviz_stats

    found = reconstruct(scene, RunOptions(method=method, seed=seed, draws=draws))
    drawn = found.idata["posterior"].to_dataset()[list(ASKED)]
    numbers = {
        "mean": drawn.mean(),
        "sd": drawn.std(),
        "mean error": arviz_stats.mcse(drawn, method="mean"),
        "sd error": arviz_stats.mcse(drawn, method="sd"),
    }
    low, high = np.quantile(drawn["speed_b"], [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return {
        "by": found.settings["method"],
        "state": "passed" if found.checks.passed else "withheld",
        "why": "; ".join(found.checks.reasons),
        "low": low,
        "high": high,
        **{f"{n} {what}": float(each[n]) for what, each in numbers.items() for n in ASKED},
    }


def study(file: Path, seeds: Iterable[int], methods: tuple[str, ...] = ALL) -> pd.DataFrame:
    """Reconstruct crashes, but for those that stand in the table.

    Args:
        file: of the table; made where it is not there.
        seeds: of the crashes.
        methods: by which each is reconstructed.

    Returns:
        The table, a row a crash and method.
    """
    rows: list[Row] = []
    if file.exists():
        lines = file.read_text("utf-8").splitlines()
        rows = list(csv.DictReader(line for line in lines if not line.startswith("# ")))
    per_method = pd.Series([int(row["seed"]) for row in rows], dtype=int).value_counts()
    done = set(per_method[per_method == len(methods)].index)
    with file.open("w", newline="", encoding="utf-8") as out:
        table = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(row for row in rows if int(row["seed"]) in done)
        todo = [seed for seed in seeds if seed not in done]
        with engine(PROCESSES) as running:
            for found in running.results(partial(reconstructed, methods), todo):
                for row in found:
                    short = {k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()}
                    table.writerow(short)
                    print(*(row[k] for k in ("seed", "method", "state", "why")), flush=True)
                out.flush()
    return pd.read_csv(file)


def remarks(table: pd.DataFrame, of: str = "reconstructions") -> Iterator[tuple[str, str]]:
    """What the table comes to, a line a finding: which part of the page it is for, and the text.

    Args:
        table: as of `study`.
        of: part of the page that the crashes are for.
    """
    by_method = {method: rows.set_index("seed") for method, rows in table.groupby("method")}
    for method in EXACT:
        mine = by_method[method]
        states = mine["state"].value_counts()
        passed = mine[mine["state"] == "passed"]
        off = (passed["truth"] - passed["speed_b mean"]).abs() / passed["speed_b sd"]
        off = off[~passed["truth"].between(passed["low"], passed["high"])]
        missed = len(off)
        excess = binomtest(missed, len(passed), 1 - LEVEL, "greater").pvalue if len(passed) else 1
        yield (
            of,
            f"{method}, {len(mine)} crashes: "
            + ", ".join(
                f"{states.get(s, 0)} {s}" for s in ("passed", "withheld", "refused", "raised")
            )
            + f"; {(passed['by'] == method).sum()} passed by itself ({_by_kind(mine, method)}), the "
            "others by another method"
            f"; of those passed {missed} have the true speed of B outside the {LEVEL:.1%} interval, "
            f"{'more than' if excess < CHANCE else 'which'} chance allows (p = {excess:.2g})"
            + (": " if missed else "")
            + ", ".join(f"seed {seed} by {by:.1f} sd" for seed, by in off.items())
            + f"; seconds a crash: median {mine['seconds'].median():.1f}, at most "
            f"{mine['seconds'].max():.0f}",
        )
    nuts, other = _passed(table)
    gaps = _gaps(nuts, other)
    far = apart(table)
    off = _off(other.loc[gaps.index], nuts.loc[gaps.index])
    yield (
        of,
        f"nuts and importance, both passed by themselves in {len(gaps)} crashes: mean or sd of "
        f"{', '.join(ASKED)} over {ERRORS} Monte Carlo errors apart in {len(far)} (chance: "
        f"{2 * len(ASKED) * len(gaps) * math.erfc(ERRORS / math.sqrt(2)):.2g})"
        + (f": seeds {', '.join(map(str, far))}" if far else "")
        + f"; the most {gaps.to_numpy().max(initial=0):.1f}. Over {WRONG} of the posterior's sd, which "
        f"would be wrong, apart in {(off > WRONG).sum()}; the most {off.max():.2f}",
    )
    known = pd.concat([nuts, other[~other.index.isin(nuts.index)]])
    for method in (each for each in APPROXIMATE if each in by_method):
        mine = by_method[method]
        mine = mine[mine["state"].isin(["passed", "withheld"])]
        mine = mine.loc[mine.index.intersection(known.index)]
        sure = known.loc[mine.index]
        right, passed = ~(_off(mine, sure) > WRONG), mine["state"] == "passed"
        counts = ((right & passed), (right & ~passed), (~right & ~passed), (~right & passed))
        if (wrong := _off(mine, sure)[~right & passed]).size:
            by = ", ".join(f"seed {seed} by {off:.3f} sd" for seed, off in wrong.items())
            yield of, f"{method}, wrong and passed: {by}"
        yield "approximations", f"| {method} | {' | '.join(str(c.sum()) for c in counts)} |"


def _by_kind(rows: pd.DataFrame, method: str) -> str:
    """How many crashes of each kind a method passed by itself, in words."""
    itself = (rows["state"] == "passed") & (rows["by"] == method)
    counts = itself.groupby([KINDS[seed % len(KINDS)] for seed in rows.index], sort=False)
    return ", ".join(f"{kind} {mine.sum()} of {len(mine)}" for kind, mine in counts)


def apart(table: pd.DataFrame) -> list[int]:
    """Seeds of the crashes in which two methods that passed differ by more than chance allows."""
    gaps = _gaps(*_passed(table))
    return list(gaps.index[gaps.max(axis=1) > ERRORS])


def repeated(seeds: list[int], of: str = "reconstructions") -> Iterator[tuple[str, str]]:
    """Crashes by more draws of both methods, a line each: do they still differ?"""
    for seed in seeds:
        scene, _ = _crash(seed)
        nuts, other = (
            pd.DataFrame([_reconstruction(scene, m, seed, MORE * METHODS[m].draws)]) for m in EXACT
        )
        gap = _gaps(nuts, other).loc[0]
        name = gap.idxmax()
        yield (
            of,
            f"seed {seed} by {MORE} times as many draws ({', '.join((*nuts['by'], *other['by']))}): "
            f"at most {gap[name]:.1f} errors apart, in the {name.split()[1]} of {name.split()[0]}, "
            f"{nuts[name][0]:.4g} and {other[name][0]:.4g}",
        )


def _passed(table: pd.DataFrame) -> list[pd.DataFrame]:
    """Rows of nuts and of importance where they passed by themselves, by seed."""
    by_itself = table[(table["state"] == "passed") & (table["by"] == table["method"])]
    return [by_itself[by_itself["method"] == method].set_index("seed") for method in EXACT]


def _gaps(one: pd.DataFrame, other: pd.DataFrame) -> pd.DataFrame:
    """By how many Monte Carlo errors means and sds differ, of the crashes in both tables."""
    both = one.index.intersection(other.index)
    one, other = one.loc[both], other.loc[both]
    return pd.DataFrame(
        {
            f"{n} {what}": (one[f"{n} {what}"] - other[f"{n} {what}"]).abs()
            / np.hypot(one[f"{n} {what} error"], other[f"{n} {what} error"])
            for n in ASKED
            for what in ("mean", "sd")
        }
    )


def _off(mine: pd.DataFrame, sure: pd.DataFrame) -> pd.Series:
    """The worst error of a mean or a sd, in the posterior's sd: infinite where it is no number."""
    errors = [
        (mine[f"{n} {what}"] - sure[f"{n} {what}"]).abs() / sure[f"{n} sd"]
        for n in ASKED
        for what in ("mean", "sd")
    ]
    return pd.concat(errors, axis=1).max(axis=1, skipna=False).fillna(np.inf)
