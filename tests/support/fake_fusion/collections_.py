"""Collections of the API: count, item, itemByName, and len, index and iteration of Python."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .base import Base


class Items(Base):
    """A collection whose list is created at every access, so that it is up to date."""

    def _all(self) -> list[Any]:
        return self._make()

    def _item(self, index: int) -> Any:
        items = self._all()
        return items[index] if 0 <= index < len(items) else None

    def _by_name(self, name: str) -> Any:
        return next((item for item in self._all() if item.name == name), None)

    def __len__(self) -> int:
        return len(self._all())

    def __getitem__(self, index: Any) -> Any:
        return self._all()[index]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._all())


def listing(cls: type) -> type:
    """Add the members `count` and `item` to a collection."""
    cls.count = property(lambda self: len(self._all()))

    def item(self: Any, index: int) -> Any:
        return self._item(index)

    cls.item = item
    return cls


def named(cls: type) -> type:
    """Add the members `count`, `item` and `itemByName` to a collection."""

    def itemByName(self: Any, name: str) -> Any:
        return self._by_name(name)

    cls.itemByName = itemByName
    return listing(cls)
