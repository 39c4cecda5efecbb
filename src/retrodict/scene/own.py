"""What of a scene is the user's own and given in Python: named, and left out of what is stored."""

from __future__ import annotations

from dataclasses import replace

from retrodict.scene.priors import OF_PYTHON
from retrodict.scene.records import Scene


def own_of(scene: Scene) -> tuple[str, ...]:
    """What of a scene is the user's own and in no scene file, in words: priors and terms."""
    own = [f"the prior of {name}" for name, p in scene.priors.items() if p.family == OF_PYTHON]
    return (*own, *(f"the likelihood term {name}" for name in scene.extra))


def without_code(scene: Scene) -> Scene:
    """The scene as it can be stored: the names of what is the user's own in Python, not the code."""
    priors = {name: replace(prior, law=None) for name, prior in scene.priors.items()}
    return replace(scene, priors=priors, extra=dict.fromkeys(scene.extra))
