"""The edges of inference: scenes and methods run over them, and what the checks said."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.atlas import Row
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.samplers import METHODS, Task
from retrodict.options import DEFAULT_RUNG
from retrodict.studies.conflict import conflicts
from tests.shared.known_truth import made
from tests.shared.posteriors import (
    draw,
    far_from_truth,
    faults,
    moved,
    off,
    sites,
    stiffness,
    vague,
    verdict_of,
    wrapped,
)

Array = np.ndarray


def rows() -> Iterator[Row]:
    """All edges of inference."""
    row = partial(Row, "inference")
    parts = []
    for sds in (0.3, 0.1):
        scene, truth = made(sds=sds)
        said, outcome = verdict_of(scene, "importance")
        far = far_from_truth(outcome, truth)
        parts.append(f"{sds:g}: {said}, truth {far:.1f} sd off")
    yield row(
        "sd -> 0: a thin posterior",
        "importance, every sd of the scene times 0.3 and 0.1",
        "; ".join(parts),
        "steps of the run-out double till the rest poses are resolved; what is not is withheld",
        "fine",
        "test_posteriors.py::test_a_thin_posterior_is_right",
    )
    parts = []
    for factor in (3.0, 10.0, 100.0):
        scene, _ = made()
        parts.append(f"{factor:g}: {verdict_of(vague(scene, factor))[0]}")
    yield row(
        "sd -> infinity: the prior alone",
        "importance, rest poses 3, 10 and 100 times as uncertain",
        "; ".join(parts),
        "Pareto k and effective sample size; nuts has divergences and R-hat; where all is well with "
        "these, that the evidence is weak. A few per cent of the prior's tails may then be missing",
        "flagged",
        "test_posteriors.py::test_rest_poses_without_information_are_withheld_or_flagged",
    )
    parts = []
    for sds in (3, 10, 40):
        scene, truth = made()
        said, outcome = verdict_of(moved(scene, "b", sds * scene.rest["b"].x.sd))
        far = far_from_truth(outcome, truth)
        parts.append(f"{sds} sd: {said}" + (f", truth {far:.1f} sd off" if outcome else ""))
        if outcome:
            item = next(each for each in conflicts(outcome) if each.name == "rest_x_b")
            parts[-1] += (
                f"; in the report: of an error in it {item.believed:.0%} would be believed, and one "
                f"sd would move B's speed by {item.moved:.2f} m/s"
            )
    yield row(
        "an outlier",
        "importance, B's rest written down 3, 10, 40 of its sds off along x",
        "; ".join(parts),
        "flags where an item lies over 2.5 sd from all else; six items and seven unknowns leave few "
        "that others could contradict: which, and what an error would do, the report says of each",
        "flagged",
        "test_posteriors.py::test_an_outlier_is_believed",
    )
    scene, _ = made()
    parts = [f"{far:+g} m: {verdict_of(moved(scene, 'a', far))[0]}" for far in (-20.0, 15.0)]
    yield row(
        "contradictory evidence",
        "importance, A's rest written down 20 m farther on its way, and 15 m back",
        "; ".join(parts),
        "a rest that no impact leads to is refused or named; one that odd coefficients lead to only "
        "has these flagged",
        "flagged",
        "test_posteriors.py::test_contradictory_evidence_is_named",
    )
    said, _ = verdict_of(wrapped(scene))
    yield row(
        "two modes: turns not written down",
        "importance, B's rotation left out",
        said,
        "other numbers of turns are tried, and the run is withheld where a second one has weight",
        "fine",
        "test_posteriors.py::test_turns_that_are_not_written_down_are_found",
    )
    yield from _heavy(row)
    yield from _nuts(row)


def _heavy(row: partial[Row]) -> Iterator[Row]:
    scene, _ = made(friction_sd=0.6)
    posterior = prepare(scene, DEFAULT_RUNG)
    sure = sites(posterior, draw(posterior, "nuts"))
    parts = []
    for method in ("importance", "laplace"):
        drawn = draw(posterior, method)
        x = sites(posterior, drawn)
        k = drawn.attributes["pareto_k"]
        held = "withheld" if faults(posterior, drawn, x) else "passed"
        parts.append(f"{method}: Pareto k {k:.2f}, {held}, {off(x, sure):.2f} sd off nuts")
    yield row(
        "heavy tails",
        "friction known to 60 %",
        "; ".join(parts),
        "Pareto k above 0.7 fails the run",
        "flagged",
        "test_posteriors.py::test_heavy_tails_do_not_pass_unseen",
    )
    parts = []
    for method in ("linear", "monte-carlo"):
        drawn = draw(posterior, method)
        x = sites(posterior, drawn)
        held = "withheld" if faults(posterior, drawn, x) else "passed"
        parts.append(
            f"{method}: {np.mean(x['e'] < 0):.0%} of the draws have e < 0, "
            f"{np.mean(np.abs(x['e_m']) > 1):.0%} e_m beyond 1; {held}, {off(x, sure):.2g} sd off nuts"
        )
    yield row(
        "linear propagation past its reach",
        "linear and monte-carlo, friction known to 60 %",
        "; ".join(parts),
        "both are held against 2000 importance draws, and fail where mean or spread is off by a fifth "
        "of the sd, or these cannot decide",
        "flagged",
        "test_posteriors.py::test_what_leaves_the_bounds_is_withheld",
    )


def _nuts(row: partial[Row]) -> Iterator[Row]:
    scene, _ = made()
    posterior = prepare(scene, DEFAULT_RUNG)
    long = draw(posterior, "nuts", 2000)
    sure, w = sites(posterior, long), long.w.reshape(-1, long.w.shape[-1])
    parts = []
    for warmup in (5, 150):
        found = METHODS["nuts"].draw(Task(posterior, 4, 500, warmup, 0, lambda *_: None))
        x = sites(posterior, found)
        held = "; ".join(faults(posterior, found, x)) or "passed"
        parts.append(f"{warmup}: {held}, {off(x, sure):.2f} sd off")
    yield row(
        "NUTS with too little warm-up",
        "5 and 150 iterations, 500 draws",
        "; ".join(parts),
        "the target is nearly a sphere of known size; the command asks for 50 at least",
        "fine",
        "test_posteriors.py::test_too_little_warm_up_is_harmless",
    )
    parts = []
    for far in (3.0, 10.0):
        whitening = posterior.transform.whitening
        shifted = whitening._replace(centre=whitening.transform(np.full(posterior.size, far)))
        elsewhere = replace(posterior, transform=posterior.transform._replace(whitening=shifted))
        found = METHODS["nuts"].draw(Task(elsewhere, 4, 500, 150, 0, lambda *_: None))
        x = sites(elsewhere, found)
        held = "; ".join(faults(elsewhere, found, x)) or "passed"
        parts.append(f"{far:g}: {held}, {off(x, sure):.2f} sd off")
    yield row(
        "NUTS from a wrong start",
        "coordinates centred 3 and 10 sd off in every unknown",
        "; ".join(parts),
        "R-hat and effective sample size; the start itself comes from a search over 128 starts",
        "fine",
        "test_posteriors.py::test_a_wrong_start_is_flagged",
    )
    naive, ours = stiffness(posterior, w)
    yield row(
        "NUTS in naive coordinates",
        "correlations of the posterior in the model's own unknowns, unconstrained as NumPyro does it, "
        "and in ours",
        f"condition number {naive:,.0f} against {ours:.1f}; a diagonal mass matrix has to cross it in "
        "steps of the narrow side; docs/inference.md runs it",
        "the coordinates, which every method of ours works in",
        "fine",
        "test_posteriors.py::test_naive_coordinates_are_stiff",
    )
