"""Self-contained HTML pages, which need no network."""

from __future__ import annotations

from html import escape

from .overwrite import GENERATOR

# Browsers load only the contents of the page itself.
_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
# A page that simulates compiles WebAssembly, and starts a worker from its own text.
_SIMULATES = _POLICY.replace("'unsafe-inline';", "'unsafe-inline' 'wasm-unsafe-eval' blob:;", 1)
_SIMULATES += "; worker-src blob:"


def html_page(title: str, style: str, *parts: str, simulates: bool = False) -> str:
    """Return a page.

    Args:
        title: Title in plain text.
        style: Style sheet.
        parts: Parts in HTML.
        simulates: Whether scripts of the page may start a worker with WebAssembly.
    """
    policy = _SIMULATES if simulates else _POLICY
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
