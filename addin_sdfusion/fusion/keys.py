"""Keys of the design's entities that stay the same from one reading to the next.

Tokens of entities differ at every call, and ids of components are the same in copies of a document.
"""

from __future__ import annotations

from collections.abc import Iterable

from .notes import optional
from .occurrences import Occurrence


class Keys:
    """Names of components and of what is in them.

    Args:
        occurrences: All of the design; the first of a component decides where names are the same.
    """

    def __init__(self, occurrences: Iterable[Occurrence]) -> None:
        self._components: dict[tuple[str, str], str] = {}
        taken: dict[str, int] = {}
        for occurrence in occurrences:
            component = _identity(occurrence)
            if component not in self._components:
                name = component[1]
                taken[name] = taken.get(name, 0) + 1
                self._components[component] = name if taken[name] == 1 else f"{name}#{taken[name]}"

    def key(self, occurrence: Occurrence, name: str, number: int = 0) -> str:
        """The name of an entity of the occurrence's component."""
        suffix = f"#{number + 1}" if number else ""
        return f"{self._components[_identity(occurrence)]}/{name}{suffix}"


def _identity(occurrence: Occurrence) -> tuple[str, str]:
    component = occurrence.component
    identity = optional(lambda: (str(component.id), str(component.name)))
    return identity or ("", occurrence.path)
