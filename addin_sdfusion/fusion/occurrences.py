"""Every component in every place, with its pose in the root frame.

An entity of a component is read through its proxy in the place, `place.of(entity)`, which Fusion
tells about in the root frame. Places are found from the top down: `assemblyContext` is not the
occurrence above, and names may contain the `+` that full paths are joined by.
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
class Place:
    """A component in a place.

    Attributes:
        path: Full path of the occurrence; empty for the root component.
        parent: Full path of the occurrence that holds it.
        occurrence: The occurrence in the root's context; None for the root component.
        component: The component.
        T: Its pose in the root frame.
    """

    path: str
    parent: str
    occurrence: Any
    component: Any
    T: Transform

    @property
    def subject(self) -> Subject:
        """What a finding about the place is about."""
        return Subject("occurrence", self.path) if self.path else Subject("design", "root")

    def children(self) -> Any:
        """The occurrences right below it."""
        if self.occurrence is None:
            return self.component.occurrences
        return self.occurrence.childOccurrences

    def named(self, name: str) -> str:
        """The name of something in the place, for findings."""
        return f"{self.path}/{name}" if self.path else name

    def of(self, native: Any) -> Any:
        """The proxy of an entity of the component in this place; itself in the root.

        Raises:
            ValueError: Fusion gives none.
        """
        if self.occurrence is None:
            return native
        proxy = native.createForAssemblyContext(self.occurrence)
        if proxy is None:
            raise ValueError("Fusion does not tell where it is in the assembly")
        return proxy

    def settled(self, told: Vector3, native: Vector3) -> Vector3:
        """A proxy's position in the root frame, in [m].

        It should be told in the root frame already. If it is the same as that of the native entity
        though the place is elsewhere, it was told in the component's frame.
        """
        moved = self.T.apply(native)
        return moved if near(told, native) and not near(told, moved) else told


def find_places(root: Any, notes: Notes) -> list[Place]:
    """The root component, then every component in every place, in the order of their paths."""
    top = Place(ROOT, ROOT, None, root, IDENTITY)
    found = {ROOT: top}
    waiting = [top]
    while waiting:
        above = waiting.pop()
        for occurrence in items(above.children, notes, above.subject, "occurrences"):
            place = _place(occurrence, above, notes)
            if place is None:
                continue
            if place.path in found:
                message = f"two occurrences have the path {place.path!r}: rename one of them"
                notes.add("error", place.subject, "same-path", message)
                continue
            found[place.path] = place
            waiting.append(place)
    return sorted(found.values(), key=lambda place: natural_key(place.path))


def _place(occurrence: Any, above: Place, notes: Notes) -> Place | None:
    todo = "If its component is in another document, open that and update the reference"
    path = notes.attempt(above.subject, "occurrences' paths", path_of, occurrence)
    if path is None:
        return None
    subject = Subject("occurrence", path)
    component = notes.attempt(subject, "component", lambda: occurrence.component, todo=todo)
    T = notes.attempt(subject, "position", _pose, occurrence, above.T, todo=todo)
    if T is None or component is None:
        return None
    if not is_rigid(T):
        message = f"occurrence {path!r} is mirrored or scaled: make its component anew"
        notes.add("error", subject, "not-rigid", message)
    return Place(path, above.path, occurrence, component, T)


def _pose(occurrence: Any, above: Transform) -> Transform:
    """The pose of an occurrence in the root frame.

    `transform2` is documented as "in its assembly context", so in the root frame for an occurrence
    that was reached from the root. In case a version of Fusion tells it relative to the occurrence
    above, that is seen by its being the same as that of the native occurrence. (`transform` is
    retired: it was wrong in some cases.)
    """
    told = frame(occurrence.transform2)
    native = occurrence.nativeObject
    if native is None:
        return told
    own = frame(native.transform2)
    composed = above.compose(own)
    return composed if same_frame(told, own) and not same_frame(told, composed) else told


def each_in(
    place: Place, collection: Callable[[], Any], notes: Notes, kind: str
) -> Iterator[tuple[Any, str, Any]]:
    """Native entity, name and proxy of every item of one of the place's collections.

    Args:
        place: The place.
        collection: Gives the collection of native entities.
        notes: Takes what fails.
        kind: What it holds: `body`, `group`, `joint` or `point`.
    """
    what = "bodies" if kind == "body" else f"{kind}s"
    for native in items(collection, notes, place.subject, what):
        name = notes.attempt(place.subject, f"{what}' names", name_of, native)
        if name is None:
            continue
        subject = subject_in(place, kind, name)
        proxy = notes.attempt(subject, "place", place.of, native)
        if proxy is not None:
            yield native, name, proxy


def name_of(entity: Any) -> str:
    """The name of anything that has one."""
    return str(entity.name)


def path_of(occurrence: Any) -> str:
    """The full path of an occurrence."""
    return str(occurrence.fullPathName)


def subject_in(place: Place, kind: str, name: str) -> Subject:
    """The subject of findings about something in a place; bodies are told apart by their place."""
    return Subject(kind, place.named(name) if kind == "body" else name)
