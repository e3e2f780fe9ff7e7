"""Application, documents and units."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from typing import Any

from .base import Base, api, new, stored
from .collections_ import Items, listing
from .maths import Point3D, point, xyz
from .model.component import Product
from .model.data import DesignData
from .model.entity import wrap
from .state import world
from .ui.ui import UserInterface

_UNITS = {"mm": 0.1, "cm": 1.0, "m": 100.0, "in": 2.54, "ft": 30.48, "rad": 1.0, "deg": 0.0}


def document_of(design: DesignData) -> Any:
    """Return the document of a design."""
    return new(FusionDocument, design=design)


@api("adsk.core")
class Document(Base):
    """Document; `_design` is its DesignData."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Document) and self._design is other._design

    def _is_gone(self) -> bool:
        return self._design not in world().documents

    name = property(lambda self: self._design.name)
    isActive = property(lambda self: world().active is self._design)
    products = property(lambda self: new(Products, design=self._design))
    parent = property(lambda _: Application.get())

    def activate(self) -> bool:
        world().active = self._design
        return True


@api("adsk.fusion")
class FusionDocument(Document):
    design = property(lambda self: wrap(self._design))


@api("adsk.core")
@listing
class Products(Items):
    def _all(self) -> list[Any]:
        return [wrap(self._design)]


def _unit(name: str) -> float:
    if name not in _UNITS:
        raise RuntimeError(f"3 : invalid argument units {name!r}")
    return _UNITS[name]


@api("adsk.core")
class Camera(Base):
    """Camera of the viewport; a copy, which must be assigned to the viewport to take effect."""

    @property
    def target(self) -> Any:
        return point(self._target)

    @target.setter
    def target(self, value: Point3D) -> None:
        self._target = xyz(value)

    @property
    def eye(self) -> Any:
        return point(self._eye)

    @eye.setter
    def eye(self, value: Point3D) -> None:
        self._eye = xyz(value)

    isFitView = stored("fit", "bool")


@api("adsk.core")
class Viewport(Base):
    @property
    def camera(self) -> Any:
        return new(Camera, **world().camera)

    @camera.setter
    def camera(self, value: Camera) -> None:
        world().camera = {k: getattr(value, f"_{k}") for k in ("target", "eye", "fit", "smooth")}


@api("adsk.core")
class Application(Base):
    @staticmethod
    def get() -> Application:
        return new(Application)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Application)

    @property
    def activeProduct(self) -> Any:
        """Design of the active document or another product; None if no document is open."""
        if world().active is not None and not world().in_design:
            return new(Product, data=world().active, path=())
        return wrap(world().active)

    userInterface = property(lambda _: new(UserInterface))
    activeViewport = property(lambda _: new(Viewport))

    version = property(lambda _: "2.0.21550")

    @staticmethod
    def log(message: str, level: int = 2, type: int = 1) -> None:
        world().log.append((message, level, type))
