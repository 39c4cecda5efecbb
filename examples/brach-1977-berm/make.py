"""Writes scene.toml beside it: the collision of SAE 770014 with the berm moved across B's way.

Synthetic. A's and B's approach and e, mu and e_m are the paper's (Table 4); vehicles, geometry, friction
and uncertainties those of ../brach-1977/scene.toml. Where the cars come to rest on this ground is
computed, with as many digits as there. Run: python examples/brach-1977-berm/make.py
"""

import sys
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from retrodict.mechanics import (
    Bodies,
    Car,
    Coefficients,
    Ground,
    Zone,
    run_out,
    separation,
    wheel_paths,
)

HERE = Path(__file__).resolve().parent
PAPER = HERE.parent / "brach-1977"
sys.path.insert(0, str(PAPER))

import recover as paper  # noqa: E402

EDGE = -5.0  # m; B slides from y = -1.6 to about -13 m
APPROACH_A = np.array([-66 * paper.FOOT, 0.0, 0.0])  # 45 mph along -x
APPROACH_B = np.array([62 * paper.FOOT, -12 * paper.FOOT, -15 * paper.DEGREE])
TABLE_4 = Coefficients(e=0.10, mu=0.35, e_m=0.70)
BODIES = Bodies(
    paper.M_A, paper.M_B, paper.I_A, paper.I_B,
    paper.D1, paper.D2, paper.D3, paper.D4, paper.GAMMA,
)  # fmt: skip


def crossing(pose: np.ndarray, velocity: np.ndarray, car: Car) -> str:
    """How many wheels pass the edge, and how fast the car spins from first to last."""
    beyond = np.asarray(wheel_paths(jnp.asarray(pose), car))[..., 1] < EDGE
    when = np.flatnonzero((beyond[1:] != beyond[:-1]).any(1))
    if not len(when):
        return "no wheel passes the edge"
    number = int((beyond.any(0) & ~beyond.all(0)).sum())
    first, last = velocity[when[[0, -1]], 2]
    return f"{number} wheels pass the edge, while it spins at {first:.1f} to {last:.1f} rad/s"


def main() -> None:
    """Run both out, print the result, and write the scene."""
    approach = jnp.asarray(np.concatenate([APPROACH_A, APPROACH_B]))
    after = np.asarray(separation(approach, BODIES, TABLE_4)).reshape(2, 3)
    edge = Zone(np.array([[0.0, EDGE]]), np.array([[0.0, -1.0]]))
    ground = Ground(jnp.array([paper.ROAD, paper.BERM]), None, edge)
    text = (PAPER / "scene.toml").read_text("utf-8")

    def put(old: str, new: str, times: int = 1) -> None:
        nonlocal text
        assert text.count(old) == times, (old, text.count(old))
        text = text.replace(old, new)

    # as in the paper's scene: (x, y, heading, rotation) of A and of B
    rests = (("-3.628", "2.221", "218.13", "38 deg"), ("8.968", "-12.896", "1.0", "743 deg"))
    starts = ((paper.LEVER_A, paper.HEADING_A), (paper.LEVER_B, paper.HEADING_B))
    for name, (lever, heading), V, car, old in zip(
        "AB", starts, after, (paper.CAR_A, paper.CAR_B), rests, strict=True
    ):
        run = run_out(jnp.array([*-lever, heading]), jnp.asarray(V), car, ground)
        pose, velocity = np.asarray(run.pose), np.asarray(run.velocity)
        x, y, turned = pose[-1]
        rotation = (turned - heading) / paper.DEGREE
        print(f"{name}: after the impact {V[0]:.2f} {V[1]:.2f} m/s {V[2]:.2f} rad/s; at rest")
        print(f"   {x:.3f} {y:.3f} m, rotation {rotation:.1f} deg; {crossing(pose, velocity, car)}")
        put(f"value = {old[0]}, sd", f"value = {x:.3f}, sd")
        put(f"value = {old[1]}, sd", f"value = {y:.3f}, sd")
        put(f"value = {old[2]}, sd = 3", f"value = {turned / paper.DEGREE % 360:.2f}, sd = 3")
        put(f'rotation = "{old[3]}"', f'rotation = "{rotation:.0f} deg"')

    for source in (
        "recovered: run-out of Table 1's first cell (-23, 8 ft/s, 35 deg/s)",
        "recovered: run-out of Table 3's velocities",
    ):
        put(source, "synthetic: run-out of Table 4 on this ground", 3)
    put('["0 m", "1.75 m"], direction = "0 deg", side = "left"',
        f'["0 m", "{EDGE} m"], direction = "0 deg", side = "right"')  # fmt: skip
    body = text[text.index("\n[vehicles.A]") :]
    (HERE / "scene.toml").write_text(HEAD + body, "utf-8")


HEAD = """\
# Synthetic, made by make.py from ../brach-1977/scene.toml: the collision of SAE 770014 on another
# ground. "Reported" and "recovered" say where a quantity of that scene is from.
schema = 1
title = "Synthetic: the collision of SAE 770014, its berm moved across B's way"
notes = [
  "Synthetic. No such berm was there. The collision is that of SAE 770014's Table 4; the berm's edge \
was moved to where B's wheels cross it while it spins, and both vehicles' rest poses were computed \
for that ground under this model (make.py).",
]
"""

if __name__ == "__main__":
    main()
