"""A toy reader: scene files in JSON."""

import json
from typing import Any

from retrodict.scene.errors import Problem, SceneError


def json_of(text: str, file: str) -> dict[str, Any]:
    """The tables and keys of a scene file in JSON."""
    try:
        return json.loads(text)
    except ValueError as error:
        raise SceneError(file, [Problem("", "", f"not valid JSON ({error}); fix it")]) from None
