"""How Sphinx builds the site.

python3 -m uv run --group docs sphinx-build -W --keep-going -b html docs out/site
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import retrodict

DOCS = Path(__file__).parent
ROOT = DOCS.parent

project = "retrodict"
author = "the retrodict developers"
copyright = "the retrodict developers, Apache-2.0"
release = version = retrodict.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_heading_anchors = 4
# tables and figures of measurements stand among the pages
exclude_patterns = ["charts", "pictures"]

default_role = "py:obj"  # `name` in a docstring is a link where that name is documented
python_use_unqualified_type_names = True
autodoc_member_order = "bysource"
napoleon_use_rtype = False

html_theme = "furo"
html_title = "retrodict"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False

# pages that stand outside docs/, and where they are on the site; the page there holds a link alone
OUTSIDE = {
    "README.md": "index",
    "CONTRIBUTING.md": "contributing",
    "CHANGELOG.md": "changes",
    "benchmarks/README.md": "benchmarks",
    "examples/README.md": "examples/index",
    "examples/brach-1977/README.md": "examples/brach-1977",
    "examples/brach-1977-berm/README.md": "examples/brach-1977-berm",
    "examples/iihs-cf10028-barrier/README.md": "examples/iihs-cf10028-barrier",
}
_LINK = re.compile(r"(\]\()([^)#\s:]+)(#[^)\s]*)?(\))")


def read_outside(app: Any, page: str, source: list[str]) -> None:
    """Put pages from outside docs/ in their places, and lead links to them there."""
    origin, folder = DOCS / f"{page}.md", (DOCS / page).parent
    for path, home in OUTSIDE.items():
        if home == page != "index":
            origin = ROOT / path
            app.env.note_dependency(str(origin))
            source[0] = origin.read_text("utf-8")

    def moved(link: re.Match[str]) -> str:
        opening, target, heading, closing = link.groups()
        path = Path(os.path.normpath(origin.parent / target))
        home = OUTSIDE.get(path.relative_to(ROOT).as_posix())
        path = DOCS / f"{home}.md" if home else path
        return f"{opening}{os.path.relpath(path, folder)}{heading or ''}{closing}"

    source[0] = _LINK.sub(moved, source[0])


def plain_text(
    app: Any, what: str, name: str, item: object, options: object, lines: list[str]
) -> None:
    """Docstrings are plain text: |x| and N* are no markup."""
    lines[:] = [re.sub(r"[|*]", r"\\\g<0>", line) for line in lines]


def skip_fields(app: Any, what: str, name: str, item: object, skip: bool, options: object) -> bool:
    """The fields of a named tuple are explained by its docstring."""
    return skip or type(item).__name__ == "_tuplegetter"


def setup(app: Any) -> None:
    """Connect the functions above."""
    app.connect("source-read", read_outside)
    app.connect("autodoc-process-docstring", plain_text, priority=400)  # before napoleon
    app.connect("autodoc-skip-member", skip_fields)
