"""Names that an SDF file needs beside those of the robot."""

from __future__ import annotations

from .chain import Names
from .model import Link
from .placement import Pose
from .pose import inverse

MODEL_FRAME = "__model__"


def joint_frame_name(joint: str, child: str) -> str:
    """The name of the frame that keeps a rotated T_child_joint exactly."""
    return f"{joint}_in_{child}"


def needs_frame(T_child_joint: Pose) -> bool:
    """Whether the inverse of T_child_joint does not give it back bit by bit."""
    return inverse(inverse(T_child_joint)) != T_child_joint


def mesh_names(link: Link) -> list[str]:
    """A name for each mesh: its own, or in SDF's need one that is there and not yet taken."""
    names = {role: Names() for role in ("visual", "collision")}
    return [names[mesh.role].give(mesh.name or f"{link.name}_{mesh.role}") for mesh in link.meshes]
