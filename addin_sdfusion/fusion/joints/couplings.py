"""Conversion of the motion links of a design to couplings of joint motions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import adsk.fusion

from ...robot.finding import Subject
from ...snapshot import CouplingSnapshot, JointSnapshot, MotionSnapshot
from ..health import problem_of
from ..notes import Notes, optional
from ..occurrences import Occurrence, Occurrences, each_in, path_of, subject_in
from ..units import CM, finite

Joints = Mapping[tuple[str, str, bool], JointSnapshot]
"""Joints by path of the occurrence, original name, and whether they are as-built."""


def read_couplings(
    occurrences: Occurrences, joints: Joints, notes: Notes
) -> Iterator[CouplingSnapshot]:
    """Yield the motion links in every occurrence; they exist in Fusion since November 2025."""
    for occurrence in occurrences.values():
        component = occurrence.component
        if not optional(lambda: int(component.motionLinks.count)):  # noqa: B023 -- called at once
            continue
        motion_links = each_in(occurrence, lambda: component.motionLinks, notes, "motion link")  # noqa: B023
        for _, name, link in motion_links:
            subject = subject_in(occurrence, "motion link", name)
            read = notes.attempt(
                subject, "motions", _coupling, link, occurrence, joints, subject, notes
            )
            if read is not None:
                yield read


def _coupling(
    link: Any, occurrence: Occurrence, joints: Joints, subject: Subject, notes: Notes
) -> CouplingSnapshot | None:
    """Return the coupling of two motions with a constant ratio and their current offset."""
    if link.isSuppressed:
        return None
    problem = problem_of(link, subject, notes)
    if problem:
        message = f"motion link {subject.name!r} is not exported: {problem}"
        notes.warn(subject, "motion-link", message)
        return None
    one = _joint(link.jointOne, occurrence, joints)
    two = one if link.jointTwo is None else _joint(link.jointTwo, occurrence, joints)
    leader, follower = _motion(one, link.motionOne), _motion(two, link.motionTwo)
    ratio = _amount(link.valueTwo, follower) / _amount(link.valueOne, leader)
    if link.isReversed:
        ratio = -ratio
    offset = follower.value - ratio * leader.value
    return CouplingSnapshot(two.name, one.name, ratio, offset, follower.role, leader.role)


def _joint(joint: Any, occurrence: Occurrence, joints: Joints) -> JointSnapshot:
    as_built = adsk.fusion.AsBuiltJoint.cast(joint) is not None
    context = joint.assemblyContext
    path = occurrence.path if context is None else path_of(context)
    snapshot = joints.get((path, str(joint.name), as_built))
    if snapshot is None:
        raise ValueError(f"joint {joint.name!r} is not in the design")
    return snapshot


def _motion(joint: JointSnapshot, kind: int) -> MotionSnapshot:
    role = _roles()[kind]
    motion = next((m for m in joint.motions if m.role == role), None)
    if motion is None:
        raise ValueError(f"joint {joint.name!r} has no motion {role or 'of this kind'}")
    return motion


def _amount(parameter: Any, motion: MotionSnapshot) -> float:
    """Return a value of a motion link, in [rad] or [m]."""
    value = finite(parameter.value) * (1.0 if motion.kind == "rotation" else CM)
    if value == 0.0:
        raise ValueError("one of its values is 0")
    return value


def _roles() -> dict[int, str]:
    types = adsk.fusion.JointMotionTypes
    return {
        types.BallJointPitchMotionType: "pitch",
        types.BallJointRollMotionType: "roll",
        types.BallJointYawMotionType: "yaw",
        types.CylindricalJointRotateMotionType: "rotation",
        types.CylindricalJointSlideMotionType: "slide",
        types.PinSlotJointRotateMotionType: "rotation",
        types.PinSlotJointSlideMotionType: "slide",
        types.PlanarJointRotateMotionType: "rotation",
        types.PlanarJointSlideOneMotionType: "primary_slide",
        types.PlanarJointSlideTwoMotionType: "secondary_slide",
        types.RevoluteJointRotateMotionType: "",
        types.SliderJointSlideMotionType: "",
    }
