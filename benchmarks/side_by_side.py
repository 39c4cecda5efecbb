"""Our impact beside PyCrash's (github.com/joe-cormier/pycrash) where the two models coincide.

python3 -m uv run python -m benchmarks.side_by_side [impacts] [seed]

PyCrash is GPL and no dependency of ours: uv puts it into an environment of its own, a second process
runs its momentum model (`IMPC`, after Carpenter and Welcher, SAE 2019-01-0422), and numbers alone
pass between the two. Where it cannot be had, this says so and succeeds. It fails if the programs
differ by more than PyCrash's own constants (32.2 ft/s², 1.46667 and 0.681818 between mph and ft/s).

They coincide without moment impulse (e_m = 1) while friction brakes a sliding that lasts: |mu| below
its critical value at e (ours) and at e = 0 (where PyCrash has the sliding end). Beyond, they part.
Brach's sliding ends for good: nothing of it is left at the critical mu. PyCrash lets it reverse under
unchanged friction up to its own limit, and from there on has the tangential velocity restored as the
normal one is: -e times what it was. The second table shows it.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from retrodict.mechanics import (
    Bodies,
    Coefficients,
    contact_velocity,
    critical_mu,
    lever_arms,
    separation,
)

PACKAGE = "pycrash==0.0.18"
FOOT, POUND, MPH = 0.3048, 0.45359237, 0.44704  # m, kg, m/s
SLUG_FT2 = POUND * 9.80665 * FOOT  # kg m² in lb ft s²
GRAVITY = 9.80665 / FOOT / 32.2  # of a weight in lb, as PyCrash converts it to mass
INTO, OUT = 1.46667 * FOOT / MPH, 0.681818 * MPH / FOOT  # and of a speed, on its way in and out
AGREES = 1e-9  # m/s and rad/s: what rounding in double precision may leave
HEADER = "      V_x      V_y    Omega  delta-v"

THERE = """
import contextlib, io, json, sys
with contextlib.redirect_stdout(io.StringIO()):
    from pycrash import Vehicle
    from pycrash.model_calcs.carpenter_momentum import IMPC
print("ready", flush=True)
results = []
for a, b, inputs in json.load(sys.stdin):
    with contextlib.redirect_stdout(io.StringIO()):
        impact = IMPC("", Vehicle("A", a), Vehicle("B", b), inputs)
    results.append([impact.v1_result, impact.v2_result])
print(json.dumps(results, default=float))
"""


class Impact(NamedTuple):
    """An impact in the road frame, and the headings (rad) that PyCrash's vehicle frames need."""

    bodies: Bodies
    approach: np.ndarray
    coefficients: Coefficients
    headings: np.ndarray


class Unavailable(Exception):
    """PyCrash cannot be run, and why."""


def impacts(number: int, rng: np.random.Generator) -> list[Impact]:
    """Impacts at random, in the regime where the models coincide."""
    drawn: list[Impact] = []
    while len(drawn) < number:
        mass, gyration = rng.uniform(900, 2400, 2), rng.uniform(1.1, 1.5, 2)
        across, headings = rng.uniform(-np.pi, np.pi), rng.uniform(-np.pi, np.pi, 2)
        normal = np.array([np.cos(across), np.sin(across)])
        axes = np.stack([normal, [-normal[1], normal[0]]], axis=1)
        lever_a = axes @ [rng.uniform(0.5, 2.2), rng.uniform(-1.2, 1.2)]
        lever_b = axes @ [-rng.uniform(0.5, 2.2), rng.uniform(-1.2, 1.2)]
        Gamma = (across + np.pi / 2) % np.pi - np.pi / 2  # the contact line has no sense
        bodies = Bodies(*mass, *mass * gyration**2, *lever_arms(lever_a, lever_b), Gamma)
        approach = rng.uniform(-20, 20, 6) * np.tile([1, 1, 0.1], 2)
        e = rng.uniform(0, 0.4)
        critical, theirs = (float(critical_mu(approach, bodies, x, 1.0)) for x in (e, 0.0))
        mu = critical * rng.uniform(0.1, 0.95)
        closing, sliding = np.asarray(contact_velocity(approach, bodies)) @ axes
        brakes = min(mu * sliding, mu * theirs) > 0 and abs(mu) < abs(theirs)
        if closing > 3 and abs(sliding) > 2 and brakes and 0.05 < abs(mu) < 1:
            drawn.append(Impact(bodies, approach, Coefficients(e, mu, 1.0), headings))
    return drawn


def here(impact: Impact, constants: bool = False) -> np.ndarray:
    """V_x, V_y, Omega and delta-v of A and B by us, if so wished with PyCrash's constants."""
    into, out, g = (INTO, OUT, GRAVITY) if constants else (1.0, 1.0, 1.0)
    bodies = impact.bodies._replace(m_a=impact.bodies.m_a * g, m_b=impact.bodies.m_b * g)
    before = impact.approach * np.tile([into, into, 1], 2)
    after = np.asarray(separation(jnp.asarray(before), bodies, impact.coefficients))
    delta_v = np.hypot(*(after - before).reshape(2, 3).T[:2])
    return np.column_stack([after.reshape(2, 3), delta_v]) * [out, out, 1, out]


def there(of: Sequence[Impact]) -> np.ndarray:
    """The same by PyCrash.

    Raises:
        Unavailable: it could not be installed or imported.
        RuntimeError: it could, but failed.
    """
    uv = os.environ.get("UV") or shutil.which("uv")
    if not uv:
        raise Unavailable("there is no uv")
    command = [uv, "run", "--isolated", "--no-project", "--python", sys.executable]
    command += ["--with", PACKAGE, "python", "-c", THERE]
    asked = json.dumps([_entries(impact) for impact in of])
    done = subprocess.run(command, input=asked, capture_output=True, text=True, check=False)
    _, imported, results = done.stdout.partition("ready\n")
    if not imported:
        raise Unavailable((done.stderr.strip().splitlines() or ["no reason given"])[-1].strip())
    if done.returncode:
        raise RuntimeError(done.stderr)
    found = []
    for impact, pair in zip(of, json.loads(results), strict=True):
        for heading, r in zip(impact.headings, pair, strict=True):
            x, y = _turned(np.array([r["vx"], r["vy"]]) * MPH, heading)
            found.append([x, y, r["oz_rad"], r["dv"] * MPH])
    return np.array(found).reshape(len(of), 2, 4)


def _entries(impact: Impact) -> list[dict[str, float]]:
    """Both vehicles and the impact as PyCrash takes them: ft, lb, mph, degrees, vehicle frames."""
    (m_a, m_b, I_a, I_b, d1, d2, d3, d4, Gamma), before = impact.bodies, impact.approach
    vehicles = []
    levers = (np.array([-d4, -d3]), np.array([d2, d1]))
    each = zip((m_a, m_b), (I_a, I_b), levers, before.reshape(2, 3), impact.headings, strict=True)
    for mass, inertia, lever, (*velocity, spin), heading in each:
        point = _turned(lever, -heading) / FOOT
        vx, vy = _turned(np.array(velocity), -heading) / MPH
        entries = {"weight": mass / POUND, "izz": inertia / SLUG_FT2, "omega_z": np.degrees(spin)}
        entries |= {"vx_initial": vx, "vy_initial": vy, "head_angle": np.degrees(heading)}
        entries |= {"init_x_pos": -lever[0] / FOOT, "init_y_pos": -lever[1] / FOOT}
        vehicles.append(entries | {"pimpact_x": point[0], "pimpact_y": point[1]})
    e, mu, _ = impact.coefficients
    plane = np.degrees(Gamma - impact.headings[0])  # its normal, from A's heading
    inputs = {"cor": e, "cof": abs(mu), "impact_norm_deg": plane}
    return [{k: float(v) for k, v in entry.items()} for entry in (*vehicles, inputs)]


def _turned(vector: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]]) @ vector


def beyond(impact: Impact) -> list[tuple[str, Impact]]:
    """The impact at e = 0.3 with more and more friction, past both programs' limits."""
    ours, theirs = (float(critical_mu(impact.approach, impact.bodies, e, 1.0)) for e in (0.3, 0.0))
    steps = {"0.5 mu_c": ours / 2, "mu_c": ours, "between": (ours + theirs) / 2}
    steps |= {"0.99 mu_0": 0.99 * theirs, "1.01 mu_0": 1.01 * theirs, "2 mu_0": 2 * theirs}
    return [(k, impact._replace(coefficients=Coefficients(0.3, v, 1.0))) for k, v in steps.items()]


def _sliding(state: np.ndarray, impact: Impact) -> float:
    Gamma = float(impact.bodies.Gamma)
    velocity = np.asarray(contact_velocity(jnp.asarray(state), impact.bodies))
    return float(velocity @ [-np.sin(Gamma), np.cos(Gamma)])


def main(number: int = 24, seed: int = 0) -> None:
    """Print both tables and where differences come from; exit with 1 if they are too large."""
    of = impacts(number, np.random.default_rng(seed))
    parting = beyond(of[0])
    try:
        answers = there([*of, *(impact for _, impact in parting)])
    except Unavailable as why:
        print(f"skipped: {PACKAGE} cannot be run here: {why}")
        return
    theirs, past = answers[:number], answers[number:]
    ours = np.array([here(impact) for impact in of])
    alike = np.array([here(impact, constants=True) for impact in of])

    print("After the impact, m/s and rad/s, road frame; difference: the largest of the four")
    print(f"{'':27}{'retrodict':^36}  {'PyCrash':^36}")
    print(f"{'':4}{'e':>7}{'mu':>8}{'/mu_c':>7} {HEADER}  {HEADER}  difference")
    for i, impact in enumerate(of):
        e, mu, _ = impact.coefficients
        share = mu / float(critical_mu(impact.approach, impact.bodies, e, 1.0))
        for j, name in enumerate("AB"):
            begin = f"{i:2d} {name}{e:7.3f}{mu:8.3f}{share:7.2f} "
            rows = ("".join(f"{x:9.4f}" for x in row) for row in (ours[i, j], theirs[i, j]))
            print(f"{begin}{'  '.join(rows)}  {np.abs(ours - theirs)[i, j].max():10.1e}")

    largest, left = np.abs(ours - theirs).max(), np.abs(alike - theirs).max()
    agree = bool(left <= AGREES)  # NaN does not
    print(
        f"\nlargest difference {largest:.1e} m/s or rad/s. PyCrash's masses are weights over"
        f" 32.2 ft/s², {GRAVITY - 1:+.2%};\nits speeds pass 1.46667 and 0.681818 between mph and"
        f" ft/s, {INTO * OUT - 1:+.1e}. With these in ours too: {left:.1e}\n"
        f"(at most {AGREES:.0e}): {'they agree' if agree else 'THEY DIFFER'}"
    )

    first = parting[0][1]
    print(
        "\nWhere they part: impact 0 with e = 0.3, sliding"
        f" {_sliding(first.approach, first):+.3f} m/s before; mu_c is critical at e, mu_0 at e = 0"
        f"\n{'mu':>19}  sliding after: retrodict  PyCrash   (retrodict with `capped`: 0 from mu_c on)"
    )
    for (name, impact), found in zip(parting, past, strict=True):
        after = [_sliding(x[:, :3].ravel(), impact) for x in (here(impact), found)]
        print(f"{name:>10} {impact.coefficients.mu:8.3f}{after[0]:26.3f}{after[1]:9.3f}")
    sys.exit(not agree)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
