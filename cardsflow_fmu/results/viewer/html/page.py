"""Self-contained HTML page of a replay."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from importlib.resources import files

from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.utils.html_page import html_page

from .page_data import encode

_PARTS = files(__package__) / "page_parts"
_SCRIPTS = ("decode.js", "bodies.js", "drawing.js", "camera.js", "controls.js", "replay.js")


def replay_page(acts: Sequence[Act]) -> str:
    """Return a page that shows motions side by side, with player controls."""
    title = " and ".join(act.title for act in acts)
    data = base64.b64encode(encode(acts)).decode()
    script = "\n".join(page_part(name) for name in _SCRIPTS)
    return html_page(
        title,
        page_part("page.css"),
        "<noscript>This replay requires JavaScript; allow scripts for this page.</noscript>",
        f'<script type="text/plain" id="motion">{data}</script>',
        f"<script>\n'use strict';\n{script}</script>",
    )


def page_part(name: str) -> str:
    """Return a script or style sheet of pages."""
    return (_PARTS / name).read_text(encoding="utf-8")
