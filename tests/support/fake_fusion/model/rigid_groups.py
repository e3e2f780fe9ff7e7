"""Rigid groups."""

from __future__ import annotations

from typing import Any

from ..base import api, edited, new
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

    isSuppressed = edited("data.suppressed", "bool", "isSuppressed")
