"""Templates and styles of the pages."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

_PACKAGE = "retrodict.explore"


def text_of(name: str, package: str = _PACKAGE) -> str:
    """The text of a file of a package.

    Args:
        name: name of the file.
        package: name of the package.
    """
    return files(package).joinpath(name).read_text("utf-8")


@cache
def template(name: str) -> Template:
    """A template of the pages, which escapes every text.

    Args:
        name: name of the template.
    """
    environment = Environment(
        loader=PackageLoader(_PACKAGE, "."),
        autoescape=True,  # what it shows of a scene is a stranger's text
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(name)
