"""The measured scene: records in SI units, the scene file, and defaults with their sources."""

from retrodict.scene.edit import build_scene, change, to_toml
from retrodict.scene.errors import Problem, SceneError
from retrodict.scene.load import load_scene, parse_scene
from retrodict.scene.records import Scene

__all__ = [
    "Problem",
    "Scene",
    "SceneError",
    "build_scene",
    "load_scene",
    "parse_scene",
]

# attached here because `edit` reads and writes scene files, and so knows the record
setattr(Scene, "change", change)  # noqa: B010
setattr(Scene, "to_toml", to_toml)  # noqa: B010
