"""The coordinates in which a posterior is sampled: a bijection beside the model, not inside it.

A rest pose measured to a hand's breadth pins the velocities after the impact to a thin curved
regression, so neither the paper's unknowns nor their whitening makes an easy target. Sampled instead is
q = (z_a, z_b, xi): how many standard deviations each rest pose misses its measurement by, and the
measured inputs as standard normal deviates. A quadratic in q, fitted to run-outs beforehand, gives
velocities after the impact; the impact model's closed-form inverse gives its unknowns. Any smooth
bijection with its Jacobian keeps the density exact, however roughly the quadratic fits.

e and e_m have hard bounds, and a posterior often leans on them (e near 0 is normal in hard
crashes). Both are quotients of functions linear in the motion, so that each bound is a margin: such a
function that stays above zero, as the opening velocity does. `constrain` moves q along a direction for
each, that changes it with the least change of all else, so that the margins lie at infinity and every
point within them is reached. A simpler impact model holds such functions at zero (no moment impulse,
no sliding left): then q is moved to where they are, and its coordinates are fewer than its entries.
The share of the sliding that friction leaves is an entry of q itself, and the motion is held at it.
Margins are exactly linear in the motion and nearly so in q: q is moved as if they were linear in it,
then the motion, by the little that was missed, which are linear equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.inference.transforms.parameters import (
    REACH,
    Constraints,
    Numbers,
    Q,
    Quadratic,
    ResponseSurface,
    TransformParameters,
    saturated,
    times,
)
from retrodict.inference.transforms.protocol import Located, Transform
from retrodict.inference.transforms.soft_bounds import soft_lower_bound
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import SLIDING, Level, quotients
from retrodict.scene.names import parsed
from retrodict.scene.records import VEHICLES

_UNBENT = 1 - 1e-6  # slope of `soft_lower_bound` from which on a margin bends nothing


def levels_of(structure: Structure) -> tuple[Level, ...]:
    """What the impact model bounds or holds fixed."""
    levels = RUNGS[structure.rung].impact.levels
    return tuple(b for b in levels if b != SLIDING or not structure.interlocked)


def margins(
    levels: Sequence[Level],
    side: Numbers,
    over: Numbers,
    under: Numbers,
    kept: Numbers | float = 0.0,
) -> list[Float[Numbers, "*any"]]:
    """What of each level held is zero; what of the others stays above: at their near, their far bounds.

    Args:
        levels: what is bounded or held.
        side: sign of each denominator, shape (levels,).
        over: numerators, or what is linear in them, shape (levels, ...).
        under: denominators likewise.
        kept: at what the level that is sampled is held.
    """

    def beyond(i: int, bound: Numbers | float) -> Numbers:
        return over[i] - bound * under[i]

    held = [(i, kept if b.sampled else b.near) for i, b in enumerate(levels) if b.held]
    free = [(i, np.sign(b.far - b.near) * side[i]) for i, b in enumerate(levels) if not b.held]
    return [
        *(beyond(i, at) for i, at in held),
        *(way * beyond(i, levels[i].near) for i, way in free),
        *(-way * beyond(i, levels[i].far) for i, way in free),
    ]


def held_of(structure: Structure) -> int:
    """How many levels are held: so many margins come first."""
    return sum(level.held for level in levels_of(structure))


def samples_sliding(structure: Structure) -> bool:
    """Whether the last entry of q is the share of the sliding that is kept, before it is bounded."""
    return SLIDING in levels_of(structure)


def length_for_regressions(structure: Structure) -> int:
    """Number of entries that regressions are fitted over: (z_a, z_b, xi)."""
    return len(structure.rest_components) + len(structure.uncertain)


def shaping_inputs(structure: Structure, vehicle: str) -> list[int]:
    """Which uncertain inputs shape a vehicle's run-out, by index."""
    other = "_b" if vehicle == "a" else "_a"
    of_either = ("skid_a", "skid_b", "time_zero_a", "time_zero_b")
    before = ("Gamma", "speed_a", "direction_a", "omega_a", *of_either)
    return [i for i, n in enumerate(structure.names) if not n.endswith(other) and n not in before]


def friction_scale(structure: Structure, data: Data, x: parts.Values) -> Float[Array, ""]:
    """sqrt(friction over its measured value): all speeds go with it, so the regressions need not."""
    name = f"friction_{structure.surfaces[0]}"
    value = data.inputs[name][0]
    if dict(structure.uncertain).get(name) == "lognormal":
        value = jnp.exp(value)
    return jnp.sqrt(x[name] / value)


def reduced(
    structure: Structure, data: Data, transform: TransformParameters, q: Q
) -> tuple[Float[Array, " separation"], Float[Array, "2 v v"]]:
    """Velocities after the impact over sqrt(friction) at q, and each vehicle's slopes by its z."""
    velocities, slopes = [], []
    v = len(structure.rests)
    for name, regression, x in zip(
        VEHICLES, transform.regressions, _regression_arguments(structure, q), strict=True
    ):
        if name in structure.inverted:
            V, by_z = _inverted(structure, data, q, name)
            velocities.append(V)
            slopes.append(by_z)
            continue
        velocities.append(regression(x))
        tame = 1 - (saturated(x[:v]) / REACH) ** 2
        constrained = 2 * times(regression.quadratic, saturated(x))[:, :v] * tame
        slopes.append(jnp.asarray(regression.linear)[:, :v] + constrained)
    return jnp.concatenate(velocities), jnp.stack(slopes)


def _inverted(
    structure: Structure, data: Data, q: Q, v: str
) -> tuple[Float[Array, " v"], Float[Array, "v v"]]:
    """`reduced` of a vehicle whose run-out has an inverse in closed form."""
    z, xi = split(structure, q)
    x = parts.from_standard(structure, data, xi)
    inverse = RUNGS[structure.rung].run_out.inverse
    assert inverse is not None, "its run-out is not integrated"
    back = inverse(structure, data, x, v)
    scale = friction_scale(structure, data, x)

    def velocity(own: Float[Array, " v"]) -> tuple[Array, Array]:
        every = z.reshape(2, -1).at[VEHICLES.index(v)].set(own)
        V = back(parts.rest_poses_at(structure, data, every.ravel())[VEHICLES.index(v)]) / scale
        return V, V

    by_z, V = jax.jacfwd(velocity, has_aux=True)(z.reshape(2, -1)[VEHICLES.index(v)])
    return V, by_z


def _regression_arguments(structure: Structure, q: Q) -> list[Float[Array, " k"]]:
    """(z, shaping inputs) of each vehicle."""
    z, xi = split(structure, q)
    shaping = [np.array(shaping_inputs(structure, v), dtype=int) for v in "ab"]
    return [jnp.concatenate([own, xi[s]]) for own, s in zip(z.reshape(2, -1), shaping, strict=True)]


def split(structure: Structure, q: Q) -> tuple[Array, Array]:
    """z and xi of q."""
    n = len(structure.rest_components)
    return q[:n], q[n : n + len(structure.uncertain)]


def separation_at(
    structure: Structure, data: Data, transform: TransformParameters, q: Q
) -> tuple[Float[Array, " separation"], parts.Values]:
    """Velocities after the impact, and measured inputs, at q."""
    x = parts.from_standard(structure, data, split(structure, q)[1])
    return friction_scale(structure, data, x) * reduced(structure, data, transform, q)[0], x


class Constrained(NamedTuple):
    """Where a point is moved to so that its levels are within bounds, or where they are held.

    Args:
        q: moved along `Constraints.along`, shape (q,).
        motion: how far the motion is moved besides, m/s and rad/s, shape (v + 1,).
        by_q: what of q would move it as far, shape (q,).
        levels: those that are bounded, by name.
        log_det: log |d (motion, inputs) / d q|, what is held in the place of the coordinate along its
            direction, less that of the regressions at `q`; minus infinity where points would be reached
            again.
    """

    q: Q
    motion: Float[Array, " v+1"]
    by_q: Q
    levels: parts.Values
    log_det: Float[Array, ""]


def constrain(
    structure: Structure, data: Data, transform: TransformParameters, q: Q
) -> Constrained:
    """Move q, then the motion, until each margin is what it was, softly above zero, or held there.

    A margin well above zero changes nothing, and nothing is spent on keeping it where it is: each
    is moved along a way that leaves the margins before it alone, and moves those after it as it may.
    Values are exact, and so are the margins' derivatives; others are those of the moves' lengths, near
    enough to steer by, and cheap.
    """
    levels, constraints = (
        levels_of(structure),
        Constraints(*map(jnp.asarray, transform.constraints)),
    )
    held, count = held_of(structure), len(transform.constraints.margin)

    first, aim, share, shift = _constrained_along_q(
        constraints, held, q - jnp.asarray(transform.centre)
    )
    there = q + shift @ constraints.along

    # then by the motion, the little that was missed
    x = parts.from_standard(structure, data, split(structure, there)[1])
    scale = friction_scale(structure, data, x)
    velocities, slopes = reduced(structure, data, transform, there)

    kept = soft_lower_bound(constraints.kept * there[-1], constraints.kept)[
        0
    ]  # where that is sampled

    def moved(motion: Float[Array, " v+1"]) -> Float[Array, " m"]:
        faster = x | {"speed_a": x["speed_a"] + motion[-1]}
        both = quotients(levels, scale * velocities + motion[:-1], faster)
        return jnp.stack(margins(levels, constraints.side, *both, kept=kept))[constraints.order]

    found = moved(jnp.zeros(velocities.size + 1))
    units, slopes = jax.lax.stop_gradient((jnp.full(velocities.size, scale), slopes))
    units = jnp.append(units, jnp.asarray(data.inputs["speed_a"])[1])
    rate = jax.lax.stop_gradient(jax.vmap(moved)(units * constraints.across) - found).T
    rate, ways = _lower_triangular(rate)
    by_q = _by_q(structure, constraints, slopes) @ ways
    linear = constraints.slope @ by_q
    own = jnp.diag(rate)
    log_det, t, bends = -jnp.log(jnp.abs(own)).sum(), jnp.zeros(count), share < _UNBENT
    for i in range(count):
        found = found.at[i].add(rate[i] @ t)
        if i >= held:  # from what the margin was before it was constrained
            above, log_slope = soft_lower_bound(
                first[i] + found[i] - aim[i], constraints.softness[i]
            )
            aim, log_det = aim.at[i].set(above), log_det + log_slope
            bends = bends.at[i].set(bends[i] | (log_slope < jnp.log(_UNBENT)))
        t = t.at[i].set((aim[i] - found[i]) / own[i])
    # nothing is missed now, but for derivatives: where a bound's divisor nears zero they count
    missed = aim - moved(units * (ways @ t @ constraints.across))
    for i in range(count):
        t = t.at[i].add(missed[i] / own[i])
        missed -= rate[:, i] * missed[i] / own[i]
    # of row i what changes t[:i] is left out: multiples of the rows before it
    share = jax.lax.stop_gradient(share)[:, None]
    turn = _determinant(share * jnp.diag(own) + (1 - share) * linear)
    log_det += jnp.log(jnp.abs(turn))
    # each is one at the centre; where they have turned, far out, points would be reached again. How
    # a margin that bends nothing would be moved does not matter
    turned = (bends & (own <= 0)).any() | (turn * jnp.sign(own).prod() <= 0)
    log_det = jnp.where(turned, -jnp.inf, log_det)
    in_place = jnp.zeros(count).at[constraints.order].set(aim)
    bounded = [level for level in levels if not level.held]
    near, far = in_place[held : held + len(bounded)], in_place[held + len(bounded) :]
    nearer, farther = (np.array([getattr(b, end) for b in bounded]) for end in ("near", "far"))
    inside = (nearer * far + farther * near) / (near + far)
    values = {level.name: inside[i] for i, level in enumerate(bounded)}
    return Constrained(there, units * (ways @ t @ constraints.across), by_q @ t, values, log_det)


def _constrained_along_q(
    constraints: Constraints, held: int, off: Q
) -> tuple[Float[Array, " m"], Float[Array, " m"], Float[Array, " m"], Float[Array, " m"]]:
    """How far to move q along `Constraints.along`, were margins linear in it.

    Args:
        constraints: the margins that are held first.
        held: how many these are.
        off: how far q is from the centre.

    Returns:
        Each margin before it is moved itself, and after; the slope of the one by the other; and the
        lengths of the moves.
    """
    count = len(constraints.margin)
    before = jnp.asarray(constraints.margin) + times(constraints.slope, off)
    moves = constraints.slope @ constraints.along.T
    after, slope, shift = jnp.zeros((3, count))
    for i in range(count):
        before = before.at[i].add(moves[i] @ shift)
        if i >= held:
            above, log_slope = soft_lower_bound(before[i], constraints.softness[i])
            after, slope = after.at[i].set(above), slope.at[i].set(jnp.exp(log_slope))
        shift = shift.at[i].set(after[i] - before[i])
    return before, after, slope, shift


def _lower_triangular(rate: Float[Array, "m m"]) -> tuple[Float[Array, "m m"], Float[Array, "m m"]]:
    """Combine ways so that each leaves alone what those before it move.

    Args:
        rate: how fast each way (a column) moves each margin (a row), shape (m, m).

    Returns:
        The same of the combined ways, lower triangular; and of how much of each way each is made.
    """
    m = len(rate)
    both = jnp.concatenate([rate, jnp.eye(m)])
    for i in range(m - 1):
        later = jnp.where(np.arange(m) > i, both[i] / both[i, i], 0.0)
        both -= jnp.outer(both[:, i], later)
    return both[:m], both[m:]


def _determinant(m: Float[Array, "n n"]) -> Float[Array, ""]:
    """By elimination: m is near triangular, and LAPACK's calls cannot be kept on disk."""
    return jnp.prod(jnp.diag(_lower_triangular(m)[0]))


def _by_q(
    structure: Structure, constraints: Constraints, slopes: Float[Array, "2 v v"]
) -> Float[Array, "q m"]:
    """What of q moves the motion along `Constraints.across`."""
    v, count = len(structure.rests), len(constraints.across)
    of_a, of_b = constraints.across[:, :v].T, constraints.across[:, v : 2 * v].T
    by_q = jnp.zeros((len(constraints.slope.T), count))
    by_q = by_q.at[: 2 * v].set(jnp.concatenate([_over(slopes[0], of_a), _over(slopes[1], of_b)]))
    speed_a = place_of_speed_a(structure)
    return by_q if speed_a is None else by_q.at[speed_a].set(constraints.across[:, -1])


def place_of_speed_a(structure: Structure) -> int | None:
    """Which entry of q is the deviate of A's speed, where the speed is linear in it."""
    if ("speed_a", "normal") not in structure.uncertain:
        return None
    return len(structure.rest_components) + structure.names.index("speed_a")


def spins(structure: Structure) -> bool:
    """Whether B's yaw rate before the impact was measured, and follows from the motion after it."""
    return "omega_b" in structure.known_of_b and bool(levels_of(structure))


def surrogate_value(
    structure: Structure,
    data: Data,
    transform: TransformParameters,
    q: Q,
    after: Float[Array, "2 v"],
    name: str,
) -> Float[Array, ""]:
    """What run-outs end at or pass, by a surrogate: rest poses by regressions, all else by responses.

    Args:
        structure: of the scene.
        data: its numbers.
        transform: the bijection's.
        q: a point.
        after: velocities after the impact there.
        name: of a prediction that has a surrogate.
    """
    z, xi = split(structure, q)
    if name in structure.rest_components:
        return parts.rest_poses_at(structure, data, z).ravel()[
            structure.rest_components.index(name)
        ]
    v = parsed(name).vehicle
    response = transform.responses[with_response_surface(structure).index(v)]
    shaping = np.array(shaping_inputs(structure, v), dtype=int)
    items = response(after[VEHICLES.index(v)], xi[shaping])
    return items[structure.on_way_of(v).index(name)]


def solve_back(
    structure: Structure, data: Data, transform: TransformParameters, q: Q
) -> parts.Values:
    """The model's unknowns at q = (z, xi) by the regressions and the closed form, without bounds."""
    return unknowns_of(structure, data, q, *separation_at(structure, data, transform, q))[0]


def unknowns_of(
    structure: Structure,
    data: Data,
    q: Q,
    separation: Float[Array, " separation"],
    x: parts.Values,
) -> tuple[parts.Values, Float[Array, ""]]:
    """A value for each of the model's sample sites, and log |d sites / d separation|."""
    sites, log_det = RUNGS[structure.rung].impact.unknowns(separation, x)
    v_bx, v_by = sites.pop("velocity_b")
    direction = jnp.arctan2(v_by, v_bx)
    if "direction_b" in structure.known_of_b:
        middle = data.inputs["direction_b"][0]
        direction = middle + jnp.arctan2(jnp.sin(direction - middle), jnp.cos(direction - middle))
    if structure.uncertain:
        sites["measured"] = split(structure, q)[1]
    return sites | {"speed_b": jnp.sqrt(v_bx**2 + v_by**2), "direction_b": direction}, log_det


def _over(m: Float[Array, "n n"], b: Float[Numbers, "n k"]) -> Float[Array, "n k"]:
    """m's inverse times b, of two or three rows, written out: LAPACK's calls cannot be kept on disk."""
    if len(m) == 2:
        adjugate = jnp.array([[m[1, 1], -m[0, 1]], [-m[1, 0], m[0, 0]]])
    else:
        u, v, w = m.T
        adjugate = jnp.stack([jnp.cross(v, w), jnp.cross(w, u), jnp.cross(u, v)])
    return (adjugate @ b) / _det(m)


def log_det_of(m: Any) -> Float[Array, ""]:
    """log |det| of a matrix of two or three rows."""
    return jnp.log(jnp.abs(_det(m)))


def _det(m: Any) -> Float[Array, ""]:
    """Determinant of a matrix of two or three rows, written out likewise."""
    if len(m) == 2:
        return m[0][0] * m[1][1] - m[0][1] * m[1][0]
    a, b, c = jnp.asarray(m).T
    return jnp.dot(a, jnp.cross(b, c))


def with_response_surface(structure: Structure) -> tuple[str, ...]:
    """Vehicles whose evidence on the way to rest is predicted by response surfaces.

    Used where a vehicle rolls: its adaptive steps have no reverse-mode derivatives.
    """
    if structure.steps or not structure.paced:
        return ()
    return tuple(v for v in VEHICLES if structure.on_way_of(v))


def example_regressions(structure: Structure) -> tuple[Quadratic, Quadratic]:
    """Regressions of the right shapes and no meaning."""
    v = len(structure.rests)
    sizes = [v + len(shaping_inputs(structure, vehicle)) for vehicle in VEHICLES]
    for_a, for_b = (Quadratic(np.zeros(v), np.zeros((v, k)), np.zeros((v, k, k))) for k in sizes)
    return for_a, for_b


class RestPose(Transform):
    """Rest poses determine the motion: they are coordinates, with surrogates for run-outs."""

    def length(self, structure: Structure) -> int:
        """Number of entries of q."""
        return length_for_regressions(structure) + samples_sliding(structure)

    def size(self, structure: Structure) -> int:
        """Number of entries of w: of q, but those that are held."""
        return self.length(structure) - held_of(structure)

    def example(self, structure: Structure) -> TransformParameters:
        """Parameters of the right shapes and no meaning."""
        n, v = self.length(structure), len(structure.rests)
        regressions = example_regressions(structure)
        responses = []
        for vehicle in with_response_surface(structure):
            m = len(structure.on_way_of(vehicle))
            k = regressions[VEHICLES.index(vehicle)].linear.shape[1]
            surface = Quadratic(np.zeros(m), np.zeros((m, k)), np.zeros((m, k, k)))
            responses.append(ResponseSurface(np.zeros(v), np.ones(v), surface))
        levels = levels_of(structure)
        m = len(margins(levels, np.ones(len(levels)), *np.ones((2, len(levels)))))
        nowhere = np.zeros((m, n))
        across, side = np.zeros((m, 2 * v + 1)), np.ones(len(levels))
        constraints = Constraints(
            side, np.arange(m), np.zeros(m), nowhere, nowhere, across, np.ones(m), np.ones(())
        )
        spread = np.zeros((n, self.size(structure)))
        return TransformParameters(
            regressions, constraints, np.zeros(n), spread, np.zeros(()), tuple(responses)
        )

    def surrogates(self, structure: Structure) -> tuple[str, ...]:
        """Rest poses, then what was measured on the way where it has a response surface."""
        on_way = (structure.on_way_of(v) for v in with_response_surface(structure))
        return (*structure.rest_components, *(name for names in on_way for name in names))

    def from_q(
        self,
        structure: Structure,
        data: Data,
        parameters: TransformParameters,
        q: Q,
        log_det: Float[Array, ""],
    ) -> Located:
        """The unknowns, the log determinant with that given, and q as it was moved."""
        v = len(structure.rest_components)
        constrained = Constrained(q, jnp.zeros(v + 1), jnp.zeros(q.size), {}, jnp.zeros(()))
        if levels_of(structure):
            constrained = constrain(structure, data, parameters, q)
        slopes = reduced(structure, data, parameters, constrained.q)[1]
        separation, x = separation_at(structure, data, parameters, constrained.q)
        log_det += constrained.log_det + v * jnp.log(friction_scale(structure, data, x))
        log_det += log_det_of(slopes[0]) + log_det_of(slopes[1])
        x["speed_a"] += constrained.motion[v]
        q = constrained.q + constrained.by_q
        sites, log_inverse = unknowns_of(structure, data, q, separation + constrained.motion[:v], x)
        # B's speed and direction take the place of two components of its velocity
        log_det += log_inverse - jnp.log(sites["speed_b"])
        if samples_sliding(structure):  # what is held at a share of a divisor moves with both
            x = parts.from_standard(structure, data, split(structure, q)[1])
            free = quotients((SLIDING,), separation + constrained.motion[:v], x)[1][0]
            softness = jnp.asarray(parameters.constraints.kept)
            log_det += (
                jnp.log(jnp.abs(free) * softness) + soft_lower_bound(softness * q[-1], softness)[1]
            )
        return sites | constrained.levels, log_det, q
