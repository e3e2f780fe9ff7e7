"""Occurrences of a design's components, with their poses in the root frame.

An entity of a component is read through its proxy in the occurrence, `occurrence.proxy(entity)`,
which Fusion gives in the root frame. Occurrences are found from the top down: `assemblyContext` is
not the occurrence above, and names may contain the `+` that full paths are joined by. The pose of
one that is reached from the root is in the root frame. (`transform` is retired.)
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
        path: Its full path; empty for the root component.
        parent: Full path of the occurrence that holds it.
        native: Fusion's occurrence in the root's context; None for the root component.
        component: The component.
        T: Its pose in the root frame.
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
        """The subject of findings about it."""
        return Subject("occurrence", self.path) if self.path else Subject("design", "root")

    def children(self) -> Any:
        """Fusion's occurrences right below it."""
        return self.component.occurrences if self.native is None else self.native.childOccurrences

    def named(self, name: str) -> str:
        """Return the name of something in it, for findings."""
        return f"{self.path}/{name}" if self.path else name

    def proxy(self, native: Any) -> Any:
        """Return the proxy of an entity of the component in this occurrence; itself in the root.

        Raises:
            ValueError: Fusion gives none.
        """
        if self.native is None:
            return native
        proxy = native.createForAssemblyContext(self.native)
        if proxy is None:
            raise ValueError("Fusion does not say where it is in the assembly")
        return proxy

    def in_root(self, read: Vector3, native: Vector3) -> Vector3:
        """Return a proxy's position in the root frame, in [m].

        It should be given in the root frame already. If it is the same as that of the native entity
        though the occurrence is elsewhere, it was given in the component's frame.
        """
        moved = self.T.apply(native)
        return moved if near(read, native) and not near(read, moved) else read


Occurrences = dict[str, Occurrence]
"""All of a design, by path."""


def find_occurrences(root: Any, notes: Notes) -> Occurrences:
    """Return the root component, then every occurrence, in the order of their paths."""
    top = Occurrence(ROOT, ROOT, None, root, IDENTITY, IDENTITY)
    found = {ROOT: top}
    first: dict[tuple[str, str], Transform] = {}
    waiting = [(native, top) for native in _below(top, notes)]
    while waiting:
        native, above = waiting.pop()
        occurrence = _occurrence(native, above, notes)
        if occurrence is None:
            continue
        if occurrence.path in found:
            message = f"two occurrences have the path {occurrence.path!r}: rename one of them"
            notes.add("error", occurrence.subject, "same-path", message)
            continue
        T_first = first.setdefault(identity(occurrence), occurrence.T)
        occurrence = replace(occurrence, T_first=T_first)
        found[occurrence.path] = occurrence
        waiting += [(below, occurrence) for below in _below(occurrence, notes)]
    return dict(sorted(found.items(), key=lambda item: natural_key(item[0])))


def _below(above: Occurrence, notes: Notes) -> list[Any]:
    """Fusion's occurrences right below one, the last first."""
    return list(items(above.children, notes, above.subject, "occurrences"))[::-1]


def identity(occurrence: Occurrence) -> tuple[str, str]:
    """Id and name of an occurrence's component: copies of a document have the same ids."""
    component = occurrence.component
    found = optional(lambda: (str(component.id), str(component.name)))
    return found or ("", occurrence.path)


def every_occurrence(root: Any) -> list[Any]:
    """Fusion's occurrences in the root's context, those above others first.

    The root's own list of all fails where one reference to another document is not resolved; this
    one goes without that.
    """
    found: list[Any] = []
    waiting = optional(lambda: list(root.occurrences)) or []
    while waiting:
        native = waiting.pop(0)
        if optional(lambda: native.component) is not None:  # noqa: B023 -- called at once
            found.append(native)
            waiting += optional(lambda: list(native.childOccurrences)) or []  # noqa: B023
    return found


def _occurrence(native: Any, above: Occurrence, notes: Notes) -> Occurrence | None:
    todo = "If its component is in another document, open that and update the reference"
    left_out = (
        "It is left out of the robot, with all that is in it. If its component is in another "
        "document, open that and update the reference; else delete it"
    )
    path = notes.attempt(above.subject, "occurrences' paths", path_of, native)
    if path is None:
        return None
    subject = Subject("occurrence", path)
    component = notes.attempt(
        subject, "component", lambda: native.component, severity="warning", todo=left_out
    )
    if component is None:
        return None
    T = notes.attempt(subject, "position", lambda: frame(native.transform2), todo=todo)
    if T is None:
        return None
    if not is_rigid(T):
        message = f"occurrence {path!r} is mirrored or scaled: make its component anew"
        notes.add("error", subject, "not-rigid", message)
    return Occurrence(path, above.path, native, component, T, T)


def each_in(
    occurrence: Occurrence, collection: Callable[[], Any], notes: Notes, kind: str
) -> Iterator[tuple[Any, str, Any]]:
    """Native entity, name and proxy of every item of one of the component's collections."""
    what = "bodies" if kind == "body" else f"{kind}s"
    for native in items(collection, notes, occurrence.subject, what):
        name = notes.attempt(occurrence.subject, f"{what}' names", name_of, native)
        if name is None:
            continue
        subject = subject_in(occurrence, kind, name)
        proxy = notes.attempt(subject, "place", occurrence.proxy, native)
        if proxy is not None:
            yield native, name, proxy


def name_of(entity: Any) -> str:
    """Return the name of anything that has one."""
    return str(entity.name)


def path_of(occurrence: Any) -> str:
    """Return the full path of Fusion's occurrence."""
    return str(occurrence.fullPathName)


def subject_in(occurrence: Occurrence, kind: str, name: str) -> Subject:
    """The subject of findings about something in an occurrence; a body's name includes the path."""
    return Subject(kind, occurrence.named(name) if kind == "body" else name)
