"""Moved positions that are not captured; tangent relationships."""

from __future__ import annotations

from typing import Any

from ..base import Base, api, new
from ..collections_ import Items, named
from ..state import world
from .data import DesignData, OccurrenceData


def moved(design: DesignData) -> list[OccurrenceData]:
    """Return the occurrences that were moved without capturing the position."""
    held = [o for c in design.components for o in c.occurrences]
    return [o for o in held if o.captured is not None]


def revert(design: DesignData) -> None:
    """Revert positions that are not captured, like an edit of a parametric design."""
    for occurrence in moved(design) if design.kind == 1 else ():
        world().set(occurrence, "T", occurrence.captured, "revert")
        world().set(occurrence, "captured", None, "revert")


@api("adsk.fusion")
class Snapshots(Base):
    """Captured positions of a design."""

    hasPendingSnapshot = property(lambda self: bool(moved(self._design)))

    def add(self) -> Any:
        for occurrence in moved(self._design):
            world().set(occurrence, "captured", None, "Snapshots.add")
        return new(Snapshot)


@api("adsk.fusion")
class Snapshot(Base):
    """A captured position."""


@api("adsk.fusion")
class TangentRelationship(Base):
    """Tangent relationship, only a name in the fake."""

    name = property(lambda self: self._name)


@api("adsk.fusion")
@named
class TangentRelationships(Items):
    def _all(self) -> list[Any]:
        return [new(TangentRelationship, name=n) for n in self._component.tangents]
