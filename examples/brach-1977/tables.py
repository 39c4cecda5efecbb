"""Tables 1 and 2 of SAE 770014: the velocities after the impact that end at the rest poses.

Prints them for nine pairs of friction and the scene of scene.toml, beside the paper's. A star marks
the cells from which the rest poses were recovered (see recover.py): they had to come out.
Run: python examples/brach-1977/tables.py
"""

from pathlib import Path

import jax.numpy as jnp
import numpy as np
from retrodict.models import RUNGS, parts

from retrodict import load_scene
from retrodict.mechanics import Car, Departures, departures

FOOT, DEGREE = 0.3048, np.pi / 180
US = np.array([FOOT, FOOT, DEGREE])
ROAD, BERM = np.array([0.50, 0.55, 0.60]), np.array([0.400, 0.425, 0.450])

# printed: Vx and Vy in ft/s, Omega in deg/s; for A and B, each road, each berm
PAPER = np.array([
    [[[-23, 8, 35], [-23, 9, 40], [-23, 9, 40]],
     [[-24, 8, 35], [-24, 9, 35], [-24, 9, 40]],
     [[-25, 9, 35], [-25, 9, 35], [-25, 9, 35]]],
    [[[17, -20, 565], [17, -20, 565], [17, -20, 565]],
     [[18, -21, 590], [18, -21, 595], [18, -21, 595]],
     [[19, -22, 615], [19, -22, 615], [19, -22, 615]]],
])  # fmt: skip

# A's rest pose was made from its first cell. B's was made from Table 3, which is its first cell in
# SI units; as B stays on the road, that fixes its first row.
MADE_FROM = np.zeros((2, 3, 3), bool)
MADE_FROM[0, 0, 0] = MADE_FROM[1, 0] = True


def tables() -> Departures:
    """Every solution for A and B (first axis), each road (second) and each berm (third)."""
    scene = load_scene(Path(__file__).parent / "scene.toml")
    structure, data = RUNGS["planar-moment+wheels"].of_scene(scene)
    x = parts.from_standard(structure, data, jnp.zeros(len(structure.uncertain)))
    rests = np.array(
        [[data.evidence[f"rest_{part}_{v}"][0] for part in ("x", "y", "heading")] for v in "ab"]
    )
    numbers = Car(*(np.asarray(value)[:, None, None] for value in parts.cars(structure, x)[:4]))
    pairs = np.stack(np.meshgrid(ROAD, BERM, indexing="ij"), axis=-1)
    ground = parts.ground(structure, data, x)._replace(coefficients=pairs)
    # the scene gives the total rotation of both vehicles
    starts = np.asarray(parts.impact_poses(x))
    return departures(
        starts[:, None, None], rests[:, None, None], numbers, ground, turns=None, steps=192
    )


def main() -> None:
    """Print both tables, the paper's first in each pair."""
    found = tables()
    here = found.velocity[..., 0, :] / US
    for v, name in enumerate("AB"):
        print(
            f"Table {v + 1}: vehicle {name}; paper | here (ft/s, ft/s, deg/s); "
            "* the rest pose is made from it"
        )
        print("road".ljust(6) + "".join(f"berm {berm:.3f}".ljust(38) for berm in BERM).rstrip())
        for i, road in enumerate(ROAD):
            cells = [
                "{:4.0f}{:4.0f}{:5.0f}".format(*PAPER[v, i, j])
                + " |{:7.2f}{:7.2f}{:8.1f}".format(*here[v, i, j])
                + (" *" if MADE_FROM[v, i, j] else "  ")
                for j in range(3)
            ]
            print((f"{road:.2f}  " + " ".join(cells)).rstrip())
    apart = np.abs(here - PAPER)
    inside = (apart <= [1, 1, 10]).all(axis=-1)
    for cells, which in ((np.ones_like(MADE_FROM), "all"), (~MADE_FROM, "those without a star")):
        most = apart[cells].max(axis=0)
        print(
            f"{which}: {inside[cells].sum()} of {cells.sum()} cells within 1 ft/s and 10 deg/s; "
            f"largest deviation {most[:2].max():.2f} ft/s, {most[2]:.1f} deg/s"
        )
    more = found.converged.sum(axis=-1)
    print(
        f"cells solved: {(more > 0).sum()} of 18; with more than one solution: {(more > 1).sum()}"
    )
    speed = np.hypot(here[..., 0], here[..., 1])
    for v, name in enumerate("AB"):
        rises = speed[v, -1] / speed[v, 0] / np.sqrt(ROAD[-1] / ROAD[0])
        berm = speed[v, :, -1] / speed[v, :, 0]
        print(
            f"{name}: speed from road {ROAD[0]:.2f} to {ROAD[-1]:.2f} rises {rises.min():.3f} to "
            f"{rises.max():.3f} times as the square root; from berm {BERM[0]:.3f} to "
            f"{BERM[-1]:.3f} it changes by {100 * np.abs(berm - 1).max():.1f} % at most"
        )


if __name__ == "__main__":
    main()
