"""Loop joints of a design: the joints at which its closed loops are cut."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from ...robot.finding import Finding, Subject
from ...robot.finding_builders import warning
from ...robot.model.loop import LoopJoint, LoopType
from ...robot.model.pose import Pose, Vector3
from ...robot.model.robot import WORLD
from ...robot.model.rotations import add, dot, multiply, normalized, subtract
from ...robot.model.transform import IDENTITY, Transform, tidy
from ..joints.edges import Edge
from ..joints.motion import joint_motion
from .cuts import closing_type, lost_properties
from .link_frames import joint_origin

_PARALLEL = 1e-12


class Loops(NamedTuple):
    """Loop joints of a robot."""

    joints: tuple[LoopJoint, ...]
    findings: tuple[Finding, ...]


def loop_joints(closings: Iterable[Edge], T_world_link: Mapping[str, Transform]) -> Loops:
    """Return the loop joints of the edges that close loops.

    The loops are closed at the pose of the design.

    Args:
        closings: The edges, each of a type that can close a loop.
        T_world_link: Poses of the links at the pose of the design.
    """
    joints, findings = [], []
    for edge in closings:
        joints.append(_loop_joint(edge, T_world_link))
        lost = lost_properties(edge)
        if lost:
            problem = (
                f"is cut to close a loop, so it has no coordinates; its {', '.join(lost)} are "
                "omitted. To keep them, cut another joint of the loop in Export"
            )
            findings.append(warning(Subject("joint", edge.name), "loop-joint-forces", problem))
    return Loops(tuple(joints), tuple(findings))


def _loop_joint(edge: Edge, T_world_link: Mapping[str, Transform]) -> LoopJoint:
    """Return a loop joint whose frame on `two` is parallel to the frame of this link."""
    closing = closing_type(edge)
    assert closing is not None, edge.name
    kind, axes = closing
    T_two, T_one = (
        IDENTITY if link is None else T_world_link[link] for link in (edge.two, edge.one)
    )
    where = joint_origin(edge) or T_two.p
    moved = joint_motion(edge.motions)
    axes_in_link = tuple(tidy(normalized(T_two.inverse().rotate(axis))) for axis in axes)
    R_one = multiply(moved.R, T_two.R)
    if _is_free(kind, axes, axes_in_link, T_one):
        R_one = T_one.R
    at_two = T_two.inverse().compose(Transform(T_two.R, where)).pose()
    at_one = T_one.inverse().compose(Transform(R_one, add(where, moved.p))).pose()
    at_two, at_one = replace(at_two, rpy=IDENTITY.p), _without_noise(at_one)
    ends = (edge.two or WORLD, at_two), (edge.one or WORLD, at_one)
    if edge.one is None:
        ends, axes_in_link = ends[::-1], axes_in_link[::-1]
    (parent, T_parent_joint), (child, T_child_joint) = ends
    return LoopJoint(edge.name, parent, child, kind, axes_in_link, T_parent_joint, T_child_joint)


def _is_free(
    kind: LoopType, axes: Sequence[Vector3], axes_in_link: Sequence[Vector3], T_one: Transform
) -> bool:
    """Return whether the frame on `one` can be parallel to the frame of this link."""
    if kind == "ball":
        return True
    if kind not in ("revolute", "cylindrical", "planar"):
        return False
    apart = subtract(T_one.inverse().rotate(axes[0]), axes_in_link[0])
    return dot(apart, apart) <= _PARALLEL**2


def _without_noise(pose: Pose) -> Pose:
    """Return the pose without rotation if its rotation is only rounding noise."""
    is_noise = max(map(abs, pose.rpy)) <= _PARALLEL
    return replace(pose, rpy=IDENTITY.p) if is_noise else pose
