"""Links by CASPR's link numbers."""

from __future__ import annotations

from collections.abc import Sequence

from ...model.robot import Link
from ..reading.xml import Node


def link_by_number(node: Node, links: Sequence[Link]) -> Link | None:
    """The link that an element's <link> numbers; None for 0, the base, and if there is none."""
    number = node.integer("link")
    if number is None or number == 0:
        return None
    if number > len(links):
        node.error("unknown-link", f"no link {number}; the robot has links 1 to {len(links)}")
        return None
    return links[number - 1]
