"""Replacement of a part, and of the parts in it, by another part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ....muscles.mirror import FindFace
from ....muscles.point_names import natural_key
from ....muscles.rows import PointRow, WrapRow
from ....muscles.table import MuscleTable
from ....robot.errors import InputError
from ....robot.model.transform import Transform
from ....snapshot import COPY, HIDDEN_KEY, KEPT
from .model import MuscleModel


def used_parts(table: MuscleTable) -> list[str]:
    """Return the paths of all parts with points or wrap surfaces, also of parts not found."""
    paths: set[str] = set()
    for path in _parts(table):
        while path:
            paths.add(path)
            path = path.rpartition("+")[0]
    return sorted(paths, key=natural_key)


def replace_part(
    model: MuscleModel, old: str, new: str, poses: Mapping[str, Transform], find_face: FindFace
) -> None:
    """Move all points and wrap surfaces of one part to the same place on another part.

    Those on parts in it, such as `leg:1+foot:1`, move to the part of the same name in the other
    part. Points that are not found are repaired. Points and surfaces whose place is unknown are
    unchanged.

    Args:
        old: Path of the part to replace, which may not exist any more.
        new: Path of the other part.
        poses: Pose of each part in the root frame, by path.
        find_face: Finds the face of the new part at the place of a wrap surface.

    Raises:
        InputError: The parts are equal, or the new part does not exist.
    """
    if not old or old == new or new not in poses:
        raise InputError("Choose the part to replace and another part.")
    before, swap = model.table, _Swap(old, new, poses, model.link_of, find_face)
    model.table = replace(
        before,
        points=tuple(map(swap.point, before.points)),
        others=tuple(map(swap.point, before.others)),
        wraps=tuple(map(swap.wrap, before.wraps)),
    )
    of_part = [path for path in _parts(before) if _is_in(path, old)]
    pairs = zip(_parts(before), _parts(model.table), strict=True)
    moved = sum(path != other for path, other in pairs)
    model.message = f"{moved} points and surfaces of {old} are moved to {new}."
    if moved < len(of_part):
        model.message += (
            f" {len(of_part) - moved} are unchanged, since their place on {new} is unknown; pick "
            "them again."
        )


@dataclass(frozen=True, slots=True)
class _Swap:
    """Replacement of a part; the attributes are the arguments of `replace_part`."""

    old: str
    new: str
    poses: Mapping[str, Transform]
    link_of: Mapping[str, str]
    find_face: FindFace

    def point(self, row: PointRow) -> PointRow:
        target = self._target(row.occurrence)
        T = self._motion(row.occurrence, target, bool(row.lost))
        if T is None or (row.lost and not _has_place_on_part(row)):
            return row
        link, at = self.link_of[target], T.apply(row.position)
        moved = replace(row, link=link, occurrence=target, position=at, lost="")
        return replace(moved, entity="", made=False, original="")

    def wrap(self, row: WrapRow) -> WrapRow:
        target = self._target(row.occurrence)
        T = self._motion(row.occurrence, target, is_on_part=False)
        if T is None or row.lost:
            return row
        centre, axis = T.apply(row.face.centre), T.rotate(row.face.axis)
        link = self.link_of[target]
        face = self.find_face(link, replace(row.face, centre=centre, axis=axis))
        return row if face is None else replace(row, link=link, occurrence=target, face=face)

    def _target(self, path: str) -> str:
        """Return the new path of a part; empty if it is not replaced or does not exist."""
        target = self.new + path.removeprefix(self.old)
        exists = target in self.poses and target in self.link_of
        return target if _is_in(path, self.old) and exists else ""

    def _motion(self, path: str, target: str, is_on_part: bool) -> Transform | None:
        """Return the transform of positions to the new part in the root frame.

        Args:
            target: Path of the new part, or empty.
            is_on_part: Whether positions are in the frame of the part instead of the root frame.
        """
        if not target:
            return None
        if is_on_part:
            return self.poses[target]
        return (
            self.poses[target].compose(self.poses[path].inverse()) if path in self.poses else None
        )


def _parts(table: MuscleTable) -> list[str]:
    """Return the part of each point and wrap surface."""
    points = [row.occurrence for row in (*table.points, *table.others)]
    return [*points, *(wrap.occurrence for wrap in table.wraps)]


def _is_in(path: str, part: str) -> bool:
    return path == part or path.startswith(f"{part}+")


def _has_place_on_part(row: PointRow) -> bool:
    """Return whether the position of a point that is not found is in the frame of its part."""
    return row.entity.startswith((KEPT, HIDDEN_KEY)) and not row.lost.startswith(COPY)
