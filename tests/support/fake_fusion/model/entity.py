"""Common properties of entities of a design: name, attributes, proxies in assemblies."""

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
_calls = count()

WRAPPERS: dict[Any, type] = {}
"""API class for each type of data, by class, or by class and kind."""


def wraps(*keys: Any) -> Any:
    """Register an API class as wrapper of a type of data."""

    def register(cls: type) -> type:
        WRAPPERS.update(dict.fromkeys(keys, cls))
        return cls

    return register


def wrap(data: Any, path: Path = ()) -> Any:
    """Return the API object of data in a context; None for None.

    Args:
        data: The data; for an occurrence, the last item of its path.
        path: Occurrences from the component of the context to the component of the data.
    """
    if data is None:
        return None
    cls = WRAPPERS.get(type(data)) or WRAPPERS[type(data), data.kind]
    return new(cls, data=data, path=path, recomputes=world().recomputes)


def current(entity: Any) -> Any:
    """Return a valid API object of the same entity; other values are returned unchanged."""
    return wrap(entity._data, entity._path) if isinstance(entity, Seen) else entity


def occurrence(path: Path) -> Any:
    """Return the Occurrence at the end of a path; None for the empty path."""
    return wrap(path[-1], path) if path else None


def reject_reference(component: ComponentData, what: str) -> None:
    """Reject an edit of a component of another document.

    Raises:
        RuntimeError: The component belongs to another document.
    """
    world().require_edit(what)
    if component.referenced:
        raise RuntimeError(f"3 : {what}: {component.name} is an external reference, read-only here")


class Seen(Base):
    """Data in a context. `_path` is the path from the component of the context to the data."""

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

    def _is_before(self, recomputes: int) -> bool:
        """Return whether this object is older than a computation that makes it invalid."""
        return self._recomputes < recomputes and world().options.recomputed == "invalid"

    _T = property(lambda self: transform(self._path))

    def _placed(self, p: Any) -> np.ndarray:
        return apply(self._T, p)

    _component = property(lambda self: self._data.component)

    attributes = property(lambda self: new(Attributes, owner=self))


def _same(a: Path, b: Path) -> bool:
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))


class WithToken(Seen):
    """Entity with a token; a design has none."""

    @property
    def entityToken(self) -> str:
        """Token, which differs at every call [reference]."""
        path = "/".join(str(id(o)) for o in self._path)
        return f"{next(_calls)}:{path}:{id(self._data)}"


class Placed(WithToken):
    """Entity that can have proxies."""

    assemblyContext = property(lambda self: occurrence(self._path))
    nativeObject = property(lambda self: wrap(self._data) if self._path else None)

    def createForAssemblyContext(self, occurrence: Occurrence) -> Any:  # noqa: F821
        if self._path:
            raise RuntimeError("3 : object is not the native object")
        if occurrence._data.component is not self._component:
            raise RuntimeError("3 : invalid argument occurrence: it is of another component")
        return wrap(self._data, occurrence._path)


class WithName(WithToken):
    """Entity with a writable name."""

    @property
    def name(self) -> str:
        return self._data.name

    @name.setter
    def name(self, value: str) -> None:
        reject_reference(self._component, f"{type(self).__name__}.name")
        if value != self._data.name:
            value = unique(value, self._siblings())
            world().set(self._data, "name", value)

    def _siblings(self) -> list[Any]:
        """Entities that must have different names."""
        return []


class WithVisibility(Seen):
    """Entity that is hidden if a parent is hidden."""

    @property
    def isVisible(self) -> bool:
        return self._data.light_bulb and all(o.light_bulb for o in self._path)


class Deletable(Seen):
    """Entity that can be deleted; its class has `_shelf`, the list that contains its data."""

    def deleteMe(self) -> bool:
        reject_reference(self._component, f"{type(self).__name__}.deleteMe")
        world().set(self._data, "gone", True)
        world().remove(self._shelf(), self._data)
        return True


def unique(name: str, others: list[Any]) -> str:
    """Return a unique name: " (1)", " (2)" ... is appended like in Fusion."""
    taken = {other.name for other in others}
    if name not in taken:
        return name
    return next(n for n in (f"{name} ({i})" for i in count(1)) if n not in taken)


@api("adsk.core")
class Attribute(Base):
    """Attribute of an entity; it becomes invalid when it is deleted."""

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
        reject_reference(self._owner._component, "Attribute.deleteMe")
        world().put(self._owner._data.attributes, self._key, None)
        return True


@api("adsk.core")
@listing
class ObjectCollection(Items):
    """Collection of any objects."""


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
    reject_reference(owner._component, "Attributes.add")
    if len(value.encode()) > _MAX_ATTRIBUTE:
        raise RuntimeError("3 : the value of an attribute is larger than 2 MB")
    world().put(owner._data.attributes, key, value)
