"""Records of a design that the add-in cannot use; they are stored again unchanged."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable
from typing import Any

from ....muscles.attributes import (
    GROUP,
    MUSCLES,
    POINTS,
    UNREAD,
    read_list,
    read_muscle,
    updated_record,
)
from ....muscles.rows import PointRow
from ....robot.errors import InputError
from ....robot.json_text import json_text
from ....snapshot import KEPT, PointUse


class StoredLists:
    """The lists of muscles and points that are stored in the open design."""

    def __init__(self, design: Any) -> None:
        self._attributes = design.attributes
        self._texts = {name: self._text(name) for name in (MUSCLES, POINTS)}

    def unread_muscles(self, deleted: Collection[str]) -> list[Any]:
        """Return the stored muscles that cannot be read, without deleted ones."""
        return [
            plain
            for plain in self._items(MUSCLES)
            if not _is_muscle(plain)
            and not (isinstance(plain, dict) and plain.get("name") in deleted)
        ]

    def unread_points(self, read: Collection[str], lost: Iterable[PointRow]) -> list[Any]:
        """Return the stored points without a row, and those of lost rows.

        Args:
            read: Entities of all rows that were read.
            lost: Lost rows that the user did not delete.
        """
        items = self._items(POINTS)
        by_entity = {f"{KEPT}/{i}": plain for i, plain in enumerate(items)}
        unread = [plain for entity, plain in by_entity.items() if entity not in read]
        for row in lost:
            if row.entity in by_entity:
                plain = by_entity[row.entity]
                unread.append({**plain, "use": updated_record(plain.get("use"), row.use)})
        return unread

    def keep_texts(self) -> None:
        """Store the former text of an attribute that is not a list under another name."""
        for name, text in self._texts.items():
            try:
                read_list(text or "[]", name)
            except InputError:
                self._attributes.add(GROUP, f"{name}{UNREAD}", text)

    def _items(self, name: str) -> list[Any]:
        try:
            return read_list(self._texts[name] or "[]", name)
        except InputError:
            return []

    def _text(self, name: str) -> str:
        attribute = self._attributes.itemByName(GROUP, name)
        return "" if attribute is None else str(attribute.value)


def update_attribute(entity: Any, name: str, use: PointUse) -> None:
    """Store muscle, number and name of a lost point in its attribute, if it can be parsed."""
    attribute = entity.attributes.itemByName(GROUP, name)
    if attribute is None:
        return
    plain = updated_record(json.loads(attribute.value), use)
    entity.attributes.add(GROUP, name, json_text(plain, ensure_ascii=False, sort_keys=True))


def _is_muscle(plain: Any) -> bool:
    try:
        read_muscle(plain, MUSCLES)
    except InputError:
        return False
    return True
