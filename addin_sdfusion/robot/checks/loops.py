"""Checks of loop joints: links, type and axes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..finding import Finding, Subject
from ..finding_builders import error, finite
from ..model.joint import Joint
from ..model.loop import AXES, LOOP_TYPES, LoopJoint
from ..model.robot import WORLD, Robot
from ..model.rotations import dot
from .tree import AXIS_TOLERANCE, link_ends, unit_axis


def loop_ends(robot: Robot) -> Iterator[Finding]:
    """Check that both links of every loop joint exist and can move relative to each other."""
    yield from link_ends(robot, robot.loops)
    bodies = rigid_bodies(robot.joints)
    for loop in robot.loops:
        if loop.parent in bodies and bodies[loop.parent] == bodies.get(loop.child):
            problem = (
                f"connects {loop.parent!r} and {loop.child!r}, which are one rigid body; remove it"
            )
            yield error(Subject("joint", loop.name), "loop-of-no-length", problem)


def loop_axes(robot: Robot) -> Iterator[Finding]:
    """Check type and axes: unit vectors, which are orthogonal for a universal joint."""
    for loop in robot.loops:
        subject = Subject("joint", loop.name)
        if loop.type not in LOOP_TYPES:
            problem = f"type {loop.type!r} cannot close a loop; use one of {', '.join(LOOP_TYPES)}"
            yield error(subject, "unsupported-loop", problem)
        elif len(loop.axes) != AXES[loop.type]:
            problem = f"a {loop.type} loop joint has {AXES[loop.type]} axes, not {len(loop.axes)}"
            yield error(subject, "wrong-axes", problem)
        else:
            yield from _axes(loop, subject)


def _axes(loop: LoopJoint, subject: Subject) -> Iterator[Finding]:
    for axis in loop.axes:
        if not finite(axis):
            yield error(subject, "not-finite", f"the axis {axis!r} is not finite")
        yield from unit_axis(subject, axis)
    if loop.type == "universal" and not abs(dot(*loop.axes)) <= AXIS_TOLERANCE:
        problem = "the axes of a universal loop joint are not orthogonal"
        yield error(subject, "axes-not-orthogonal", problem)
    for pose in (loop.T_parent_joint, loop.T_child_joint):
        if not finite((*pose.position, *pose.rpy)):
            yield error(subject, "not-finite", "the pose of its frame is not finite")


def rigid_bodies(joints: Sequence[Joint]) -> dict[str, str]:
    """Return a representative link of the rigid body of each link.

    Links that are fixed to each other have the same representative.

    Args:
        joints: Joints of the tree, parents first.
    """
    bodies = {WORLD: WORLD}
    for joint in joints:
        bodies[joint.child] = (
            joint.child if joint.motions else bodies.get(joint.parent, joint.parent)
        )
    return bodies
