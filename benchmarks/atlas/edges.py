"""The edges of the mechanics: each option run over it, and what came out beside what is right."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.atlas import Row
from retrodict.mechanics import (
    Bodies,
    Coefficients,
    Ground,
    NotDetermined,
    Wheels,
    against_barrier,
    capped,
    critical_mu,
    printed_e_m,
    rest,
    separation,
    severity,
    solve,
)
from retrodict.mechanics.integration import MOST_STEPS
from retrodict.mechanics.solve import NAMES
from tests.shared import reference
from tests.shared.edges import (
    BEFORE,
    BODIES,
    CAR,
    COEFFICIENTS,
    PLAIN,
    SPINNING,
    by_reference,
    endless_sliding,
    error_of_steps,
    grazed_edge,
    grazing,
    on_edge,
    parted_by_spin,
    skid,
    soft,
    undone,
)

Array = np.ndarray

_separation = jax.jit(separation, static_argnames="moment_equation")
_severity = jax.jit(severity)
_capped = jax.jit(capped)
_critical = jax.jit(critical_mu)
_rest = jax.jit(rest, static_argnames="steps")


def _audit(before: Array, bodies: Bodies, c: Coefficients) -> Any:
    return _severity(jnp.asarray(before), bodies, c, jnp.zeros(2))


def impacts() -> Iterator[Row]:
    """Edges of the impact."""
    row = partial(Row, "impact")
    spins, gains = [], []
    for gap in (1e-1, 1e-3, 1e-6):
        c = COEFFICIENTS._replace(e_m=0.5 + gap)
        printed = _separation(jnp.asarray(BEFORE), BODIES, c, moment_equation="as-printed")
        spins.append(float(abs(printed[5])))
        gains.append(bool(_audit(BEFORE, BODIES, c._replace(e_m=printed_e_m(c.e_m))).gains_energy))
    at = _separation(
        jnp.asarray(BEFORE), BODIES, COEFFICIENTS._replace(e_m=0.5), moment_equation="as-printed"
    )
    yield row(
        "printed eq 24 near e_m = 1/2",
        'separation(…, moment_equation="as-printed") at e_m = 1/2 + 0.1, 0.001, 1e-6 and 1/2',
        f"spin of B after {spins[0]:.3g}, {spins[1]:.3g}, {spins[2]:.3g} rad/s; at 1/2 "
        f"{'not numbers' if np.isnan(np.asarray(at)).any() else 'numbers'}",
        'the default, "corrected"; severity at printed_e_m flags a gain of energy: '
        + ", ".join("yes" if g else "no" for g in gains),
        "flagged",
        "test_impacts.py::test_printed_eq_24_near_one_half",
    )
    before = np.array([10.0, 4.0, 0.0, 10.0, -4.0, 0.0])
    try:
        undone(before, BODIES._replace(Gamma=0.0), COEFFICIENTS)
        seen = "a solution"
    except NotDetermined as refusal:
        seen = str(refusal)
    yield row(
        "zero closing speed",
        "two vehicles side by side at one speed along the normal, forward and back",
        f"forward nothing changes; approach_and_coefficients gives not numbers; solve refuses: {seen}",
        "solve names what the motion does not determine",
        "flagged",
        "test_impacts.py::test_zero_closing_speed_is_refused_by_name",
    )
    parts = []
    for k in (1, 3, 5, 7, 9, 11):
        try:
            off = abs(undone(BEFORE, grazing(10.0**-k), COEFFICIENTS)["e"] - COEFFICIENTS.e)
            parts.append(f"e off by {off:.0e} at 1e-{k} rad")
        except NotDetermined:
            parts.append(f"refused at 1e-{k} rad")
    yield row(
        "Gamma grazing",
        "the relative velocity turned towards the contact line; then solved back",
        "; ".join(parts),
        "solve's condition number, and its refusal where e is lost in rounding",
        "flagged",
        "test_impacts.py::test_gamma_grazing_loses_e_slowly_and_is_then_refused",
    )
    critical = float(_critical(jnp.asarray(BEFORE), BODIES, 0.1, 0.7))
    past = [
        _audit(BEFORE, BODIES, COEFFICIENTS._replace(mu=r * critical))
        for r in (1.0, 1.01, 3.0, -0.1)
    ]
    held = _capped(jnp.asarray(BEFORE), BODIES, 0.1, 3 * critical, 0.7)
    yield row(
        "mu past critical",
        f"mu at 1, 1.01, 3 and -0.1 times its critical value {critical:.3g}",
        "reversal of sliding flagged: "
        + ", ".join("yes" if bool(t.reverses_sliding) else "no" for t in past)
        + f"; capped holds it at {float(held.coefficients.mu):.3g}",
        "severity and solve flag it, the checks count such draws, capped cuts",
        "flagged",
        "test_impacts.py::test_mu_past_critical_is_flagged_and_capped",
    )
    bodies, approach = endless_sliding()
    endless = _critical(jnp.asarray(approach), bodies, 0.1, 1.0)
    after = _separation(jnp.asarray(approach), bodies, Coefficients(0.1, endless, 1.0))
    driving = _audit(approach, bodies, Coefficients(0.1, -0.3 * float(np.sign(endless)), 1.0))
    yield row(
        "no friction ends the sliding",
        "an impact that friction unloads faster than it brakes: mu at its critical value, and of "
        "the other sign",
        f"critical mu {float(endless):g}; velocities at it "
        f"{'not numbers' if np.isnan(np.asarray(after)).any() else 'numbers'}; mu of the other sign "
        f"flagged: {'yes' if bool(driving.reverses_sliding) else 'no'}",
        "severity flags the sign; give mu as a number there",
        "flagged",
        "test_impacts.py::test_sliding_that_no_friction_ends",
    )
    slow = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 8.0])
    parts = []
    for closing in (20.0, 12.0, 5.0):
        slow[0] = closing - 12.0  # B's spin takes its contact point along at 12 m/s
        audit = _audit(slow, parted_by_spin(), Coefficients(0.1, 0.0, 0.0))
        parts.append(f"{'yes' if bool(audit.pulls) else 'no'} at {closing:g} m/s")
    yield row(
        "closing speed small beside the spin",
        "B spins at 8 rad/s, e_m = 0: the moment alone parts the contact points",
        f"an impulse that pulls, flagged: {', '.join(parts)}",
        "severity.pulls",
        "flagged",
        "test_impacts.py::test_an_impulse_that_pulls_is_flagged",
    )
    parts = []
    for share in (0.9, 0.99, 0.999999):
        audit = _audit(*soft(share))
        size = float(np.abs(np.asarray(audit.after)).max())
        flag = "gain flagged" if bool(audit.gains_energy) else "no flag"
        parts.append(f"{size:.3g} m/s or rad/s ({flag})")
    yield row(
        "a contact without stiffness",
        "e_m = -1, arms near the radius of gyration: 0.9, 0.99, 0.999999 of where eq 22's divisor is 0",
        f"largest velocity after 20 m/s before: {', '.join(parts)}",
        "the energy audit names the moment; e_m from 0 to 1 has no such place",
        "flagged",
        "test_impacts.py::test_a_contact_without_stiffness_gains_energy_and_says_so",
    )
    parts = []
    wall = against_barrier(1857.0, 3374.0, 0.205, 2.079, -0.155)
    before = np.array([*BEFORE[:3], 0.0, 0.0, 0.0])
    expected = np.asarray(_separation(jnp.asarray(before), wall, COEFFICIENTS))
    for ratio in (1e2, 1e6, 1e12):
        heavy = wall._replace(m_b=1857.0 * ratio, I_b=3374.0 * ratio)
        after = np.asarray(_separation(jnp.asarray(before), heavy, COEFFICIENTS))
        parts.append(f"{np.abs(after - expected).max():.0e} m/s at {ratio:.0e}")
    yield row(
        "mass ratios to a barrier",
        "B heavier and heavier, beside against_barrier; then B's approach sought from A's change",
        f"off by {', '.join(parts)}; infinite: {barrier_result()}",
        "solve refuses what an unmoved body cannot determine",
        "fine",
        "test_impacts.py::test_mass_ratios_tend_to_the_barrier",
    )
    worst = 0.0
    for kept in ([2, 5], [0, 1, 3, 4]):
        before = np.zeros(6)
        before[kept] = BEFORE[kept]
        found = undone(before, BODIES, COEFFICIENTS)
        worst = max(
            worst, *(abs(found[n] - v) for n, v in zip(NAMES[3:6], before[3:], strict=True))
        )
    yield row(
        "spin alone, translation alone",
        "an impact of bodies that only spin, and of bodies that only move; there and back",
        f"B's approach comes back within {worst:.0e} m/s and rad/s",
        "nothing needed",
        "fine",
        "test_impacts.py::test_spin_alone_and_translation_alone_come_back",
    )
    single = jax.tree.map(jnp.float32, (BODIES, COEFFICIENTS))
    after = _separation(jnp.asarray(BEFORE, jnp.float32), *single)
    off = np.abs(
        np.asarray(after) - np.asarray(_separation(jnp.asarray(BEFORE), BODIES, COEFFICIENTS))
    )
    bodies = grazing(1e-5)
    single = jax.tree.map(jnp.float32, (bodies, COEFFICIENTS))
    audit = _severity(jnp.asarray(BEFORE, jnp.float32), *single, jnp.zeros(2, jnp.float32))
    grazed = np.abs(
        np.asarray(audit.after) - np.asarray(_audit(BEFORE, bodies, COEFFICIENTS).after)
    )
    yield row(
        "float32",
        "the impact in single precision, as it is and grazing by 1e-5 rad; a run-out of single numbers",
        f"off by {off.max():.0e} and {grazed.max():.0e} m/s or rad/s; run-outs compute in double",
        "float64 is switched on by import retrodict; inference knows nothing else",
        "fine",
        "test_impacts.py::test_single_precision_keeps_five_digits",
    )


def barrier_result() -> str:
    """What solve says when A's velocities are sought from what hit a barrier."""
    wall = against_barrier(1857.0, 3374.0, 0.205, 2.079, -0.155)
    before = np.array([*BEFORE[:3], 0.0, 0.0, 0.0])
    after = np.asarray(_separation(jnp.asarray(before), wall, COEFFICIENTS))
    known = dict(zip(NAMES, [*before, *after.tolist(), *map(float, COEFFICIENTS)], strict=True))
    try:
        solve(known, wall, (*NAMES[:3], *NAMES[6:9]))
    except NotDetermined as refusal:
        return f"refused ({refusal.rank} of 6 determined)"
    return "answered"


def run_outs() -> Iterator[Row]:
    """Edges of the run-out."""
    row = partial(Row, "run-out")
    velocities = [[3.0, v, 4.0] for v in (5.8, 5.95, 6.0, 6.1, 6.3)]
    truth = np.array([by_reference(v, 0.7) for v in velocities])
    gaps = [
        np.abs(np.array([skid(v, 0.7, steps) for v in velocities]) - truth)[:, :2].max() * 1e3
        for steps in (None, 48, 768)
    ]
    yield row(
        "a wheel at the instant centre",
        "starts along which a wheel's slip vanishes on the way",
        f"off by {gaps[0]:.1g} mm by default, {gaps[1]:.2g} mm in 48 steps, {gaps[2]:.2g} mm in 768",
        "the contact patch smooths the force; steps adapt",
        "fine",
        "test_run_outs.py::test_a_wheel_at_the_instant_centre",
    )
    slide, turn = skid([10.0, 0.0, 0.0], 0.5), skid([0.0, 0.0, 8.0], 0.5)
    still, crawl = skid([0.0, 0.0, 0.0], 0.5), skid([1e-7, 0.0, 1e-7], 0.5)
    block = 10.0**2 / (2 * 0.5 * reference.GRAVITY)
    yield row(
        "spin against translation; at rest",
        "10 m/s without spin; 8 rad/s without translation; nothing; 1e-7 of each",
        f"way {abs(np.hypot(*slide[:2]) - block):.0e} m off v²/2fg; it turns {turn[2] - 0.3:.3g} rad "
        f"and strays {np.hypot(*turn[:2]):.2g} m; stands within {np.hypot(*still[:2]):.0e} and "
        f"{np.hypot(*crawl[:2]):.0e} m",
        "what is slower than 1e-4 m/s is run at that",
        "fine",
        "test_run_outs.py::test_spin_alone_translation_alone_and_nothing",
    )
    edges = np.linspace(-0.15, 0.15, 7)
    truth = np.array([reference.solve(grazed_edge(e))[0] for e in edges])
    gaps = [
        np.abs(np.array([on_edge(grazed_edge(e), steps) for e in edges]) - truth)[:, :2].max() * 1e3
        for steps in (None, 48, 768)
    ]
    yield row(
        "zone boundaries grazed",
        f"{len(edges)} edges that the foremost wheel comes to rest on, from a tyre's width before it",
        f"off by {gaps[0]:.1g} mm by default, {gaps[1]:.2g} mm in 48 steps, {gaps[2]:.2g} mm in 768",
        "friction passes over a tyre's width",
        "fine",
        "test_run_outs.py::test_a_zone_boundary_grazed",
    )
    parts, coarse = [], []
    for friction in (0.1, 0.03, 0.01, 0.003):
        found = skid([20.0, 0.0, 15.0], friction)
        if not np.isfinite(found).all():
            parts.append(f"friction {friction:g}: not numbers")
            continue
        parts.append(
            f"friction {friction:g}: {np.hypot(*found[:2]):.0f} m and {found[2] / (2 * np.pi):.0f} turns"
        )
        few = skid([20.0, 0.0, 15.0], friction, 96)
        coarse.append(f"{np.hypot(*(few - found)[:2]):.2g} m")
    yield row(
        "ice and long slides",
        "20 m/s and 15 rad/s on less and less friction, by default and in 96 steps",
        f"{'; '.join(parts)}; 96 steps off by {', '.join(coarse)}",
        f"beyond {MOST_STEPS} adaptive steps the rest pose is not a number; of fixed steps step_error "
        "gives it",
        "flagged",
        "test_run_outs.py::test_ice_ends_right_or_not_a_number",
    )
    truth, counts = by_reference(SPINNING, 0.5), (3, 12, 48, 192, 768)
    gaps = [np.hypot(*(skid(SPINNING, 0.5, n) - truth)[:2]) * 1e3 for n in counts]
    errors = [np.hypot(*error_of_steps(n)[:2]) * 1e3 for n in counts]
    yield row(
        "steps from coarse to fine",
        "rest(…, steps=3, 12, 48, 192, 768), 12 m/s and 8 rad/s on 0.5",
        f"off by {', '.join(f'{g:.2g}' for g in gaps)} mm; step_error gives "
        f"{', '.join(f'{e:.2g}' for e in errors)} mm",
        "the default, which adapts; step_error, as inference has a check of its own",
        "flagged",
        "test_run_outs.py::test_steps_from_coarse_to_fine",
    )
    headings = (0.3 + 2 * np.pi, 0.3 - 2 * np.pi)
    ground = Ground(jnp.array([0.5]), None, PLAIN)
    first = skid([8.0, 1.0, 12.0], 0.5)
    moved = [
        np.abs(
            np.asarray(_rest(jnp.array([0.0, 0.0, h]), jnp.array([8.0, 1.0, 12.0]), CAR, ground))
            - [*first[:2], first[2] + h - 0.3]
        ).max()
        for h in headings
    ]
    yield row(
        "turns that wrap",
        f"a car that turns {first[2] - 0.3:.3g} rad; started a turn on and a turn back",
        f"headings count turns: the same within {max(moved):.0e} m and rad",
        "headings are never wrapped; what a rest heading hides, departures and inference try",
        "fine",
        "test_run_outs.py::test_turns_that_wrap",
    )
    parts = []
    for drag in (0.05, 0.01, 0.001, 0.0):
        wheels = Wheels(jnp.full(4, drag), jnp.zeros(4))
        found = skid([10.0, 0.5, 1.0], 0.7, wheels=wheels)
        parts.append(f"drag {drag:g}: {way(found)}")
    yield row(
        "wheels that roll freely",
        "10 m/s with less and less drag",
        "; ".join(parts),
        "a motion that nothing brakes has no rest pose, and none is given",
        "flagged",
        "test_run_outs.py::test_free_wheels_give_no_rest_pose",
    )
    parts = []
    for height in (0.5, 0.7, 0.9):
        found = skid([0.0, 10.0, 0.0], 1.0, height=height)
        parts.append(f"{height:g} m: {way(found, 2)}")
    yield row(
        "a wheel that lifts",
        "load transfer, sideways on friction 1, track 1.5 m, centre of gravity higher and higher",
        "; ".join(parts),
        "no rest pose where a load would be negative",
        "flagged",
        "test_run_outs.py::test_a_wheel_that_lifts_gives_no_rest_pose",
    )
    parts = []
    for c in (0.01, 0.05, 0.2):
        ground = Ground(jnp.array([0.7]), jnp.array([c]), PLAIN)
        found = np.asarray(_rest(jnp.zeros(3), jnp.array([30.0, 0.0, 1.0]), CAR, ground))
        parts.append(f"c = {c:g}: {way(found)}")
    yield row(
        "friction lost to speed",
        "30 m/s and 1 rad/s on 0.7 exp(-c v)",
        "; ".join(parts),
        "nothing needed: the clock is not time",
        "fine",
        "test_run_outs.py::test_friction_lost_to_speed",
    )


def way(rest_pose: Array, decimals: int = 0) -> str:
    """How far from its start a vehicle stands, in words."""
    if not np.isfinite(rest_pose).all():
        return "not numbers"
    return f"{np.hypot(*rest_pose[:2]):.{decimals}f} m"
