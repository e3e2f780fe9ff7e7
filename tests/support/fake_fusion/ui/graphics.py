"""Custom graphics: lines and texts. Part of the model: edits need a transaction."""

from __future__ import annotations

from typing import Any

from ..base import Base, api, new, stored
from ..collections_ import Items, listing
from ..curves import Color
from ..maths import Matrix3D
from ..model.data import GraphicsData
from ..model.entity import wrap, wraps
from ..state import world


@api("adsk.fusion")
class CustomGraphicsCoordinates(Base):
    """Sequence of coordinates x, y, z of points, in [cm]."""

    @staticmethod
    def create(coordinates: list[float]) -> CustomGraphicsCoordinates:
        if len(coordinates) % 3:
            raise RuntimeError("3 : invalid argument coordinates")
        return new(CustomGraphicsCoordinates, xyz=[float(v) for v in coordinates])

    coordinates = property(lambda self: list(self._xyz))
    coordinateCount = property(lambda self: len(self._xyz) // 3)


@api("adsk.fusion")
class CustomGraphicsColorEffect(Base):
    pass


@api("adsk.fusion")
class CustomGraphicsSolidColorEffect(CustomGraphicsColorEffect):
    @staticmethod
    def create(color: Color) -> CustomGraphicsSolidColorEffect:
        return new(CustomGraphicsSolidColorEffect, rgba=color)

    color = property(lambda self: self._rgba)


@api("adsk.fusion")
class CustomGraphicsShowThroughColorEffect(CustomGraphicsColorEffect):
    """Colour of an entity that is visible, with an opacity, through bodies that cover it."""

    @staticmethod
    def create(color: Color, opacity: float) -> CustomGraphicsShowThroughColorEffect:
        if not 0.0 <= opacity <= 1.0:
            raise RuntimeError("3 : invalid argument opacity")
        return new(CustomGraphicsShowThroughColorEffect, rgba=color, share=float(opacity))

    color = property(lambda self: self._rgba)
    opacity = property(lambda self: self._share)


@api("adsk.fusion")
class CustomGraphicsBillBoard(Base):
    @staticmethod
    def create(anchorPoint: Point3D | None) -> CustomGraphicsBillBoard:  # noqa: F821
        return new(CustomGraphicsBillBoard, anchor=anchorPoint, style=1)

    anchorPoint = property(lambda self: self._anchor)
    billBoardStyle = stored("style", "int")


@api("adsk.fusion")
class CustomGraphicsViewScale(Base):
    @staticmethod
    def create(pixelScale: float, anchorPoint: Point3D) -> CustomGraphicsViewScale:  # noqa: F821
        return new(CustomGraphicsViewScale, scale=float(pixelScale), anchor=anchorPoint)

    pixelScale = property(lambda self: self._scale)
    anchorPoint = property(lambda self: self._anchor)


def _field(name: str, kind: str, default: Any, doc: str = "") -> property:
    """Return a property stored in the fields of the data; `kind` is its annotation."""

    def fget(self: Any) -> Any:
        return self._data.fields.get(name, default)

    def fset(self: Any, value: Any) -> None:
        world().put(self._data.fields, name, value, f"{type(self).__name__}.{name}")

    fset.__annotations__["value"] = kind
    return property(fget, fset, doc=doc)


@api("adsk.fusion")
class CustomGraphicsEntity(Base):
    """Base of all graphics."""

    _data: GraphicsData
    _path = ()

    color = _field("color", "CustomGraphicsColorEffect | None", None)
    depthPriority = _field("depthPriority", "int", 0)
    isSelectable = _field("isSelectable", "bool", True)
    isVisible = _field("isVisible", "bool", True)
    id = _field("id", "str", "")
    name = _field("name", "str", "")
    transform = _field("transform", "Matrix3D", None)
    billBoarding = _field("billBoarding", "CustomGraphicsBillBoard | None", None)
    viewScale = _field("viewScale", "CustomGraphicsViewScale | None", None)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CustomGraphicsEntity) and self._data is other._data

    def _is_gone(self) -> bool:
        data = self._data
        while isinstance(data, GraphicsData):
            if data.gone:
                return True
            data = data.parent
        return False


@api("adsk.fusion")
@wraps((GraphicsData, "lines"))
class CustomGraphicsLines(CustomGraphicsEntity):
    coordinates = _field("coordinates", "CustomGraphicsCoordinates", None)
    weight = _field("weight", "float", 1.0)
    isLineStrip = _field("isLineStrip", "bool", True)


@api("adsk.fusion")
@wraps((GraphicsData, "text"))
class CustomGraphicsText(CustomGraphicsEntity):
    formattedText = _field("formattedText", "str", "")
    font = _field("font", "str", "")
    size = _field("size", "float", 1.0)


@api("adsk.fusion")
@listing
@wraps((GraphicsData, "group"))
class CustomGraphicsGroup(Items, CustomGraphicsEntity):
    def _all(self) -> list[Any]:
        return [wrap(item) for item in self._data.items]

    def _add(self, kind: str, **fields: Any) -> Any:
        data = GraphicsData("", kind=kind, fields=fields, parent=self._data)
        world().append(self._data.items, data, f"CustomGraphicsGroup.add {kind}")
        return wrap(data)

    def addLines(
        self,
        coordinates: CustomGraphicsCoordinates,
        indexList: list[int],
        isLineStrip: bool,
        lineStripLengths: list[int] = [],  # noqa: B006
    ) -> Any:
        _check_indices(coordinates, indexList)
        return self._add(
            "lines",
            coordinates=coordinates,
            indexList=list(indexList),
            isLineStrip=isLineStrip,
            lineStripLengths=list(lineStripLengths),
        )

    def addText(self, formattedText: str, font: str, size: float, transform: Matrix3D) -> Any:
        if not formattedText or size <= 0.0:
            raise RuntimeError("3 : invalid argument formattedText or size")
        return self._add(
            "text", formattedText=formattedText, font=font, size=float(size), transform=transform
        )


def _check_indices(coordinates: Any, indices: Any) -> None:
    if any(not 0 <= i < coordinates.coordinateCount for i in indices):
        raise RuntimeError("3 : invalid argument indexList: out of range")


@api("adsk.fusion")
@listing
class CustomGraphicsGroups(Items):
    def _all(self) -> list[Any]:
        return [wrap(group) for group in self._component.graphics]

    def add(self) -> Any:
        data = GraphicsData("", parent=self._component)
        world().append(self._component.graphics, data, "CustomGraphicsGroups.add")
        return wrap(data)
