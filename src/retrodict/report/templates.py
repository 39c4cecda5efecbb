"""Templates of HTML, in which every text is escaped."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined, Template


@cache
def template(name: str) -> Template:
    """A template of this package.

    Args:
        name: file name of the template.
    """
    environment = Environment(
        loader=PackageLoader("retrodict.report", "."),
        autoescape=True,  # titles, notes and sources are a stranger's text
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(name)
