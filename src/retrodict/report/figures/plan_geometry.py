"""Where things lie on the plan of a scene: outlines, surfaces, skids, wheels, the contact line."""

from __future__ import annotations

import numpy as np
from matplotlib.path import Path
from matplotlib.transforms import Bbox

from retrodict.scene.outlines import body_middle
from retrodict.scene.records import Edge, Measured, Scene, Surface, Vehicle

WALL = 0.6  # m: thickness of a wall, as it is drawn
Pose = tuple[float, float, float]


def impact_pose(scene: Scene, vehicle: str) -> Pose:
    """A vehicle's measured pose at impact: the impact centre less the lever to it (m, rad)."""
    return *scene.at_impact(vehicle), scene.vehicles[vehicle].heading.value


def outline(vehicle: Vehicle, pose: Pose) -> np.ndarray:
    """Corners of a vehicle, then the three of its forward mark, shape (7, 2), in m."""
    middle = body_middle(vehicle)
    front, rear = middle + vehicle.length / 2, middle - vehicle.length / 2
    half = vehicle.width / 2
    body = np.array([
        [front, half], [rear, half], [rear, -half], [front, -half],
        [front, 0], [front - half, 0.3 * half], [front - half, -0.3 * half],
    ])  # fmt: skip
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return body @ np.array([[c, s], [-s, c]]) + np.array(pose[:2])


def barrier_outline(scene: Scene, reach: float) -> np.ndarray:
    """Corners of the barrier that A struck, in m; a wall reaches `reach` (m) to either side."""
    barrier, contact = scene.barrier, scene.contact
    assert barrier, "asked of a scene that has one"
    struck = np.array([contact.x.value, contact.y.value])
    normal = np.array([np.cos(contact.Gamma.value), np.sin(contact.Gamma.value)])
    normal *= np.copysign(1.0, (struck - impact_pose(scene, "a")[:2]) @ normal)  # away from A
    if barrier.kind == "pole":
        turn = np.linspace(0, 2 * np.pi, 36, endpoint=False)
        around = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return struck + barrier.diameter / 2 * (normal + around)
    along = reach * np.array([-normal[1], normal[0]])
    behind = WALL * normal
    return struck + np.array([along, -along, behind - along, behind + along])


def area_of(surface: Surface, view: tuple[float, float, float, float]) -> np.ndarray:
    """Corners of the part of a surface to draw in a view (x0, x1, y0, y1 in m), shape (any, 2).

    The road has no corners, nor has a surface that lies beyond the view. An outline is drawn whole, as
    measured, even where it reaches beyond the view.
    """
    if surface.edge is not None:
        return half_plane(surface.edge, view)
    x0, x1, y0, y1 = view
    corners = np.array(surface.outline.corners if surface.outline else []).reshape(-1, 2)
    seen = len(corners) and Path(corners).intersects_bbox(Bbox([[x0, y0], [x1, y1]]))
    return corners if seen else corners[:0]


def half_plane(edge: Edge, view: tuple[float, float, float, float]) -> np.ndarray:
    """The part of a view (x0, x1, y0, y1 in m) beyond an edge, as a polygon's corners."""
    x0, x1, y0, y1 = view
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    sign = 1.0 if edge.side == "left" else -1.0
    inward = sign * np.array([-np.sin(edge.direction), np.cos(edge.direction)])
    origin = np.array([edge.x, edge.y]) + edge.offset.value * inward
    depth = (corners - origin) @ inward
    kept = []
    for i in range(4):
        j = (i + 1) % 4
        if depth[i] >= 0:
            kept.append(corners[i])
        if depth[i] * depth[j] < 0:
            share = depth[i] / (depth[i] - depth[j])
            kept.append(corners[i] + share * (corners[j] - corners[i]))
    return np.array(kept).reshape(-1, 2)


def wheel_paths(vehicle: Vehicle, pose: np.ndarray) -> np.ndarray:
    """Paths of the four wheels, shape (4, steps, 2), in m, for poses of shape (steps, 3)."""
    front, rear, half = vehicle.front_axle.value, vehicle.rear_axle.value, vehicle.track.value / 2
    places = np.array([[front, half], [front, -half], [-rear, half], [-rear, -half]])
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    ahead, left = np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)
    return np.array([pose[:, :2] + u * ahead + w * left for u, w in places])


def skid_lines(scene: Scene) -> list[tuple[str, np.ndarray]]:
    """Skid lines up to the impact, by vehicle: (side, end, xy) in m, shape (2, 2, 2)."""
    found = []
    for v in scene.skidded:
        own, vehicle = scene.approach[v], scene.vehicles[v]
        angle = (own.direction or vehicle.heading).value
        ahead = np.array([np.cos(angle), np.sin(angle)])
        aside = np.array([-ahead[1], ahead[0]]) * vehicle.track.value / 2
        centre = np.array(scene.at_impact(v))
        begin = centre - own.skid_length * ahead
        found.append((v, np.array([[begin + side, centre + side] for side in (aside, -aside)])))
    return found


def rest_outline(scene: Scene, v: str) -> np.ndarray:
    """Corners at rest as of `outline`, or the centre of gravity alone where no heading was measured."""
    rest = scene.rest[v]
    if rest.heading is None:
        return np.array([[rest.x.value, rest.y.value]])
    return outline(scene.vehicles[v], (rest.x.value, rest.y.value, rest.heading.value))


def ends_of_rotation(scene: Scene) -> list[tuple[str, float, float, Measured | None]]:
    """Vehicle, x, y and heading of each end of rotation whose coordinates were both measured."""
    ends = scene.end_of_rotation.items()
    return [
        (v, end["x"].value, end["y"].value, end.get("heading"))
        for v, end in ends
        if {"x", "y"} <= end.keys()
    ]


def contact_lines(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """The contact line and its normal, from end to end, in m."""
    centre = np.array([scene.contact.x.value, scene.contact.y.value])
    c, s = np.cos(scene.contact.Gamma.value), np.sin(scene.contact.Gamma.value)
    half = 0.45 * max(v.length for v in scene.vehicles.values())
    return centre + half * np.array([[s, -c], [-s, c]]), centre + half * np.array([[0, 0], [c, s]])
