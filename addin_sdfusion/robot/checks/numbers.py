"""Checks that all numbers are finite, except limits that may be infinite."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields, is_dataclass

from ..finding import Finding, Subject
from ..finding_builders import all_muscles, all_task_frames, error, finite
from ..model.joint import Coordinate, Joint
from ..model.muscle import Muscle
from ..model.robot import SHAPE_SIZES, Link, Robot


def numbers(robot: Robot) -> Iterator[Finding]:
    """Check that no number is NaN, and that only limits are infinite."""
    yield from _report(Subject("robot", robot.name), "gravity", robot.gravity)
    for link in robot.links:
        subject = Subject("link", link.name)
        yield from _report(subject, "mass or inertia", link.inertia)
        yield from _report(subject, "end", link.end)
        yield from _report(subject, "mesh", *((mesh.pose, mesh.scale) for mesh in link.meshes))
        yield from _shapes(subject, link)
    for joint in robot.joints:
        yield from _report(Subject("joint", joint.name), "pose or axis", *joint_numbers(joint))
        for c in joint.coordinates:
            yield from _coordinate(Subject("coordinate", c.name), c)
    for subject, muscle in all_muscles(robot):
        yield from _muscle(subject, muscle)
    for surface in robot.wrap_surfaces:
        sizes = (surface.radius, _limit(surface.length, math.inf), surface.half_axes)
        subject = Subject("wrap_surface", surface.name)
        yield from _report(subject, "pose, radius or length", surface.pose, sizes)
    for subject, frame in all_task_frames(robot):
        yield from _report(subject, "position", frame.position)


def floats(part: object) -> Iterator[float]:
    """Return all floating-point numbers of nested dataclasses and tuples."""
    if isinstance(part, float):
        yield part
    elif isinstance(part, tuple):
        for entry in part:
            yield from floats(entry)
    elif is_dataclass(part):
        for field in fields(part):
            yield from floats(getattr(part, field.name))


def joint_numbers(joint: Joint) -> Iterator[float]:
    """Return axes and poses of a joint."""
    axes = tuple(motion.axis for motion in joint.motions)
    return floats((joint.T_parent_joint, joint.T_child_joint, axes))


def _shapes(subject: Subject, link: Link) -> Iterator[Finding]:
    for shape in link.shapes:
        yield from _report(subject, "shape", shape.pose, shape.sizes)
        count = SHAPE_SIZES[shape.kind]
        if len(shape.sizes) != count or any(size <= 0.0 for size in shape.sizes):
            listed = " ".join(f"{size:g}" for size in shape.sizes)
            problem = f"its {shape.kind} needs {count} positive sizes, not {listed or 'none'}"
            yield error(subject, "bad-size", problem)


def _coordinate(subject: Subject, c: Coordinate) -> Iterator[Finding]:
    yield from _report(
        subject, "initial value, damping or armature", c.initial, c.damping, c.armature
    )
    yield from _report(subject, "spring or friction", c.stiffness, c.rest, c.friction)
    limits = (_limit(c.lower, -math.inf), _limit(c.upper, math.inf))
    yield from _report(subject, "limit", limits)
    motor = (_limit(c.tau_min, -math.inf), _limit(c.tau_max, math.inf))
    yield from _report(subject, "motor limit", motor)
    yield from _report(subject, "limit force", c.limit_force)


def _muscle(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    points, wraps = muscle.via_points, muscle.wraps
    forces = (muscle.f_min, _limit(muscle.f_max, math.inf))
    positions = tuple(point.position for point in points)
    yield from _report(subject, "via point or force limit", positions, forces)
    conditions = [point.when for point in points if point.when is not None]
    ranges = [x for when in conditions for x in (when.low, when.high) if not math.isinf(x)]
    smoothing = [when.smoothing for when in conditions]
    sides = [wrap.side_point.position for wrap in wraps if wrap.side_point is not None]
    parts = (*ranges, *smoothing, muscle.branches, muscle.terms, *sides)
    yield from _report(subject, "condition, branch or term", *parts)
    frictions = (muscle.friction, *(point.friction for point in points))
    frictions += (*(wrap.friction for wrap in wraps), muscle.presliding)
    pulley = muscle.pulley and muscle.pulley.parameters
    cable = (*frictions, muscle.model.parameters, pulley)
    yield from _report(subject, "cable or pulley parameter", *cable)


def _limit(value: float, unlimited: float) -> float | None:
    return None if value == unlimited else value


def _report(subject: Subject, label: str, *parts: object) -> Iterator[Finding]:
    if not finite(floats(parts)):
        yield error(subject, "not-finite", f"{label} is not a finite number")
