"""Every method of ours beside the reference of many scenes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks import tables
from benchmarks.competitors import Array
from benchmarks.inference.reference import (
    ASKED,
    STATISTICS,
    Effort,
    Posteriors,
    Reference,
    drawn_by,
    errors_of,
    fault_of,
    least_ess,
    long_runs,
    pooled,
    posteriors_of,
    sites_of,
    statistics_of,
)
from benchmarks.tables import Remark
from retrodict.inference import Unanswerable
from retrodict.inference.samplers import METHODS
from tests.shared import random_scenes

COMPARED = {name: METHODS[name].draws for name in ("nuts", "smc")} | {"importance": 2500}


class Compared(NamedTuple):
    """A method on a scene: differences from the reference, and in Monte Carlo errors of both."""

    scene: str
    method: str
    ess: float
    fault: str
    off: Array  # in sd, (statistic, quantity)
    z: Array


def compare(posteriors: Posteriors, known: Reference, scene: str) -> Iterator[Compared]:
    """Every method of ours beside the reference of a scene."""
    for method, entry in METHODS.items():
        drawn = drawn_by(posteriors[method], method, COMPARED.get(method, 10_000), 1)
        x = sites_of(posteriors[method], drawn)
        with np.errstate(all="ignore"):
            off = statistics_of(x) - known.values
            z = (
                off / np.hypot(errors_of(x), known.errors)
                if entry.exact
                else np.full((4, 4), np.nan)
            )
        yield Compared(scene, method, least_ess(x), fault_of(drawn), off / known.values[1], z)


def at_random(effort: Effort) -> Iterator[Compared]:
    """Crashes of `tests.shared.random_scenes`, the first seeds that are answered.

    Their reference is the mean of a long run of nuts and one of importance, without one that is at
    fault by itself where the other is not.
    """
    done, seed = 0, 0
    while done < effort.scenes:
        made, _ = random_scenes.scene(np.random.default_rng(seed))
        name, seed = f"synthetic {seed}", seed + 1
        try:
            posteriors = posteriors_of(made)
        except Unanswerable:
            continue
        long = [*long_runs(posteriors, effort.long, 4 * effort.long).values()]
        sound = [x for x, fault in long if not fault] or [x for x, _ in long]
        known = Reference(
            *pooled([statistics_of(x) for x in sound], [errors_of(x) for x in sound]), {}
        )
        yield from compare(posteriors, known, name)
        print(name, flush=True)
        done += 1


def judged(rows: Sequence[Compared]) -> Iterator[Remark]:
    """Whether the exact ones are, and how far off the others."""
    for method, entry in METHODS.items():
        mine = [row for row in rows if row.method == method]
        faulty = [row.scene for row in mine if row.fault]
        faults = f"; {len(faulty)} faulted by itself ({', '.join(faulty)})" if faulty else ""
        if entry.exact:
            mine = [row for row in mine if not row.fault] or mine
            z = np.abs(np.array([row.z[:2] for row in mine]))
            i = np.unravel_index(np.argmax(z), z.shape)
            yield (
                "agreement",
                f"{method}: {len(mine)} scenes, {z.size} differences of means and sds: worst"
                f" {z.max():.1f} Monte Carlo errors ({STATISTICS[i[1]]} of {ASKED[i[2]]},"
                f" {mine[i[0]].scene}), {np.mean(z > 2):.1%} beyond two (5 % by chance){faults}:"
                f" {'agrees' if z.max() < 4 else 'DISAGREES'}",
            )
            continue
        off = np.abs(np.array([row.off for row in mine]))
        cells = []
        for what, part in (("mean", off[:, :1]), ("sd", off[:, 1:2]), ("limits", off[:, 2:])):
            of_scene = part.max(axis=(1, 2))
            i = np.unravel_index(np.argmax(part), part.shape)
            cells.append(
                f"{what} off by {np.median(of_scene):.2g} (median scene) and {part.max():.2g} sd"
                f" ({ASKED[i[2]]}, {mine[i[0]].scene})"
            )
        bad = int((off.max(axis=(1, 2)) > 0.2).sum())
        yield (
            "approximate",
            f"{method}: {', '.join(cells)}; more than 0.2 sd off in {bad} of {len(mine)} scenes{faults}",
        )


def write(rows: Sequence[Compared], remarks: Sequence[Remark], file: Path) -> None:
    """Write `agreement.csv`."""
    columns = [f"{what}_{s}" for what in ("error_sd", "z") for s in STATISTICS]
    cells = [
        [row.scene, row.method, name, row.ess, *row.off[:, i], *row.z[:, i], row.fault]
        for row in rows
        for i, name in enumerate(ASKED)
    ]
    tables.write(file, ["scene", "method", "quantity", "ess", *columns, "fault"], cells, remarks)
