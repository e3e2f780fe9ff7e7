"""Fields of the blob for loop joints: the scalar constraint equations of each loop joint."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import LoopJoint, Robot

from .arrays import FloatArray
from .frames import Place, transform

_POINT, _DIRECTION = 0, 1
"""enum closure of layout.h."""


class Closure(NamedTuple):
    """Constraint u·(p_B - p_A) = 0 or u·v = 0 in the joint frames A and B of a loop joint.

    Attributes:
        kind: Whether the equation constrains a point or a direction.
        u: Unit vector in A, shape (3,).
        w: For a direction, the direction of v in A when the loop is closed, shape (3,); zero if
            both signs are allowed.
        v: For a direction, the unit vector in B, shape (3,).
    """

    loop: LoopJoint
    kind: int
    u: FloatArray
    w: FloatArray
    v: FloatArray

    @property
    def unit(self) -> str:
        """Unit of the gap of this equation."""
        return "m" if self.kind == _POINT else "rad"


def closures(robot: Robot) -> list[Closure]:
    """Return the equations of all loop joints, for each joint first points, then directions."""
    return [closure for loop in robot.loops for closure in _joint_closures(loop)]


def _joint_closures(loop: LoopJoint) -> Iterator[Closure]:
    basis = _basis(loop)
    a, b, c = basis
    points = {"prismatic": (b, c), "cylindrical": (b, c), "planar": (a,)}
    directions = {
        "fixed": ((a, b), (b, c), (c, a)),
        "prismatic": ((a, b), (b, c), (c, a)),
        "revolute": ((b, a), (c, a)),
        "cylindrical": ((b, a), (c, a)),
        "planar": ((b, a), (c, a)),
    }
    none = np.zeros(3)
    for u in points.get(loop.type, basis):
        yield Closure(loop, _POINT, u, none, none)
    for u, v in directions.get(loop.type, ()):
        yield Closure(loop, _DIRECTION, u, v, v)
    if loop.type == "universal":
        yield Closure(loop, _DIRECTION, a, none, b)


def _basis(loop: LoopJoint) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return an orthonormal basis whose first vector is along the joint's first axis.

    For a universal joint, the second vector is along the second axis.
    """
    if not loop.axes:
        x, y, z = np.eye(3)
        return x, y, z
    a = np.array(loop.axes[0]) / np.linalg.norm(loop.axes[0])
    least = np.eye(3)[np.argmin(np.abs(a))]
    second = np.array(loop.axes[1]) if loop.type == "universal" else np.cross(a, least)
    second = second - a * (a @ second)
    b = second / np.linalg.norm(second)
    return a, b, np.cross(a, b)


def loop_fields(robot: Robot, places: Mapping[str, Place]) -> dict[str, ArrayLike]:
    """Return the fields for loop joints by name."""
    kinds, frames, along, at, other = [], [], [], [], []
    for kind, loop, u, w, v in ((c.kind, c.loop, c.u, c.w, c.v) for c in closures(robot)):
        A, B = places[loop.parent], places[loop.child]
        T_A = A.T_frame_link @ transform(loop.T_parent_joint)
        T_B = B.T_frame_link @ transform(loop.T_child_joint)
        kinds.append(kind)
        frames.append((A.frame, B.frame))
        along.append(T_A[:3, :3] @ u)
        at.append(T_A[:3, 3] if kind == _POINT else T_A[:3, :3] @ w)
        other.append(T_B[:3, 3] if kind == _POINT else T_B[:3, :3] @ v)
    return {
        "closure_kind": kinds,
        "closure_frame": frames,
        "closure_along": along,
        "closure_at": at,
        "closure_other": other,
    }
