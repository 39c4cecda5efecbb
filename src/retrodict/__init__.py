"""Reconstructs vehicle collisions and says how sure it is: the public names.

A scene comes from `load_scene`, `parse_scene`, `build_scene` or `import_evidence`, and `vehicles` lists
the cars that it may name. `reconstruct` gives a `Result`; `load_result` and `replay` read one. `ladder`
compares models, `batch` answers many scenes, `session` and `sweep` answer while numbers change.
`calibrate` and `validate` say whether answers can be relied on. `numpyro_model` and `log_density` are
for other samplers, and `mechanics`, with `plot_impact` and `plot_path`, for the equations alone.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from retrodict import mechanics
    from retrodict.api import (
        Calibration,
        Ladder,
        Result,
        Validation,
        batch,
        calibrate,
        ladder,
        load_result,
        reconstruct,
        replay,
        validate,
    )
    from retrodict.interchange.importing import Import, import_evidence
    from retrodict.live import Answer, Session, session, sweep
    from retrodict.own_sampler import LogDensity, NumpyroModel, log_density, numpyro_model
    from retrodict.report.figures.impact import plot_impact
    from retrodict.report.figures.path import plot_path
    from retrodict.scene import Scene, SceneError, build_scene, load_scene, parse_scene
    from retrodict.scene.vehicle_library import VehicleClass, vehicles

    __version__: str

__all__ = [
    "Answer",
    "Calibration",
    "Import",
    "Ladder",
    "LogDensity",
    "NumpyroModel",
    "Result",
    "Scene",
    "SceneError",
    "Session",
    "Validation",
    "VehicleClass",
    "__version__",
    "batch",
    "build_scene",
    "calibrate",
    "import_evidence",
    "ladder",
    "load_result",
    "load_scene",
    "log_density",
    "mechanics",
    "numpyro_model",
    "parse_scene",
    "plot_impact",
    "plot_path",
    "reconstruct",
    "replay",
    "session",
    "sweep",
    "validate",
    "vehicles",
]

# found when first asked for, so that importing the package, or its --help, does not wait for JAX
_HOMES = {
    "Answer": "retrodict.live",
    "Calibration": "retrodict.api",
    "Import": "retrodict.interchange.importing",
    "Ladder": "retrodict.studies.comparison",
    "Result": "retrodict.result",
    "Validation": "retrodict.api",
    "batch": "retrodict.api",
    "calibrate": "retrodict.api",
    "import_evidence": "retrodict.interchange.importing",
    "ladder": "retrodict.api",
    "load_result": "retrodict.result",
    "plot_impact": "retrodict.report.figures.impact",
    "plot_path": "retrodict.report.figures.path",
    "reconstruct": "retrodict.api",
    "replay": "retrodict.api",
    "validate": "retrodict.api",
    "LogDensity": "retrodict.own_sampler",
    "NumpyroModel": "retrodict.own_sampler",
    "log_density": "retrodict.own_sampler",
    "numpyro_model": "retrodict.own_sampler",
    "Session": "retrodict.live",
    "session": "retrodict.live",
    "sweep": "retrodict.live",
    "Scene": "retrodict.notebook",
    "SceneError": "retrodict.notebook",
    "build_scene": "retrodict.notebook",
    "load_scene": "retrodict.notebook",
    "parse_scene": "retrodict.notebook",
    "VehicleClass": "retrodict.scene.vehicle_library",
    "vehicles": "retrodict.scene.vehicle_library",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("retrodict")
    if name == "mechanics":
        return import_module("retrodict.mechanics")
    if name not in _HOMES:
        raise AttributeError(f"module 'retrodict' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
