"""Self-contained HTML pages: head, sections and tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from cardsflow_fmu.utils.html_page import html_page


class Markup(str):
    """HTML of a table cell that is not escaped."""


def page(title: str, *parts: str, scripts: Sequence[str] = ()) -> str:
    """Return a page without external addresses."""
    style = (files(__package__) / "report.css").read_text(encoding="utf-8")
    return html_page(title, style, *parts, scripts=scripts)


def section(title: str, *parts: str) -> str:
    """Return a section with a title."""
    return "\n".join(("<section>", f"<h2>{escape(title)}</h2>", *parts, "</section>"))


def collapsible_section(title: str, *parts: str) -> str:
    """Return a section that expands with a click on its title."""
    head = f"<details><summary><h2>{escape(title)}</h2></summary>"
    return "\n".join((head, *parts, "</details>"))


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Return a table with right-aligned numbers and dashes for None; empty without rows."""
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
