"""Keys of the design's entities that stay the same from one reading to the next.

Tokens of entities differ at every call, and ids of components are the same in copies of a document.
"""

from __future__ import annotations

from collections.abc import Iterable

from .occurrences import Occurrence, identity


class Keys:
    """Names of components and of what is in them.

    Args:
        occurrences: All of the design; the first of a component decides where names are the same.
    """

    def __init__(self, occurrences: Iterable[Occurrence]) -> None:
        self._components: dict[tuple[str, str], str] = {}
        taken: dict[str, int] = {}
        for occurrence in occurrences:
            component = identity(occurrence)
            if component not in self._components:
                name = component[1]
                taken[name] = taken.get(name, 0) + 1
                self._components[component] = name if taken[name] == 1 else f"{name}#{taken[name]}"

    def key(self, occurrence: Occurrence, name: str, number: int = 0) -> str:
        """The name of an entity of the occurrence's component."""
        suffix = f"#{number + 1}" if number else ""
        return f"{self._components[identity(occurrence)]}/{name}{suffix}"
