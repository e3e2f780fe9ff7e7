"""Self-contained HTML page of a replay, and the page that follows a run."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from importlib.resources import files

from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.utils.html_page import html_page, script_element

from .page_data import encode

_HERE = files(__package__)
SHARED_SCRIPTS = (
    *("decode.js", "bodies.js", "drawing.js", "camera.js", "controls.js", "tooltip.js"),
    *("plots.js", "scene.js"),
)
"""Scripts of replays and of pages that simulate."""
_SCRIPTS = (*SHARED_SCRIPTS, "muscle_table.js", "stream.js", "replay.js")


def replay_page(acts: Sequence[Act], *, follows: bool = False) -> str:
    """Return a page that shows motions side by side, with player controls.

    Args:
        acts: The motions.
        follows: Whether the page shows the frames that its server sends, see `stream_frames`.
    """
    title = " and ".join(act.title for act in acts)
    data = base64.b64encode(encode(acts)).decode()
    return html_page(
        title,
        page_part("page.css"),
        "<noscript>This replay requires JavaScript; allow scripts for this page.</noscript>",
        f'<script type="text/plain" id="motion">{data}</script>',
        *(['<script type="text/plain" id="follows"></script>'] if follows else []),
        script_element(replay_script()),
        scripts=(replay_script(),),
        connects=follows,
    )


def replay_script() -> str:
    """Return the script of a replay page."""
    return strict_script(_SCRIPTS)


def strict_script(names: Sequence[str]) -> str:
    """Return a script from parts, in strict mode."""
    return "\n".join(("'use strict';", *map(page_part, names)))


def page_part(name: str) -> str:
    """Return a script or style sheet of pages, such as `page.css` or `play_parts/play.css`."""
    part = _HERE / name if "/" in name else _HERE / "page_parts" / name
    return part.read_text(encoding="utf-8")
