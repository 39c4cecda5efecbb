"""The same crash written down otherwise: mirrored, turned, moved, with A and B exchanged."""

import math
from collections.abc import Callable
from dataclasses import replace

from retrodict.scene.records import Measured, Rest, Scene, Vehicle

_LETTERS = {"a": "b", "b": "a"}


def _opposite(measured: Measured) -> Measured:
    return replace(measured, value=-measured.value)


def _moved(scene: Scene, to: Callable[[float, float], tuple[float, float]], by: float) -> Scene:
    """All points of a scene that has rests at the most taken elsewhere, and all angles by `by`."""
    assert not scene.marks
    assert not scene.end_of_rotation
    assert all(surface.edge is None and surface.outline is None for surface in scene.surfaces)

    def point(x: Measured, y: Measured) -> tuple[Measured, Measured]:
        assert math.isclose(x.sd, y.sd), "errors that are not round would have to be turned"
        there = to(x.value, y.value)
        return replace(x, value=there[0]), replace(y, value=there[1])

    def turned(angle: Measured) -> Measured:
        return replace(angle, value=angle.value + by)

    def rest(before: Rest) -> Rest:
        x, y = point(before.x, before.y)
        heading = before.heading and turned(before.heading)
        return replace(before, x=x, y=y, heading=heading)

    x, y = point(scene.contact.x, scene.contact.y)
    return replace(
        scene,
        vehicles={
            v: replace(one, heading=turned(one.heading)) for v, one in scene.vehicles.items()
        },
        approach={
            v: replace(one, direction=one.direction and turned(one.direction))
            for v, one in scene.approach.items()
        },
        rest={v: rest(one) for v, one in scene.rest.items()},
        contact=replace(scene.contact, x=x, y=y, Gamma=turned(scene.contact.Gamma)),
    )


def shifted(scene: Scene, x: float, y: float) -> Scene:
    """The scene x m along the x axis, and y m along the y axis."""
    return _moved(scene, lambda x_, y_: (x_ + x, y_ + y), 0.0)


def turned(scene: Scene, angle: float) -> Scene:
    """The scene turned about the origin by an angle, rad."""
    cos, sin = math.cos(angle), math.sin(angle)
    return _moved(scene, lambda x, y: (x * cos - y * sin, x * sin + y * cos), angle)


def mirrored(scene: Scene) -> Scene:
    """The scene seen in a mirror along the x axis: left is right."""
    assert not scene.marks
    assert not scene.end_of_rotation

    def vehicle(one: Vehicle) -> Vehicle:
        assert one.wheels is None, "wheels would have to change sides"
        return replace(
            one, heading=_opposite(one.heading), impact_angle=_opposite(one.impact_angle)
        )

    def rest(one: Rest) -> Rest:
        return replace(one, y=_opposite(one.y), heading=one.heading and _opposite(one.heading))

    sideways = {"direction", "yaw_rate", "delta_v_left", "delta_v_left_at_least"}
    return replace(
        scene,
        vehicles={v: vehicle(one) for v, one in scene.vehicles.items()},
        approach={
            v: replace(
                one,
                direction=one.direction and _opposite(one.direction),
                yaw_rate=one.yaw_rate and _opposite(one.yaw_rate),
            )
            for v, one in scene.approach.items()
        },
        rest={v: rest(one) for v, one in scene.rest.items()},
        departure={
            v: {k: _opposite(m) if k in sideways else m for k, m in items.items()}
            for v, items in scene.departure.items()
        },
        contact=replace(
            scene.contact, y=_opposite(scene.contact.y), Gamma=_opposite(scene.contact.Gamma)
        ),
    )


def exchanged(scene: Scene) -> Scene:
    """The scene with the letters of the vehicles exchanged: the speed of the other is sought."""

    def other(name: str) -> str:
        of_one = name.startswith(("speed_", "omega_"))
        return f"{name[:-1]}{_LETTERS[name[-1]]}" if of_one else name

    sought = (scene.approach["a"], scene.approach["b"])
    assert sought[0].speed is not None
    assert sought[1].speed is None
    return replace(
        scene,
        vehicles={v: scene.vehicles[_LETTERS[v]] for v in scene.vehicles},
        approach={v: scene.approach[_LETTERS[v]] for v in scene.approach},
        rest={_LETTERS[v]: one for v, one in scene.rest.items()},
        departure={_LETTERS[v]: one for v, one in scene.departure.items()},
        marks={_LETTERS[v]: ones for v, ones in scene.marks.items()},
        end_of_rotation={_LETTERS[v]: one for v, one in scene.end_of_rotation.items()},
        question=tuple(other(name) for name in scene.question),
        priors={other(name): prior for name, prior in scene.priors.items()},
    )
