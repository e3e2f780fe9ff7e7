"""Loop joints as conditions on points, for formats without such joints.

ball         a point of the child coincides with a point of the parent
revolute     two such points on the axis
universal    one such point; points on the two axes have the distance that makes the axes
             orthogonal
cylindrical  two points of the child on a line of the parent
prismatic    a third point on a parallel line
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from ..model.loop import LoopJoint
from ..model.pose import IDENTITY, Pose, Vector3
from ..model.rotations import (
    Matrix3,
    apply,
    axis_rotation,
    cross,
    dot,
    multiply,
    normalized,
    perpendicular,
    rotate,
    rotation,
    rpy,
    scale,
    subtract,
    transpose,
)
from .joint_chains import Names

ARM = 0.1
"""Distance of the points from the origin of the joint frame, in [m]."""
_EQUAL = 1e-9
_SAME_AXIS = 1e-14

Kind = Literal["point", "line", "distance"]
_Shift = tuple[str, Kind, Vector3, Vector3]


@dataclass(frozen=True, slots=True)
class LoopPoint:
    """A condition on a point of each of two links.

    Attributes:
        parent, child: The links.
        kind: `point`: both points coincide; `line`: the point of the child is on a line through
            the point of the parent; `distance`: the points have a constant distance.
        in_parent, in_child: The points in the frames of the links, in [m].
        direction: Unit vector along the line in the frame of the parent.
        distance: In [m].
    """

    name: str
    parent: str
    child: str
    kind: Kind
    in_parent: Vector3
    in_child: Vector3
    direction: Vector3 = (0.0, 0.0, 0.0)
    distance: float = 0.0


def loop_points(loop: LoopJoint, names: Names) -> tuple[LoopPoint, ...]:
    """Return the conditions of a loop joint; none for types that points cannot represent.

    Args:
        loop: The loop joint, whose name the first condition has.
        names: Names of other conditions.
    """
    shifts = _shifts(loop)
    if shifts is None:
        return ()
    zero = IDENTITY.position
    direction = rotate(rotation(loop.T_parent_joint.rpy), loop.axes[0]) if loop.axes else zero
    return tuple(
        LoopPoint(
            names.unique(f"{loop.name}{suffix}") if suffix else loop.name,
            loop.parent,
            loop.child,
            kind,
            apply(loop.T_parent_joint, of_parent),
            apply(loop.T_child_joint, of_child),
            direction if kind == "line" else zero,
            math.sqrt(2.0) * ARM if kind == "distance" else 0.0,
        )
        for suffix, kind, of_parent, of_child in shifts
    )


def _shifts(loop: LoopJoint) -> tuple[_Shift, ...] | None:
    """Return suffix, kind and the points in the joint frames of parent and child, in [m]."""
    zero = IDENTITY.position
    along = [scale(ARM, axis) for axis in loop.axes]
    if loop.type == "ball":
        return (("", "point", zero, zero),)
    if loop.type == "revolute":
        return ("", "point", zero, zero), ("_axis", "point", along[0], along[0])
    if loop.type == "universal":
        return ("", "point", zero, zero), ("_axes", "distance", along[0], along[1])
    if loop.type not in ("cylindrical", "prismatic"):
        return None
    first: tuple[_Shift, _Shift] = ("", "line", zero, zero), ("_axis", "line", zero, along[0])
    side = scale(ARM, _orthogonal(loop.axes[0]))
    return first if loop.type == "cylindrical" else (*first, ("_turn", "line", side, side))


def join_points(
    parts: Sequence[LoopJoint | LoopPoint],
) -> tuple[tuple[LoopJoint, ...], tuple[LoopPoint, ...]]:
    """Return loop joints from consecutive conditions between the same links, and other conditions.

    A loop joint has the name of its first condition.
    """
    joints: list[LoopJoint] = []
    others: list[LoopPoint] = []
    k = 0
    while k < len(parts):
        first = parts[k]
        if isinstance(first, LoopJoint):
            joints.append(first)
            k += 1
            continue
        same = [
            p for p in parts[k : k + 3] if isinstance(p, LoopPoint) and _ends(p) == _ends(first)
        ]
        joint, count = _joint(same)
        if joint is None:
            others.append(first)
        else:
            joints.append(joint)
        k += count
    return tuple(joints), tuple(others)


def _ends(point: LoopPoint) -> tuple[str, str]:
    return point.parent, point.child


def _joint(points: Sequence[LoopPoint]) -> tuple[LoopJoint | None, int]:
    """Return the loop joint of the first conditions, and their number; None if they are none."""
    kinds = "".join(point.kind[0] for point in points)
    if kinds == "lll" and (joint := _prismatic(*points)) is not None:
        return joint, 3
    if kinds.startswith("ll") and (joint := _cylindrical(*points[:2])) is not None:
        return joint, 2
    if kinds.startswith("pd") and (joint := _universal(*points[:2])) is not None:
        return joint, 2
    if kinds.startswith("pp") and (joint := _revolute(*points[:2])) is not None:
        return joint, 2
    if kinds.startswith("p"):
        return _loop_joint(points[0], "ball"), 1
    return None, 1


def _revolute(first: LoopPoint, second: LoopPoint) -> LoopJoint | None:
    in_parent, in_child = _between(first, second)
    if not _is_same_length(in_parent, in_child):
        return None
    axis = normalized(in_parent)
    return _loop_joint(first, "revolute", (axis,), _smallest_rotation(axis, normalized(in_child)))


def _universal(first: LoopPoint, second: LoopPoint) -> LoopJoint | None:
    in_parent, in_child = _between(first, second)
    length = math.hypot(*in_parent)
    is_square = abs(second.distance - math.sqrt(2.0) * length) <= _EQUAL * length
    if not is_square or not _is_same_length(in_parent, in_child):
        return None
    axis = normalized(in_parent)
    other = _orthogonal(axis)
    R = _smallest_rotation(other, normalized(in_child))
    return _loop_joint(first, "universal", (axis, other), R)


def _cylindrical(first: LoopPoint, second: LoopPoint) -> LoopJoint | None:
    in_parent, in_child = _between(first, second)
    is_one_line = math.hypot(*cross(first.direction, second.direction)) <= _EQUAL
    is_one_line &= math.hypot(*cross(first.direction, in_parent)) <= _EQUAL
    if not is_one_line or not any(in_child):
        return None
    axis = first.direction
    return _loop_joint(
        first, "cylindrical", (axis,), _smallest_rotation(axis, normalized(in_child))
    )


def _prismatic(first: LoopPoint, second: LoopPoint, third: LoopPoint) -> LoopJoint | None:
    hinge = _cylindrical(first, second)
    is_parallel = math.hypot(*cross(first.direction, third.direction)) <= _EQUAL
    if hinge is None or not is_parallel:
        return None
    axis, (side, side_in_child) = first.direction, _between(first, third)
    axis_in_child = normalized(subtract(second.in_child, first.in_child))
    across = perpendicular(side, axis)
    across_in_child = perpendicular(side_in_child, axis_in_child)
    if not _is_same_length(across, across_in_child):
        return None
    R = multiply(
        transpose(_frame(axis_in_child, normalized(across_in_child))),
        _frame(axis, normalized(across)),
    )
    return _loop_joint(first, "prismatic", (axis,), R)


def _loop_joint(
    first: LoopPoint,
    kind: Literal["ball", "revolute", "universal", "cylindrical", "prismatic"],
    axes: tuple[Vector3, ...] = (),
    R: Matrix3 | None = None,
) -> LoopJoint:
    turned = IDENTITY.rpy if R is None else rpy(R)
    ends = Pose(first.in_parent), Pose(first.in_child, turned)
    return LoopJoint(first.name, first.parent, first.child, kind, axes, *ends)


def _between(first: LoopPoint, second: LoopPoint) -> tuple[Vector3, Vector3]:
    in_parent = subtract(second.in_parent, first.in_parent)
    return in_parent, subtract(second.in_child, first.in_child)


def _is_same_length(a: Vector3, b: Vector3) -> bool:
    length = math.hypot(*a)
    return length > 0.0 and abs(math.hypot(*b) - length) <= _EQUAL * length


def _orthogonal(axis: Vector3) -> Vector3:
    """Return a unit vector orthogonal to a unit vector."""
    least = min((abs(x), k) for k, x in enumerate(axis))[1]
    return normalized(cross(axis, (float(least == 0), float(least == 1), float(least == 2))))


def _frame(x: Vector3, y: Vector3) -> Matrix3:
    """Return the matrix whose rows are two orthogonal unit vectors and their cross product."""
    return x, y, cross(x, y)


def _smallest_rotation(a: Vector3, b: Vector3) -> Matrix3 | None:
    """Return the smallest rotation of a unit vector to another one; None if they are equal."""
    across = cross(a, b)
    sine = math.hypot(*across)
    if sine <= _SAME_AXIS and dot(a, b) > 0.0:
        return None
    if sine <= _SAME_AXIS:
        across = _orthogonal(a)
    return axis_rotation(normalized(across), math.atan2(sine, dot(a, b)))
