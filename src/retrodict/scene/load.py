"""Reading a scene file: its text, its tables and keys, its entries, its scene."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from retrodict.scene.errors import Problem, SceneError, shown
from retrodict.scene.records import Scene
from retrodict.scene.units import LENGTH, Dimension, in_unit_of

# text and the name of its file -> the tables and keys of a scene file; raises SceneError
Reader = Callable[[str, str], dict[str, Any]]

_FILE_BYTES = 100_000
_LINE_LENGTH = 2_000  # the parser's time grows with the square of a dotted key's length
_TOO_LONG = f"longer than {_FILE_BYTES} bytes; a scene file is a page of text"


def as_scene(scene: Scene | str | Path) -> Scene:
    """A scene as it is, or the one in the scene file at a path.

    Args:
        scene: measured scene, or the path of a scene file.

    Returns:
        The scene.

    Raises:
        SceneError: the file cannot be read, or something in it is wrong.
    """
    return scene if isinstance(scene, Scene) else load_scene(scene)


def load_scene(path: str | Path) -> Scene:
    """A scene from a scene file.

    Args:
        path: path of a file that one of `READERS` reads, by its suffix; any other suffix is read as
            TOML. The keys are described in docs/scene-file.md.

    Returns:
        The scene in SI units and radians, named after the file, or after its folder where the file
        is called scene.toml.

    Raises:
        SceneError: the file cannot be read, or something in it is wrong.

    Examples:
        >>> import retrodict as rd
        >>> scene = rd.load_scene("examples/brach-1977/scene.toml")
        >>> scene.name, round(scene.approach["a"].speed.value, 1)  # m/s
        ('brach-1977', 20.1)
    """
    stem = Path(path).stem
    name = stem if stem != "scene" else Path(path).resolve().parent.name
    reader = READERS.get(Path(path).suffix.lower(), toml_of)
    text = read_text(path)
    return scene_from(reader(text, str(path)), name, text, str(path))


def read_text(path: str | Path, kind: str = "scene file") -> str:
    """The text of a file that somebody wrote by hand.

    Args:
        path: path of the file.
        kind: kind of file, for messages.

    Returns:
        The text.

    Raises:
        SceneError: there is no such file, or it is too long, or no text.
    """
    try:
        if not Path(path).is_file():
            what = "not a file" if Path(path).exists() else "no such file"
            what = "is a folder" if Path(path).is_dir() else what
            raise _file_error(path, f"{what}; write the path of a {kind}")
        with open(path, "rb") as file:
            raw = file.read(_FILE_BYTES + 1)
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        # a byte above the limit may have cut a character in two
        if len(raw) > _FILE_BYTES:
            raise _file_error(path, _TOO_LONG) from None
        line = raw.count(b"\n", 0, error.start) + 1
        raise _file_error(path, f"line {line} is not UTF-8 text; save the file as UTF-8") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "not a path"
        raise _file_error(
            path, f"cannot be read ({reason}); correct the path or the permissions"
        ) from None
    return text


def parse_scene(text: str, name: str) -> Scene:
    """A scene from the text of a scene file.

    Args:
        text: TOML, see `load_scene`.
        name: short identifier of the scene, which also stands for the file in error messages.

    Returns:
        The scene in SI units and radians.

    Raises:
        SceneError: something in it is wrong.

    Examples:
        >>> from pathlib import Path
        >>> import retrodict as rd
        >>> text = Path("examples/brach-1977/scene.toml").read_text("utf-8")
        >>> rd.parse_scene(text.replace("44.96", "50"), "faster").name
        'faster'
        >>> rd.parse_scene("schema = 1", "empty")
        Traceback (most recent call last):
            ...
        retrodict.scene.errors.SceneError: empty: ...
    """
    text = text.removeprefix("\ufeff")
    return scene_from(tables_of(text, name), name, text, name)


def _file_error(path: str | Path, fix: str) -> SceneError:
    return SceneError(str(path), [Problem("", "", fix)])


def scene_from(document: dict[str, Any], name: str, text: str, file: str) -> Scene:
    """A scene from the tables and keys of a scene file.

    Args:
        document: tables and keys of the file, as TOML or another program wrote them.
        name: short identifier of the scene.
        text: the file as it was written.
        file: name of the file, for messages.

    Returns:
        The scene in SI units and radians.

    Raises:
        SceneError: something in it is wrong.
    """
    # pydantic takes a while to import; whoever needs only the records does not wait for it
    from pydantic import ValidationError

    from retrodict.scene.build import scene_of
    from retrodict.scene.explain import problems_of
    from retrodict.scene.schema import validated

    try:
        entry = validated(document)
    except ValidationError as error:
        raise SceneError(file, problems_of(error)) from None
    problems: list[Problem] = []

    def complain(key: str, fix: str, amount: float = 0.0, dimension: Dimension = LENGTH) -> None:
        raw = value_at(document, key)
        written = in_unit_of(raw, amount, dimension)
        # what a class fills in is not written
        value = "" if raw is None else shown(raw)
        problems.append(Problem(key, value, fix.format(amount=written)))

    scene = scene_of(entry, name, text, complain)
    if problems:
        raise SceneError(file, problems)
    return scene


def toml_of(text: str, file: str) -> dict[str, Any]:
    """The tables and keys of a TOML text.

    Args:
        text: text of the file, as written.
        file: name of the file, for messages.

    Returns:
        The tables and keys.

    Raises:
        SceneError: the text is too long, or not valid TOML.
    """
    if len(text) > _FILE_BYTES:
        raise _file_error(file, _TOO_LONG)
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):
        if len(line) > _LINE_LENGTH:
            fix = f"longer than {_LINE_LENGTH} characters; break the line"
            raise SceneError(file, [Problem(f"line {number}", shown(line), fix)])
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise _file_error(file, "nested too deeply; a scene file has tables in tables") from None
    except ValueError as error:  # TOMLDecodeError, or a number of more digits than Python reads
        said = re.fullmatch(r"(.*) \(at (line (\d+), column \d+)\)", str(error), re.DOTALL)
        reason, place, line = said.group(1, 2, 3) if said else (str(error), "", "")
        value = shown(lines[int(line) - 1].strip()) if line else ""
        fix = _fix_of(reason, lines[int(line) - 1] if line else "")
        problem = Problem(place, value, f"not valid TOML ({shown(reason)[1:-1]}); {fix}")
        raise SceneError(file, [problem]) from None


def _fix_of(reason: str, line: str) -> str:
    """Advice on a line that is not TOML."""
    if "declare" in reason or "overwrite" in reason:
        return "write every table and key once"
    if re.search("[“”„«»‘]", line):
        return 'these are typographic quotes; write straight ones: "'
    if re.search(r"=\s*[+-]?[0-9]+,[0-9]", line):
        return "write a decimal point, no comma"
    if re.search("[\u00a0\u2007\u202f\u200b\ufeff]", line.partition('"')[0]):
        return (
            "the line has a space that is no plain one (as word processors write it); type it anew"
        )
    if re.search(r"=\s*[–—−]", line):
        return "this is a dash; write a minus sign: -"
    return 'text and quantities stand in quotes, like mass = "1857 ± 37 kg"'


# so that a text is not read again at each change of its scene; callers must not alter the tables
tables_of = lru_cache(maxsize=8)(toml_of)


# readers by suffix; a reader of another format is a file of its own and a line here
READERS: dict[str, Reader] = {".toml": toml_of}


def value_at(document: Mapping[str, Any], key: str) -> Any:
    """The value at a dotted key of a scene file's tables, where a vehicle may be A or a.

    Args:
        document: the tables and keys.
        key: dotted key, such as "vehicles.A.mass" or "impact.point[0]".

    Returns:
        The value as TOML has it; None where there is none.
    """
    value: Any = document
    for part in re.findall(r"[^.\[\]]+", key):
        try:
            if isinstance(value, list):
                value = value[int(part)]
            else:
                value = value[part] if part in value else value[part.lower()]
        except (KeyError, IndexError, TypeError):
            return None
    return value
