"""A toy table of evidence, taken from a scene file to its report: how a vehicle struck a kerb.

Run by itself with a copy of the package in which only the files that CONTRIBUTING names were changed
(`ADDED`). It reads a scene and prints, as JSON, what became of the two items.
"""

import json
import sys

_KERB = """
KERB: dict[str, Field] = {
    "speed": Field(
        units.SPEED, 0, 150, "4 ± 1 m/s", uncertainty="required", label="speed of {} at the kerb",
        meaning="a toy",
    ),
    "course": Field(
        units.DIRECTION, -360, 360, "35 ± 8 deg", uncertainty="required",
        label="course of {} at the kerb", meaning="a toy",
    ),
}"""
_TABLE = """    "kerb": Evidence(
        what="how it struck a kerb", table="kerb", fields=KERB, prefix="kerb_", where="after the impact",
    ),"""
_PREDICTIONS = """    "kerb_speed": Prediction(lambda motion: jnp.hypot(*motion.after[:2])),
    "kerb_course": Prediction(
        lambda motion: jnp.arctan2(motion.after[1], motion.after[0]), circular=True
    ),"""

# file -> (line, the line behind which the addition goes; the addition)
ADDED = {
    "src/retrodict/scene/fields.py": (
        ("# tables of evidence by attribute of the scene", _KERB),
        ("AFTER: dict[str, Evidence] = {", _TABLE),
    ),
    "src/retrodict/scene/records.py": (
        (
            "    skidded_on: tuple[Surface, ...] = ()",
            "    kerb: dict[str, Items] = field(default_factory=dict)",
        ),
    ),
    "models/evidence.py": (
        ('    "yaw_mark": Prediction(lambda motion: motion.over_critical),', _PREDICTIONS),
    ),
}


def main(text: str) -> dict[str, object]:
    """What became of the items in a scene that states them."""
    import jax
    from numpyro import handlers
    from retrodict.models import RUNGS

    from retrodict.explore.controls import controls
    from retrodict.report.fragments import scene_html
    from retrodict.scene import parse_scene
    from retrodict.scene.quantities import label_and_unit
    from retrodict.scene.write import scene_toml

    scene = parse_scene(text, "toy")
    again = parse_scene(scene_toml(scene), "toy").evidence()
    names = [name for name in scene.evidence() if name.startswith("kerb")]
    rung = RUNGS["momentum+slide"]
    structure, data = rung.of_scene(scene)
    model = handlers.seed(rung.model, jax.random.key(0))
    trace = handlers.trace(model).get_trace(structure, data)
    x, y = (float(trace[site]["value"]) for site in ("Vbx", "Vby"))
    return {
        "values": {
            name: [scene.evidence()[name].value, scene.evidence()[name].sd] for name in names
        },
        "written": {name: [again[name].value, again[name].sd] for name in names},
        "labels": [label_and_unit(name, "us")[0] for name in names],
        "sliders": [each.key for each in controls(scene) if "kerb" in each.key],
        "predicted": float(trace["kerb_speed_b"]["fn"].mean),
        "speed": float((x**2 + y**2) ** 0.5),
        "report": scene_html(scene, "us"),
    }


if __name__ == "__main__":
    json.dump(main(sys.stdin.read()), sys.stdout)
