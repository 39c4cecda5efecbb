"""A made-up reconstruction with all that a real one has, and no sampler behind it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest
import xarray as xr
from arviz_base import from_dict
from retrodict.models.description import Description

from retrodict.findings import Findings
from retrodict.inference.outcome import Checks, Outcome
from retrodict.inference.pointwise import pointwise
from retrodict.options import RunOptions
from retrodict.result import Result
from retrodict.scene.questions import questions_from
from retrodict.scene.records import (
    VEHICLES,
    Approach,
    Contact,
    Edge,
    Mark,
    Measured,
    Rest,
    RunOutError,
    Scene,
    Surface,
    Vehicle,
)

CHAINS, DRAWS = 4, 500
DEGREE = np.pi / 180

QUESTIONS = {
    "exceeds": ["impact_speed_b > 45 mph", "impact_speed_b > 100 m/s", "delta_v_a > 30 mph"],
    "between": "40 mph < impact_speed_b < 45 mph",
    "likelihood_ratio": [
        {"first": "impact_speed_b at most 40 mph", "second": "impact_speed_b at least 45 mph"}
    ],
    "avoidable": [
        {
            "vehicle": "B",
            "limit": "35 mph",
            "reaction": "1.2 ± 0.3 s",
            "deceleration": "0.7 ± 0.07 g",
        }
    ],
    "time_distance": "3 s",
}

DESCRIPTION = Description(
    name="planar-moment+wheels",
    title="Planar impact with moment impulse, then a skid to rest on four locked wheels",
    equations=(
        "momentum along x and y: SAE 770014 eqs 19, 20",
        "restitution e and equivalent friction μ along the contact line: SAE 770014 eqs 22, 23",
    ),
    assumptions=("all four wheels of both vehicles are locked from impact to rest",),
    left_out=("secondary impacts, and crush as evidence", "load transfer, pitch and roll; slopes"),
    priors=(
        ("speed of B", "half-normal, scale 30 m/s", "nearly flat over road speeds"),
        ("e", "half-normal, scale 0.2, cut at 1", "staged car crashes: mean 0.09, largest 0.28"),
    ),
)


def _vehicle(
    name: str, mass: float, yaw: float, lever: tuple[float, float], heading: float
) -> Vehicle:
    return Vehicle(
        name=name,
        mass=Measured(mass, 40.0, "lognormal", "kerb weight and occupants, SAE 2016-01-1486"),
        yaw_inertia=Measured(yaw, 0.05 * yaw, "lognormal", "Garrott regression", "value"),
        front_axle=Measured(1.30, 0.05, "lognormal", "data sheet", "sd"),
        rear_axle=Measured(1.45, 0.05, "lognormal", "data sheet", "sd"),
        track=Measured(1.52, source="data sheet"),
        impact_distance=Measured(lever[0], 0.05, "lognormal", "damage profile"),
        impact_angle=Measured(lever[1], 2 * DEGREE, source="damage profile"),
        heading=Measured(heading, 3 * DEGREE, source="tyre marks"),
        length=4.9,
        width=1.85,
    )


def make_scene() -> Scene:
    """Two cars that meet by the centre line; the numbers are those of no real collision."""
    rest = {
        "a": Rest(
            Measured(-2.9, 0.25, source="total station"),
            Measured(2.4, 0.25, source="total station"),
            Measured(205 * DEGREE, 4 * DEGREE, source="photograph"),
            True,
        ),
        "b": Rest(
            Measured(6.6, 0.3, source="total station"),
            Measured(-9.4, 0.3, source="total station"),
            Measured(700 * DEGREE, 5 * DEGREE, source="photograph"),
            True,
        ),
    }
    return Scene(
        title="Two cars on a made-up road",
        name="made-up",
        text='title = "Two cars on a made-up road"\n\n[vehicles.a]\nmass = "1857 ± 40 kg"\n',
        vehicles={
            "a": _vehicle("saloon A", 1857.0, 3374.0, (2.09, 0.098), np.pi),
            "b": _vehicle("saloon B", 1778.0, 3007.0, (1.76, 28 * DEGREE), 40 * DEGREE),
        },
        approach={
            "a": Approach(
                Measured(20.1, 0.5, "lognormal", "event data recorder"),
                Measured(np.pi, 1 * DEGREE, source="lane"),
                Measured(0.0),
            ),
            "b": Approach(None, None, None),
        },
        rest=rest,
        contact=Contact(
            Measured(0.0, 0.15, source="gouge marks"),
            Measured(0.0, 0.15, source="gouge marks"),
            Measured(-0.155, 3 * DEGREE, source="damage profile"),
        ),
        surfaces=(
            Surface("road", Measured(0.5, 0.05, "lognormal", "skid test"), Measured(0.0), None),
            Surface(
                "berm",
                Measured(0.4, 0.06, "lognormal", "textbook range", "sd"),
                Measured(0.01, 0.002, "lognormal", "textbook", "value"),
                Edge(0.0, -7.5, 0.05, "right", Measured(0.0, 0.1, source="tape")),
            ),
        ),
        notes=("The weather was dry.",),
    )


def make_sparse_scene() -> Scene:
    """The same cars with other evidence: A's speed and rest and B's heading at rest are not known."""
    full = make_scene()
    a, b = full.approach["a"], full.approach["b"]
    at_second = {
        "speed": Measured(6.0, 0.5, source="film"),
        "course": Measured(-55 * DEGREE, 6 * DEGREE, source="film"),
    }
    return replace(
        full,
        approach={
            "a": replace(a, speed=None),
            "b": replace(b, skid=Measured(12.0, 0.5, "lognormal", "tape")),
        },
        rest={"b": replace(full.rest["b"], heading=None, turns_known=False)},
        departure={
            "a": {
                "direction": Measured(140 * DEGREE, 8 * DEGREE, source="first metres of the marks"),
                "delta_v_forward": Measured(-13.0, 1.0, source="event data recorder"),
            },
        },
        marks={
            "b": (
                Mark(2.0, -1.5, 0.2, "front_left", "taped", ""),
                Mark(4.5, -5.0, 0.15, "centre", "photograph", "sd", **at_second),
            )
        },
        end_of_rotation={
            "b": {
                "x": Measured(5.5, 0.5, source="tyre marks"),
                "y": Measured(-7.0, 0.5, source="tyre marks"),
                "heading": Measured(-50 * DEGREE, 5 * DEGREE, source="tyre marks"),
            }
        },
        question=("speed_a", "speed_b", "e", "e_m", "mu"),
        robust=True,
    )


def make_outcome(scene: Scene | None = None, seed: int = 7) -> Outcome:
    """An outcome whose draws are normal about known values: speed_b is 19.2 ± 0.9 m/s."""
    scene = scene or make_scene()
    rng = np.random.default_rng(seed)

    def normal(mean: float, sd: float, draws: int = DRAWS, chains: int = CHAINS) -> np.ndarray:
        return rng.normal(mean, sd, (chains, draws))

    speed = normal(19.2, 0.9)
    # e, e_m, mu lean on the speed, as they do in a real reconstruction
    lean = (speed - 19.2) / 0.9
    posterior = {
        "speed_b": speed,
        "e": np.abs(0.10 + 0.03 * lean + normal(0, 0.05)),
        "e_m": np.clip(0.70 - 0.05 * lean + normal(0, 0.08), -1, 1),
        "mu": 0.35 + 0.06 * lean + normal(0, 0.05),
        "vbx": 18.8 + 0.88 * lean,
        "vby": -3.7 + 0.1 * lean + normal(0, 0.3),
        "omega_b": normal(-0.26, 0.5),
        "direction_b": normal(-0.19, 0.02),
        **{f"delta_v_{v}": normal(13.5, 0.6) for v in VEHICLES},
        "energy_lost": normal(3.9e5, 2.4e4),
        "Vax": normal(-7.0, 0.4),
        "Vay": normal(2.4, 0.2),
        "Omega_a": normal(0.61, 0.1),
        "Vbx": normal(5.2, 0.3),
        "Vby": normal(-6.1, 0.3),
        "Omega_b": normal(9.9, 0.6),
    }
    prior = {
        "speed_b": np.abs(normal(0, 30, 500, 1)),
        "e": np.abs(normal(0, 0.2, 500, 1)),
        "e_m": rng.uniform(-1, 1, (1, 500)),
        "mu": normal(0, 1, 500, 1),
    }
    for name, m in scene.inputs().items():
        if m.sd > 0:
            posterior[name] = normal(m.value + rng.normal(0, 0.4) * m.sd, 0.85 * m.sd)
            prior[name] = normal(m.value, m.sd, 500, 1)
    for v, approach in scene.approach.items():
        if approach.speed is None and v == "a":
            posterior["speed_a"] = normal(20.3, 0.7)
            prior["speed_a"] = np.abs(normal(0, 30, 500, 1))
        if approach.skid is not None:
            posterior[f"travelling_speed_{v}"] = np.sqrt(posterior[f"speed_{v}"] ** 2 + 118.0)
            if f"speed_{v}" in prior:
                prior[f"travelling_speed_{v}"] = np.sqrt(prior[f"speed_{v}"] ** 2 + 118.0)
    evidence = scene.evidence()
    shift = dict(zip(evidence, cycle((0.2, -0.4, 0.1, 0.6, 1.7, -0.2)), strict=False))
    predictive = {
        name: normal(m.value + shift[name] * m.sd, 1.3 * m.sd) for name, m in evidence.items()
    }
    groups = {
        "posterior": posterior,
        "prior": prior,
        "posterior_predictive": predictive,
        "prior_predictive": {n: normal(m.value, 9.0, 500, 1) for n, m in evidence.items()},
        "log_likelihood": {n: normal(-1, 0.5) for n in evidence},
        "sample_stats": {
            "diverging": np.zeros((CHAINS, DRAWS), bool),
            "energy": normal(30, 4),
            "acceptance_rate": np.clip(normal(0.9, 0.05), 0, 1),
        },
    }
    idata = from_dict(groups)
    for group, values in (
        ("observed_data", {n: ((), m.value) for n, m in evidence.items()}),
        ("constant_data", {f"{n}_sd": ((), m.sd) for n, m in evidence.items()}),
    ):
        idata[group] = xr.DataTree(xr.Dataset(values))
    idata["trajectories"] = xr.DataTree(_trajectories(scene, rng))
    return Outcome(
        scene=scene,
        description=DESCRIPTION,
        idata=pointwise(idata),
        checks=Checks(0, 1.0021, 1843.0, 1712.0, True),
        seconds={"total": 21.4, "compile": 9.1, "sample": 11.2},
        versions={"retrodict": "0.1.0", "Python": "3.12.1", "jax": "0.12.0"},
        seed=20,
        settings={"chains": CHAINS, "draws": DRAWS, "warmup": 500},
        asked=RunOptions("planar-moment+wheels", "nuts", CHAINS, DRAWS, 500, seed=20),
    )


def _trajectories(
    scene: Scene, rng: np.random.Generator, count: int = 60, steps: int = 40
) -> xr.Dataset:
    s = np.linspace(0, 1, steps)
    path = np.zeros((count, 2, steps, 3))
    for i, v in enumerate(VEHICLES):
        vehicle, rest = scene.vehicles[v], scene.rest.get(v, make_scene().rest[v])
        at_rest = rest.heading or Measured(0.0, 1.0)
        heading = vehicle.heading.value
        angle = heading + vehicle.impact_angle.value
        start = -vehicle.impact_distance.value * np.array([np.cos(angle), np.sin(angle)])
        end = np.array([rest.x.value, rest.y.value, at_rest.value])
        ends = end + rng.normal(size=(count, 3)) * [rest.x.sd, rest.y.sd, at_rest.sd]
        for j in range(2):
            bulge = rng.normal(0.6 * (-1) ** (i + j), 0.15, (count, 1)) * s * (1 - s)
            path[:, i, :, j] = start[j] + (ends[:, j : j + 1] - start[j]) * s + bulge
        path[:, i, :, 2] = heading + (ends[:, 2:] - heading) * s
    speed = rng.normal([20.1, 19.2], 0.9, (count, 2))
    course = np.array([np.pi, -0.19])
    coords = {"vehicle": list(VEHICLES), "pose": ["x", "y", "heading"], "axis": ["x", "y"]}
    variables = {
        "path": (("run", "vehicle", "step", "pose"), path),
        "time": (("run", "vehicle", "step"), 0.1 * speed[..., None] * (1 - np.sqrt(1 - s))),
        "before": (
            ("run", "vehicle", "axis"),
            np.stack([speed * np.cos(course), speed * np.sin(course)], axis=-1),
        ),
    }
    return xr.Dataset(variables, coords)


def fail(outcome: Outcome, failed: tuple[str, ...] = ("e_m",)) -> Outcome:
    """The same outcome with failed checks."""
    reasons = ("R-hat of e_m is 1.050 (limit 1.01).", "12 divergent transitions.")
    return replace(outcome, checks=Checks(12, 1.05, 92.0, 80.0, False, reasons, failed))


def without(outcome: Outcome, group: str) -> Outcome:
    """The same outcome with one group fewer."""
    kept = {name: tree for name, tree in outcome.idata.children.items() if name != group}
    return replace(outcome, idata=xr.DataTree(children={k: t.copy() for k, t in kept.items()}))


_RESULTS: dict[int, Result] = {}


def found_of(outcome: Outcome) -> Findings:
    """The findings of an outcome that many tests share, computed once."""
    return _RESULTS.setdefault(id(outcome), Result(outcome)).findings


@pytest.fixture(scope="session")
def outcome() -> Outcome:
    return make_outcome()


@pytest.fixture(scope="session")
def sparse() -> Outcome:
    return make_outcome(make_sparse_scene())


@pytest.fixture(scope="session")
def asked() -> Outcome:
    """An outcome of a scene that asks every question but the corner range."""
    return make_outcome(replace(make_sparse_scene(), questions=questions_from(QUESTIONS, "test")))


@pytest.fixture(scope="session")
def rolled() -> Outcome:
    """An outcome whose run-out is taken to miss B by 4 % of its way, and its heading by 8 deg."""
    scene = make_sparse_scene()
    error = RunOutError(
        Measured(0.04, source="judgement", assumed="value"), Measured(8 * DEGREE, source="tests")
    )
    b = replace(scene.vehicles["b"], run_out_error=error)
    return make_outcome(replace(scene, vehicles=scene.vehicles | {"b": b}))


@pytest.fixture(scope="session")
def failing(outcome: Outcome) -> Outcome:
    return fail(outcome)


@pytest.fixture(scope="session")
def drop() -> Callable[[Outcome, str], Outcome]:
    return without
