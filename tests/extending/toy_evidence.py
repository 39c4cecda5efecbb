"""A toy item of evidence, registered before a scene is read: the speed along the heading after impact.

Run by itself, because what a scene file may hold is fixed when the first one is read. It prints the
item's label and unit, what was measured, and the prediction beside that by the velocities drawn, m/s.
"""

import sys

import jax
import jax.numpy as jnp
from numpyro import handlers
from retrodict.models.evidence import PREDICTIONS, Prediction

from retrodict.scene import units
from retrodict.scene.fields import DEPARTURE, Field

DEPARTURE["forward"] = Field(
    *(units.SPEED, -150, 150, "5 ± 1 m/s"),
    uncertainty="required",
    label="speed of {} along its heading",
)
PREDICTIONS["departure_forward"] = Prediction(
    lambda motion: motion.after[:2] @ jnp.stack([jnp.cos(motion.heading), jnp.sin(motion.heading)])
)

if __name__ == "__main__":
    from retrodict.models import RUNGS

    from retrodict.scene import parse_scene
    from retrodict.scene.quantities import label_and_unit

    scene = parse_scene(sys.stdin.read(), "toy")
    name = "departure_forward_b"
    structure, data = RUNGS["momentum+slide"].of_scene(scene)

    @jax.jit
    def predicted() -> tuple[jax.Array, jax.Array]:
        model = handlers.seed(RUNGS["momentum+slide"].model, jax.random.key(0))
        trace = handlers.trace(model).get_trace(structure, data)
        x, y, heading = (trace[site]["value"] for site in ("Vbx", "Vby", "heading_b"))
        return trace[name]["fn"].mean, x * jnp.cos(heading) + y * jnp.sin(heading)

    label, unit = label_and_unit(name, "si")
    print(label, unit.symbol, sep="|")
    print(*data.evidence[name].tolist())
    print(*map(float, predicted()))
