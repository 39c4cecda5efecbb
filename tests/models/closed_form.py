"""The posterior of momentum alone and a straight slide, in closed form, for tests to integrate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import stats

from retrodict.scene.records import Measured, Scene
from tests.shared.scenes import LEVER_A, LEVER_B

GRAVITY = 9.80665


def everything_exact(scene: Scene) -> Scene:
    """With no uncertainty but that of the rest poses."""
    a = scene.approach["a"]
    surface = replace(scene.surfaces[0], friction=Measured(0.5))
    return replace(
        scene,
        approach=scene.approach | {"a": replace(a, speed=Measured(a.speed.value))},
        contact=replace(scene.contact, Gamma=Measured(scene.contact.Gamma.value)),
        surfaces=(surface,),
    )


def momentum_and_slide(
    scene: Scene,
    z: np.ndarray,
    friction: np.ndarray | float = 0.5,
    slower: np.ndarray | float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """B's speed and the log of prior over |d unknowns / d rest|, of rest positions solved back.

    Args:
        scene: that of `collision`, whose rest positions count.
        z: these less the measured ones, in standard deviations, shape (any, 2, 2).
        friction: of the road.
        slower: by how much A's speed is below 20.1168 m/s.
    """
    grip, V, log_slope = np.asarray(friction) * GRAVITY, [], 0.0
    for i, (v, lever) in enumerate(zip("ab", (LEVER_A, LEVER_B), strict=True)):
        rest = np.array([scene.rest[v].x.value, scene.rest[v].y.value]) + 0.15 * z[:, i]
        way = rest + lever
        far = np.hypot(*way.T)
        V.append(way / far[:, None] * np.sqrt(2 * grip * far)[:, None])
        log_slope += np.log(grip / far)  # |dV / d rest|
    m_a, m_b = 1857.0, 1778.0
    v_a = np.stack(np.broadcast_arrays(slower - 20.1168, 0.0), axis=-1)
    P = m_a * (V[0] - v_a)
    speed = np.hypot(*(V[1] + P / m_b).T)
    log_slope += 2 * np.log(m_a) - np.log(speed)  # to impulse, speed and direction
    prior = stats.halfnorm(scale=30).logpdf(speed) - np.log(2 * np.pi)
    prior += stats.norm(0, 20 * m_a).logpdf(P).sum(axis=1)
    return speed, prior + log_slope
