"""Simulated user of the add-in in a design with all kinds of entities to pick."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from fake_fusion import Builder
from fake_fusion.maths import rotation, translation

DEFINE = "cardsflowDefineMuscles"


def build_arm(**more: Any) -> Any:
    """Draw a torso and a rotated arm with a nested hand, with all kinds of entities to pick."""
    build = Builder("robot", **more)
    torso = build.place("torso", translation((1.0, 2.0, 3.0)), grounded=True)
    holder = build.place("holder", rotation(0.7, (1.0, 2.0, 3.0)) @ translation((5.0, 0.0, 1.0)))
    arm = build.place(
        "arm", rotation(-1.1, (0.0, 1.0, 1.0)) @ translation((0.0, 4.0, 0.0)), above=holder
    )
    build.box(torso, (2.0, 3.0, 4.0))
    build.cylinder(arm, 1.0, 6.0)
    build.sphere(arm, 1.5, translation((0.0, 0.0, 5.0)))
    build.torus(arm, 3.0, 0.5)
    build.sketch(arm, points=[(1.0, 2.0, 0.0)])
    build.point(arm, (0.0, 1.0, 2.0), "my own point")
    build.joint(
        "shoulder", "revolute", one=arm, two=torso, origin=(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0)
    )
    build.rigid_group("EXPORT_torso", [torso])
    build.rigid_group("EXPORT_arm", [holder])
    build.done()
    return build


class User:
    """Simulated user, who finds the entities to click."""

    def __init__(self, fusion: Any) -> None:
        self.fusion = fusion
        self.root = fusion.design.rootComponent

    def define(self, *points: Any) -> Any:
        """Return the open dialog of Define muscles with picked points."""
        command = self.fusion.run_command(DEFINE)
        for entity in points:
            command.pick("pick", entity)
            assert command["pick"].selectionCount == 0
        return command

    def occurrence(self, name: str) -> Any:
        return next(o for o in self.root.allOccurrences if o.component.name == name)

    def body(self, name: str, index: int = 0) -> Any:
        return self.occurrence(name).bRepBodies.item(index)

    def vertex(self, index: int = 0) -> Any:
        return self.body("torso").vertices.item(index)

    def vertices(self, count: int) -> list[Any]:
        return [self.vertex(k) for k in range(count)]

    def face(self, kind: str) -> Any:
        bodies = self.occurrence("arm").bRepBodies
        for i in range(bodies.count):
            for j in range(bodies.item(i).faces.count):
                face = bodies.item(i).faces.item(j)
                if type(face.geometry).__name__ == kind:
                    return face
        raise AssertionError(kind)

    def circle(self) -> Any:
        return self.body("arm").edges.item(0)

    def sketch_point(self) -> Any:
        arm = self.occurrence("arm")
        return arm.component.sketches.item(0).sketchPoints.item(0).createForAssemblyContext(arm)

    def own_point(self) -> Any:
        arm = self.occurrence("arm")
        return arm.component.constructionPoints.itemByName("my own point").createForAssemblyContext(
            arm
        )

    def points(self) -> dict[str, np.ndarray]:
        """Return the construction points by name, in the root frame, in [cm]."""
        found = {}
        places = [(self.root, None)] + [(o.component, o) for o in self.root.allOccurrences]
        for component, occurrence in places:
            for i in range(component.constructionPoints.count):
                point = component.constructionPoints.item(i)
                seen = point.createForAssemblyContext(occurrence) if occurrence else point
                found[point.name] = np.array(seen.geometry.asArray())
        return found

    def attribute(self, name: str) -> dict[str, Any]:
        """Return the attribute of a construction point."""
        for component in (self.root, *(o.component for o in self.root.allOccurrences)):
            point = component.constructionPoints.itemByName(name)
            if point is not None:
                return json.loads(point.attributes.itemByName("CARDSFlow", "point").value)
        raise KeyError(name)
