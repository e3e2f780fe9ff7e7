"""Construction points."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import Base, api, new
from ..collections_ import Items, named
from ..maths import Point3D, apply, inverse, point, xyz
from ..state import world
from .bodies import BRepEdge, BRepFace, BRepVertex
from .captures import revert
from .component import Occurrence
from .data import ComponentData, PointData, transform
from .entity import (
    Deletable,
    Placed,
    Seen,
    WithName,
    WithVisibility,
    reject_reference,
    unique,
    wrap,
    wraps,
)
from .sketches import SketchPoint
from .timeline import WithTimeline


@api("adsk.fusion")
class ConstructionPointDefinition(Base):
    pass


@api("adsk.fusion")
class ConstructionPointPointDefinition(ConstructionPointDefinition):
    pass


@api("adsk.fusion")
class ConstructionPointCenterDefinition(ConstructionPointDefinition):
    pass


@api("adsk.fusion")
@wraps(PointData)
class ConstructionPoint(Placed, WithName, WithTimeline, WithVisibility, Deletable):
    def _shelf(self) -> list[Any]:
        return self._data.component.points

    def _siblings(self) -> list[Any]:
        return self._shelf()

    component = property(lambda self: wrap(self._data.component))
    parent = property(lambda self: wrap(self._data.component))

    @property
    def geometry(self) -> Any:
        """Position in the frame of the context."""
        return point(self._placed(self._data.position))

    @property
    def definition(self) -> Any:
        """Definition of the point; None in direct modelling."""
        if self._data.definition is None:
            return None
        by_centre = self._data.definition[0] == "center"
        cls = ConstructionPointCenterDefinition if by_centre else ConstructionPointPointDefinition
        return new(cls, point=self)

    healthState = property(lambda self: self._data.health)
    errorOrWarningMessage = property(lambda self: self._data.problem)


@api("adsk.fusion")
class ConstructionPointInput(Base):
    def setByPoint(self, point: Base) -> bool:
        """Set a vertex, a sketch point or, in direct modelling, a Point3D; else add() fails."""
        if not isinstance(point, (BRepVertex, SketchPoint, Point3D)):
            raise RuntimeError("3 : invalid argument point: a vertex, sketch point or Point3D")
        design = self._component.design
        if isinstance(point, Point3D) and design.kind == 1 and not design.is_edited():
            raise RuntimeError("3 : a Point3D is not valid in the parametric modeling mode")
        self._how = ("point", point)
        return True

    def setByCenter(self, circularEntity: Base) -> bool:
        """Set a circular edge, a sphere or a torus face."""
        if not _is_circular(circularEntity):
            raise RuntimeError("3 : invalid argument circularEntity: it has no centre")
        self._how = ("center", circularEntity)
        return True


def _is_circular(entity: Any) -> bool:
    if isinstance(entity, BRepEdge):
        return entity._data.geometry.radius > 0.0
    return isinstance(entity, BRepFace) and entity._data.geometry.kind in ("sphere", "torus")


def position_of(entity: Any) -> np.ndarray:
    """Return the position of a point on an entity in the frame of its context, in [cm]."""
    if isinstance(entity, Point3D):
        return xyz(entity)
    if isinstance(entity, (BRepVertex, ConstructionPoint)):
        return xyz(entity.geometry)
    if isinstance(entity, SketchPoint):
        return xyz(entity.worldGeometry)
    if isinstance(entity, BRepEdge):
        return xyz(entity.geometry.center)
    return xyz(entity.geometry.origin)


@api("adsk.fusion")
@named
class ConstructionPoints(Items):
    """Construction points of a component."""

    def _all(self) -> list[Any]:
        return [wrap(p) for p in self._component.points]

    component = property(lambda self: wrap(self._component))

    def createInput(self, occurrenceForCreation: Occurrence | None = None) -> Any:
        made = {"component": self._component, "occurrence": occurrenceForCreation, "how": None}
        return new(ConstructionPointInput, **made)

    def add(self, input: ConstructionPointInput) -> Any:
        component = self._component
        reject_reference(component, "ConstructionPoints.add")
        if component.design.intent == 1 and component is component.design.root:
            raise RuntimeError("3 : an assembly design takes no features")
        if input._how is None:
            raise RuntimeError("3 : the input of the construction point is not set")
        how, entity = input._how
        if isinstance(entity, Point3D) and component.design.kind == 1:
            raise RuntimeError("3 : Environment is not supported: Point3D in a parametric design")
        position = _place(component, entity, input._occurrence)
        definition = None
        if isinstance(entity, Seen) and component.design.kind == 1:
            definition = (how, entity._data, entity._path)
        data = PointData(
            unique(f"Point{len(component.points) + 1}", component.points),
            component=component,
            position=position,
            definition=definition,
            by_user=False,
        )
        world().append(component.points, data, "ConstructionPoints.add")
        revert(component.design)
        world().recomputes += 1
        return wrap(data)


def _place(component: ComponentData, entity: Any, creation: Any) -> np.ndarray:
    """Return the position in the frame of the component.

    Raises:
        RuntimeError: The entity belongs to another component and the occurrence is missing.
    """
    position = position_of(entity)
    if isinstance(entity, Point3D):
        return position
    context = entity._path
    if not context and entity._data.component is component:
        return position
    top = context[0].parent if context else entity._data.component
    if top is component:  # a proxy in the context of this component
        return position
    if creation is None or creation._data.component is not component:
        raise RuntimeError("3 : Provided input paths are not valid.")
    if top is not creation._path[0].parent:
        raise RuntimeError("3 : Provided input paths are not valid.")
    return apply(inverse(transform(creation._path)), position)
