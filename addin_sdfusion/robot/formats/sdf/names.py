"""Names that an SDF file needs beside those of the robot."""

from __future__ import annotations

from itertools import count, islice

from ...model.pose import Pose
from ...model.robot import Link
from ...model.rotations import inverse
from ..writing.xml_text import written

MODEL_FRAME = "__model__"
NO_LIMIT = 1e16
"""SDF's own value for a limit that is none, in [rad] or [m]."""


def joint_frame_name(joint: str, child: str) -> str:
    """Return the name of the frame that keeps a rotated T_child_joint exactly."""
    return f"{joint}_in_{child}"


def needs_frame(T_child_joint: Pose) -> bool:
    """Return whether the inverse of T_child_joint does not give it back bit by bit."""
    (x, y, z), (roll, pitch, yaw) = (
        map(written, part) for part in (inverse(T_child_joint).position, inverse(T_child_joint).rpy)
    )
    return inverse(Pose((x, y, z), (roll, pitch, yaw))) != T_child_joint


def mesh_names(link: Link) -> list[str]:
    """A name for each mesh: its own, or where SDF needs it one that is there and not yet taken."""
    taken = {(mesh.role, mesh.name) for mesh in link.meshes}
    given: set[tuple[str, str]] = set()
    names = []
    for k, mesh in enumerate(link.meshes):
        name = mesh.name
        if not name or (mesh.role, name) in given:
            name = f"{name or link.name}_{k}"
            while (mesh.role, name) in taken or (mesh.role, name) in given:
                name += "_"
        given.add((mesh.role, name))
        names.append(name)
    return names


def shape_names(link: Link) -> list[str]:
    """Return a name for each shape that no collision mesh has."""
    taken = {n for m, n in zip(link.meshes, mesh_names(link), strict=True) if m.role == "collision"}
    free = (name for k in count(1) if (name := f"{link.name}_shape_{k}") not in taken)
    return list(islice(free, len(link.shapes)))
