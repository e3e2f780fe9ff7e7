"""Occurrences of the components of a design, with their poses in the root frame.

An entity of a component is read through its proxy in the occurrence, `occurrence.proxy(entity)`,
whose coordinates are in the root frame. Occurrences are searched from the root downwards, because
`assemblyContext` is not the parent occurrence and names may contain the separator `+` of full
paths. The pose of an occurrence that is reached from the root is in the root frame. (`transform` is
deprecated.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from ..muscles.point_names import natural_key
from ..robot.finding import Subject
from ..robot.model.pose import Vector3
from ..robot.model.transform import IDENTITY, Transform
from ..snapshot import ROOT
from .notes import Notes, items, optional
from .units import frame, is_rigid, near


@dataclass(frozen=True)
class Occurrence:
    """An occurrence of a component, or the root component itself.

    Attributes:
        path: Full path; empty for the root component.
        parent: Full path of the parent occurrence.
        native: Fusion's occurrence in the context of the root; None for the root component.
        T: Pose in the root frame.
        T_first: Pose of the first occurrence of the same component.
    """

    path: str
    parent: str
    native: Any
    component: Any
    T: Transform
    T_first: Transform

    @property
    def subject(self) -> Subject:
        """Subject of findings on the occurrence."""
        return Subject("occurrence", self.path) if self.path else Subject("design", "root")

    def children(self) -> Any:
        """Fusion's child occurrences."""
        return self.component.occurrences if self.native is None else self.native.childOccurrences

    def named(self, name: str) -> str:
        """Return the full name of an object in the occurrence, for findings."""
        return f"{self.path}/{name}" if self.path else name

    def proxy(self, native: Any) -> Any:
        """Return the proxy of an entity of the component; in the root, the entity itself.

        Raises:
            ValueError: Fusion does not provide a proxy.
        """
        if self.native is None:
            return native
        proxy = native.createForAssemblyContext(self.native)
        if proxy is None:
            raise ValueError("Fusion does not report its position in the assembly")
        return proxy

    def in_root(self, read: Vector3, native: Vector3) -> Vector3:
        """Return the position of a proxy in the root frame, in [m].

        Fusion should report it in the root frame. If it equals the position of the native entity
        although the occurrence is moved, Fusion reported it in the frame of the component.
        """
        moved = self.T.apply(native)
        return moved if near(read, native) and not near(read, moved) else read


Occurrences = dict[str, Occurrence]
"""All occurrences of a design, by path."""


def find_occurrences(root: Any, notes: Notes) -> Occurrences:
    """Return the root component, then every occurrence, in the order of their paths."""
    top = Occurrence(ROOT, ROOT, None, root, IDENTITY, IDENTITY)
    occurrences = {ROOT: top}
    first: dict[tuple[str, str], Transform] = {}
    waiting = [(native, top) for native in _native_children(top, notes)]
    while waiting:
        native, above = waiting.pop()
        occurrence = _occurrence(native, above, notes)
        if occurrence is None:
            continue
        if occurrence.path in occurrences:
            message = f"two occurrences have the path {occurrence.path!r}: rename one of them"
            notes.add("error", occurrence.subject, "same-path", message)
            continue
        T_first = first.setdefault(identity(occurrence), occurrence.T)
        occurrence = replace(occurrence, T_first=T_first)
        occurrences[occurrence.path] = occurrence
        waiting += [(below, occurrence) for below in _native_children(occurrence, notes)]
    return dict(sorted(occurrences.items(), key=lambda item: natural_key(item[0])))


def readable_occurrences(root: Any) -> Occurrences:
    """Return the root component and all occurrences that can be read, without findings."""
    return find_occurrences(root, Notes(lambda _: None))


def _native_children(above: Occurrence, notes: Notes) -> list[Any]:
    """Return Fusion's child occurrences in reverse order."""
    return list(items(above.children, notes, above.subject, "occurrences"))[::-1]


def identity(occurrence: Occurrence) -> tuple[str, str]:
    """Return id and name of a component, since copies of a document have the same ids."""
    component = occurrence.component
    id_and_name = optional(lambda: (str(component.id), str(component.name)))
    return id_and_name or ("", occurrence.path)


def component_id(component: Any) -> str:
    """Return the persistent id of a component; empty if Fusion does not report it."""
    return optional(lambda: str(component.id)) or ""


def _occurrence(native: Any, above: Occurrence, notes: Notes) -> Occurrence | None:
    todo = "If its component is in another document, open it and update the reference"
    not_exported = (
        "It is not exported, including its contents. If its component is in another document, "
        "open that document and update the reference; otherwise delete it"
    )
    path = notes.attempt(above.subject, "occurrences' paths", path_of, native)
    if path is None:
        return None
    subject = Subject("occurrence", path)
    component = notes.attempt(
        subject, "component", lambda: native.component, severity="warning", todo=not_exported
    )
    if component is None:
        return None
    T = notes.attempt(subject, "position", lambda: frame(native.transform2), todo=todo)
    if T is None:
        return None
    if not is_rigid(T):
        message = f"occurrence {path!r} is mirrored or scaled: create its component again"
        notes.add("error", subject, "not-rigid", message)
    return Occurrence(path, above.path, native, component, T, T)


def each_in(
    occurrence: Occurrence, collection: Callable[[], Any], notes: Notes, kind: str
) -> Iterator[tuple[Any, str, Any]]:
    """Yield native entity, name and proxy of every item of a collection of the component."""
    label = "bodies" if kind == "body" else f"{kind}s"
    for native in items(collection, notes, occurrence.subject, label):
        name = notes.attempt(occurrence.subject, f"{label}' names", name_of, native)
        if name is None:
            continue
        subject = subject_in(occurrence, kind, name)
        proxy = notes.attempt(subject, "place", occurrence.proxy, native)
        if proxy is not None:
            yield native, name, proxy


def name_of(entity: Any) -> str:
    """Return the name of an entity."""
    return str(entity.name)


def path_of(occurrence: Any) -> str:
    """Return the full path of Fusion's occurrence."""
    return str(occurrence.fullPathName)


def subject_in(occurrence: Occurrence, kind: str, name: str) -> Subject:
    """Return the subject of findings on an object; the name of a body includes the path."""
    return Subject(kind, occurrence.named(name) if kind == "body" else name)
