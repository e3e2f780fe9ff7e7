"""Checks that all numbers are finite, except limits that may be infinite."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import astuple

from ..finding import Finding, Subject
from ..finding_builders import all_muscles, all_task_frames, error, finite
from ..model.joint import Coordinate, Joint
from ..model.muscle import Muscle, WrapSurface
from ..model.robot import SHAPE_SIZES, Link, Robot


def numbers(robot: Robot) -> Iterator[Finding]:
    """Check that no number is NaN, and that only limits are infinite."""
    yield from _report(Subject("robot", robot.name), "gravity", robot.gravity)
    for link in robot.links:
        yield from _report(Subject("link", link.name), "mass or inertia", link_numbers(link))
        yield from _report(Subject("link", link.name), "end", link.end or ())
        yield from _report(Subject("link", link.name), "mesh", mesh_numbers(link))
        yield from _shapes(link)
    for joint in robot.joints:
        yield from _report(Subject("joint", joint.name), "pose or axis", joint_numbers(joint))
        for c in joint.coordinates:
            subject = Subject("coordinate", c.name)
            yield from _report(
                subject, "initial value, damping or armature", (c.initial, c.damping, c.armature)
            )
            resisting = (c.stiffness, c.rest, c.friction)
            yield from _report(subject, "spring or friction", resisting)
            yield from _limits(subject, c)
            if c.limit_force is not None:
                yield from _report(subject, "limit force", astuple(c.limit_force))
    for subject, muscle in all_muscles(robot):
        yield from _report(subject, "via point or force limit", muscle_numbers(muscle))
        yield from _report(subject, "condition, branch or term", path_numbers(muscle))
        yield from _report(subject, "cable or pulley parameter", cable_numbers(muscle))
    for surface in robot.wrap_surfaces:
        subject = Subject("wrap_surface", surface.name)
        yield from _report(subject, "pose, radius or length", surface_numbers(surface))
    for subject, frame in all_task_frames(robot):
        yield from _report(subject, "position", frame.position)


def link_numbers(link: Link) -> tuple[float, ...]:
    """Return mass, centre of mass and inertia matrix of a link."""
    i = link.inertia
    return (i.mass, *i.com, i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz)


def mesh_numbers(link: Link) -> tuple[float, ...]:
    """Return poses and scales of a link's meshes."""
    return tuple(
        number
        for mesh in link.meshes
        for number in (*mesh.pose.position, *mesh.pose.rpy, *mesh.scale)
    )


def _shapes(link: Link) -> Iterator[Finding]:
    subject = Subject("link", link.name)
    for shape in link.shapes:
        yield from _report(subject, "shape", (*shape.pose.position, *shape.pose.rpy, *shape.sizes))
        count = SHAPE_SIZES[shape.kind]
        if len(shape.sizes) != count or any(size <= 0.0 for size in shape.sizes):
            listed = " ".join(f"{size:g}" for size in shape.sizes)
            problem = f"its {shape.kind} needs {count} positive sizes, not {listed or 'none'}"
            yield error(subject, "bad-size", problem)


def joint_numbers(joint: Joint) -> tuple[float, ...]:
    """Return axes and poses of a joint."""
    poses = (joint.T_parent_joint, joint.T_child_joint)
    axes = [number for motion in joint.motions for number in motion.axis]
    return (*axes, *(number for pose in poses for number in (*pose.position, *pose.rpy)))


def muscle_numbers(muscle: Muscle) -> tuple[float, ...]:
    """Return via points and force limits of a muscle, except an infinite f_max."""
    points = [number for point in muscle.via_points for number in point.position]
    upper = () if muscle.f_max == math.inf else (muscle.f_max,)
    return (*points, muscle.f_min, *upper)


def path_numbers(muscle: Muscle) -> tuple[float, ...]:
    """Return the numbers of conditions, branches, terms and side points of a muscle's path.

    Infinite limits of conditions are omitted.
    """
    conditions = [point.when for point in muscle.via_points if point.when is not None]
    ranges = [x for when in conditions for x in (when.low, when.high) if not math.isinf(x)]
    sides = [wrap.side_point.position for wrap in muscle.wraps if wrap.side_point is not None]
    return (
        *ranges,
        *(when.smoothing for when in conditions),
        *(branch.divisor for branch in muscle.branches),
        *(term.factor for term in muscle.terms),
        *(x for position in sides for x in position),
    )


def cable_numbers(muscle: Muscle) -> tuple[float, ...]:
    """Return friction, presliding, cable parameters and pulley parameters of a muscle."""
    pulley = muscle.pulley.parameters if muscle.pulley else ()
    rows = (row for _, row in pulley)
    parameters = (number for _, number in muscle.model.parameters)
    coefficients = [point.friction for point in muscle.via_points]
    coefficients += [wrap.friction for wrap in muscle.wraps]
    friction = (muscle.friction, *(mu for mu in coefficients if mu is not None))
    return (*friction, muscle.presliding, *parameters, *(n for row in rows for n in row))


def surface_numbers(surface: WrapSurface) -> tuple[float, ...]:
    """Return pose and sizes of a wrap surface, except an infinite length."""
    length = () if surface.length == math.inf else (surface.length,)
    axes = surface.half_axes or ()
    return (*surface.pose.position, *surface.pose.rpy, surface.radius, *length, *axes)


def _limits(subject: Subject, c: Coordinate) -> Iterator[Finding]:
    lower = () if c.lower == -math.inf else (c.lower,)
    upper = () if c.upper == math.inf else (c.upper,)
    yield from _report(subject, "limit", lower + upper)
    weakest = () if c.tau_min == -math.inf else (c.tau_min,)
    strongest = () if c.tau_max == math.inf else (c.tau_max,)
    yield from _report(subject, "motor limit", weakest + strongest)


def _report(subject: Subject, label: str, values: Iterable[float]) -> Iterator[Finding]:
    if not finite(values):
        yield error(subject, "not-finite", f"{label} is not a finite number")
