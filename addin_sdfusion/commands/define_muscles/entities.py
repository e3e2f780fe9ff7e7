"""Construction points and wrap faces of a design, by the keys of its snapshot."""

from __future__ import annotations

from typing import Any

from ...fusion.inserted import KEPT
from ...fusion.occurrences import every_occurrence
from ...muscles.attributes import GROUP, WRAP, stored_surface
from ...snapshot import DesignSnapshot, SurfaceUse


class Entities:
    """Construction points and wrap faces.

    Attributes:
        points: Construction points in the snapshot and picked construction points.
        faces: Faces with a wrap attribute.
    """

    def __init__(self, design: Any, snapshot: DesignSnapshot) -> None:
        self.points: dict[str, Any] = {}
        self.faces: dict[str, Any] = {}
        root = design.rootComponent
        components: dict[str, Any] = {"": root}
        components |= {o.fullPathName: o.component for o in every_occurrence(root)}
        for point in snapshot.points:
            component = components.get(point.occurrence)
            if component is None or point.entity.startswith(KEPT):
                continue
            found = component.constructionPoints.itemByName(point.name)
            if found is not None:
                self.points[point.entity or f"{point.occurrence}/{point.name}"] = found
        free = [a for a in design.findAttributes(GROUP, WRAP) if a.parent is not None]
        for surface in snapshot.surfaces:
            match = next((a for a in free if _use(a.value) == surface.use), None)
            if match is not None and surface.entity not in self.faces:
                free.remove(match)
                self.faces[surface.entity] = match.parent

    def point_key(self, point: Any) -> str:
        """Return the key of a construction point; a new key if it is not in the snapshot."""
        return _key(self.points, point, "point")

    def face_key(self, face: Any) -> str:
        """Return the key of a face; a new key if it is not in the snapshot."""
        return _key(self.faces, face, "face")


def _use(text: str) -> SurfaceUse | None:
    return stored_surface({WRAP: text}, "", [])


def _key(known: dict[str, Any], entity: Any, kind: str) -> str:
    """Return the key of an entity, compared by identity.

    Copies of a document have the same ids and names.
    """
    native = entity.nativeObject or entity
    for key, other in known.items():
        if other == native:
            return key
    key = f"picked:{kind} {len(known)}"
    known[key] = native
    return key
