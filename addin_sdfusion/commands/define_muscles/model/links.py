"""Replacement of links by other links."""

from __future__ import annotations

from dataclasses import replace

from ....muscles.point_names import natural_key
from ....muscles.rows import PointRow
from ....muscles.table import MuscleTable
from ....robot.errors import InputError
from .model import MuscleModel


def used_links(table: MuscleTable) -> list[str]:
    """Return the links of all points and wrap surfaces that were found."""
    links = {p.link for p in (*table.points, *table.others) if not p.lost}
    return sorted(links | {w.link for w in table.wraps if not w.lost}, key=natural_key)


def replace_link(model: MuscleModel, old: str, new: str) -> None:
    """Move all points and wrap surfaces of one link to another link.

    Args:
        old: The link to replace, which may not exist any more.
        new: The other link; empty for the link of each part.
    """
    if not old or old == new:
        raise InputError("Choose the link to replace and another link.")
    table, link_of = model.table, model.link_of

    def link(occurrence: str) -> str:
        return new or link_of.get(occurrence, old)

    def move(point: PointRow) -> PointRow:
        if point.link != old or point.lost:
            return point
        new_link = link(point.occurrence)
        is_part_link = new_link == link_of.get(point.occurrence)
        return replace(point, link=new_link) if is_part_link else point.on_link(new_link)

    model.table = replace(
        table,
        points=tuple(map(move, table.points)),
        others=tuple(map(move, table.others)),
        wraps=tuple(
            replace(w, link=link(w.occurrence)) if w.link == old and not w.lost else w
            for w in table.wraps
        ),
    )
    model.message = f"Link {old} is replaced by {new or 'the link of each part'}."
