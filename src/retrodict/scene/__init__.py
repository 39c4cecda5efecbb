"""What was measured: records in SI, the scene file at the door, defaults with their sources."""

from retrodict.scene.errors import Problem, SceneError
from retrodict.scene.load import load_scene, parse_scene
from retrodict.scene.records import Scene

__all__ = ["Problem", "Scene", "SceneError", "load_scene", "parse_scene"]
