"""Each line of docs/by-hand.md: its arithmetic gives its result, and so does `retrodict.mechanics`."""

from __future__ import annotations

import math
import re
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from retrodict.mechanics import (
    Bodies,
    Car,
    Ground,
    Zone,
    approach_and_coefficients,
    audit,
    axes,
    contact_velocity,
    rest,
    run_out,
    separation,
    undo,
)

PAGE = Path(__file__).parents[1] / "docs" / "by-hand.md"
BODIES = Bodies(1857.0, 1778.0, 3374.0, 3007.0, 1.636, 0.653, 0.205, 2.079, -0.155)
BEFORE_A = jnp.array([-20.1, 0.0, 0.0])
AFTER = jnp.array([-7.0, 2.4, 0.61, 5.2, -6.1, 9.9])
Line = tuple[str, str, str]


def lines() -> dict[str, Line]:
    """Of each quantity: the formula with numbers, the result as printed, and its unit."""
    found = {}
    for row in PAGE.read_text("utf-8").splitlines():
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        if number := re.fullmatch(r"(−?[\d.]+) ?(.*)", cells[-1]):
            name = f"{cells[0]} of a slide" if cells[0] in found else cells[0]
            found[name] = (cells[-2], number[1].replace("−", "-"), number[2])
    return found


def half_a_digit(printed: str) -> float:
    return 0.5 * 10.0 ** -len(printed.partition(".")[2])


LINES = lines()


@pytest.mark.parametrize("name", LINES)
def test_a_calculator_gives_each_result(name: str) -> None:
    """To the last digit that is printed, from the numbers that are printed."""
    written, printed, unit = LINES[name]
    for sign, code in {"×": "*", "−": "-", "²": "**2", "√": "sqrt"}.items():
        written = written.replace(sign, code)
    assert re.fullmatch(r"[\d.+*/() -]+", re.sub("sqrt|cos|sin", "", written))
    functions = {"sqrt": math.sqrt, "cos": math.cos, "sin": math.sin}
    value = eval(written, {"__builtins__": {}}, functions) / (1000 if unit == "kJ" else 1)
    assert value == pytest.approx(float(printed), abs=1.001 * half_a_digit(printed))


def by_mechanics() -> dict[str, float]:
    """Every quantity of the page, by the functions that a reconstruction uses."""
    found = undo(AFTER, BEFORE_A, BODIES)
    approach_b, coefficients = approach_and_coefficients(AFTER, BEFORE_A, BODIES)
    before = jnp.concatenate([BEFORE_A, approach_b])
    after = separation(before, BODIES, coefficients)
    normal, tangent = axes(BODIES)
    P = found.P[0] * normal + found.P[1] * tangent
    (u_x, u_y), (U_x, U_y) = (contact_velocity(state, BODIES) for state in (before, after))
    m_a, m_b, I_a, I_b, d1, d2, d3, d4, _ = BODIES
    f_a, f_b = P[0] * d3 - P[1] * d4, P[0] * d1 - P[1] * d2
    energy = audit(before, BODIES, coefficients)
    values = {
        "P_x": P[0],
        "P_y": P[1],
        "v_bx": approach_b[0],
        "v_by": approach_b[1],
        "G": -(f_a + f_b),
        "ω_b": approach_b[2],
        "speed": jnp.hypot(*approach_b[:2]),
        "cos Γ": normal[0],
        "sin Γ": normal[1],
        "U_x": U_x,
        "U_y": U_y,
        "parting": found.opening,
        "u_x": u_x,
        "u_y": u_y,
        "closing": found.closing,
        "e": coefficients.e,
        "P_n": found.P[0],
        "P_t": found.P[1],
        "μ": coefficients.mu,
        "f_a": f_a,
        "f_b": f_b,
        "spin": found.spin,
        "free spin": found.free_spin,
        "e_m": coefficients.e_m,
        "energy, before": energy.before / 1000,
        "energy, after": energy.after / 1000,
        "delta-v of A": jnp.hypot(*(after - before)[:2]),
        "delta-v of B": jnp.hypot(*(after - before)[3:5]),
    }
    for when, state in (("before", before), ("after", after)):
        v_ax, v_ay, w_a, v_bx, v_by, w_b = state
        of_a, of_b = d4 * v_ay - d3 * v_ax, d1 * v_bx - d2 * v_by
        values[f"along x, {when}"] = m_a * v_ax + m_b * v_bx
        values[f"along y, {when}"] = m_a * v_ay + m_b * v_by
        values[f"angular, {when}"] = I_a * w_a + m_a * of_a + I_b * w_b + m_b * of_b
    return {name: float(value) for name, value in (values | of_a_slide()).items()}


def of_a_slide() -> dict[str, float]:
    """The speed that leads 25 m along friction 0.7, its sensitivities by differences of run-outs."""
    car, nowhere = Car(1.8, 1.3, 1.5, 1.5), Zone(np.zeros((0, 2)), np.zeros((0, 2)))
    start = jnp.zeros(3)

    def length(speed: float, friction: float = 0.70) -> float:
        ground = Ground(jnp.array([friction]), None, nowhere)
        return float(rest(start, jnp.array([speed, 0.0, 0.0]), car, ground, steps=48)[0])

    speed = 18.0
    for _ in range(4):  # Newton's method
        slope = (length(speed + 0.01) - length(speed - 0.01)) / 0.02
        speed += (25.0 - length(speed)) / slope
    per_friction = -(length(speed, 0.701) - length(speed, 0.699)) / 0.002 / slope
    by_friction = abs(per_friction) * 0.05
    sd = math.hypot(by_friction, 0.5 / slope)
    ground = Ground(jnp.array([0.70]), None, nowhere)
    path = run_out(start, jnp.array([speed, 0.0, 0.0]), car, ground, steps=48)
    return {
        "speed of a slide": speed,
        "in mph": speed / 0.44704,
        "time": float(path.time[-1]),
        "relative sd": sd / speed,
        "sd": sd,
        "sd by the friction alone": by_friction,
    }


def test_mechanics_gives_each_result() -> None:
    """Within one and a half units of the last digit: the page goes on with rounded numbers."""
    values = by_mechanics()
    assert set(values) == set(LINES)
    for name, (_, printed, _) in LINES.items():
        assert values[name] == pytest.approx(float(printed), abs=3 * half_a_digit(printed)), name
