"""Scenes that tests share, built from records, so that they need no file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from retrodict.scene.records import (
    Approach,
    Contact,
    Edge,
    Measured,
    Rest,
    Scene,
    Surface,
    Vehicle,
    Wheels,
)

DEGREE = np.pi / 180
LEVER_A, LEVER_B = np.array([-2.079, -0.205]), np.array([0.653, 1.636])


def positive(value: float, share: float = 0.0) -> Measured:
    """A quantity that cannot be negative, with a relative standard deviation."""
    return Measured(value, share * value, "lognormal")


def vehicle(
    name: str, mass: float, inertia: float, lever: np.ndarray, heading: float, share: float
) -> Vehicle:
    """A car whose impact centre lies at `lever` from its centre of gravity, in the road frame."""
    angle = np.arctan2(lever[1], lever[0]) - heading
    return Vehicle(
        name=name,
        mass=positive(mass, share),
        yaw_inertia=positive(inertia, 4 * share),
        front_axle=positive(1.35),
        rear_axle=positive(1.45),
        track=positive(1.5),
        impact_distance=positive(float(np.hypot(*lever)), share),
        impact_angle=Measured(float((angle + np.pi) % (2 * np.pi) - np.pi), 100 * share * DEGREE),
        heading=Measured(heading, 100 * share * DEGREE),
        length=4.7,
        width=1.8,
    )


def collision(
    *,
    share: float = 0.02,
    berm: bool = True,
    turns_known: bool = True,
    interlocked: bool = False,
    rest: tuple[tuple[float, ...], tuple[float, ...]] = (
        (-3.59, 2.18, 3.799),
        (8.968, -12.896, 12.584),
    ),
) -> Scene:
    """The geometry of SAE 770014's example; `share` = 0 leaves only its nine main unknowns.

    Its printed mu of 0.35 is beyond mu_c, 0.32: its answer is to be found where parts `interlocked`.
    """
    d = 1.0 if share else 0.0
    surfaces = [Surface("road", positive(0.5, 0.06), Measured(0.0), None)]
    if berm:
        edge = Edge(0.0, 1.75, 0.0, "left", Measured(0.0, 0.1 * d))
        surfaces.append(Surface("berm", positive(0.4, 0.075), Measured(0.0), edge))
    return Scene(
        title="A collision",
        name="collision",
        text="",
        vehicles={
            "a": vehicle("car A", 1857.0, 3374.0, LEVER_A, np.pi, share),
            "b": vehicle("car B", 1778.0, 3007.0, LEVER_B, -22 * DEGREE, share),
        },
        approach={
            "a": Approach(
                Measured(20.1168, 0.894), Measured(np.pi, d * DEGREE), Measured(0.0, 2 * d * DEGREE)
            ),
            "b": Approach(None, None, None),
        },
        rest={
            v: Rest(Measured(x, 0.15), Measured(y, 0.15), Measured(h, 3 * DEGREE), turns_known)
            for v, (x, y, h) in zip("ab", rest, strict=True)
        },
        contact=Contact(
            Measured(0.0, 0.1 * d),
            Measured(0.0, 0.1 * d),
            Measured(-0.155, 3 * DEGREE),
            interlocked,
        ),
        surfaces=tuple(surfaces),
    )


def at_rest(scene: Scene, poses: dict[str, tuple[float, float, float]]) -> Scene:
    """The scene with other rest poses (x, y in m, heading in rad with its turns), known as well."""
    rest = {}
    for v, pose in poses.items():
        own = scene.rest[v]
        x, y, heading = (
            replace(m, value=value)
            for m, value in zip((own.x, own.y, own.heading), pose, strict=True)
        )
        rest[v] = Rest(x, y, heading, turns_known=True)
    return replace(scene, rest=rest)


def rolls(scene: Scene, v: str, drags: tuple[float, float, float, float]) -> Scene:
    """The scene with the wheels of a vehicle rolling, front left, front right, rear left, rear right."""
    drag = (Measured(each, 0.05, "logitnormal") for each in drags)
    car = replace(scene.vehicles[v], wheels=Wheels(*drag, Measured(0.0, 0.05)))
    return replace(scene, vehicles=scene.vehicles | {v: car})
