"""Self-contained HTML pages, which need no network."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from html import escape

from .overwrite import GENERATOR

# Browsers load only the contents of the page itself, and execute only scripts with known hashes.
# Event handlers in attributes, which a name in a file could contain, are never executed.
_POLICY = "default-src 'none'; script-src {scripts}; style-src 'unsafe-inline'; img-src data:"


def html_page(
    title: str,
    style: str,
    *parts: str,
    scripts: Sequence[str] = (),
    simulates: bool = False,
    connects: bool = False,
) -> str:
    """Return a page.

    Args:
        title: Title in plain text.
        scripts: Scripts that may be executed, in the page and in frames that it contains.
        simulates: Whether scripts of the page may start a worker with WebAssembly.
        connects: Whether scripts of the page may send requests to its server.
    """
    allowed = [_hash(script) for script in scripts]
    allowed += ["'wasm-unsafe-eval'", "blob:"] if simulates else []
    policy = _POLICY.format(scripts=" ".join(allowed) or "'none'")
    policy += "; worker-src blob:" if simulates else ""
    policy += "; connect-src 'self'" if connects else ""
    return "\n".join(
        (
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            GENERATOR,
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
            '<meta name="viewport" content="width=device-width">',
            f'<link rel="icon" href="data:,"><title>{escape(title)}</title>',
            f"<style>{style}</style></head><body>",
            *parts,
            "</body></html>",
            "",
        )
    )


def script_element(script: str) -> str:
    """Return a script as HTML."""
    return f"<script>{script}</script>"


def _hash(script: str) -> str:
    digest = hashlib.sha256(script.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"
