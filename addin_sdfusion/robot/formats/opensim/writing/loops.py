"""Writer of loop joints in OpenSim: coincident points, welded frames."""

from __future__ import annotations

from xml.etree import ElementTree

from ....model.loop import LoopJoint
from ....model.pose import Pose
from ....model.rotations import rotation
from ...writing.xml_text import element, numbers
from .bodies import frame_path, placement

CONSTRAINTS = {"ball": "PointConstraint", "fixed": "WeldConstraint"}
"""OpenSim class of each supported type of loop joint; hinges are written as two balls."""


def add_loop(constraints: ElementTree.Element, loop: LoopJoint) -> None:
    """Add a loop joint of a supported type."""
    node = element(constraints, CONSTRAINTS[loop.type], name=loop.name)
    ends = (loop.parent, loop.T_parent_joint), (loop.child, loop.T_child_joint)
    if loop.type == "ball":
        for k, (link, _) in enumerate(ends, start=1):
            element(node, f"socket_body_{k}", frame_path(link))
        for k, (_, T) in enumerate(ends, start=1):
            element(node, f"location_body_{k}", numbers(T.position))
        return
    for k in (1, 2):
        element(node, f"socket_frame{k}", f"{loop.name}_{k}")
    frames = element(node, "frames")
    for k, (link, T) in enumerate(ends, start=1):
        _add_frame(frames, f"{loop.name}_{k}", link, T)


def _add_frame(frames: ElementTree.Element, name: str, link: str, T: Pose) -> None:
    frame = element(frames, "PhysicalOffsetFrame", name=name)
    element(frame, "socket_parent", frame_path(link))
    placement(frame, ("translation", "orientation"), T.position, rotation(T.rpy))
