"""Construction points, wrap faces and picked entities of a design, by key."""

from __future__ import annotations

from typing import Any

from ...fusion.handles import Handles
from ...fusion.occurrences import component_id, readable_occurrences
from ...fusion.points import hidden_points
from ...muscles.attributes import GROUP, WRAP
from ...muscles.stored import stored_surface
from ...snapshot import KEPT, DesignSnapshot, SurfaceSnapshot
from .model.picks import HANDLE


class Entities:
    """Entities to which the rows of the muscle table belong.

    Attributes:
        points: Construction points in the snapshot and picked construction points.
        faces: Faces with a wrap attribute and picked faces.
        picked: Other picked entities that define a point, by handle.
    """

    def __init__(self, design: Any, snapshot: DesignSnapshot) -> None:
        self.points, self.faces = Handles(design), Handles(design)
        self.picked = Handles(design)
        occurrences = readable_occurrences(design.rootComponent)
        components = {path: o.component for path, o in occurrences.items()}
        for point in snapshot.points:
            component = components.get(point.occurrence)
            if component is None or point.entity.startswith(KEPT):
                continue
            native = component.constructionPoints.itemByName(point.name)
            if native is not None:
                self.points[point.entity or f"{point.occurrence}/{point.name}"] = native
        visible = {component_id(component) for component in components.values()}
        for key, point, _ in hidden_points(design, visible):
            self.points[key] = point
        free = [a for a in design.findAttributes(GROUP, WRAP) if a.parent is not None]
        for surface in snapshot.surfaces:
            component = components.get(surface.occurrence)
            match = next((a for a in free if _is_of(a, surface, component)), None)
            if match is not None and surface.entity not in self.faces:
                free.remove(match)
                self.faces[surface.entity] = match.parent

    def point_key(self, point: Any) -> str:
        """Return the key of a construction point; a new key if it is not in the snapshot."""
        return _key(self.points, point, "point")

    def face_key(self, face: Any) -> str:
        """Return the key of a face; a new key if it is not in the snapshot."""
        return _key(self.faces, face, "face")

    def handle(self, entity: Any) -> str:
        """Return a new handle of a picked entity."""
        handle = f"{HANDLE}{len(self.picked)}"
        self.picked[handle] = entity
        return handle


def _is_of(attribute: Any, surface: SurfaceSnapshot, component: Any) -> bool:
    """Return whether an attribute contains the use of a surface of a component."""
    use, read = surface.use, stored_surface({WRAP: attribute.value}, "", [])
    if use is None or read is None:
        return False
    is_hidden = surface.lost and not surface.occurrence
    if not is_hidden and attribute.parent.body.parentComponent != component:
        return False
    return (use.name, use.link, use.muscles) == (read.name, read.link, read.muscles)


def _key(handles: Handles, entity: Any, kind: str) -> str:
    """Return the key of an entity, compared by identity.

    Copies of a document have the same ids and names.
    """
    native = entity.nativeObject or entity
    for key in handles:
        if handles.get(key) == native:
            return str(key)
    key = f"picked:{kind} {len(handles)}"
    handles[key] = native
    return key
