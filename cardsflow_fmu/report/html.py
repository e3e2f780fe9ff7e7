"""Pages that open offline: head, sections and tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from cardsflow_fmu.utils.overwrite import GENERATOR

# Only what is in the page itself may be loaded.
_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"


class Markup(str):
    """HTML for a cell of a table, which is not escaped."""


def page(title: str, *parts: str) -> str:
    """A page, which names no address.

    Args:
        title: Plain text.
        parts: HTML.
    """
    style = (files(__package__) / "report.css").read_text(encoding="utf-8")
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


def section(title: str, *parts: str) -> str:
    """A part of a page under its title."""
    return "\n".join(("<section>", f"<h2>{escape(title)}</h2>", *parts, "</section>"))


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table; numbers stand right, None is a dash; empty without rows.

    Args:
        heads: Of the columns.
        rows: Texts, numbers, `Markup` or None.
    """
    body = ["<tr>" + "".join(map(_cell, row)) + "</tr>" for row in rows]
    if not body:
        return ""
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    return "\n".join((f"<table><thead><tr>{head}</tr></thead><tbody>", *body, "</tbody></table>"))


def _cell(value: Any) -> str:
    if value is None:
        return "<td>-</td>"
    if isinstance(value, Markup):
        return f"<td>{value}</td>"
    if isinstance(value, int | float) and not isinstance(value, bool):
        text = f"{value:.6g}" if math.isfinite(value) else "unlimited"
        return f'<td class="number">{text}</td>'
    return f"<td>{escape(str(value))}</td>"
