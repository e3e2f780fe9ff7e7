"""Self-contained HTML pages, which need no network."""

from __future__ import annotations

from html import escape

from .overwrite import GENERATOR

# Browsers load only the contents of the page itself.
_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"


def html_page(title: str, style: str, *parts: str) -> str:
    """Return a page with a title in plain text, a style sheet, and parts in HTML."""
    return "\n".join(
        (
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            GENERATOR,
            f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
            '<meta name="viewport" content="width=device-width">',
            f'<link rel="icon" href="data:,"><title>{escape(title)}</title>',
            f"<style>{style}</style></head><body>",
            *parts,
            "</body></html>",
            "",
        )
    )
