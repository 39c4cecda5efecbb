"""Toy quantities of a vehicle, of the impact and of a surface, taken from a scene file to its report.

Run by itself with a copy of the package in which only the files that CONTRIBUTING names were changed
(`ADDED`). It reads a scene and prints, as JSON, what became of the three quantities.
"""

import json
import sys

_FIELD = (
    'Field(units.LENGTH, 0.1, 3, "1 m", default=DEFAULTS["cg_height"], label="{}", meaning="a toy")'
)

# file -> (line, the line behind which the addition goes; the addition)
ADDED = {
    "src/retrodict/scene/fields.py": (
        ("VEHICLE: dict[str, Field] = {", f'    "reach": {_FIELD.format("reach of {}")},'),
        ("IMPACT: dict[str, Field] = {", f'    "depth": {_FIELD.format("depth of the contact")},'),
        ("SURFACE: dict[str, Field] = {", f'    "layer": {_FIELD.format("layer of the {}")},'),
    ),
    "src/retrodict/scene/records.py": (
        ("    cg_height: Measured | None = None", "    reach: Measured | None = None"),
    ),
    "src/retrodict/scene/place_records.py": (
        ("    interlocked: bool = False", "    depth: Measured | None = None"),
        ("    outline: Outline | None = None", "    layer: Measured | None = None"),
    ),
}


def main(text: str) -> dict[str, object]:
    """What became of the quantities in a scene that states them."""
    import jax
    from numpyro import handlers
    from retrodict.models import RUNGS

    from retrodict.explore.controls import controls
    from retrodict.report.fragments import scene_html
    from retrodict.scene import parse_scene
    from retrodict.scene.quantities import label_and_unit
    from retrodict.scene.write import scene_toml

    scene = parse_scene(text, "toy")
    again = parse_scene(scene_toml(scene), "toy")
    names = [name for name in scene.inputs() if name.startswith(("reach", "depth", "layer"))]
    rung = RUNGS["momentum+slide"]
    structure, data = rung.of_scene(scene)
    model = handlers.seed(rung.model, jax.random.key(0))
    trace = handlers.trace(model).get_trace(structure, data)
    return {
        "values": {name: [scene.inputs()[name].value, scene.inputs()[name].sd] for name in names},
        "written": {name: again.inputs()[name].value for name in names},
        "labels": {name: label_and_unit(name, "us")[0] for name in names},
        "units": {name: label_and_unit(name, "us")[1].symbol for name in names},
        "sliders": [each.key for each in controls(scene)],
        "draws": {name: float(trace[name]["value"]) for name in names},
        "report": scene_html(scene, "us"),
    }


if __name__ == "__main__":
    json.dump(main(sys.stdin.read()), sys.stdout)
