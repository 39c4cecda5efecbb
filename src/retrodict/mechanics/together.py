"""Two vehicles that go on together after an impact: their common motion, and the body that they make."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from retrodict.mechanics.motion import Car, Joined, wheel_loads, wheel_places
from retrodict.mechanics.rotation import cos_sin
from retrodict.mechanics.runout import Path
from retrodict.mechanics.tyre import Wheels


class Masses(NamedTuple):
    """Masses and yaw inertias of two vehicles, A's first.

    Args:
        mass: masses, kg.
        yaw_inertia: yaw inertias, kg m².
    """

    mass: Float[Array, "2"]
    yaw_inertia: Float[Array, "2"]


def common_motion(
    before: Float[Array, "6"], apart: Float[Array, "2"], masses: Masses
) -> Float[Array, "6"]:
    """Velocities after an impact that joins two vehicles to one rigid body.

    Momentum and angular momentum about the common centre of gravity are kept; no coefficient is left. It
    is the planar impact with restitution e = 0, impact moment coefficient e_m = 0 and no sliding left.

    Args:
        before: velocities before, A's first: x and y, m/s, and yaw rate, rad/s.
        apart: vector from A's centre of gravity to B's, m.
        masses: masses and yaw inertias.

    Returns:
        Velocities after, as `before`: each centre of gravity's, and the common yaw rate.

    Source:
        SAE 770014, eqs 19 to 21 with e_m = 0, which the paper names for vehicles that lock together.
    """
    v, omega = before.reshape(2, 3)[:, :2], before.reshape(2, 3)[:, 2]
    share = masses.mass / masses.mass.sum()
    reduced = share[0] * masses.mass[1]
    past = v[1] - v[0]
    momentum = masses.yaw_inertia @ omega + reduced * (apart[0] * past[1] - apart[1] * past[0])
    Omega = momentum / (masses.yaw_inertia.sum() + reduced * (apart @ apart))
    turning = Omega * jnp.stack([-apart[1], apart[0]])  # of B as A sees it
    V = share @ v
    after = jnp.stack([V - share[1] * turning, V + share[0] * turning])
    return jnp.concatenate([after, jnp.full((2, 1), Omega)], axis=1).reshape(-1)


class Layout(NamedTuple):
    """How two joined vehicles lie: their common centre of gravity, and each one's pose as seen from it.

    Args:
        pose: x, y of the common centre of gravity, m, and A's heading, rad, which counts as the body's.
        offset: vectors from there to the vehicles' own centres of gravity, m, road frame at the impact.
        heading: heading of each vehicle at the impact, rad.
    """

    pose: Float[Array, "3"]
    offset: Float[Array, "2 2"]
    heading: Float[Array, "2"]

    def poses(self, of_body: Float[Array, "*any 3"]) -> Float[Array, "2 *any 3"]:
        """Poses of both vehicles, x, y (m) and heading (rad), for poses of the body."""
        turned = of_body[..., 2] - self.pose[2]
        c, s = cos_sin(turned)
        rows = [
            jnp.stack(
                [
                    of_body[..., 0] + c * x - s * y,
                    of_body[..., 1] + s * x + c * y,
                    heading + turned,
                ],
                axis=-1,
            )
            for (x, y), heading in zip(self.offset, self.heading, strict=True)
        ]
        return jnp.stack(rows)

    def paths(self, of_body: Path) -> Path:
        """Paths of both vehicles, stacked, for the path of the body."""
        poses, Omega = self.poses(of_body.pose), of_body.velocity[:, 2]
        arms = poses[..., :2] - of_body.pose[:, :2]
        turning = Omega[:, None] * jnp.stack([-arms[..., 1], arms[..., 0]], axis=-1)
        velocity = jnp.concatenate(
            [
                of_body.velocity[:, :2] + turning,
                jnp.broadcast_to(Omega[:, None], (*poses.shape[:2], 1)),
            ],
            axis=-1,
        )
        return Path(poses, velocity, jnp.broadcast_to(of_body.time, poses.shape[:2]))


def layout(poses: Float[Array, "2 3"], mass: Float[Array, "2"]) -> Layout:
    """How two vehicles lie that are joined at these poses.

    Args:
        poses: x, y (m) and heading (rad) of each at the impact.
        mass: masses, kg.
    """
    centre = mass @ poses[:, :2] / mass.sum()
    return Layout(jnp.append(centre, poses[0, 2]), poses[:, :2] - centre, poses[:, 2])


def joined(layout: Layout, masses: Masses, cars: Car, grip: Float[Array, "2"]) -> Joined:
    """The body that two joined vehicles make, on the wheels of both.

    Each vehicle's weight stays on its own wheels.

    Args:
        layout: arrangement of the vehicles.
        masses: masses and yaw inertias.
        cars: axles, tracks and wheels of both, stacked; loads are static.
        grip: factor of the surfaces' friction for each one's tyres.
    """
    share = masses.mass / masses.mass.sum()
    whole = masses.yaw_inertia.sum() / masses.mass.sum() + share @ jnp.sum(layout.offset**2, axis=1)
    ahead, left, load, drag, steer = [], [], [], [], []
    back_c, back_s = cos_sin(-layout.pose[2])
    for i in range(2):
        k2, front, rear, track = (jnp.asarray(each)[i] for each in cars[:4])
        own = Car(k2, front, rear, track)
        u, v = wheel_places(own)
        c, s = cos_sin(layout.heading[i])
        x, y = layout.offset[i, 0] + c * u - s * v, layout.offset[i, 1] + s * u + c * v
        ahead.append(back_c * x - back_s * y)
        left.append(back_s * x + back_c * y)
        load.append(share[i] * grip[i] * wheel_loads(own))
        if cars.wheels is not None:
            drag.append(jnp.asarray(cars.wheels.drag)[i])
            steer.append(jnp.asarray(cars.wheels.steer)[i] + layout.heading[i] - layout.pose[2])
    wheels = Wheels(jnp.concatenate(drag), jnp.concatenate(steer)) if drag else None
    return Joined(
        whole, jnp.concatenate(ahead), jnp.concatenate(left), jnp.concatenate(load), wheels
    )
