"""Scenes as notebooks meet them: read from a file, and able to show themselves."""

from __future__ import annotations

from retrodict.scene import Scene, SceneError, build_scene, load_scene, parse_scene

__all__ = ["Scene", "SceneError", "build_scene", "load_scene", "parse_scene"]


def _repr_html_(scene: Scene) -> str:
    from retrodict.report.fragments import scene_html

    return scene_html(scene)


# attached here because `scene` lies below `report` and must not know it
setattr(Scene, "_repr_html_", _repr_html_)  # noqa: B010
