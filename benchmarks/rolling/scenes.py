"""Random crashes of cars whose wheels roll: scene files and true values.

The written values of the cars are drawn first. The true value of every input is then drawn from the law
that the scene file states for it, and those of the unknowns from the priors of docs/scene-file.md. Every
item of evidence is the true value plus an error of the size that is written beside it.
"""

from __future__ import annotations

import json
from math import hypot
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.special import expit, logit

from benchmarks.rolling import truth
from retrodict.scene import Scene, parse_scene
from retrodict.scene.records import VEHICLES, WHEELS, Measured
from tests.shared.random_scenes import DEGREE, Cars, cars

WAY, LEAST_WAY = 150.0, 1.0  # m: path length of each car, at most and at least
LEAST_CLOSING = 3.0  # m/s, along the normal
MOST_E, MOST_MU, MOST_SPIN = 0.5, 1.0, 12.0  # restitution, friction, rad/s
REST = ("rest_x", "rest_y", "rest_heading")
DRAGS = ("rolling", "0.1 ± 0.05")  # how a rolling wheel is written: by the default, or by a number
OTHER_DRAG, STEERED, RECORDER, COURSE, SPEEDS_ONLY = 0.3, 0.5, 0.75, 0.5, 0.5  # shares of scenes
STEER = 20.0  # deg, at most, to either side

# Which wheels of A and of B roll, as bits. Of 16 scenes in a row (but 15 where all eight wheels would
# be locked) A has each pattern once, and so has B; in 255 every pair but that comes once.
PATTERNS = tuple(
    (a, b) for i in range(256) if (a := i % 16) | (b := (5 * i + i // 16 + 3) % 16) != 0
)


POSITION, HEADING = 0.15, 3 * DEGREE  # standard deviations of measuring a pose, m and rad


class Errors(NamedTuple):
    """Standard deviations: of each coordinate of a point of the path, m, and of a heading, rad."""

    position: float
    heading: float


def errors(scene: Scene, v: str, way: float) -> Errors:
    """Errors of a pose after so long a path: of measuring it, and of the run-out model by its default.

    Args:
        scene: with the vehicles.
        v: which of them.
        way: path length from the impact, m.
    """
    missed = scene.vehicles[v].run_out_error
    return Errors(
        position=hypot(POSITION, missed.of_position(way)),
        heading=hypot(HEADING, missed.of_heading(way)),
    )


class Plan(NamedTuple):
    """What kind of scene it is.

    Args:
        wheels: of A and B, "L" for locked and "R" for rolling, in the order of `WHEELS`.
        drag: how rolling wheels are written.
        steered: whether the front wheels of cars that roll are.
        recorder: whether A's speed is known from a recorder.
        course: whether B's direction of travel and yaw rate before the impact are known.
        speeds_only: whether speeds are all that is asked.
    """

    wheels: tuple[str, str]
    drag: str
    steered: bool
    recorder: bool
    course: bool
    speeds_only: bool

    @property
    def asked(self) -> tuple[str, ...]:
        """The unknowns that are asked."""
        speeds = ("speed_b",) if self.recorder else ("speed_a", "speed_b")
        return speeds if self.speeds_only else (*speeds, "e", "e_m", "mu")


class Made(NamedTuple):
    """A synthetic crash.

    Args:
        plan: of what kind it is.
        text: its scene file.
        truth: the true value of everything, SI units and radians, by flat name.
    """

    plan: Plan
    text: str
    truth: dict[str, float]


def crash(index: int) -> Made:
    """A crash at random.

    Args:
        index: of the scene, which is also its seed.

    Returns:
        Its plan, its scene file and its truth.
    """
    rng = np.random.default_rng(index)
    plan = _plan(index, rng)
    while True:
        drawn = cars(rng)
        made = None if drawn is None else _crash(index, plan, drawn, rng)
        if made is not None:
            return made


def write(index: int, made: Made, folder: Path) -> Path:
    """Write a crash's scene.toml and truth.json into a folder of its own.

    Args:
        index: of the scene.
        made: the crash.
        folder: of all scenes.

    Returns:
        The scene file.
    """
    mine = folder / f"{index:03d}"
    mine.mkdir(parents=True, exist_ok=True)
    (mine / "scene.toml").write_text(made.text, "utf-8")
    content = {"plan": made.plan._asdict(), "truth": made.truth}
    (mine / "truth.json").write_text(
        json.dumps(content, indent=2, ensure_ascii=False) + "\n", "utf-8"
    )
    return mine / "scene.toml"


def _plan(index: int, rng: np.random.Generator) -> Plan:
    wheels = [
        "".join("LR"[bits >> i & 1] for i in range(4)) for bits in PATTERNS[index % len(PATTERNS)]
    ]
    other, steered, recorder, course, speeds_only = rng.random(5) < [
        OTHER_DRAG, STEERED, RECORDER, COURSE, SPEEDS_ONLY
    ]  # fmt: skip
    return Plan(
        (wheels[0], wheels[1]),
        DRAGS[int(other)],
        bool(steered),
        bool(recorder),
        bool(course or not recorder),  # without either, momentum leaves both speeds open
        bool(speeds_only),
    )


def _crash(index: int, plan: Plan, written: Cars, rng: np.random.Generator) -> Made | None:
    """A crash of cars with these written values; None where it is not plausible."""
    head, place = _head(index, plan), _place(written, rng)
    vehicles = [_vehicle(i, plan, written, rng) for i in (0, 1)]
    scene = parse_scene("\n".join([head, *vehicles, place, _UNMEASURED]), f"{index:03d}")
    true = {name: draw(m, rng) for name, m in scene.inputs().items()}
    true |= _motion_before(scene, written, rng)
    after = _impact(scene, true, rng)
    if after is None:
        return None
    for i, v in enumerate(VEHICLES):
        friction = true["friction_road"] * true[f"grip_{v}"]
        poses = truth.path(_pose(v, true), after[i], _car(v, true), friction)
        way = truth.way(poses)
        if not LEAST_WAY < way[-1] < WAY:
            return None
        true[f"way_{v}"] = float(way[-1])
        true |= dict(zip((f"{part}_{v}" for part in REST), poses[-1].tolist(), strict=True))
        vehicles[i] += _evidence(scene, v, poses, way, rng)
    return Made(plan, "\n".join([head, *vehicles, place]), true)


# --- true values -------------------------------------------------------------------------------


def draw(measured: Measured, rng: np.random.Generator) -> float:
    """A true value from the law that a scene states for a measured one (docs/scene-file.md)."""
    value, sd, z = measured.value, measured.sd, rng.standard_normal()
    if sd == 0:
        return value
    if measured.law == "lognormal":  # with this mean and standard deviation
        variance = np.log1p((sd / value) ** 2)
        return float(value * np.exp(np.sqrt(variance) * z - variance / 2))
    if measured.law == "logitnormal":  # about this median, with a scale by the delta method
        return float(expit(logit(value) + sd / (value * (1 - value)) * z))
    return float(value + sd * z)


def farthest(made: Made) -> tuple[str, float]:
    """The input whose true value lies farthest from what the scene file says, and by how many sd."""
    scene = parse_scene(made.text, "a synthetic crash")
    off = {
        name: deviate(measured, made.truth[name])
        for name, measured in scene.inputs().items()
        if measured.sd and name in made.truth
    }
    return max(off.items(), key=lambda item: abs(item[1]))


def deviate(measured: Measured, true: float) -> float:
    """What `draw` made a true value of: a standard normal number."""
    value, sd = measured.value, measured.sd
    if measured.law == "lognormal":
        variance = np.log1p((sd / value) ** 2)
        return float((np.log(true / value) + variance / 2) / np.sqrt(variance))
    if measured.law == "logitnormal":
        return float((logit(true) - logit(value)) * value * (1 - value) / sd)
    return (true - value) / sd


def _motion_before(scene: Scene, written: Cars, rng: np.random.Generator) -> dict[str, float]:
    """What nobody measured of the motion before the impact; B's course lies about its heading."""
    yaw_rate = scene.priors["omega_b"].numbers[0]
    drawn = {
        "speed_a": rng.uniform(8, 25),
        "speed_b": rng.uniform(3, 30),
        "direction_b": written.heading[1] + rng.normal(0, 0.2),
        "omega_b": rng.normal(0, yaw_rate),
    }
    return {name: float(value) for name, value in drawn.items() if name not in scene.inputs()}


def _impact(scene: Scene, true: dict[str, float], rng: np.random.Generator) -> truth.Array | None:
    """Velocities after the impact, shape (2, 3); None where it is not plausible.

    The coefficients come from the scene's priors and are added to `true`.
    """
    bodies = truth.Impact(
        mass=np.array([true[f"mass_{v}"] for v in VEHICLES]),
        inertia=np.array([true[f"yaw_inertia_{v}"] for v in VEHICLES]),
        lever=np.array([_lever(v, true) for v in VEHICLES]),
        Gamma=true["Gamma"],
    )
    before = np.concatenate([_velocity(v, true) for v in VEHICLES])
    closing = truth.closing_speed(before, bodies)
    if closing < LEAST_CLOSING:
        return None
    fast, slow, over = scene.priors["e"].numbers
    e = abs(rng.normal(0, fast + (slow - fast) * np.exp(-closing / over)))
    e_m = rng.normal(*scene.priors["e_m"].numbers)
    if e > MOST_E or abs(e_m) > 1:
        return None
    scale, median = scene.priors["mu"].numbers
    critical = truth.critical_mu(before, bodies, e, e_m)
    if rng.random() < 1 / (1 + (critical / 2) ** 4):  # sliding ends
        mu = critical * (1 - scale * abs(rng.normal()))
    else:  # a log-logistic of shape 5, cut at the critical mu
        mu = np.inf
        while mu > abs(critical):
            u = rng.random()
            mu = median * (u / (1 - u)) ** (1 / 5)
        mu *= np.sign(critical)
    if not abs(mu) < MOST_MU:
        return None
    after = truth.separation(before, bodies, e, mu, e_m)
    if truth.energy(after, bodies) > truth.energy(before, bodies):
        return None
    velocities = after.reshape(2, 3)
    if np.abs(velocities[:, 2]).max() > MOST_SPIN:
        return None
    true |= {"e": float(e), "e_m": float(e_m), "mu": float(mu)}
    return velocities


def _lever(v: str, true: dict[str, float]) -> truth.Array:
    """From a vehicle's centre of gravity to the impact centre, in the road's axes, m."""
    angle = true[f"heading_{v}"] + true[f"impact_angle_{v}"]
    return true[f"impact_distance_{v}"] * np.array([np.cos(angle), np.sin(angle)])


def _velocity(v: str, true: dict[str, float]) -> truth.Array:
    speed, direction = true[f"speed_{v}"], true[f"direction_{v}"]
    return np.array([speed * np.cos(direction), speed * np.sin(direction), true[f"omega_{v}"]])


def _pose(v: str, true: dict[str, float]) -> truth.Array:
    """Of a vehicle at impact."""
    centre = np.array([true["impact_x"], true["impact_y"]]) - _lever(v, true)
    return np.append(centre, true[f"heading_{v}"])


def _car(v: str, true: dict[str, float]) -> truth.Car:
    return truth.Car(
        k2=true[f"yaw_inertia_{v}"] / true[f"mass_{v}"],
        front=true[f"front_axle_{v}"],
        rear=true[f"rear_axle_{v}"],
        track=true[f"track_{v}"],
        drag=np.array([_drag(true, wheel, v) for wheel in WHEELS]),
        steer=true.get(f"steer_{v}", 0.0),
    )


def _drag(true: dict[str, float], wheel: str, v: str) -> float:
    """Of a wheel: the factor that a vehicle's drags share multiplies its odds."""
    own = true.get(f"drag_{wheel}_{v}", 1.0)
    factor = true.get(f"drag_factor_{v}", 1.0)
    return own if own == 1 else float(expit(logit(own) + np.log(factor)))


# --- the scene file ----------------------------------------------------------------------------

_UNMEASURED = """
[vehicles.A.rest]
position = ["0 m", "0 m"]
"""  # placeholder: a scene needs some evidence


def _head(index: int, plan: Plan) -> str:
    question = f"question = {json.dumps(plan.asked)}\n"  # else the default, which is all of them
    return f"""schema = 1
title = "A synthetic crash, number {index}: wheels of A {plan.wheels[0]}, of B {plan.wheels[1]}"
{question if plan.speeds_only else ""}"""


def _vehicle(i: int, plan: Plan, written: Cars, rng: np.random.Generator) -> str:
    """A vehicle's table, without what was measured after the impact."""
    corner, heading = written.corner[i], _degrees(written.heading[i])
    lines = [
        f"[vehicles.{'AB'[i]}]",
        f'name = "car {"AB"[i]}"',
        f'mass = "{written.mass[i]:.0f} kg ± 2 %"',
        f'yaw_inertia = "{written.inertia[i]:.0f} kg m^2 ± 6 %"',
        f'cg_to_front_axle = "{written.front[i]:.3f} m"',
        f'cg_to_rear_axle = "{written.rear[i]:.3f} m"',
        f'track = "{written.track[i]:.3f} m"',
        'length = "4.6 m"',
        'width = "1.75 m"',
        f'impact_centre.distance = "{np.hypot(*corner):.3f} m ± 3 %"',
        f'impact_centre.angle = "{_degrees(np.arctan2(corner[1], corner[0]))} ± 2 deg"',
        f'impact.heading = "{heading} ± 2 deg"',
    ]
    if "R" in plan.wheels[i]:
        turn = {"L": "locked", "R": plan.drag}
        wheels = zip(WHEELS, plan.wheels[i], strict=True)
        lines.append(f"wheels = {{ {', '.join(f'{w} = "{turn[how]}"' for w, how in wheels)} }}")
        if plan.steered:
            lines.append(f'steer = "{rng.uniform(-STEER, STEER):.1f} ± 3 deg"')
    if i == 0 and plan.recorder:
        lines.append(f'approach.speed = "{rng.uniform(8, 25):.2f} m/s ± 4 %"')
    if i == 0:
        lines += [f'approach.direction = "{heading} ± 1 deg"', 'approach.yaw_rate = "0 ± 2 deg/s"']
    elif plan.course:
        course = _degrees(written.heading[1] + rng.normal(0, 0.2))
        lines += [f'approach.direction = "{course} ± 3 deg"', 'approach.yaw_rate = "0 ± 2 deg/s"']
    else:
        lines.append('approach.direction = "unknown"')
    return "\n" + "\n".join(lines) + "\n"


def _place(written: Cars, rng: np.random.Generator) -> str:
    return f"""
[impact]
point = ["0 ± 0.05 m", "0 ± 0.05 m"]
contact_line = "{_degrees(written.Gamma)} ± 3 deg"

[surfaces.road]
friction = "{rng.uniform(0.35, 0.85):.3f} ± 6 %"
"""


def _evidence(
    scene: Scene, v: str, poses: truth.Array, way: truth.Array, rng: np.random.Generator
) -> str:
    """The rest pose and one point of the path, measured with the errors that are written."""
    of_rest = errors(scene, v, way[-1])
    x, y, heading = poses[-1] + rng.standard_normal(3) * [*[of_rest.position] * 2, of_rest.heading]
    passed = np.searchsorted(way, rng.uniform(0.2, 0.8) * way[-1])
    of_mark = errors(scene, v, way[passed])
    mark_x, mark_y = poses[passed, :2] + of_mark.position * rng.standard_normal(2)
    turned = heading - scene.vehicles[v].heading.value
    sd = f"{POSITION} m"
    return f"""
[vehicles.{v.upper()}.rest]
position = ["{x:.2f} ± {sd}", "{y:.2f} ± {sd}"]
heading = "{_degrees(heading)} ± {np.degrees(HEADING):.0f} deg"
rotation = "{np.degrees(turned):.0f} deg"

[[vehicles.{v.upper()}.marks]]
point = ["{mark_x:.2f} m", "{mark_y:.2f} m"]
uncertainty = "{POSITION} m"
"""


def _degrees(angle: float) -> str:
    """An angle within half a turn of 0, to a tenth of a degree."""
    return f"{np.degrees(np.arctan2(np.sin(angle), np.cos(angle))):.1f}"
