"""Names and keys of the entities of a design.

Names of joints and groups are unique only within their component, but a robot requires unique
names. Entity tokens differ at every call, and component ids are equal in copies of a document. The
keys of this module are the same each time a design is read.
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


def with_unique_names(items: Iterable[tuple[str, Named]], kind: str, notes: Notes) -> list[Named]:
    """Return the items with unique names: the first keeps its name, the others are numbered."""
    pairs = list(items)
    count = Counter(item.name for _, item in pairs)
    used = set(count)
    seen: set[str] = set()
    named: list[Named] = []
    for path, item in pairs:
        name = item.name
        if name in seen:
            name = free_name(name, used)
            used.add(name)
            message = (
                f"{kind} {item.name!r} of {path or 'the root component'} is called {name!r} in the "
                f"robot: {count[item.name]} have this name, because they are in different "
                "components or their component has several occurrences. Rename them if needed"
            )
            if kind == "joint" or item.name.startswith(
                LINK_PREFIX
            ):  # the names of other items are not exported
                notes.warn(Subject(kind, item.name), "same-name", message)
        seen.add(item.name)
        named.append(replace(item, name=name))
    return named


def free_name(name: str, used: Collection[str]) -> str:
    """Return a name with the smallest numeric suffix that makes it unique."""
    number = 2
    while f"{name}_{number}" in used:
        number += 1
    return f"{name}_{number}"


class Keys:
    """Unique keys of components and their entities.

    Args:
        occurrences: All occurrences of the design. If components have equal names, the component
            that occurs first keeps its name.
    """

    def __init__(self, occurrences: Iterable[Occurrence]) -> None:
        self._components: dict[tuple[str, str], str] = {}
        count: dict[str, int] = {}
        for occurrence in occurrences:
            component = identity(occurrence)
            if component not in self._components:
                name = component[1]
                count[name] = count.get(name, 0) + 1
                self._components[component] = name if count[name] == 1 else f"{name}#{count[name]}"

    def key(self, occurrence: Occurrence, name: str, number: int = 0) -> str:
        """Return the key of an entity of the component of an occurrence."""
        suffix = f"#{number + 1}" if number else ""
        return f"{self._components[identity(occurrence)]}/{name}{suffix}"
