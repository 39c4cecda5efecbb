"""A document as one HTML page that needs nothing else and loads nothing."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING

from markupsafe import Markup

from retrodict.report.templates import template

if TYPE_CHECKING:
    from retrodict.report.blocks import Document


def render(document: Document) -> bytes:
    """The HTML page of a document.

    Args:
        document: document to render; every text is escaped.

    Returns:
        HTML in UTF-8; the page loads nothing, and no script but the replay's may run in it.
    """
    scripts = ""
    if document.replay:
        from retrodict.report.replay_html import replay_script_hash  # matplotlib is slow to import

        scripts = f"script-src {replay_script_hash()}; "
    page = template("document.html.j2").render(
        document=document,
        replay=Markup(document.replay),
        scripts=scripts,
        kind=lambda block: type(block).__name__,
        encoded=lambda image: base64.b64encode(image).decode("ascii"),
    )
    return page.encode()
