"""Writer of loop joints in OpenSim: conditions on points, welded frames."""

from __future__ import annotations

from xml.etree import ElementTree

from ....model.loop import LoopJoint, LoopType
from ....transforms.joint_chains import Names
from ....transforms.loop_points import LoopPoint, loop_points
from ...writing.xml_text import element, numbers
from .bodies import add_frame, frame_path

SUPPORTED: tuple[LoopType, ...] = (
    "fixed",
    "ball",
    "revolute",
    "universal",
    "cylindrical",
    "prismatic",
)
"""Types of loop joints that OpenSim's constraints can represent."""


def add_loop(constraints: ElementTree.Element, loop: LoopJoint, names: Names) -> None:
    """Add the constraints of a loop joint of a supported type."""
    if loop.type == "fixed":
        _add_weld(constraints, loop)
    for point in loop_points(loop, names):
        _add_point(constraints, point)


def _add_point(constraints: ElementTree.Element, point: LoopPoint) -> None:
    ends = frame_path(point.parent), frame_path(point.child)
    if point.kind == "line":
        node = element(constraints, "PointOnLineConstraint", name=point.name)
        for tag, link in zip(("line_body", "follower_body"), ends, strict=True):
            element(node, f"socket_{tag}", link)
        element(node, "line_direction_vec", numbers(point.direction))
        element(node, "point_on_line", numbers(point.in_parent))
        element(node, "point_on_follower", numbers(point.in_child))
        return
    is_point = point.kind == "point"
    tag = "PointConstraint" if is_point else "ConstantDistanceConstraint"
    node = element(constraints, tag, name=point.name)
    for k, link in enumerate(ends, start=1):
        element(node, f"socket_body_{k}", link)
    for k, place in enumerate((point.in_parent, point.in_child), start=1):
        element(node, f"location_body_{k}", numbers(place))
    if not is_point:
        element(node, "constant_distance", numbers([point.distance]))


def _add_weld(constraints: ElementTree.Element, loop: LoopJoint) -> None:
    node = element(constraints, "WeldConstraint", name=loop.name)
    ends = (loop.parent, loop.T_parent_joint), (loop.child, loop.T_child_joint)
    for k in (1, 2):
        element(node, f"socket_frame{k}", f"{loop.name}_{k}")
    frames = element(node, "frames")
    for k, (link, T) in enumerate(ends, start=1):
        add_frame(frames, f"{loop.name}_{k}", link, T)
