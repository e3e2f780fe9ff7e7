"""A six-legged robot that was read in real Fusion, drawn in the fake.

The data are in a folder next to the repository: 97 occurrences, 18 joints, 49 rigid groups.
"""

from __future__ import annotations

import json
import math
from pathlib import Path as File
from typing import Any

import numpy as np
import pytest
from fake_fusion import Builder
from fake_fusion.maths import inverse
from fake_fusion.model.data import Path

FOLDER = File(__file__).parents[3] / "../shared/fusion"


def live_data(name: str) -> Any:
    """Return the data of a file next to the repository."""
    file = FOLDER / name
    if not file.is_file():
        pytest.skip(f"{name} does not exist")
    return json.loads(file.read_text())


class Drawn:
    """The robot drawn in the fake.

    Attributes:
        data: Data read in Fusion.
        build: Builder of the design.
        paths: Path of every occurrence by its full path name.
    """

    def __init__(self) -> None:
        self.data = live_data("live_assembly.json")
        self.build = Builder("six legs")
        self.poses = {
            o["full_path"]: np.array(o["transform2_cm"]).reshape(4, 4)
            for o in self.data["occurrences"]
        }
        self.paths: dict[str, Path] = {"": ()}
        self._components: dict[str, Any] = {}
        for full in self.poses:
            self._place(full)
        for joint in self.data["as_built_joints"]:
            self._joint(joint)
        for k, group in enumerate(self.data["rigid_groups"]):
            self._group(f"group {k}", group)

    def _place(self, full: str) -> None:
        above, _, leaf = full.rpartition("+")
        T = inverse(self.poses[above]) @ self.poses[full] if above else self.poses[full]
        holder = self.paths[above]
        component, number = leaf.split(":")
        shelf = holder[-1].component.occurrences if holder else self.build.root.occurrences
        known = next((o for o in shelf if o.name == leaf), None)
        if known is None:
            made = self._components.get(component)
            path = self.build.place(made or component, T, above=holder)
            path[-1].name = f"{component}:{number}"
            self._components[component] = path[-1].component
        else:  # a part of another copy of the leg, or with another pose in it
            path = (*holder, known)
            if len(path) > 2 and not np.allclose(known.T, T, atol=1e-6):
                path[0].component.poses[path[1:]] = T
        self.paths[full] = path

    def _joint(self, joint: dict[str, Any]) -> None:
        leg = self.paths[joint["assembly_context"]]
        if any(known.name == joint["name"] for known in leg[-1].component.as_built):
            return  # listed for every leg but defined once
        limits = joint["limits"]
        self.build.joint(
            joint["name"],
            joint["type"],
            self.paths[joint["occurrence_one"]],
            self.paths[joint["occurrence_two"]],
            T=np.array(joint["AsBuiltJoint.transform_as_reported_cm"]).reshape(4, 4),
            values=[math.radians(joint["rotation_value_deg"])],
            limits=[tuple(math.radians(limits[f"{end}_deg"]) for end in ("minimum", "maximum"))],
            inside=leg,
            as_built=True,
            dragged=True,
        )

    def _group(self, name: str, group: dict[str, Any]) -> None:
        members = [self.paths[full] for full in group["occurrences"]]
        leg = members[0][:1] if members else ()
        shelf = leg[-1].component.groups if leg else self.build.root.groups
        own = [m[1:] for m in members]
        if not leg or all(known.members != own for known in shelf):
            self.build.rigid_group(name, members, inside=leg, stale=not group["name_readable"])
