"""Names that SDF files need in addition to the names of the robot."""

from __future__ import annotations

from itertools import count, islice

from ...model.pose import Pose
from ...model.robot import Link
from ...model.rotations import inverse
from ..writing.xml_text import written

MODEL_FRAME = "__model__"
NO_LIMIT = 1e16
"""Value that represents no limit in SDF, in [rad] or [m]."""


def joint_frame_name(joint: str, child: str) -> str:
    """Return the name of the frame that stores T_child_joint without rounding errors."""
    return f"{joint}_in_{child}"


def needs_frame(T_child_joint: Pose) -> bool:
    """Return whether inverting T_child_joint twice changes any bit."""
    (x, y, z), (roll, pitch, yaw) = (
        map(written, part) for part in (inverse(T_child_joint).position, inverse(T_child_joint).rpy)
    )
    return inverse(Pose((x, y, z), (roll, pitch, yaw))) != T_child_joint


def mesh_names(link: Link) -> list[str]:
    """Return a unique name for each mesh: its name, or a new name if it has none."""
    original = {(mesh.role, mesh.name) for mesh in link.meshes}
    used: set[tuple[str, str]] = set()
    names = []
    for k, mesh in enumerate(link.meshes):
        name = mesh.name
        if not name or (mesh.role, name) in used:
            name = f"{name or link.name}_{k}"
            while (mesh.role, name) in original or (mesh.role, name) in used:
                name += "_"
        used.add((mesh.role, name))
        names.append(name)
    return names


def shape_names(link: Link) -> list[str]:
    """Return names for the shapes that differ from the names of collision meshes."""
    used = {n for m, n in zip(link.meshes, mesh_names(link), strict=True) if m.role == "collision"}
    free = (name for k in count(1) if (name := f"{link.name}_shape_{k}") not in used)
    return list(islice(free, len(link.shapes)))
