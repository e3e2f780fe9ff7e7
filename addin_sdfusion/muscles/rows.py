"""Rows of a muscle table: points and wrap surfaces with their positions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, replace

from ..robot.errors import InputError
from ..robot.model.pose import Vector3
from ..snapshot import (
    MuscleSnapshot,
    PointUse,
    SurfaceSnapshot,
    SurfaceUse,
    WrapUse,
)
from .point_names import natural_key


@dataclass(frozen=True, slots=True, kw_only=True)
class PointRow(PointUse):
    """The stored use of a point with its position; the occurrence is the one that contains it.

    Attributes:
        position: In the root frame, in [m].
        entity: Identifier of the point in the CAD system; empty if unknown.
        lost: Reason why the point was not found; empty if it was found. A lost point is stored
            unchanged until the user deletes it.
    """

    position: Vector3
    entity: str = ""
    lost: str = ""

    @property
    def use(self) -> PointUse:
        """The use to store on the point."""
        return PointUse(**{f.name: getattr(self, f.name) for f in fields(PointUse)})

    def on_link(self, link: str) -> PointRow:
        """Return the point fixed to another link.

        A construction point that the add-in created is created again in the component of the other
        link, so that it moves with that link.

        Raises:
            InputError: The point was not found.
        """
        self.require_found()
        moved = replace(self, link=link)
        return replace(moved, entity="", occurrence="", made=False) if self.made else moved

    def require_found(self) -> None:
        """Raise an InputError if the point was not found."""
        if self.lost:
            raise InputError(f"This point is not found: {self.lost}. Delete it or pick it again.")


@dataclass(frozen=True, slots=True, kw_only=True)
class WrapRow(SurfaceUse):
    """The stored use of a wrap surface, with its shape."""

    face: SurfaceSnapshot

    @property
    def use(self) -> SurfaceUse:
        """The use to store on the face."""
        return SurfaceUse(**{f.name: getattr(self, f.name) for f in fields(SurfaceUse)})

    @property
    def lost(self) -> str:
        """Reason why the face was not found; empty if it was found."""
        return self.face.lost


def change_uses(wrap: WrapRow, edit: Callable[[int, WrapUse], WrapUse | None]) -> WrapRow:
    """Return a wrap surface with edited uses; a use is deleted if `edit` returns None."""
    uses = [edit(i, use) for i, use in enumerate(wrap.muscles)]
    return replace(wrap, muscles=tuple(use for use in uses if use is not None))


def by_name(points: Iterable[PointRow]) -> tuple[PointRow, ...]:
    """Return task points and markers in the order of a table."""
    order = ("task", "marker")
    return tuple(
        sorted(points, key=lambda p: (order.index(p.role), natural_key(p.name), p.occurrence))
    )


def free_name(names: Sequence[str], rows: Sequence[MuscleSnapshot | PointUse | SurfaceUse]) -> str:
    """Return the first unused name; the number of names must exceed the number of rows."""
    used = {row.name for row in rows}
    return next(name for name in names if name not in used)
