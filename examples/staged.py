"""Writes scene.toml and truth.toml of the staged collisions whose impact phase alone is used.

Sought is the approach speed of the vehicle that struck, which is B here; A's is known. One rule makes
every scene of RICSAC, and one those of NHTSA, before any was reconstructed; they stand in README.md
beside this file. Run: python examples/staged.py
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

HERE = Path(__file__).resolve().parent
CENTIMETRE, DEGREE = 0.01, math.radians(1)
DEPTH = 0.10  # m, sd of the impact centre across the crushed face
SHARE_OF_WIDTH = 1 / 8  # its sd along the face, of the crush's width
GYRATION = 0.49  # wheelbases; the default of the package
YAW_RATE = 15  # deg/s, sd

VOSSOU = "Vossou & Koulocheris 2018, Tables 1 and 2"
NEADES = "Neades 2011, Appendix D"
CORRECTED = "Neades 2011, Tables 5.3 and 5.4"
ROSE = "SAE 2006-01-0908, Figs 13 and 14"


@dataclass(frozen=True)
class Crush:
    """Damage: its width, offset of its middle (to the right, or forward) and depths C1 to C6, cm."""

    face: Literal["front", "rear", "right"]
    width: float
    offset: float
    depths: tuple[float, ...]


@dataclass(frozen=True)
class Car:
    """A vehicle of a RICSAC test.

    Args:
        name: make, model and year.
        mass: kg.
        class_inertia: yaw inertia of its size class in CRASH3, kg m².
        front, rear: centre of gravity to either end, m.
        width: m.
        wheelbase, track: of the model, m.
        crush: its damage.
        heading: at impact, deg.
        speed: before impact, m/s.
        yaw_rate: after impact, rad/s.
        delta_v: as corrected by Brach & Smith 2002 and by McHenry 1997, m/s.
    """

    name: str
    mass: float
    class_inertia: float
    front: float
    rear: float
    width: float
    wheelbase: float
    track: float
    crush: Crush
    heading: float
    speed: float
    yaw_rate: float
    delta_v: tuple[float, float]


CHEVELLE = {"front": 2.51, "rear": 2.90, "width": 1.96, "wheelbase": 2.90, "track": 1.55}
TORINO = {"front": 2.51, "rear": 2.90, "width": 1.96, "wheelbase": 2.95, "track": 1.61}
PINTO = {"front": 2.12, "rear": 2.33, "width": 1.71, "wheelbase": 2.39, "track": 1.40}
VEGA = {"front": 2.12, "rear": 2.33, "width": 1.71, "wheelbase": 2.46, "track": 1.39}

# vehicle 1, which struck, and vehicle 2; the frame is Vossou & Koulocheris's, and this project's
RICSAC = {
    1: (
        Car(
            "Chevrolet Chevelle Malibu 1974", 2096, 5054, **CHEVELLE,
            crush=Crush("front", 117, 36, (10, 14, 18, 26, 31, 38)),
            heading=180, speed=8.86, yaw_rate=-1.57, delta_v=(5.27, 5.50),
        ),
        Car(
            "Ford Pinto 1974", 1398, 2659, **PINTO,
            crush=Crush("right", 288, 55, (1, 30, 27, 30, 23, 10)),
            heading=60, speed=8.86, yaw_rate=0.0, delta_v=(6.62, 7.55),
        ),
    ),
    4: (
        Car(
            "Ford Torino", 2259, 5447, **TORINO,
            crush=Crush("front", 105, 41, (16, 20, 25, 32, 38, 46)),
            heading=180, speed=17.3, yaw_rate=-0.65, delta_v=(8.31, 8.36),
        ),
        Car(
            "Ford Pinto", 1447, 2752, **PINTO,
            crush=Crush("rear", 106, -23, (91, 81, 74, 61, 50, 38)),
            heading=170, speed=0.0, yaw_rate=-0.52, delta_v=(9.66, 9.92),
        ),
    ),
    8: (
        Car(
            "Chevrolet Chevelle (first)", 2031, 4899, **CHEVELLE,
            crush=Crush("front", 185, 0, (7, 9, 0, 0, 0, 0)),
            heading=180, speed=9.3, yaw_rate=-1.99, delta_v=(6.97, 6.66),
        ),
        Car(
            "Chevrolet Chevelle (second)", 2136, 5152, **CHEVELLE,
            crush=Crush("right", 215, 38, (16, 21, 23, 15, 11, 2)),
            heading=90, speed=9.3, yaw_rate=-0.31, delta_v=(4.78, 4.92),
        ),
    ),
    11: (
        Car(
            "Chevrolet Vega", 1379, 2624, **VEGA,
            crush=Crush("front", 83, -32, (56, 51, 47, 43, 38, 32)),
            heading=180, speed=9.12, yaw_rate=0.52, delta_v=(11.18, 10.95),
        ),
        Car(
            "Ford Torino", 2200, 5305, **TORINO,
            crush=Crush("front", 82, -33, (75, 67, 58, 47, 36, 28)),
            heading=-10, speed=9.12, yaw_rate=0.0, delta_v=(7.20, 7.02),
        ),
    ),
}  # fmt: skip
CONTACT_LINE = {1: -30, 4: -10, 8: 0, 11: 0}  # deg, Vossou & Koulocheris 2018
CONFIGURATION = {
    1: "60 degrees, front to side",
    4: "10 degrees, front to the rear of a standing car",
    8: "90 degrees, front to side",
    11: "10 degrees, front to front, offset",
}
NOTES = {
    1: "Vossou & Koulocheris 2018 print 8.95 m/s for vehicle 1, probably a misprint: vehicle 2's \
components, Neades 2011 (8.8 m/s) and the energy in SAE 871993 say 8.86.",
    4: "Neades 2011 has 17.2 m/s.",
    8: "Neades 2011 has 9.2 m/s.",
    11: "Neades 2011 has 9.1 m/s.",
}
# mass and both corrected delta-v of vehicles 1 and 2, of every test of which these are at hand
# (Neades 2011, Tables 5.3 and 5.4, Appendix D)
MOMENTUM = {
    test: tuple((car.mass, car.delta_v) for car in cars) for test, cars in RICSAC.items()
} | {
    6: ((1950, (4.11, 4.07)), (1190, (6.53, 6.39))),
    10: ((1046, (12.83, 15.20)), (2141, (5.86, 5.59))),
}


def delta_v_error() -> float:
    """Relative sd of a delta-v: momentum gained and lost should agree, and how far they do not."""
    off = []
    for (m_1, dv_1), (m_2, dv_2) in MOMENTUM.values():
        off.append(math.log(m_1 * np.mean(dv_1) / (m_2 * np.mean(dv_2))))
    return float(np.sqrt(np.mean(np.square(off)) / 2))  # each vehicle's share


def impact_centre(car: Car) -> tuple[float, float, float, float]:
    """Middle of the crushed area on the crushed face: distance and angle with their sds, m and deg."""
    crush = car.crush
    depths = np.array(crush.depths) * CENTIMETRE
    along = np.linspace(-0.5, 0.5, depths.size) * crush.width * CENTIMETRE
    area = np.trapezoid(depths, along)
    depth = area / np.ptp(along)
    middle = crush.offset * CENTIMETRE + np.trapezoid(depths * along, along) / area
    spread = crush.width * CENTIMETRE * SHARE_OF_WIDTH
    # C1 is leftmost at either end, and rearmost on a side
    forward, left = {
        "front": (car.front - depth, -middle),
        "rear": (depth - car.rear, -middle),
        "right": (middle, depth - car.width / 2),
    }[crush.face]
    sd = np.array([spread, DEPTH] if crush.face == "right" else [DEPTH, spread])
    distance = math.hypot(forward, left)
    outward = np.array([forward, left]) / distance
    across = np.array([-left, forward]) / distance**2
    return (
        distance,
        math.atan2(left, forward) / DEGREE,
        float(np.hypot(*(outward * sd))),
        float(np.hypot(*(across * sd))) / DEGREE,
    )


def line(key: str, value: str, sd: str, unit: str, source: str) -> str:
    """A quantity as the scene file has it; with the package's uncertainty where sd is empty."""
    sd = f"sd = {sd}, " if sd else ""
    return f'{key} = {{ value = {value}, {sd}unit = "{unit}", source = "{source}" }}'


def of_model(wheelbase: float, track: float) -> list[str]:
    """What nothing here depends on but has to be written."""
    source = "of the model; not published for this car"
    return [
        line("wheelbase", f"{wheelbase:.2f}", "0.05", "m", source),
        line("track", f"{track:.2f}", "0.03", "m", source),
    ]


def vehicle(letter: str, car: Car, known: bool) -> str:
    """A vehicle of a RICSAC test, with its speed where that is known."""
    distance, angle, distance_sd, angle_sd = impact_centre(car)
    own = car.mass * (GYRATION * car.wheelbase) ** 2
    inertia = (own + car.class_inertia) / 2
    inertia_sd = max(abs(own - car.class_inertia) / 2, 0.08 * inertia)
    dv, error = float(np.mean(car.delta_v)), delta_v_error()
    of_inertia = (
        f"between {GYRATION} wheelbases as radius of gyration ({own:.0f}) and the size class of "
        f"CRASH3 ({car.class_inertia}; {NEADES})"
    )
    crushed = (
        f"middle of the crush of its {car.crush.face} ({NEADES}); error: {DEPTH} m in depth, an "
        "eighth of the crush's width along the face"
    )
    corrected = (
        f"mean of two published corrections ({CORRECTED}); {error:.0%}, as the momenta of six tests "
        "disagree"
    )
    turned = f"{VOSSOU}; {YAW_RATE} deg/s, a quarter of the range of NHTSA 4363"
    speed = line(
        "approach.speed", f"{car.speed}", f"{max(0.02 * car.speed, 0.05):.2f}", "m/s",
        f"{VOSSOU}; 2 %, as sources differ" if car.speed else "it stood; error assumed",
    )  # fmt: skip
    lines = [
        f"[vehicles.{letter}]",
        f'name = "{car.name}"',
        line("mass", f"{car.mass}", f"{0.01 * car.mass:.0f}", "kg", f"{NEADES}; 1 % assumed"),
        line("yaw_inertia", f"{inertia:.0f}", f"{inertia_sd:.0f}", "kg m^2", of_inertia),
        *of_model(car.wheelbase, car.track),
        f'length = "{car.front + car.rear:.2f} m"',
        f'width = "{car.width} m"',
        line("impact_centre.distance", f"{distance:.2f}", f"{distance_sd:.2f}", "m", crushed),
        line("impact_centre.angle", f"{angle:.0f}", f"{angle_sd:.0f}", "deg", "likewise"),
        *guided(car.heading, VOSSOU),
        *([speed] if known else []),
        line("departure.delta_v", f"{dv:.2f}", f"{error * dv:.2f}", "m/s", corrected),
        line("departure.yaw_rate", f"{car.yaw_rate}", f"{YAW_RATE * DEGREE:.2f}", "rad/s", turned),
    ]
    return "\n".join(lines)


def guided(heading: float, source: str) -> list[str]:
    """How a car came that was led to the impact."""
    return [
        line("impact.heading", f"{heading}", "1", "deg", f"{source}; error of guidance assumed"),
        line("approach.direction", f"{heading}", "1", "deg", "along its heading; likewise"),
        'approach.yaw_rate = "0 ± 1 deg/s"',
    ]


KNOWN = "A is vehicle 2 of the test, whose speed counts as known; B is vehicle 1, whose is sought."


def scene(test: str, title: str, notes: list[str], vehicles: list[str], contact: str) -> str:
    """The whole scene file."""
    noted = ", ".join(f'"{note}"' for note in (KNOWN, *notes))
    return "\n".join(
        [
            f"# {test}, its impact phase. Written by ../staged.py: see there.",
            "schema = 1",
            f'title = "{test}, impact phase: {title}"',
            f"notes = [{noted}]",
            'question = ["speed_b"]',
            *(f"\n{vehicle}" for vehicle in vehicles),
            "\n[impact]",
            'point = ["0 m", "0 m"]',
            f"{contact}\n",
        ]
    )


def ricsac(test: int) -> tuple[str, str]:
    """Scene and truth of a RICSAC test."""
    one, two = RICSAC[test]
    contact = line(
        "contact_line", f"{CONTACT_LINE[test]}", "8", "deg", f"{VOSSOU}; error assumed"
    )  # fmt: skip
    cars = [vehicle("A", two, known=True), vehicle("B", one, known=False)]
    text = scene(f"RICSAC {test}", CONFIGURATION[test], [], cars, contact)
    truth = line("speed_b", f"{one.speed}", "", "m/s", VOSSOU)
    return text, f'note = "{NOTES[test]}"\n{truth}\n'


@dataclass(frozen=True)
class Staged:
    """A vehicle of an NHTSA test, in the units of its source.

    Args:
        name: make, model and year.
        weight, inertia: lb, lb ft s².
        distance, angle: of the impact centre, ft and deg.
        heading: deg.
        speed: before impact, mph.
        wheelbase, track: of the model, m.
        delta_v, yaw_rate: as measured, mph and deg/s; None where they were not.
    """

    name: str
    weight: float
    inertia: float
    distance: float
    angle: float
    heading: float
    speed: float
    wheelbase: float
    track: float
    delta_v: float | None = None
    yaw_rate: float | None = None


# the contact line's angle, vehicle 1, which struck, and vehicle 2. The yaw rates are published without
# signs; these are those of the published impact (tests/test_examples.py)
NHTSA = {
    4363: (
        55.0,
        Staged("Honda Accord 1997", 3451.1, 2152, 2.6, 23.8, 180, 35.1, 2.72, 1.51, 39.5, -48),
        Staged("Chevrolet Blazer 1997", 4695.4, 2805, 5.7, 10.6, 32, 35.0, 2.72, 1.43, 29.1, 197),
    ),
    4364: (
        51.9,
        Staged("Honda Accord 1997", 3451.1, 2152, 2.3, 45.7, 180, 35.0, 2.72, 1.51),
        Staged(
            "Chevrolet Trailblazer 2002", 5192.5, 3563, 7.1, 11.2, 30, 34.9, 2.87, 1.60, 26.6, 136
        ),
    ),
}
CHOSEN = (
    "Impact centres, contact line and yaw inertias are those with which SAE 2006-01-0908 reconstructs "
    "the test, and may have been chosen to fit it."
)


def staged(letter: str, car: Staged, known: bool) -> str:
    """A vehicle of an NHTSA test, with its speed where that is known."""
    lines = [
        f"[vehicles.{letter}]",
        f'name = "{car.name}"',
        line("mass", f"{car.weight}", "", "lb", ROSE),
        line("yaw_inertia", f"{car.inertia}", "", "lb ft s^2", ROSE),
        *of_model(car.wheelbase, car.track),
        line("impact_centre.distance", f"{car.distance}", "", "ft", ROSE),
        line("impact_centre.angle", f"{car.angle}", "", "deg", ROSE),
        *guided(car.heading, ROSE),
    ]
    if known:
        speed, sd = f"{car.speed}", f"{0.01 * car.speed:.2f}"
        lines += [line("approach.speed", speed, sd, "mph", f"{ROSE}; 1 % assumed")]
    if car.delta_v is not None:
        allowed = f"{ROSE}, measured; half of the 10 % that 49 CFR 563 allows a recorder"
        sd = f"{0.05 * car.delta_v:.1f}"
        lines += [line("departure.delta_v", f"{car.delta_v}", sd, "mph", allowed)]
    if car.yaw_rate is not None:
        ranged = f"{ROSE}, measured, its sign the blow's; a quarter of the range of test 4363"
        turned = line("departure.yaw_rate", f"{car.yaw_rate}", f"{YAW_RATE}", "deg/s", ranged)
        lines += [turned]
    return "\n".join(lines)


def nhtsa(test: int) -> tuple[str, str]:
    """Scene and truth of an NHTSA test."""
    normal, one, two = NHTSA[test]
    title = f"left front to left front, {two.heading} degrees"
    contact = line("contact_line", f"{normal}", "8", "deg", f"{ROSE}; error assumed")
    cars = [staged("A", two, known=True), staged("B", one, known=False)]
    text = scene(f"NHTSA {test}", title, [CHOSEN], cars, contact)
    return text, line("speed_b", f"{one.speed}", "", "mph", ROSE) + "\n"


def files() -> dict[Path, str]:
    """Every file and its text."""
    made = {f"ricsac-{test:02d}": ricsac(test) for test in RICSAC}
    made |= {f"nhtsa-{test}": nhtsa(test) for test in NHTSA}
    return {
        HERE / folder / name: text
        for folder, texts in made.items()
        for name, text in zip(("scene.toml", "truth.toml"), texts, strict=True)
    }


def main() -> None:
    """Write them, and print the rule's number."""
    for path, text in files().items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, "utf-8")
    print(f"delta-v of RICSAC: {delta_v_error():.1%}")


if __name__ == "__main__":
    main()
