"""Conversion of link numbers in CASPR files to links."""

from __future__ import annotations

from collections.abc import Sequence

from ...model.robot import Link
from ..reading.xml import Node


def link_by_number(node: Node, links: Sequence[Link]) -> Link | None:
    """Return the link in <link> of an element; None for 0, the base, or an unknown number."""
    number = node.integer("link")
    if number is None or number == 0:
        return None
    if number > len(links):
        node.error("unknown-link", f"unknown link {number}; known: 1 to {len(links)}")
        return None
    return links[number - 1]
