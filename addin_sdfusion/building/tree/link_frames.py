"""Frames of links, and the joints between them.

If all coordinates are zero, the frame of every link is parallel to the world frame. Its origin is
the origin of the joint that connects the link to its parent. The design may have any pose: the
displacement of the preceding joints is removed from each joint.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ...robot.model.joint import Coordinate, Joint, Motion
from ...robot.model.pose import Pose, Vector3
from ...robot.model.robot import WORLD
from ...robot.model.rotations import add, normalized, subtract
from ...robot.model.transform import IDENTITY, Transform, tidy
from ...snapshot import MotionSnapshot
from ..joints.checks import coordinate_name
from ..joints.edges import Edge
from ..joints.motion import joint_motion
from .tree import Branch


class Frames(NamedTuple):
    """The joints of a robot and the poses of its links.

    Attributes:
        joints: Joints, parents first.
        T_world_link: Pose of every link at the pose of the design.
    """

    joints: tuple[Joint, ...]
    T_world_link: dict[str, Transform]


class _LinkPose(NamedTuple):
    """Pose of a link.

    Attributes:
        displaced: Displacement from the zero pose to the pose of the design.
        origin: Origin of the link frame at the zero pose, in [m].
    """

    displaced: Transform
    origin: Vector3


def place_links(branches: Sequence[Branch]) -> Frames:
    """Return the joints and link poses of a tree.

    Args:
        branches: Branches of the tree, parents first.
    """
    placed: dict[str | None, _LinkPose] = {None: _LinkPose(IDENTITY, IDENTITY.p)}
    joints = []
    for branch in branches:
        parent = placed[branch.parent]
        joint, placed[branch.child] = _place_link(branch, parent)
        joints.append(joint)
    poses = {
        link: Transform(at.displaced.R, at.displaced.apply(at.origin))
        for link, at in placed.items()
        if link is not None
    }
    return Frames(tuple(joints), poses)


def _place_link(branch: Branch, parent: _LinkPose) -> tuple[Joint, _LinkPose]:
    edge = branch.edge
    where = joint_origin(edge)
    if where is None:
        where = parent.displaced.apply(parent.origin)
    motions = edge.motions
    if branch.child != edge.one:
        where, motions = _reverse_joint(where, motions)
    back = parent.displaced.inverse()
    origin = back.apply(where)
    displaced = joint_motion(motions).about(where).compose(parent.displaced)
    axes = [tidy(normalized(back.rotate(motion.axis))) for motion in motions]
    joint = Joint(
        edge.name,
        WORLD if branch.parent is None else branch.parent,
        branch.child,
        tuple(
            Motion(m.kind, axis, k) for k, (m, axis) in enumerate(zip(motions, axes, strict=True))
        ),
        tuple(_coordinate(edge, motion) for motion in motions),
        Pose(tidy(subtract(origin, parent.origin))),
    )
    return joint, _LinkPose(displaced, origin)


def joint_origin(edge: Edge) -> Vector3 | None:
    """Return the position of the joint on `two`, before it slides.

    The origin on `one` takes precedence, since the axis moves with `one`.
    """
    if edge.origin_one is not None:
        return subtract(edge.origin_one, joint_motion(edge.motions).p)
    return edge.origin_two


def _reverse_joint(
    where: Vector3, motions: tuple[MotionSnapshot, ...]
) -> tuple[Vector3, tuple[MotionSnapshot, ...]]:
    """Return a joint from `one` to `two`: the inverse motions in reverse order."""
    T = joint_motion(motions)
    single = len(motions) == 1  # the axis of a single motion is the same on both sides
    axes = [motion.axis if single else T.rotate(motion.axis) for motion in motions]
    turned = [
        replace(motion, axis=subtract((0.0, 0.0, 0.0), axis))
        for motion, axis in zip(motions, axes, strict=True)
    ]
    return add(where, T.p), tuple(reversed(turned))


def _coordinate(edge: Edge, motion: MotionSnapshot) -> Coordinate:
    return Coordinate(
        coordinate_name(edge.name, motion, len(edge.motions)),
        -math.inf if motion.lower is None else motion.lower,
        math.inf if motion.upper is None else motion.upper,
        motion.value + 0.0,
        motion.damping,
        "rad" if motion.kind == "rotation" else "m",
        stiffness=motion.stiffness,
        rest=motion.rest,
        friction=motion.friction,
        tau_min=-math.inf if motion.effort is None else -motion.effort,
        tau_max=math.inf if motion.effort is None else motion.effort,
        max_velocity=math.inf if motion.velocity is None else motion.velocity,
    )
