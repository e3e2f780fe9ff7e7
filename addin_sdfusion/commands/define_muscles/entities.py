"""The construction points and wrap faces of a design, by what its snapshot calls them."""

from __future__ import annotations

from typing import Any

from ...muscles.muscle_attributes import GROUP, WRAP
from ...snapshot import DesignSnapshot


class Entities:
    """Construction points and wrap faces.

    Attributes:
        points: Construction points that are in the snapshot, or were picked.
        faces: Faces with a wrap attribute.
    """

    def __init__(self, design: Any, snapshot: DesignSnapshot) -> None:
        self.points: dict[str, Any] = {}
        self.faces: dict[str, Any] = {}
        self._keys: dict[tuple[str, str], str] = {}
        root = design.rootComponent
        components: dict[str, Any] = {o.fullPathName: o.component for o in root.allOccurrences}
        components[""] = root
        for point in snapshot.points:
            component = components.get(point.occurrence)
            if component is None:
                continue
            found = component.constructionPoints.itemByName(point.name)
            if found is not None:
                key = point.entity or f"{point.occurrence}/{point.name}"
                self.points[key] = found
                self._keys[component.id, point.name] = key
        free = [a for a in design.findAttributes(GROUP, WRAP) if a.parent is not None]
        for surface in snapshot.surfaces:
            text = surface.attributes.get(WRAP)
            match = next((a for a in free if a.value == text), None)
            if match is not None and surface.entity not in self.faces:
                free.remove(match)
                self.faces[surface.entity] = match.parent

    def point_key(self, point: Any) -> str:
        """What the snapshot calls a construction point, or a name for one that it has not."""
        native = point.nativeObject or point
        place = native.component.id, native.name
        if place not in self._keys:
            self._keys[place] = f"picked:{place[0]}/{place[1]}"
            self.points[self._keys[place]] = native
        return self._keys[place]

    def face_key(self, face: Any) -> str:
        """What the snapshot calls a face, or a name for one that it has not."""
        native = face.nativeObject or face
        for key, known in self.faces.items():
            if known == native:
                return key
        key = f"picked:face {len(self.faces)}"
        self.faces[key] = native
        return key
