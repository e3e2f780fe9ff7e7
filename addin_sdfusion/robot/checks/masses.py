"""Checks of masses and inertias: physically possible, and positive along every joint motion."""

from __future__ import annotations

from collections.abc import Iterator

from ..finding import Finding, Subject
from ..finding_builders import error, finite, warning
from ..model.joint import Joint
from ..model.pose import IDENTITY, Pose, Vector3
from ..model.robot import Link, Robot
from ..model.rotations import (
    Matrix3,
    compose,
    cross,
    dot,
    inverse,
    rotate,
    rotation,
    subtract,
)
from .numbers import floats, joint_numbers

MINOR_TOLERANCE = 1e-9
"""Tolerance for negative minors, relative to the largest entry of the matrix."""
ZERO_INERTIA = 1e-15
"""Inertia that is considered zero, in [kg·m²]: below any machine part, above rounding errors."""


def inertias(robot: Robot) -> Iterator[Finding]:
    """Check that masses are not negative and inertia matrices are physically possible."""
    for link in robot.links:
        if not finite(floats(link.inertia)):
            continue
        subject = Subject("link", link.name)
        if link.inertia.mass < 0.0:
            yield error(subject, "negative-mass", f"mass {link.inertia.mass!r} is negative")
        if not positive_semidefinite(link.inertia.matrix):
            problem = "the inertia matrix is not positive semi-definite; correct its entries"
            yield error(subject, "inertia-not-psd", problem)
        elif not positive_semidefinite(density_matrix(link.inertia.matrix)):
            problem = (
                "a principal moment of inertia exceeds the sum of the other two, which is "
                "physically impossible; is the matrix about the centre of mass?"
            )
            yield warning(subject, "inertia-triangle", problem)


def moving_bodies(robot: Robot) -> Iterator[Finding]:
    """Check that every last moving body has inertia about, or mass along, its joint axis."""
    if robot.joints and all(
        not link.inertia.mass and not any(floats(link.inertia.matrix)) for link in robot.links
    ):
        problem = (
            "no link has a mass; muscle lengths and moment arms are available, but the robot "
            "cannot be simulated"
        )
        yield warning(Subject("robot", robot.name), "no-masses", problem)
        return
    links = {link.name: link for link in robot.links}
    carried: dict[str, list[Joint]] = {}
    for joint in robot.joints:
        carried.setdefault(joint.parent, []).append(joint)
    for joint in {joint.child: joint for joint in robot.joints if joint.type != "fixed"}.values():
        body = _body(joint, carried)
        if body is None or not all(name in links for name in body):
            continue
        parts = [(links[name], pose) for name, pose in body.items()]
        if not all(finite(floats(link.inertia)) for link, _ in parts):
            continue
        subject = Subject("link", joint.child)
        if not joint.is_plain or any(c.armature for c in joint.coordinates):
            continue  # the check of the mass matrix covers these joints
        last = joint.motions[-1]
        if last.kind == "translation" and sum(link.inertia.mass for link, _ in parts) == 0.0:
            problem = f"no mass moves along joint {joint.name!r}; give the link a mass"
            yield error(subject, "no-mass-along-axis", problem)
        if last.kind == "rotation" and _inertia_about(joint, parts) <= ZERO_INERTIA:
            problem = (
                f"no inertia about joint {joint.name!r}; give the link a mass away from the axis "
                "or an inertia about it"
            )
            yield error(subject, "no-inertia-about-axis", problem)


def inertia_about_axis(robot: Robot) -> Iterator[Finding]:
    """Check that each link on a revolute joint has inertia about the axis through its COM."""
    links = {link.name: link for link in robot.links}
    for joint in robot.joints:
        link = links.get(joint.child)
        if joint.type != "revolute" or link is None or not _usable(joint, link):
            continue
        axis = _last_axis(joint)
        about_com = dot(axis, rotate(link.inertia.matrix, axis))
        if about_com <= MINOR_TOLERANCE * max(link.inertia.ixx, link.inertia.iyy, link.inertia.izz):
            problem = (
                f"inertia about the axis of joint {joint.name!r} through the centre of mass is "
                "zero; only the mass away from the axis contributes"
            )
            yield warning(Subject("link", link.name), "zero-inertia-about-axis", problem)


def positive_semidefinite(A: Matrix3) -> bool:
    """Return whether a symmetric matrix is positive semi-definite, within rounding errors."""
    scale = max(abs(entry) for row in A for entry in row)
    if scale == 0.0:
        return True
    a, b, c = ((row[0] / scale, row[1] / scale, row[2] / scale) for row in A)
    minors = (
        a[0],
        b[1],
        c[2],
        a[0] * b[1] - a[1] * a[1],
        a[0] * c[2] - a[2] * a[2],
        b[1] * c[2] - b[2] * b[2],
        dot(a, cross(b, c)),
    )
    return all(minor >= -MINOR_TOLERANCE for minor in minors)


def density_matrix(inertia: Matrix3) -> Matrix3:
    """Return ∫ r rᵀ dm = ½ tr(I) 1 - I.

    It is positive semi-definite exactly if the triangle inequality of the moments holds.

    Args:
        inertia: Inertia matrix about the centre of mass, in [kg·m²].
    """
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    half = 0.5 * (xx + yy + zz)
    return (half - xx, -xy, -xz), (-xy, half - yy, -yz), (-xz, -yz, half - zz)


def _usable(joint: Joint, link: Link) -> bool:
    return finite(floats(link.inertia)) and finite(joint_numbers(joint))


def _body(joint: Joint, carried: dict[str, list[Joint]]) -> dict[str, Pose] | None:
    """Return the joint's child and all links fixed to it, with poses in the child's frame.

    Return None if another joint moves a link on this body, since it is then not the last one.
    """
    body = {joint.child: IDENTITY}
    waiting = [joint.child]
    while waiting:
        name = waiting.pop()
        for other in carried.get(name, []):
            if other.child in body:
                continue
            if other.type != "fixed" or not finite(joint_numbers(other)):
                return None
            T_parent_child = compose(other.T_parent_joint, inverse(other.T_child_joint))
            body[other.child] = compose(body[name], T_parent_child)
            waiting.append(other.child)
    return body if finite(joint_numbers(joint)) else None


def _inertia_about(joint: Joint, parts: list[tuple[Link, Pose]]) -> float:
    """Return the inertia of links about a joint's last axis, in [kg·m²].

    Poses are in the child's frame.
    """
    axis = _last_axis(joint)
    total = 0.0
    for link, T_child_link in parts:
        inertia = link.inertia.in_frame(T_child_link)
        lever = cross(axis, subtract(inertia.com, joint.T_child_joint.position))
        total += dot(axis, rotate(inertia.matrix, axis)) + inertia.mass * dot(lever, lever)
    return total


def _last_axis(joint: Joint) -> Vector3:
    """Return the axis of a joint's last motion, in the child's frame."""
    return rotate(rotation(joint.T_child_joint.rpy), joint.motions[-1].axis)
