"""Timeline objects, with the health state of entities that do not have it themselves."""

from __future__ import annotations

from typing import Any

from ..base import Base, api, new
from .entity import Seen


@api("adsk.fusion")
class TimelineObject(Base):
    """Timeline object of the entity `_owner`."""

    entity = property(lambda self: self._owner)
    name = property(lambda self: self._owner._data.name)
    isSuppressed = property(lambda self: getattr(self._owner._data, "suppressed", False))
    errorOrWarningMessage = property(lambda self: getattr(self._owner._data, "problem", ""))

    @property
    def healthState(self) -> int:
        data = self._owner._data
        return 3 if getattr(data, "suppressed", False) else getattr(data, "health", 0)


class WithTimeline(Seen):
    """Entity with a timeline object, except in direct designs."""

    @property
    def timelineObject(self) -> Any:
        design = self._component.design
        if design.kind == 0:
            return None
        if design.is_edited():
            raise RuntimeError("2 : InternalValidationError : the timeline is hidden in an edit")
        return new(TimelineObject, owner=self)
