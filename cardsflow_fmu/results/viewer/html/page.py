"""Self-contained HTML page of a replay, and the page that follows a run."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from importlib.resources import files

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.utils.html_page import html_page, script_element

from .page_data import encode

_HERE = files(__package__)
SHARED_SCRIPTS = (
    *("decode.js", "bodies.js", "drawing.js", "camera.js", "controls.js", "tooltip.js"),
    *("plots.js", "scene.js"),
)
"""Scripts of replays and of pages that simulate."""
EDITING_SCRIPTS = ("links.js", "widgets.js")
"""Scripts of pages in which a user changes something."""
_SCRIPTS = (*SHARED_SCRIPTS, "muscle_table.js", "stream.js", "replay.js")


def replay_page(acts: Sequence[Act], *, follows: bool = False) -> str:
    """Return a page that shows motions side by side, with player controls.

    Args:
        follows: Whether the page shows the frames that its server sends, see `stream_frames`.
    """
    title = " and ".join(act.title for act in acts)
    data = base64.b64encode(encode(acts)).decode()
    texts = {"motion": data} | ({"follows": ""} if follows else {})
    return page_with(title, ("page.css",), texts, replay_script(), connects=follows)


def page_with(
    title: str,
    styles: Sequence[str],
    texts: Mapping[str, str],
    script: str,
    *,
    simulates: bool = False,
    connects: bool = False,
) -> str:
    """Return a page with a script and its data; see also `html_page`.

    Args:
        styles: Names of style sheets, as for `page_part`.
        texts: Data for the script, by the ids of their elements; without the character `<`, except
            for scripts.
    """
    data = (f'<script type="text/plain" id="{id_}">{text}</script>' for id_, text in texts.items())
    return html_page(
        title,
        "".join(map(page_part, styles)),
        "<noscript>This page requires JavaScript; allow scripts for this page.</noscript>",
        *data,
        script_element(script),
        scripts=(script,),
        simulates=simulates,
        connects=connects,
    )


def replay_script() -> str:
    """Return the script of a replay page."""
    return strict_script(_SCRIPTS)


def strict_script(names: Sequence[str]) -> str:
    """Return a script from parts, in strict mode."""
    return "\n".join(("'use strict';", *map(page_part, names)))


def data_json(data: object) -> str:
    """Return data as JSON that cannot end an element."""
    return json_text(data).replace("<", "\\u003c")


def page_part(name: str) -> str:
    """Return a script or style sheet of pages, such as `page.css` or `play_parts/play.css`."""
    file = _HERE / name if "/" in name else _HERE / "page_parts" / name
    return file.read_text(encoding="utf-8")
