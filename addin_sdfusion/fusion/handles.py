"""API objects that are used after Fusion recomputed the model."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .notes import optional


class Handles:
    """API objects by key, which are found again by their tokens once they are invalid.

    An undone preview, or the end of an edit of a base feature, can make vertices, edges, faces and
    points invalid, although they still exist in the model.
    """

    def __init__(self, design: Any) -> None:
        self._design = design
        self._entities: dict[Any, tuple[Any, str]] = {}

    def __setitem__(self, key: Any, entity: Any) -> None:
        self._entities[key] = entity, optional(lambda: str(entity.entityToken)) or ""

    def __contains__(self, key: object) -> bool:
        return key in self._entities

    def __len__(self) -> int:
        return len(self._entities)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._entities)

    def get(self, key: Any) -> Any:
        """Return a valid object; None for an unknown key or an object that no longer exists."""
        entity, token = self._entities.get(key, (None, ""))
        if entity is None or entity.isValid:
            return entity
        entities = optional(lambda: list(self._design.findEntityByToken(token))) or ()
        if len(entities) != 1:  # deleted, or a face that was split
            return None
        self._entities[key] = entities[0], token
        return entities[0]
