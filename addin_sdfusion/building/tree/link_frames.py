"""Frames of links, and the joints between them.

With all coordinates at zero every link's frame is parallel to the world's, and its origin is that
of the joint that carries it. The design may have any pose: each joint is moved back by what the
joints before it are displaced.
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
    """The joints of a robot and where its links are.

    Attributes:
        joints: Parents first.
        T_world_link: Pose of every link at the design's pose.
    """

    joints: tuple[Joint, ...]
    T_world_link: dict[str, Transform]


class _Placed(NamedTuple):
    """A link.

    Attributes:
        displaced: Displacement from the zero pose to that of the design.
        origin: Of its frame at the zero pose, in [m].
    """

    displaced: Transform
    origin: Vector3


def place_links(branches: Sequence[Branch]) -> Frames:
    """Place the links of a tree, whose branches are in order, parents first."""
    placed: dict[str | None, _Placed] = {None: _Placed(IDENTITY, IDENTITY.p)}
    joints = []
    for branch in branches:
        parent = placed[branch.parent]
        joint, placed[branch.child] = _carried(branch, parent)
        joints.append(joint)
    poses = {
        link: Transform(at.displaced.R, at.displaced.apply(at.origin))
        for link, at in placed.items()
        if link is not None
    }
    return Frames(tuple(joints), poses)


def _carried(branch: Branch, parent: _Placed) -> tuple[Joint, _Placed]:
    edge = branch.edge
    where = _origin(edge)
    if where is None:
        where = parent.displaced.apply(parent.origin)
    motions = edge.motions
    if branch.child != edge.one:
        where, motions = _reversed(where, motions)
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
    return joint, _Placed(displaced, origin)


def _origin(edge: Edge) -> Vector3 | None:
    """Where the joint is on `two`: before it slides. What `one` says counts, as its axis turns."""
    if edge.origin_one is not None:
        return subtract(edge.origin_one, joint_motion(edge.motions).p)
    return edge.origin_two


def _reversed(
    where: Vector3, motions: tuple[MotionSnapshot, ...]
) -> tuple[Vector3, tuple[MotionSnapshot, ...]]:
    """Return a joint as seen from `one`: the motions undone, the last one first."""
    T = joint_motion(motions)
    single = len(motions) == 1  # its axis is the same on both sides
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
    )
