"""Rigid groups."""

from __future__ import annotations

from typing import Any

from ..base import api, edited, new
from .data import GroupData
from .entity import WithName, WithVisibility, occurrence, wraps
from .joints import Sibling


@api("adsk.fusion")
@wraps(GroupData)
class RigidGroup(Sibling, WithVisibility):
    """Rigid group. Obsolete groups have no members, and name and token raise [live]."""

    def _shelf(self) -> list[Any]:
        return self._data.component.groups

    @property
    def occurrences(self) -> Any:
        from .component import OccurrenceList

        path, members = self._path, [] if self._data.stale else self._data.members
        return new(OccurrenceList, make=lambda: [occurrence((*path, *m)) for m in members])

    @property
    def name(self) -> str:
        self._reject_stale("name")
        return self._data.name

    @name.setter
    def name(self, value: str) -> None:
        self._reject_stale("name")
        WithName.name.fset(self, value)

    def _reject_stale(self, member: str) -> None:
        if self._data.stale:
            raise RuntimeError(f"2 : InternalValidationError : RigidGroup.{member}")

    isSuppressed = edited("data.suppressed", "bool", "isSuppressed")
