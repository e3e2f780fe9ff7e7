"""Occurrences of a design's components, with their poses in the root frame.

An entity of a component is read through its proxy in the occurrence, `occurrence.proxy(entity)`,
which Fusion gives in the root frame. Occurrences are found from the top down: `assemblyContext` is
not the occurrence above, and names may contain the `+` that full paths are joined by.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from ..muscles.point_names import natural_key
from ..robot.finding import Subject
from ..robot.model.pose import Vector3
from ..robot.model.transform import IDENTITY, Transform
from ..snapshot import ROOT
from .notes import Notes, items
from .units import frame, is_rigid, near, same_frame


@dataclass(frozen=True)
class Occurrence:
    """An occurrence of a component, or the root component itself.

    Attributes:
        path: Its full path; empty for the root component.
        parent: Full path of the occurrence that holds it.
        native: Fusion's occurrence in the root's context; None for the root component.
        component: The component.
        T: Its pose in the root frame.
    """

    path: str
    parent: str
    native: Any
    component: Any
    T: Transform

    @property
    def subject(self) -> Subject:
        """The subject of findings about it."""
        return Subject("occurrence", self.path) if self.path else Subject("design", "root")

    def children(self) -> Any:
        """Fusion's occurrences right below it."""
        return self.component.occurrences if self.native is None else self.native.childOccurrences

    def named(self, name: str) -> str:
        """The name of something in it, for findings."""
        return f"{self.path}/{name}" if self.path else name

    def proxy(self, native: Any) -> Any:
        """The proxy of an entity of the component in this occurrence; itself in the root.

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
        """A proxy's position in the root frame, in [m].

        It should be given in the root frame already. If it is the same as that of the native entity
        though the occurrence is elsewhere, it was given in the component's frame.
        """
        moved = self.T.apply(native)
        return moved if near(read, native) and not near(read, moved) else read


Occurrences = dict[str, Occurrence]
"""All of a design, by path."""


def find_occurrences(root: Any, notes: Notes) -> Occurrences:
    """The root component, then every occurrence, in the order of their paths."""
    top = Occurrence(ROOT, ROOT, None, root, IDENTITY)
    found = {ROOT: top}
    waiting = [top]
    while waiting:
        above = waiting.pop()
        for native in items(above.children, notes, above.subject, "occurrences"):
            occurrence = _occurrence(native, above, notes)
            if occurrence is None:
                continue
            if occurrence.path in found:
                message = f"two occurrences have the path {occurrence.path!r}: rename one of them"
                notes.add("error", occurrence.subject, "same-path", message)
                continue
            found[occurrence.path] = occurrence
            waiting.append(occurrence)
    return dict(sorted(found.items(), key=lambda item: natural_key(item[0])))


def _occurrence(native: Any, above: Occurrence, notes: Notes) -> Occurrence | None:
    todo = "If its component is in another document, open that and update the reference"
    path = notes.attempt(above.subject, "occurrences' paths", path_of, native)
    if path is None:
        return None
    subject = Subject("occurrence", path)
    component = notes.attempt(subject, "component", lambda: native.component, todo=todo)
    T = notes.attempt(subject, "position", _pose, native, above.T, todo=todo)
    if T is None or component is None:
        return None
    if not is_rigid(T):
        message = f"occurrence {path!r} is mirrored or scaled: make its component anew"
        notes.add("error", subject, "not-rigid", message)
    return Occurrence(path, above.path, native, component, T)


def _pose(occurrence: Any, above: Transform) -> Transform:
    """The pose of Fusion's occurrence in the root frame.

    `transform2` is documented as "in its assembly context", so in the root frame for an occurrence
    that was reached from the root. In case a version of Fusion gives it relative to the occurrence
    above, that is seen by its being the same as that of the native occurrence. (`transform` is
    retired: it was wrong in some cases.)
    """
    read = frame(occurrence.transform2)
    native = occurrence.nativeObject
    if native is None:
        return read
    own = frame(native.transform2)
    composed = above.compose(own)
    return composed if same_frame(read, own) and not same_frame(read, composed) else read


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
    """The name of anything that has one."""
    return str(entity.name)


def path_of(occurrence: Any) -> str:
    """The full path of Fusion's occurrence."""
    return str(occurrence.fullPathName)


def subject_in(occurrence: Occurrence, kind: str, name: str) -> Subject:
    """The subject of findings about something in an occurrence; a body's name includes the path."""
    return Subject(kind, occurrence.named(name) if kind == "body" else name)
