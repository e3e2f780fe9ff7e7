"""The replay page, which opens from disk and needs no network."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from importlib.resources import files

from cardsflow_fmu.utils.overwrite import GENERATOR

from .page_data import Act, encode

_PARTS = files(__package__) / "page_parts"
_SCRIPTS = ("decode.js", "bodies.js", "drawing.js", "camera.js", "controls.js", "replay.js")

# Nothing but what stands in the page itself may be loaded, whatever the page is opened from.
_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"


def replay_page(acts: Sequence[Act]) -> str:
    """A page that shows motions side by side, with play, scrub, speed and switches."""
    title = escape(" and ".join(act.title for act in acts))
    data = base64.b64encode(encode(acts)).decode()
    script = "\n".join(_part(name) for name in _SCRIPTS)
    return "\n".join(
        (
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            GENERATOR,
            f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
            '<meta name="viewport" content="width=device-width">',
            f'<link rel="icon" href="data:,"><title>{title}</title>',
            f"<style>{_part('page.css')}</style></head><body>",
            "<noscript>The replay is drawn by the script in this page: allow it.</noscript>",
            f'<script type="text/plain" id="motion">{data}</script>',
            f"<script>\n'use strict';\n{script}</script>",
            "</body></html>",
            "",
        )
    )


def _part(name: str) -> str:
    return (_PARTS / name).read_text(encoding="utf-8")
