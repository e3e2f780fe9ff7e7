"""Names for the design's own entities that stay the same from one reading to the next.

Tokens of entities differ at every call, and ids of components are the same in copies of a document.
"""

from __future__ import annotations

from collections.abc import Iterable

from .notes import if_told
from .occurrences import Place


class Keys:
    """Names of components and of what is in them.

    Args:
        places: All places; the first place of a component decides where names are the same.
    """

    def __init__(self, places: Iterable[Place]) -> None:
        self._components: dict[tuple[str, str], str] = {}
        taken: dict[str, int] = {}
        for place in places:
            place_id = _identity(place)
            if place_id not in self._components:
                name = place_id[1]
                taken[name] = taken.get(name, 0) + 1
                self._components[place_id] = name if taken[name] == 1 else f"{name}#{taken[name]}"

    def key(self, place: Place, name: str, number: int = 0) -> str:
        """The name of an entity of the place's component.

        Args:
            place: Any place of the component.
            name: The entity's name.
            number: Counts those of the same name in the same component.
        """
        suffix = f"#{number + 1}" if number else ""
        return f"{self._components[_identity(place)]}/{name}{suffix}"


def _identity(place: Place) -> tuple[str, str]:
    component = place.component
    told = if_told(lambda: (str(component.id), str(component.name)))
    return told or ("", place.path)
