"""Scenes as notebooks meet them: read from a file, and able to show themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from retrodict.scene import Scene, SceneError, build_scene, load_scene, parse_scene
from retrodict.scene.quantities import Units

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Scene", "SceneError", "build_scene", "load_scene", "parse_scene"]


def _repr_html_(scene: Scene) -> str:
    from retrodict.report.fragments import scene_html

    return scene_html(scene)


def plot(scene: Scene, units: Units = "si") -> Figure:
    """The scene from above, to scale: what was measured, before any run.

    Args:
        scene: scene to draw.
        units: units of the figure, "si" or "us".

    Returns:
        Surfaces, outlines at impact and at rest, the contact line, marks, and what was measured
        within two standard deviations.
    """
    from retrodict.report.figures.scene import plan_figure

    return plan_figure(scene, units)


# attached here because `scene` lies below `report` and must not know it
setattr(Scene, "_repr_html_", _repr_html_)  # noqa: B010
setattr(Scene, "plot", plot)  # noqa: B010
