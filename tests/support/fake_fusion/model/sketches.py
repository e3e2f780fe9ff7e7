"""Sketches of the user with points that can be picked but not edited."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import Base, api, new
from ..collections_ import Items, listing, named
from ..maths import matrix, point
from ..state import world
from .data import SketchData, SketchPointData
from .entity import Deletable, Placed, WithName, WithVisibility, wrap, wraps


@api("adsk.fusion")
@wraps(SketchData)
class Sketch(Placed, WithName, WithVisibility, Deletable):
    def _shelf(self) -> list[Any]:
        return self._data.component.sketches

    def _siblings(self) -> list[Any]:
        return self._shelf()

    parentComponent = property(lambda self: wrap(self._data.component))
    transform = property(lambda self: matrix(self._T @ self._data.T))
    sketchPoints = property(lambda self: new(SketchPoints, sketch=self))


@api("adsk.fusion")
@named
class Sketches(Items):
    """Sketches of a component; `add` fails, because the add-in must not create sketches."""

    def _all(self) -> list[Any]:
        return [wrap(s) for s in self._component.sketches]


@api("adsk.fusion")
class SketchEntity(Base):
    pass


class _InSketch(Placed):
    _T_sketch = property(lambda self: self._T @ self._data.sketch.T)

    def _is_gone(self) -> bool:
        return super()._is_gone() or self._data.sketch.gone


@api("adsk.fusion")
@wraps(SketchPointData)
class SketchPoint(_InSketch, SketchEntity):
    @property
    def geometry(self) -> Any:
        """Position in the frame of the sketch."""
        return point(self._data.position)

    @property
    def worldGeometry(self) -> Any:
        """Position in the frame of the context."""
        T = self._T_sketch
        return point(T[:3, :3] @ np.asarray(self._data.position) + T[:3, 3])

    def deleteMe(self) -> bool:
        world().set(self._data, "gone", True, "SketchPoint.deleteMe")
        world().remove(self._data.sketch.points, self._data)
        return True


@api("adsk.fusion")
@listing
class SketchPoints(Items):
    def _all(self) -> list[Any]:
        return [wrap(p, self._sketch._path) for p in self._sketch._data.points]
