"""Motion links, which couple two joint motions."""

from __future__ import annotations

from typing import Any

from ..base import api, new
from ..collections_ import Items, named
from .data import MotionLinkData
from .entity import wrap, wraps
from .joints import ModelParameter, Sibling


@api("adsk.fusion")
@wraps(MotionLinkData)
class MotionLink(Sibling):
    def _shelf(self) -> list[Any]:
        return self._data.component.motion_links

    jointOne = property(lambda self: wrap(self._data.joint_one, self._path))
    jointTwo = property(lambda self: wrap(self._data.joint_two, self._path))
    motionOne = property(lambda self: self._data.motions[0])
    motionTwo = property(lambda self: self._data.motions[1])
    valueOne = property(lambda self: new(ModelParameter, value=self._data.values[0]))
    valueTwo = property(lambda self: new(ModelParameter, value=self._data.values[1]))
    isReversed = property(lambda self: self._data.reversed)
    isSuppressed = property(lambda self: self._data.suppressed)
    healthState = property(lambda self: self._data.health)
    errorOrWarningMessage = property(lambda self: self._data.problem)


@api("adsk.fusion")
@named
class MotionLinks(Items):
    def _all(self) -> list[Any]:
        return [wrap(link) for link in self._component.motion_links]
