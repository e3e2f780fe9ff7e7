"""Rigid groups."""

from __future__ import annotations

from typing import Any

from ..base import api, new
from ..state import world
from .data import GroupData
from .entity import WithVisibility, occurrence, wraps
from .joints import Sibling


@api("adsk.fusion")
@wraps(GroupData)
class RigidGroup(Sibling, WithVisibility):
    def _shelf(self) -> list[Any]:
        return self._data.component.groups

    @property
    def occurrences(self) -> Any:
        from .component import OccurrenceList

        path, members = self._path, self._data.members
        return new(OccurrenceList, make=lambda: [occurrence((*path, *m)) for m in members])

    @property
    def isSuppressed(self) -> bool:
        return self._data.suppressed

    @isSuppressed.setter
    def isSuppressed(self, value: bool) -> None:
        world().set(self._data, "suppressed", value, "RigidGroup.isSuppressed")
