"""Path of a muscle over its via points and wrap surfaces, as the dialog draws and measures it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..robot.model.pose import Vector3
from ..robot.model.transform import IDENTITY, Transform
from ..snapshot import SurfaceSnapshot
from .rows import WrapRow
from .table import MuscleTable
from .wrap_path import path_over


@dataclass(frozen=True, slots=True)
class MusclePath:
    """Path of a muscle.

    Attributes:
        points: Points of the path in the root frame, in [m]; arcs are polylines.
        length: Exact length, in [m].
        omitted: Number of wraps that the path does not contain: inside wraps, lost surfaces and
            all but one surface between the same two points.
    """

    points: list[Vector3]
    length: float
    omitted: int = 0

    @property
    def length_text(self) -> str:
        """The length in [mm], with a note if wraps are omitted."""
        note = f" ({self.omitted} wraps are not included)" if self.omitted else ""
        return f"{1000 * self.length:.1f} mm{note}"


def path_of(
    table: MuscleTable, muscle: str, moved: Mapping[str, Transform] | None = None
) -> MusclePath:
    """Return the path of a muscle without its lost points.

    Args:
        moved: Displacement of links from the pose of the design, in the root frame; links that are
            not listed do not move.
    """
    of = moved or {}
    points = [point for point in table.points_of(muscle) if not point.lost]
    places = [of.get(p.link, IDENTITY).apply(p.position) if of else p.position for p in points]
    uses = {use.after: (wrap, use) for wrap, use in table.wraps_of(muscle)}
    omitted = len(table.wraps_of(muscle)) - len(uses)
    path, length = places[:1], 0.0
    for point, start, end in zip(points, places, places[1:], strict=False):
        wrap, use = uses.get(point.number, (None, None))
        wrapped = None
        if wrap is not None and use is not None:
            if wrap.lost or use.inside:
                omitted += 1
            else:
                wrapped = path_over(start, end, _face(wrap, of), use)
        path += [*(wrapped.points if wrapped else ()), end]
        length += wrapped.length if wrapped else math.dist(start, end)
    return MusclePath(path, length, omitted)


def _face(wrap: WrapRow, moved: Mapping[str, Transform]) -> SurfaceSnapshot:
    """Return the surface at the displaced pose of its link."""
    T = moved.get(wrap.link)
    if T is None:
        return wrap.face
    return replace(wrap.face, centre=T.apply(wrap.face.centre), axis=T.rotate(wrap.face.axis))
