"""Findings on single joints of a design."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...robot.finding import Finding, Subject
from ...robot.finding_builders import error, finite, warning
from ...robot.model.rotations import dot, subtract
from ...snapshot import JointSnapshot, MotionSnapshot
from .motion import joint_motion

APART = 1e-5
"""Maximum distance of the two sides of a joint that coincide, in [m]."""


def joint_errors(subject: Subject, joint: JointSnapshot) -> list[Finding]:
    """Return the error that prevents the export of a joint, if there is one."""
    if joint.problem:
        problem = f"is broken: {joint.problem.strip()}; edit it until the design shows no error"
        return [error(subject, "broken-joint", problem)]
    if joint.kind == "inferred":
        problem = (
            "has an inferred type, which has no axes; edit it and choose rigid, revolute, slider, "
            "cylindrical, pin-slot, planar or ball"
        )
        return [error(subject, "unsupported-joint", problem)]
    if joint.one is None or joint.two is None:
        problem = "does not specify which components it connects; edit it and select both again"
        return [error(subject, "joint-without-component", problem)]
    if not finite(_numbers(joint)):
        return [error(subject, "not-finite", "its origin, axis or value is not a finite number")]
    if joint.kind == "rigid":
        return []
    if not joint.motions:
        return [error(subject, "joint-without-motion", "has no motion; delete and create it again")]
    if any(not any(motion.axis) for motion in joint.motions):
        return [
            error(subject, "zero-axis", "has an axis without direction; edit it and choose one")
        ]
    turns = any(motion.kind == "rotation" for motion in joint.motions)
    if turns and joint.origin_one is None and joint.origin_two is None:
        problem = "does not specify its position; edit it and select its origins again"
        return [error(subject, "joint-without-origin", problem)]
    return []


def joint_warnings(subject: Subject, joint: JointSnapshot) -> Iterator[Finding]:
    """Yield warnings on a joint that can be exported."""
    if joint.kind == "rigid":
        return
    if joint.locked:
        problem = "is locked in the design but exported as movable; make it rigid to fix it"
        yield warning(subject, "locked-joint", problem)
    if joint.kind == "ball" and any(motion.value for motion in joint.motions):
        problem = (
            "the ball joint is rotated, and the design does not specify the order of rotations; "
            "pitch, yaw, roll is used. Move it to its home position before the export"
        )
        yield warning(subject, "ball-joint-turned", problem)
    yield from _limits(subject, joint)
    yield from _origins(subject, joint)


def coordinate_name(joint: str, motion: MotionSnapshot, count: int) -> str:
    """Return the name of the coordinate of a motion: the joint's name if it has only one."""
    return joint if count == 1 else f"{joint}_{motion.role or motion.kind}"


def _limits(subject: Subject, joint: JointSnapshot) -> Iterator[Finding]:
    for motion in joint.motions:
        if motion.lower is None or motion.lower != motion.upper:
            continue
        problem = (
            f"both limits are {motion.lower:g}, so it cannot move; edit the limits of joint "
            f"{subject.name!r} or make it rigid"
        )
        called = coordinate_name(subject.name, motion, len(joint.motions))
        yield warning(Subject("coordinate", called), "zero-limits", problem)


def _origins(subject: Subject, joint: JointSnapshot) -> Iterator[Finding]:
    """Yield a warning if the two sides of a joint are apart.

    The motions of the joint and an offset along its axis are allowed.
    """
    if joint.origin_one is None or joint.origin_two is None:
        return
    apart = subtract(subtract(joint.origin_one, joint.origin_two), joint_motion(joint.motions).p)
    rotations = [motion.axis for motion in joint.motions if motion.kind == "rotation"]
    along = dot(apart, rotations[0]) if len(rotations) == 1 else 0.0
    distance = math.sqrt(max(dot(apart, apart) - along * along, 0.0))
    if rotations and distance > APART:
        problem = (
            f"its two sides are {1e3 * distance:.3g} mm apart perpendicular to its axis; the axis "
            "of the moving side is used. Edit its offset if this is not intended"
        )
        yield warning(subject, "joint-sides-apart", problem)


def _numbers(joint: JointSnapshot) -> Iterator[float]:
    yield from joint.origin_one or ()
    yield from joint.origin_two or ()
    for motion in joint.motions:
        yield from motion.axis
        yield motion.value
