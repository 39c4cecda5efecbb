"""Warnings about values of a scene that are possible but improbable; the scene is used as written."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator

from retrodict.scene.energy import CLASS_STIFFNESS_ERROR
from retrodict.scene.records import Measured, Scene, Vehicle

# share of the distance between the centres of gravity that lies across the contact line: two cars side
# by side, a length apart, have two fifths
_ACROSS = 1 / 3
# a measuring error that is smaller than the run-out model's by this factor adds less than 2 % to it
_SHARPER = 5
_OF_CONTACT = ("impact_centre", "contact_line")
_NAMED = 3  # slips in one warning
# kg/m²: mass over the square of the wheelbase, of passenger cars from the lightest to the heaviest;
# longer wheelbases are lorries', loaded or not
_MASSES, _LONGEST = (100.0, 380.0), 3.4
_LIGHTEST = 80.0  # kg/m²: of empty lorries
_TRACK, _TWO_TRACKS = (0.35, 0.85), 500.0  # wheelbases; kg: lighter ones may be motorcycles
_WIDE = 0.3  # sd of friction over its value
_POUND = 0.45359237
_MPH = 0.44704
_ALONG = 0.2  # sine of the angle between courses, below which momentum across them tells no speeds
# share of a push across the contact line that the written components of delta-v must show; number of
# standard deviations that count as certain
_MOSTLY, _SURE = 0.7, 3.0
_RADIUS = (0.35, 0.65)  # radius of gyration in yaw, wheelbases; the default's sources: 0.47 to 0.50


def plausibility_warnings(scene: Scene) -> tuple[str, ...]:
    """Warnings about values that are probably not what the author meant.

    Args:
        scene: measured scene.

    Returns:
        A line each: the key, what is odd and what to look at.
    """
    # one wrong value may cause several of these: only the most specific is given
    wrong = _gains(scene) or [*_masses(scene), *_inertias(scene), *_courses(scene)]
    missing = scene.missing(_OF_CONTACT)
    if placed := not missing:
        wrong = wrong or _slips(scene)
        wrong = wrong or _sides(scene) or _beyond_the_wall(scene) or _pushes(scene)
    return (
        *wrong,
        *(() if placed or scene.contact.together or scene.alone else [_momentum_alone(missing)]),
        *_sizes(scene),
        *_lifts(scene),
        *_rolls(scene),
        *_frictions(scene),
        *_energies(scene),
    )


def _gains(scene: Scene) -> list[str]:
    """Speeds that part faster than they met, so that the impact would gain energy."""
    if scene.single or set(scene.departure) != set(scene.vehicles):
        return []
    numbers: dict[str, Measured] = {}
    for v, vehicle in scene.vehicles.items():
        after, before = scene.departure[v], scene.approach[v]
        if "speed" not in after or "direction" not in after or before.direction is None:
            return []
        numbers |= {f"mass_{v}": vehicle.mass, f"course_{v}": before.direction}
        numbers |= {f"V_{v}": after["speed"], f"way_{v}": after["direction"]}
        if before.speed is not None:
            numbers[f"v_{v}"] = before.speed
    values = {name: m.value for name, m in numbers.items()}
    if (speeds := _met_and_parted(values)) is None:
        return []
    met, parted = speeds
    squares = 0.0
    for name, m in numbers.items():
        moved = _met_and_parted(values | {name: m.value + m.sd})
        if moved is not None:
            squares += (moved[1] - moved[0] - (parted - met)) ** 2
    sd = math.sqrt(squares)
    if parted - met <= sd:
        return []
    return [
        "vehicles.A.departure, vehicles.B.departure: these speeds part faster "
        f"({parted:.1f} m/s, {parted / _MPH:.0f} mph) than they met ({met:.1f} m/s, "
        f"{met / _MPH:.0f} mph, by momentum), by {(parted - met) / sd if sd else math.inf:.1f} times "
        "the error, so that the impact would gain energy: look at speeds and directions, and whether "
        "they are of one impact"
    ]


def _met_and_parted(values: dict[str, float]) -> tuple[float, float] | None:
    """Relative speed of both vehicles before the impact, by momentum, and after it, m/s.

    Args:
        values: masses, courses before, ways and speeds after the impact, and those speeds before it
            that are known.

    Returns:
        Both; None where momentum does not tell the speeds before.
    """
    masses = values["mass_a"], values["mass_b"]
    after = [cmath.rect(values[f"V_{v}"], values[f"way_{v}"]) for v in "ab"]
    one, other = (cmath.rect(1, values[f"course_{v}"]) for v in "ab")
    left = sum(m * V for m, V in zip(masses, after, strict=True))
    v_a, v_b = values.get("v_a"), values.get("v_b")
    across = (one.conjugate() * other).imag  # of the courses
    if v_a is None and v_b is None:
        if abs(across) < _ALONG:
            return None
        v_a = -(other.conjugate() * left).imag / (masses[0] * across)
        v_b = (one.conjugate() * left).imag / (masses[1] * across)
    elif v_a is None and v_b is not None:
        v_a = (one.conjugate() * (left - masses[1] * v_b * other)).real / masses[0]
    elif v_b is None and v_a is not None:
        v_b = (other.conjugate() * (left - masses[0] * v_a * one)).real / masses[1]
    assert v_a is not None, "each case gives both"
    assert v_b is not None, "each case gives both"
    return abs(v_a * one - v_b * other), abs(after[0] - after[1])


def _momentum_alone(missing: list[str]) -> str:
    """What is missing for the models with coefficients of the impact."""
    return (
        f"{', '.join(missing)}: not written, so that momentum alone answers, and only how fast the "
        "vehicles were; e, e_m and μ, and what evidence on the contact says, need them"
    )


def _slips(scene: Scene) -> list[str]:
    """Vehicles that do not fit one another or their motion, with the slips that would explain it."""
    if scene.single:
        return []
    from retrodict.scene import slips  # NumPy: scenes are read without

    missed, odd = slips.misfit(scene), [*_sides(scene), *_overlaps(scene)]
    if missed <= slips.CONFLICT and not odd:
        return []
    fitting = sorted(
        (left, words)
        for words, other in slips.undone(scene)
        if not (_sides(other) or _overlaps(other))
        and (left := slips.misfit(other)) <= slips.CONFLICT
        and (odd or left <= missed / 2)
    )
    first = (
        odd[0]
        if odd
        else (
            "approach, rest, departure: no crash of two vehicles fits them: by a rough estimate "
            f"momentum or a rotation is off by {missed:.1f} times its error, where {slips.CONFLICT} is "
            "the most without a slip"
        )
    )
    if not fitting:
        return odd or _pushes(scene) or [f"{first}: look at directions, signs and units"]
    likely = ", or if ".join(words for _, words in fitting[:_NAMED])
    return [f"{first}; all would fit{'' if odd else f' ({fitting[0][0]:.1f})'} if {likely}"]


def _sides(scene: Scene) -> list[str]:
    """Contact lines that do not part the vehicles, often because they were counted from the x axis."""

    # `mechanics.either_side` checks the same of draws, in JAX, which `retrodict check` does without
    def beyond(v: str) -> complex:
        """How far a centre of gravity lies off the contact line (real part), and along it."""
        vehicle = scene.vehicles[v]
        angle = vehicle.heading.value + vehicle.impact_angle.value - scene.contact.Gamma.value
        return -cmath.rect(vehicle.impact_distance.value, angle)

    if scene.alone:
        return []
    if scene.barrier:
        off = beyond("a")
        if abs(off.real) >= _ACROSS * abs(off):
            return []
        return [
            f"impact.contact_line: it hardly parts the vehicle from the {scene.barrier.kind}: of the "
            f"{abs(off):.1f} m from its centre of gravity to the impact centre "
            f"{abs(off.real):.1f} m lie across it; it is counted from the y axis: look at it and at the "
            "angle of the impact centre"
        ]
    of_a, of_b = map(beyond, scene.vehicles)
    across, apart = abs((of_a - of_b).real), abs(of_a - of_b)
    if of_a.real * of_b.real > 0:
        odd = (
            f"both centres of gravity lie on one side of it, A's {abs(of_a.real):.1f} m and B's "
            f"{abs(of_b.real):.1f} m off"
        )
    elif across < _ACROSS * apart:
        odd = (
            f"it hardly parts the vehicles: of the {apart:.1f} m between their centres of gravity "
            f"{across:.1f} m lie across it"
        )
    else:
        return []
    return [
        f"impact.contact_line: {odd}; it is counted from the y axis: look at it and at the angles of "
        "the impact centres"
    ]


def _overlaps(scene: Scene) -> list[str]:
    """Vehicles that stand within each other at impact, deeper than any crush."""
    if scene.single:
        return []
    a, b = scene.vehicles.values()
    between = complex(*scene.at_impact("b")) - complex(*scene.at_impact("a"))

    def reach(vehicle: Vehicle, along: complex) -> float:
        """Distance from a vehicle's middle to its outline's farthest point along a unit vector, m."""
        ahead = along * cmath.rect(1, -vehicle.heading.value)
        return (abs(ahead.real) * vehicle.length + abs(ahead.imag) * vehicle.width) / 2

    def depth(along: complex) -> float:
        apart = abs((between * along.conjugate()).real)
        return reach(a, along) + reach(b, along) - apart

    sides = (cmath.rect(1, own.heading.value + turn) for own in (a, b) for turn in (0, math.pi / 2))
    deep, most = min(map(depth, sides)), min(a.width, b.width)
    if deep <= most:
        return []
    return [
        f"vehicles.A.impact_centre, vehicles.B.impact_centre: the vehicles stand {deep:.1f} m within "
        "each other at impact: look at the distances and angles, and at the headings"
    ]


def _beyond_the_wall(scene: Scene) -> list[str]:
    """A rest position on the other side of the struck wall, through which no run-out passes."""
    if scene.barrier is None or scene.barrier.kind != "wall" or "a" not in scene.rest:
        return []
    normal = cmath.rect(1, scene.contact.Gamma.value)
    struck = complex(scene.contact.x.value, scene.contact.y.value)

    def off(x: float, y: float) -> float:
        return ((complex(x, y) - struck) * normal.conjugate()).real

    rest = scene.rest["a"]
    before, after = off(*scene.at_impact("a")), off(rest.x.value, rest.y.value)
    if before * after > 0:
        return []
    return [
        f"vehicles.A.rest.position: {abs(after):.1f} m beyond the face of the wall, which the vehicle "
        "did not pass: look at it, at impact.point and at impact.contact_line"
    ]


def _wheelbases(scene: Scene) -> Iterator[tuple[str, Vehicle, float]]:
    """Key, vehicle and wheelbase (m) of each vehicle whose wheelbase is known."""
    for v, vehicle in scene.vehicles.items():
        key = f"vehicles.{v.upper()}"
        if f"{key}.wheelbase" not in scene.unwritten:
            yield key, vehicle, vehicle.front_axle.value + vehicle.rear_axle.value


def _masses(scene: Scene) -> list[str]:
    """Masses that no car of this wheelbase has, with a note where they would fit in the other unit."""
    found = []
    for key, vehicle, wheelbase in _wheelbases(scene):
        mass, (least, most) = vehicle.mass.value, (bound * wheelbase**2 for bound in _MASSES)
        if wheelbase > _LONGEST or least <= mass <= most:
            continue
        heavy = mass > most
        other, unit = (mass * _POUND, "pounds") if heavy else (mass / _POUND, "kilograms")
        would = f", and {other:.0f} kg were it in {unit}" if least <= other <= most else ""
        found.append(
            f"{key}.mass: {mass:.0f} kg is {'more' if heavy else 'less'} than cars with "
            f"a wheelbase of {wheelbase:.2f} m have{would}: look at both and at their units"
        )
    return found


def _sizes(scene: Scene) -> list[str]:
    """Tracks that do not suit the wheelbase, and wheelbases that may be the length of the vehicle."""
    found = []
    for key, vehicle, wheelbase in _wheelbases(scene):
        mass, track = vehicle.mass.value, vehicle.track.value
        light = mass < _LIGHTEST * wheelbase**2 and not vehicle.articulated
        if wheelbase > _LONGEST and light:
            found.append(
                f"{key}.wheelbase: {wheelbase:.2f} m is much for a vehicle of "
                f"{mass:.0f} kg: see that it is not the length of the vehicle"
            )
        share = track / wheelbase
        if wheelbase <= _LONGEST and mass > _TWO_TRACKS and not _TRACK[0] <= share <= _TRACK[1]:
            found.append(
                f"{key}.track: {track:.2f} m is {share:.2f} of the wheelbase, where cars "
                f"have {_TRACK[0]} to {_TRACK[1]}: look at both and at their units"
            )
    return found


def _frictions(scene: Scene) -> list[str]:
    """Frictions that leave nearly every surface possible."""
    return [
        f"surfaces.{surface.name}.friction: ± {surface.friction.sd:.2g} is one standard deviation; of "
        "drag sleds and skid tests it is 0.02 to 0.08: see that it is not half a range"
        for surface in scene.surfaces
        if surface.friction.sd > _WIDE * surface.friction.value
    ]


def _pushes(scene: Scene) -> list[str]:
    """Delta-v towards the other vehicle, where an impact pushes each away from the contact."""
    found = []
    for v, departure in scene.departure.items():
        vehicle = scene.vehicles[v]
        parts = [departure.get(f"delta_v_{part}") for part in ("forward", "left")]
        written = [part for part in parts if part is not None]
        across = cmath.rect(1, scene.contact.Gamma.value - vehicle.heading.value)
        centre = cmath.rect(1, vehicle.impact_angle.value)  # from the centre of gravity
        outward = -across if (across * centre.conjugate()).real > 0 else across
        shares = [
            share for share, part in zip((outward.real, outward.imag), parts, strict=True) if part
        ]
        if not written or math.hypot(*shares) < _MOSTLY:
            continue
        pushed = sum(share * part.value for share, part in zip(shares, written, strict=True))
        sd = math.hypot(*(share * part.sd for share, part in zip(shares, written, strict=True)))
        if pushed < -_SURE * sd:
            keys = " and ".join(
                f"delta_v_{name}"
                for name, part in zip(("forward", "left"), parts, strict=True)
                if part
            )
            found.append(
                f"vehicles.{v.upper()}.departure: {keys} of {abs(pushed):.1f} m/s towards the place "
                "that was struck, where an impact pushes away from it: look at the sign (forward and "
                "left are positive) and at the impact centre"
            )
    return found


def _inertias(scene: Scene) -> list[str]:
    found = []
    for key, vehicle, wheelbase in _wheelbases(scene):
        radius = math.sqrt(vehicle.yaw_inertia.value / vehicle.mass.value) / wheelbase
        if not _RADIUS[0] <= radius <= _RADIUS[1]:
            found.append(
                f"{key}.yaw_inertia: makes a radius of gyration of {radius:.2f} "
                "wheelbases, where vehicles have about 0.5: look at its unit, the mass and the "
                "wheelbase"
            )
    return found


def _lifts(scene: Scene) -> list[str]:
    """Centres of gravity so high that a wheel lifts where the vehicle slides at its worst angle."""
    found = []
    for v, vehicle in scene.vehicles.items():
        if vehicle.cg_height is None:
            continue
        front, rear = vehicle.front_axle.value, vehicle.rear_axle.value
        # load of a wheel on the axle with less load, and what braking lengthwise and sideways takes off
        load = min(front, rear) / (front + rear) / 2
        taken = math.hypot(0.5 / (front + rear), 2 * load / vehicle.track.value)
        grip = vehicle.grip.value * max(surface.friction.value for surface in scene.surfaces)
        highest = load / (grip * taken)
        if vehicle.cg_height.value > highest:
            found.append(
                f"vehicles.{v.upper()}.cg_height: above {highest:.2f} m a wheel of it may lift on "
                f"friction of {grip:.2f}; the model ends there, and takes such motions for impossible: "
                "look at it and at the track, or leave cg_height out"
            )
    return found


def assumed_approach(scene: Scene) -> str:
    """Note on vehicles that are taken to travel along their headings; empty where there is none."""
    along = [
        v.upper()
        for v, own in scene.approach.items()
        if own.direction is not None and own.direction.assumed == "value"
    ]
    if scene.alone or not along:
        return ""
    several = len(along) > 1
    who = f"{' and '.join(along)} {'are' if several else 'is'}"
    return (
        f"{who} taken to travel along {'their headings' if several else 'its heading'} before the "
        'impact, and not to yaw; of a vehicle that slid write approach.direction = "unknown".'
    )


def _courses(scene: Scene) -> list[str]:
    found = []
    for v in scene.vehicles:
        course = scene.approach[v].direction
        if course is None:
            continue
        off = math.remainder(course.value - scene.vehicles[v].heading.value, math.tau)
        if abs(off) > math.pi / 2:
            found.append(
                f"vehicles.{v.upper()}.approach.direction: {abs(math.degrees(off)):.0f} deg off the "
                "heading at impact, so that the vehicle travels backwards: look at both"
            )
    return found


def _rolls(scene: Scene) -> list[str]:
    """Rest positions much sharper than any run-out can follow a rolling vehicle."""
    found, evidence = [], scene.evidence()
    for v, rest in scene.rest.items():
        missed = evidence[f"rest_x_{v}"].model_sd
        measured = math.hypot(rest.x.sd, rest.y.sd) / math.sqrt(2)
        if missed <= _SHARPER * measured:
            continue
        length = scene.path_to(v, rest.x.value, rest.y.value)
        found.append(
            f"vehicles.{v.upper()}.rest.position: measured to {measured:.2g} m, but {v.upper()} rolled "
            f"{length:.0f} m, after which a run-out model misses it by about {missed:.2g} m "
            "(run_out_error), which makes it weak evidence: marks along its way, or a direction or "
            "speed after the impact, would add more"
        )
    return found


def _energies(scene: Scene) -> list[str]:
    """Energies from crush, whose errors are little known."""
    known, found = f"{CLASS_STIFFNESS_ERROR:.0%}", []
    for key, stated in scene.energy_lost.items():
        line = (
            f"impact.{key}: energies from crush and stiffness by class missed the measured loss by "
            f"{known} (root mean square) in nine staged crashes: look at the answer without it, too"
        )
        if stated.sd < (CLASS_STIFFNESS_ERROR - 1e-9) * stated.value:
            share = f"{100 * stated.sd / stated.value:.3g}%"
            line += (
                f"; its uncertainty of {share} is smaller: write ± {known}, or say in its source why it "
                "is known better"
            )
        found.append(line)
    return found
