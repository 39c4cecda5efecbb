"""A toy impact with a coefficient of its own: points whose impulse has any size and direction.

The impulse is `ratio` times that by which both would go on together, turned by `swerve`.
"""

import jax.numpy as jnp
import numpyro
from numpyro import distributions as dist
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description
from retrodict.models.impact import MOMENTUM, SHORT, Impact, Separation


def forward_model(structure: Structure, data: Data, x: parts.Values) -> Separation:
    """B's approach, ratio and swerve; then momentum."""
    m_a, m_b = x["mass_a"], x["mass_b"]
    v_a = parts.approach_of_a(x)[:2]
    speed_b = numpyro.sample("speed_b", dist.HalfNormal(data.priors["speed_b"][0]))
    direction_b = numpyro.sample("direction_b", dist.Uniform(-jnp.pi, jnp.pi))
    ratio = numpyro.sample("ratio", dist.LogNormal(*data.priors["ratio"]))
    swerve = numpyro.sample("swerve", dist.Uniform(-jnp.pi, jnp.pi))
    v_b = speed_b * jnp.stack([jnp.cos(direction_b), jnp.sin(direction_b)])
    cos, sin = jnp.cos(swerve), jnp.sin(swerve)
    turn = jnp.stack([jnp.stack([cos, -sin]), jnp.stack([sin, cos])])
    P = ratio * m_a * m_b / (m_a + m_b) * turn @ (v_b - v_a)
    after = jnp.concatenate([v_a + P / m_a, v_b - P / m_b])
    parts.record_motion(after, jnp.stack([P / m_a, -P / m_b]))
    return after


def unknowns(after: Separation, x: parts.Values) -> tuple[parts.Values, jnp.ndarray]:
    """The inverse: polar coordinates of the impulse about the closing velocity."""
    m_a, m_b = x["mass_a"], x["mass_b"]
    v_a = parts.approach_of_a(x)[:2]
    P = m_a * (after[:2] - v_a)
    v_b = after[2:] + P / m_b
    (x_c, y_c), unit = v_b - v_a, m_a * m_b / (m_a + m_b) * jnp.hypot(*(v_b - v_a))
    ratio = jnp.hypot(*P) / unit
    swerve = jnp.arctan2(x_c * P[1] - y_c * P[0], x_c * P[0] + y_c * P[1])
    log_det = 2 * jnp.log(m_a) - 2 * jnp.log(unit) - jnp.log(ratio)
    return {"velocity_b": v_b, "ratio": ratio, "swerve": swerve}, log_det


IMPACT = Impact(
    description=Description(
        name="toy",
        title="points that strike with an impulse of any size and direction",
        equations=MOMENTUM,
        assumptions=(SHORT,),
        left_out=("yaw",),
    ),
    forward_model=forward_model,
    answers=("speed_a", "speed_b", "ratio"),
    levels=(),
    unknowns=unknowns,
    priors=("speed_a", "speed_b", "ratio"),
    nesting=frozenset(),
)
