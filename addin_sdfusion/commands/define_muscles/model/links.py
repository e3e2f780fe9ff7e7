"""Replacement of links by other links, and of parts by other parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ....muscles.mirror import FindFace
from ....muscles.point_names import natural_key
from ....muscles.rows import PointRow, WrapRow
from ....muscles.table import MuscleTable
from ....robot.errors import InputError
from ....robot.model.transform import Transform
from ....snapshot import COPY, HIDDEN_KEY, KEPT
from .model import MuscleModel


def used_links(table: MuscleTable) -> list[str]:
    """Return the links of all points and wrap surfaces that were found."""
    links = {p.link for p in (*table.points, *table.others) if not p.lost}
    return sorted(links | {w.link for w in table.wraps if not w.lost}, key=natural_key)


def replace_link(model: MuscleModel, old: str, new: str) -> None:
    """Move all points and wrap surfaces of one link to another link.

    Args:
        model: The model.
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
        there = link(point.occurrence)
        is_there = there == link_of.get(point.occurrence)
        return replace(point, link=there) if is_there else point.on_link(there)

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


def used_parts(table: MuscleTable) -> list[str]:
    """Return the paths of the parts of all points and wrap surfaces, also of those not found."""
    return sorted(set(_parts(table)) - {""}, key=natural_key)


def _parts(table: MuscleTable) -> list[str]:
    """Return the part of each point and wrap surface."""
    points = [row.occurrence for row in (*table.points, *table.others)]
    return [*points, *(wrap.occurrence for wrap in table.wraps)]


def replace_part(
    model: MuscleModel, old: str, new: str, poses: Mapping[str, Transform], find_face: FindFace
) -> None:
    """Move all points and wrap surfaces of one part to the same place on another part.

    Points that are not found are repaired. Points and surfaces whose place on the part is unknown
    are unchanged.

    Args:
        model: The model.
        old: Path of the part to replace, which may not exist any more.
        new: Path of the other part.
        poses: Pose of each part in the root frame, by path.
        find_face: Finds the face of the new part at the place of a wrap surface.

    Raises:
        InputError: The parts are equal, or the new part does not belong to a link.
    """
    link = model.link_of.get(new, "")
    if not old or old == new:
        raise InputError("Choose the part to replace and another part.")
    if not link or new not in poses:
        raise InputError(f"{new} does not belong to a link: add it to a rigid group EXPORT_<link>.")
    T_new_old = poses[new].compose(poses[old].inverse()) if old in poses else None

    def move(row: PointRow) -> PointRow:
        if row.occurrence != old:
            return row
        if row.lost:
            at = poses[new].apply(row.position) if _has_place_on_part(row) else None
        else:
            at = T_new_old.apply(row.position) if T_new_old is not None else None
        if at is None:
            return row
        moved = replace(row, link=link, occurrence=new, position=at, lost="")
        return replace(moved, entity="", made=False, original="")

    def move_wrap(row: WrapRow) -> WrapRow:
        if row.occurrence != old or row.lost or T_new_old is None:
            return row
        centre, axis = T_new_old.apply(row.face.centre), T_new_old.rotate(row.face.axis)
        face = find_face(link, replace(row.face, centre=centre, axis=axis))
        return row if face is None else replace(row, link=link, occurrence=new, face=face)

    table = model.table
    model.table = replace(
        table,
        points=tuple(map(move, table.points)),
        others=tuple(map(move, table.others)),
        wraps=tuple(map(move_wrap, table.wraps)),
    )
    before, left = (_parts(t).count(old) for t in (table, model.table))
    model.message = f"{before - left} points and surfaces of {old} are moved to {new}."
    if left:
        model.message += f" {left} are unchanged: their place on {old} is unknown; pick them again."


def _has_place_on_part(row: PointRow) -> bool:
    """Return whether the position of a point that is not found is in the frame of its part."""
    return row.entity.startswith((KEPT, HIDDEN_KEY)) and not row.lost.startswith(COPY)
