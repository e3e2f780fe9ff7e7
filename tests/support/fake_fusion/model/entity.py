"""Common properties of a design's entities: name, attributes, proxies in assemblies."""

from __future__ import annotations

from itertools import count
from typing import Any

import numpy as np

from ..base import Base, api, by_name, new
from ..collections_ import Items, listing
from ..maths import apply
from ..state import world
from .data import ComponentData, Path, transform

_MAX_ATTRIBUTE = 2 * 1024 * 1024

WRAPPERS: dict[Any, type] = {}
"""The class of the API for a kind of data: by its class, or by class and kind."""


def wraps(*keys: Any) -> Any:
    """Register a class of the API as what a kind of data looks like."""

    def register(cls: type) -> type:
        WRAPPERS.update(dict.fromkeys(keys, cls))
        return cls

    return register


def wrap(data: Any, path: Path = ()) -> Any:
    """The API's object for data seen in a context; None for None.

    Args:
        data: The data; for an occurrence, the last of its path.
        path: Where: occurrences from the context's component down to the data's component.
    """
    if data is None:
        return None
    cls = WRAPPERS.get(type(data)) or WRAPPERS[type(data), data.kind]
    return new(cls, data=data, path=path)


def occurrence(path: Path) -> Any:
    """The Occurrence at the end of a path; None for the empty path."""
    return wrap(path[-1], path) if path else None


def refuse_reference(component: ComponentData, what: str) -> None:
    """Reject an edit of a component that lives in another document.

    Raises:
        RuntimeError: It does.
    """
    world().require_edit(what)
    if component.referenced:
        raise RuntimeError(f"3 : {what}: {component.name} is an external reference, read-only here")


class Seen(Base):
    """Data seen in a context. `_path` leads from the context's component to the data's."""

    _data: Any
    _path: Path

    def __eq__(self, other: object) -> bool:
        same = isinstance(other, Seen) and self._data is other._data
        return same and _same(self._path, other._path)

    def __repr__(self) -> str:
        place = "+".join(o.name for o in self._path)
        return f"<{type(self).__name__} {getattr(self._data, 'name', '')!r} in {place or 'itself'}>"

    def _is_gone(self) -> bool:
        return self._data.gone or any(o.gone for o in self._path)

    _T = property(lambda self: transform(self._path))

    def _placed(self, p: Any) -> np.ndarray:
        return apply(self._T, p)

    _component = property(lambda self: self._data.component)
    attributes = property(lambda self: new(Attributes, owner=self))


def _same(a: Path, b: Path) -> bool:
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))


class Placed(Seen):
    """An entity that proxies exist of."""

    assemblyContext = property(lambda self: occurrence(self._path))
    nativeObject = property(lambda self: wrap(self._data) if self._path else None)

    def createForAssemblyContext(self, occurrence: Occurrence) -> Any:  # noqa: F821
        if self._path:
            raise RuntimeError("3 : object is not the native object")
        if occurrence._data.component is not self._component:
            raise RuntimeError("3 : invalid argument occurrence: it is of another component")
        return wrap(self._data, occurrence._path)


class WithName(Seen):
    """An entity with a name that can be written."""

    @property
    def name(self) -> str:
        return self._data.name

    @name.setter
    def name(self, value: str) -> None:
        refuse_reference(self._component, f"{type(self).__name__}.name")
        if value != self._data.name:
            value = unique(value, self._siblings())
            world().set(self._data, "name", value)

    def _siblings(self) -> list[Any]:
        """What must not have the same name."""
        return []


class WithVisibility(Seen):
    """An entity that is hidden with what it is in."""

    @property
    def isVisible(self) -> bool:
        return self._data.light_bulb and all(o.light_bulb for o in self._path)


class Deletable(Seen):
    """An entity that can be deleted; its class has `_shelf`, the list that holds its data."""

    def deleteMe(self) -> bool:
        refuse_reference(self._component, f"{type(self).__name__}.deleteMe")
        world().set(self._data, "gone", True)
        world().remove(self._shelf(), self._data)
        return True


def unique(name: str, others: list[Any]) -> str:
    """A name that none of the others has: " (1)", " (2)" ... are appended, as Fusion does."""
    taken = {other.name for other in others}
    if name not in taken:
        return name
    return next(n for n in (f"{name} ({i})" for i in count(1)) if n not in taken)


@api("adsk.core")
class Attribute(Base):
    """Group, name and value on an entity; gone when the entity does not have it any more."""

    def _is_gone(self) -> bool:
        return self._owner._is_gone() or self._key not in self._owner._data.attributes

    def __eq__(self, other: object) -> bool:
        same = isinstance(other, Attribute) and self._key == other._key
        return same and self._owner == other._owner

    groupName = property(lambda self: self._key[0])
    name = property(lambda self: self._key[1])

    @property
    def value(self) -> str:
        return self._owner._data.attributes[self._key]

    @value.setter
    def value(self, value: str) -> None:
        _write(self._owner, self._key, value)

    parent = property(lambda self: wrap(self._owner._data, self._owner._path))
    otherParents = property(lambda _: by_name("ObjectCollection", make=list))

    def deleteMe(self) -> bool:
        refuse_reference(self._owner._component, "Attribute.deleteMe")
        world().put(self._owner._data.attributes, self._key, None)
        return True


@api("adsk.core")
@listing
class ObjectCollection(Items):
    """Of any objects."""


@api("adsk.core")
@listing
class Attributes(Items):
    def _all(self) -> list[Any]:
        keys = self._owner._data.attributes
        return [new(Attribute, owner=self._owner, key=key) for key in keys]

    def itemByName(self, groupName: str, name: str) -> Attribute | None:
        key = (groupName, name)
        held = key in self._owner._data.attributes
        return new(Attribute, owner=self._owner, key=key) if held else None

    def itemsByGroup(self, groupName: str) -> list:
        return [a for a in self._all() if a._key[0] == groupName]

    def add(self, groupName: str, name: str, value: str) -> Attribute:
        if not groupName or not name:
            raise RuntimeError("3 : invalid argument groupName or name")
        _write(self._owner, (groupName, name), value)
        return new(Attribute, owner=self._owner, key=(groupName, name))


def _write(owner: Seen, key: tuple[str, str], value: str) -> None:
    refuse_reference(owner._component, "Attributes.add")
    if len(value.encode()) > _MAX_ATTRIBUTE:
        raise RuntimeError("3 : the value of an attribute is larger than 2 MB")
    world().put(owner._data.attributes, key, value)
