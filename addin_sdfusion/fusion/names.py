"""Names and keys of a design's entities.

Names of joints and groups are unique in their component only, and a robot needs unique ones. Tokens
of entities differ at every call, and ids of components are the same in copies of a document; keys
stay the same from one reading to the next.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import replace
from typing import TypeVar

from ..robot.finding import Subject
from ..snapshot import LINK_PREFIX, GroupSnapshot, JointSnapshot
from .notes import Notes
from .occurrences import Occurrence, identity

Named = TypeVar("Named", JointSnapshot, GroupSnapshot)


def with_unique_names(found: Iterable[tuple[str, Named]], kind: str, notes: Notes) -> list[Named]:
    """Return the same with unique names: the first of a name keeps it, the others are numbered."""
    pairs = list(found)
    count = Counter(item.name for _, item in pairs)
    taken = set(count)
    seen: set[str] = set()
    made: list[Named] = []
    for path, item in pairs:
        name = item.name
        if name in seen:
            name = free_name(name, taken)
            taken.add(name)
            message = (
                f"{kind} {item.name!r} of {path or 'the root component'} is called {name!r} in the "
                f"robot: there are {count[item.name]} of that name, because they are in different "
                "components or their component is in several places. Rename them if you mind"
            )
            if kind == "joint" or item.name.startswith(
                LINK_PREFIX
            ):  # others' names are not exported
                notes.warn(Subject(kind, item.name), "same-name", message)
        seen.add(item.name)
        made.append(replace(item, name=name))
    return made


def free_name(name: str, taken: Collection[str]) -> str:
    """Return a name with the smallest number behind it that makes it free."""
    number = 2
    while f"{name}_{number}" in taken:
        number += 1
    return f"{name}_{number}"


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
        """Return the name of an entity of the occurrence's component."""
        suffix = f"#{number + 1}" if number else ""
        return f"{self._components[identity(occurrence)]}/{name}{suffix}"
