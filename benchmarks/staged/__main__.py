"""Writes scene.toml and truth.toml of the second set of staged collisions, from printed numbers.

python3 -m uv run python -m benchmarks.staged

The rules, fixed before any was reconstructed, are in docs/validation.md. The cases stand in cases/
beside this file, and `retrodict validate examples benchmarks/staged/cases` scores them. True speeds go
into truth.toml, and of A where two cars met and it counts as known.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
CASES = HERE / "cases"
TABLE = HERE / "barriers.csv"

PAPER = "SAE 2014-01-0469, Appendix 2"
LIBRARY = "the class's mean in docs/vehicles.md"
NHTSA = "NHTSA test 7292, v07292.EV5"
CHANNELS = "NHTSA test 7292, accelerometers of both sills"

FOOT = 0.3048
DELTA_V = 0.05  # relative sd, of the resultant
YAW_RATE = 15  # deg/s, sd
GAMMA = 8  # deg, sd of the contact line
GUIDED = 1  # deg, sd of headings and directions
ALONG, ACROSS = 1 / 8, 0.10  # sd of the impact centre: of the face's length along it, m across it
CG_SHARE = 0.41  # wheelbases, front axle to centre of gravity
CG_ERROR = 0.03  # wheelbases
OVERHANG = 0.48  # front overhang over length less wheelbase
A_PILLAR = 1.65  # m, bumper to A-pillar where no overlap and Γ of a barrier test give it
QUARTER, GAMMA_OF_QUARTER = 0.25, 74.5  # overlap that is not printed, and its Γ, deg


@dataclass(frozen=True)
class Model:
    """A model of car, by its maker's data.

    Args:
        class_mass, class_spread: mean and spread of the mass of its class in the library, kg.
        wheelbase, length, width: m.
        bumper: front bumper to centre of gravity, m; None where the rule gives it.
    """

    class_mass: float
    class_spread: float
    wheelbase: float
    length: float
    width: float
    bumper: float | None = None

    @property
    def to_bumper(self) -> float:
        """Centre of gravity to front bumper, m."""
        if self.bumper is not None:
            return self.bumper
        return CG_SHARE * self.wheelbase + OVERHANG * (self.length - self.wheelbase)


# mean and spread by class: those of the wheelbase
SUBCOMPACT, INTERMEDIATE, FULL_SIZE = (1244, 168), (1621, 122), (1736, 128)
SMALL_SUV, PICKUP = (1639, 195), (2003, 402)
MODELS = {
    "Audi A4": Model(*FULL_SIZE, 2.808, 4.701, 1.826),
    "BMW 328i": Model(*FULL_SIZE, 2.810, 4.624, 1.811),
    "Ford Fusion": Model(*INTERMEDIATE, 2.728, 4.831, 1.83, bumper=2.24),
    "Honda Accord": Model(*FULL_SIZE, 2.799, 4.930, 1.847),
    "Lexus IS 250": Model(*INTERMEDIATE, 2.730, 4.580, 1.801),
    "Mercedes-Benz C 250": Model(*INTERMEDIATE, 2.761, 4.630, 1.770),
    "Mitsubishi Galant": Model(*INTERMEDIATE, 2.751, 4.851, 1.839),
    "Subaru Forester": Model(*SMALL_SUV, 2.616, 4.559, 1.781),
    "Volkswagen CC": Model(*INTERMEDIATE, 2.710, 4.798, 1.854),
    "Volvo S60": Model(*INTERMEDIATE, 2.776, 4.628, 1.865),
    "Acura TL": Model(*INTERMEDIATE, 2.776, 4.928, 1.880),
    "Fiat 500": Model(*SUBCOMPACT, 2.300, 3.547, 1.627),
    "Ford Taurus": Model(*FULL_SIZE, 2.868, 5.154, 1.936),
    "Kia Rio": Model(*SUBCOMPACT, 2.410, 4.240, 1.679),
    "Lexus ES350": Model(*INTERMEDIATE, 2.776, 4.857, 1.821),
    "Toyota Tundra": Model(*PICKUP, 3.259, 5.524, 1.910),
}
BARRIERS = {  # kind of face, and diameter of the edge (m), for drawing
    "Flat 150 barrier": ("rigid", 0.30),
    "Flat steel wall 5 cm rad": ("rigid", 0.10),
    "Flat steel wall 15 cm": ("rigid", 0.30),
    "25.4 cm pole": ("rigid", 0.254),
    "50.8 cm pole": ("rigid", 0.508),
    "Deformable barrier face": ("deformable", 0.30),
}
MADE_FROM = {"yes": "made from this test", "no": "not made from it"}
INCONSISTENT = (
    "its numbers contradict one another: 1.39 m² for the ratio of yaw inertia to mass follows from "
    "them, 2.0 from those of other Fusions"
)


@dataclass(frozen=True)
class Tested:
    """A car in a test of two.

    Args:
        name: model and year.
        model: its dimensions.
        mass, mass_sd: kg.
        mass_source: where the mass is from.
        speed: before impact, as printed, with its unit.
        delta_v: lines of the scene file that have its delta-v.
        yaw_rate, yaw_rate_sd: after impact, deg/s.
        heading: at impact, deg.
        source: where delta-v and yaw rate are from.
        speed_source: where the speed is from.
    """

    name: str
    model: Model
    mass: float
    mass_sd: float
    mass_source: str
    speed: tuple[float, str]
    delta_v: tuple[str, ...]
    yaw_rate: float
    yaw_rate_sd: float
    heading: float
    source: str = f"{PAPER}, Part 2"
    speed_source: str = f"{PAPER}, Part 2"


def line(key: str, value: float, sd: float | None, unit: str, source: str, digits: int = 3) -> str:
    """A quantity as the scene file has it; with the package's uncertainty where sd is None."""
    error = "" if sd is None else f"sd = {sd:.{digits}g}, "
    return f'{key} = {{ value = {value:.6g}, {error}unit = "{unit}", source = "{source}" }}'


def impact_centre(model: Model, overlap: float, pillar: float) -> list[str]:
    """The middle of the face from the bumper, within the overlap, to the A-pillar at the left side.

    Args:
        model: the car.
        overlap: overlap of the front, m.
        pillar: bumper to A-pillar, m.
    """
    forward, left = model.to_bumper - pillar / 2, model.width / 2 - overlap / 2
    distance, face = math.hypot(forward, left), math.hypot(pillar, overlap)
    along = (-pillar / face, overlap / face)
    across = (overlap / face, pillar / face)
    errors = (  # independent ones, each as a vector (forward, left), m
        (ALONG * face * along[0], ALONG * face * along[1]),
        (ACROSS * across[0], ACROSS * across[1]),
        (CG_ERROR * model.wheelbase, 0.0),
    )
    outward = (forward / distance, left / distance)
    aside = (-left / distance, forward / distance)
    sd = [math.hypot(*(x * to[0] + y * to[1] for x, y in errors)) for to in (outward, aside)]
    source = "middle of the face from bumper to A-pillar; rule in docs/validation.md"
    angle = math.degrees(math.atan2(left, forward))
    angle_sd = math.degrees(sd[1] / distance)
    return [
        line("impact_centre.distance", round(distance, 3), sd[0], "m", source, 2),
        line("impact_centre.angle", round(angle, 1), angle_sd, "deg", "likewise", 2),
    ]


def dimensions(model: Model) -> list[str]:
    """What the maker's data give."""
    return [
        line("wheelbase", model.wheelbase, 0.01, "m", "of the model, its maker's data"),
        line("track", round(0.85 * model.width, 2), 0.03, "m", "0.85 of the width; no effect here"),
        f'length = "{model.length:.2f} m"',
        f'width = "{model.width:.2f} m"',
    ]


def guided(heading: float) -> list[str]:
    """How a car came that was led to the impact."""
    return [
        line("impact.heading", heading, GUIDED, "deg", "guided; error assumed"),
        line("approach.direction", heading, GUIDED, "deg", "along its heading; likewise"),
        f'approach.yaw_rate = "0 ± {GUIDED} deg/s"',
    ]


def components(forward: float, left: float, unit: str, source: str) -> tuple[str, ...]:
    """Both components of a delta-v, with the error of their resultant."""
    sd = DELTA_V * math.hypot(forward, left)
    said = f"{source}; {DELTA_V:.0%} of the resultant"
    return (
        line("departure.delta_v_forward", forward, sd, unit, said),
        line("departure.delta_v_left", left, sd, unit, said),
    )


def groups(**labels: str) -> str:
    """The groups that a case is counted with."""
    return "\n[groups]\n" + "".join(f'{name} = "{label}"\n' for name, label in labels.items())


def head(name: str, title: str, asked: str, notes: tuple[str, ...] = ()) -> list[str]:
    """How a scene file begins."""
    noted = ", ".join(f'"{note}"' for note in notes)
    return [
        f"# {name}, its impact phase. Written by `python -m benchmarks.staged`: see there.",
        "schema = 1",
        f'title = "{name}, impact phase: {title}"',
        *([f"notes = [{noted}]"] if notes else []),
        f'question = ["{asked}"]',
    ]


def barrier(row: dict[str, str]) -> tuple[str, str]:
    """Scene and truth of a barrier test."""
    model = MODELS[row["vehicle"]]
    face, diameter = BARRIERS[row["barrier"]]
    overlap = float(row["overlap"]) / 100 * model.width
    gamma = float(row["Gamma"])
    printed = f"{PAPER}, Part 1"
    scene = [
        *head(f"IIHS {row['test']}", f"{row['year']} {row['vehicle']}, small overlap", "speed_a"),
        "\n[barrier]",
        'kind = "pole"',
        f'name = "{row["barrier"]}"',
        f'diameter = "{diameter} m"',
        "\n[vehicles.A]",
        f'name = "{row["year"]} {row["vehicle"]}"',
        line("mass", model.class_mass, 0.01 * model.class_mass, "kg", f"{LIBRARY}; no effect here"),
        *dimensions(model),
        *impact_centre(model, overlap, overlap * math.tan(math.radians(gamma))),
        *guided(0),
        *components(-float(row["rearwards"]), -float(row["right"]), "ft/s", printed),
        line(
            "departure.yaw_rate", float(row["yaw_rate"]), YAW_RATE, "deg/s",
            f"{printed}; error as in examples/",
        ),
        "\n[impact]",
        'point = ["0 m", "0 m"]',
        line("contact_line", gamma, GAMMA, "deg", f"{printed}: Γ; error assumed"),
    ]  # fmt: skip
    truth = line("speed_a", float(row["speed"]), None, "ft/s", printed)
    note = f'note = "{INCONSISTENT}"\n' if row["test"] == "CF10023" else ""
    labels = groups(contact=row["group"], face=face, priors=MADE_FROM[row["in_priors"]])
    return "\n".join([*scene, ""]), f"{note}{truth}\n{labels}"


def vehicle(letter: str, car: Tested, overlap: float, known: bool) -> list[str]:
    """A car of a test of two, with its speed where that counts as known."""
    value, unit = car.speed
    speed = line("approach.speed", value, 0.01 * value, unit, f"{car.speed_source}; 1 % assumed")
    if not value:
        speed = line("approach.speed", 0, 0.05, "m/s", "it stood; error assumed")
    return [
        f"\n[vehicles.{letter}]",
        f'name = "{car.name}"',
        line("mass", car.mass, car.mass_sd, "kg", car.mass_source),
        *dimensions(car.model),
        *impact_centre(car.model, overlap, A_PILLAR),
        *guided(car.heading),
        *([speed] if known else []),
        *car.delta_v,
        line("departure.yaw_rate", car.yaw_rate, car.yaw_rate_sd, "deg/s", car.source),
    ]


def pair(
    name: str, title: str, overlap: float, gamma: float, of_gamma: str, cars: tuple[Tested, Tested]
) -> tuple[str, str]:
    """Scene and truth of a test of two cars: A, whose speed counts as known, and B."""
    known = "The speed of A counts as known; that of B is sought."
    scene = head(name, title, "speed_b", (known,))
    for letter, car in zip("AB", cars, strict=True):
        scene += vehicle(letter, car, overlap * car.model.width, known=letter == "A")
    scene += [
        "\n[impact]",
        'point = ["0 m", "0 m"]',
        line("contact_line", gamma, GAMMA, "deg", of_gamma),
    ]
    value, unit = cars[1].speed
    truth = line("speed_b", value, None, unit, cars[1].speed_source)
    labels = {"priors": MADE_FROM["no"]}
    if name.startswith("IIHS"):
        labels = {"contact": "sideswipe"} | labels
    return "\n".join([*scene, ""]), f"{truth}\n{groups(**labels)}"


def printed(
    name: str, model: Model, mass: tuple[float, float, str], row: tuple[float, float, float],
    heading: float,
) -> Tested:  # fmt: skip
    """A car of an IIHS pair: speed and delta-v (ft/s) and yaw rate (deg/s) as printed."""
    speed, delta_v, yaw_rate = row
    said = f"{PAPER}, Part 2; {DELTA_V:.0%}"
    of_delta_v = line("departure.delta_v", delta_v, DELTA_V * delta_v, "ft/s", said)
    return Tested(name, model, *mass, (speed, "ft/s"), (of_delta_v,), yaw_rate, YAW_RATE, heading)


FUSION, GALANT, S60 = (MODELS[name] for name in ("Ford Fusion", "Mitsubishi Galant", "Volvo S60"))
# IIHS's reports on CF09009A and B have dimensions, weights and 62 % of the weight on the front axle
TAURUS_2001 = Model(*INTERMEDIATE, 2.76, 5.02, 1.85, bumper=0.38 * 2.76 + OVERHANG * (5.02 - 2.76))
BULLET = Model(*INTERMEDIATE, 2.75, 5.022, 1.845, bumper=1.118 + OVERHANG * (5.022 - 2.75))
TARGET = Model(*INTERMEDIATE, 2.75, 5.020, 1.845, bumper=1.108 + OVERHANG * (5.020 - 2.75))

WEIGHED = "IIHS's report on this car: weighed, 62 % on the front axle"
AS_CF11002 = (1619, 0.02 * 1619, "as weighed for CF11002, SAE 2014-01-0469, Table 1")
OF_CLASS = (
    1621,
    0.02 * 1621,
    f"{LIBRARY}; both cars are of one model, so that only its error counts",
)
ANY_GALANT = (1621, 122, f"{LIBRARY}, and the class's spread")

# name: overlap, Γ (deg), and both cars: A at 0 deg, B at 180 deg
PAIRS = {
    "CF09009": (0.28, 74.0, (
        printed("2005 Ford Taurus", TAURUS_2001, (1528, 15.3, WEIGHED), (50.94, 33.0, 64.0), 0),
        printed("2001 Ford Taurus", TAURUS_2001, (1545, 15.5, WEIGHED), (51.12, 32.6, 75.38), 180),
    )),
    "CF10010": (0.28, 71.8, (
        printed("2008 Ford Fusion", FUSION, AS_CF11002, (58.69, 37.2, 94.85), 0),
        printed("2009 Mitsubishi Galant", GALANT, ANY_GALANT, (58.51, 38.7, 63.28), 180),
    )),
    "CF11017": (0.21, 80.7, (
        printed("2009 Ford Fusion", FUSION, AS_CF11002, (58.51, 31.1, 67.33), 0),
        printed("2008 Ford Fusion", FUSION, AS_CF11002, (58.60, 32.3, 85.33), 180),
    )),
    "CF11018": (0.21, 77.2, (
        printed("2009 Mitsubishi Galant (first)", GALANT, OF_CLASS, (58.51, 39.9, 117.56), 0),
        printed("2009 Mitsubishi Galant (second)", GALANT, OF_CLASS, (58.69, 39.7, 116.14), 180),
    )),
    "CF11019": (0.22, 77.0, (
        printed("2012 Volvo S60 (first)", S60, OF_CLASS, (58.51, 40.7, 142.33), 0),
        printed("2012 Volvo S60 (second)", S60, OF_CLASS, (58.60, 40.2, 140.83), 180),
    )),
}  # fmt: skip


def standing_target() -> tuple[str, str]:
    """Scene and truth of NHTSA 7292. In its channels' frame y is to the right and angles clockwise."""
    heading = -187 + 360
    share = 0.12  # of a yaw rate: the sensors' spacing is assumed
    target = Tested(
        "2006 Ford Taurus, the target", TARGET, 1730, 17.3, f"{NHTSA}; 1 % assumed", (0.0, "km/h"),
        components(-46.7, -23.6, "km/h", CHANNELS), 75, share * 75, heading, CHANNELS, NHTSA,
    )  # fmt: skip
    bullet = Tested(
        "2007 Ford Taurus, the bullet", BULLET, 1735, 17.35, f"{NHTSA}; 1 % assumed", (113.4, "km/h"),
        components(-51.5, -17.6, "km/h", CHANNELS), 154, share * 154, 0, CHANNELS, NHTSA,
    )  # fmt: skip
    turned = heading - 180
    return pair(
        "NHTSA 7292", "left front to left front, 7 degrees, the target standing", QUARTER,
        GAMMA_OF_QUARTER + turned / 2, "an overlap of a quarter, mean of both cars; error assumed",
        (target, bullet),
    )  # fmt: skip


def files() -> dict[Path, str]:
    """Every file and its text."""
    rows = csv.DictReader(x for x in TABLE.read_text("utf-8").splitlines() if x[0] != "#")
    made = {f"iihs-{row['test'].lower()}": barrier(row) for row in rows}
    of_gamma = f"{PAPER}, Part 2: Γ; error assumed"
    for test, (overlap, gamma, cars) in PAIRS.items():
        title = f"left front to left front, head-on, overlap {overlap:.0%}"
        made[f"iihs-{test.lower()}"] = pair(f"IIHS {test}", title, overlap, gamma, of_gamma, cars)
    made["nhtsa-7292"] = standing_target()
    return {
        CASES / folder / name: text
        for folder, texts in made.items()
        for name, text in zip(("scene.toml", "truth.toml"), texts, strict=True)
    }


def main() -> None:
    """Write them."""
    for path, text in files().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
