"""Problems of the entries of a scene file, and how to fix them."""

from __future__ import annotations

import difflib
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from retrodict.scene.errors import Problem, SceneError, key_path, shown
from retrodict.scene.kinds import Kind
from retrodict.scene.schema import SceneEntry

# what people call a key that has another name here
_ALIKE = 0.75  # of two keys: below it the same key in another table is likelier
_OTHER_NAMES = {
    "direction": "course",
    "drag": "friction",
    "gamma": "contact_line",
    "grade": "slope",
    "height": "cg_height",
    "inertia": "yaw_inertia",
    "mu": "friction",
    "omega": "yaw_rate",
    "slope": "grade",
    "velocity": "speed",
    "weight": "mass",
}


def entries_of[T: BaseModel](model: type[T], document: object, file: str) -> T:
    """The entries of a file.

    Args:
        model: model of the whole file.
        document: tables and keys of the file.
        file: name of the file, for messages.

    Raises:
        SceneError: something in it is wrong.
    """
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise SceneError(file, problems_of(error, model)) from None


def problems_of(error: ValidationError, root: type[BaseModel] = SceneEntry) -> list[Problem]:
    """The problems in a validation error, in the words of a file's author.

    Args:
        error: error that was raised by validating a file.
        root: model of the whole file that it was validated against.

    Returns:
        Every problem with its key, the value as written, and what to write instead.
    """
    problems = []
    for found in error.errors(include_url=False):
        parts, value, kind = list(found["loc"]), found["input"], found["type"]
        if parts and parts[-1] == "[key]":  # the name of a surface rather than what it holds
            parts.pop()
        if kind == "missing":
            while isinstance(parts[-1], int):
                parts.pop()
            fix = f"missing; write {_assignment(parts, root)}"
            problems.append(Problem(key_path(parts), "", fix))
            continue
        if kind == "fault":
            fix, place = found["ctx"]["fix"], found["ctx"]["at"]
            # a validator's path, or a key of the user's own, which may have dots
            own = isinstance(value, dict) and place in value
            for part in [place] if own else place.split(".") if place else ():
                parts.append(part)
                value = value.get(part)
        elif kind == "extra_forbidden":
            fix = _unknown_key(parts, root)
        else:
            fix = f"not what is expected here; write {_assignment(parts, root)}"
        problems.append(Problem(key_path(parts), "" if value is None else shown(value), fix))
    return problems


def _unknown_key(parts: list[Any], root: type[BaseModel]) -> str:
    model, _ = _descend(parts[:-1], root)
    keys = list(_fields(model)) if model else []
    key = parts[-1].lower()
    if key.upper() in keys and key in keys:
        return f"given twice; keep either {key.upper()} or {key}"
    keys = [k for k in keys if k.upper() not in keys or k.isupper()]  # A, not also a
    near = [_OTHER_NAMES[key]] if _OTHER_NAMES.get(key) in keys else []
    near = near or difflib.get_close_matches(key, keys, 1, _ALIKE)
    known = f"known here: {', '.join(keys)}"
    if not near and (places := _places(root, key)):
        where = " or ".join(places[:3])
        return f"unknown key here; it belongs in {where} ({known})"
    near = near or difflib.get_close_matches(key, keys, 1)
    if near:
        return f'unknown key; did you mean "{near[0]}"?'
    return f"unknown key; leave it out ({known})"


def _places(model: type[BaseModel], key: str, table: str = "") -> list[str]:
    """The tables in which a key stands, by their paths: of each vehicle, of any surface."""
    found = []
    for name, field in _fields(model).items():
        if name == key:
            found.append(f"[{table}]" if table else "the file itself, above all tables")
        if (inner := _model_in(field.annotation)) is None:
            continue
        if name.lower() == "b" or (len(name) == 1 and name.islower()):  # has the keys of vehicle A
            continue
        own = f"{table}.{name}" if table else name
        own += ".NAME" if get_origin(field.annotation) is dict else ""
        found += _places(inner, key, own)
    return list(dict.fromkeys(found))


def _assignment(parts: list[Any], root: type[BaseModel]) -> str:
    while isinstance(parts[-1], int):
        parts = parts[:-1]
    _, field = _descend(parts, root)
    if field is None:  # a surface, under a name that the user chose
        example = '{ friction = "0.50 ± 0.03" }'
    elif field.examples:
        example = str(field.examples[0])
    else:
        example = next(f'"{kind.example}"' for kind in field.metadata if isinstance(kind, Kind))
    return f"{key_path(parts[-1:])} = {example}"


def _descend(
    parts: list[Any], root: type[BaseModel]
) -> tuple[type[BaseModel] | None, FieldInfo | None]:
    """The table that a key leads to, if it leads to one, and the field that the key is."""
    model: type[BaseModel] | None = root
    field: FieldInfo | None = None
    named = False  # the next part is a name that the user chose
    for part in parts:
        if isinstance(part, int):  # a place in a list
            continue
        if named:
            named, field = False, None
            continue
        if model:
            field = _fields(model).get(part)
        annotation = field.annotation if field else None
        named = get_origin(annotation) is dict
        model = _model_in(annotation)
    return model, field


def _fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    fields: dict[str, FieldInfo] = {}
    for name, field in model.model_fields.items():
        choices = getattr(field.validation_alias, "choices", None) or [field.alias or name]
        fields |= dict.fromkeys(choices, field)
    return fields


def _model_in(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((m for m in map(_model_in, get_args(annotation)) if m), None)
