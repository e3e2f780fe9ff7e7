"""Conversion of the mass properties of CAD bodies to inertia matrices, and their sums.

CAD systems report the moments of inertia about the origin of the root frame. They do not document
whether the products of inertia are the matrix entries, -∫ x y dm, or ∫ x y dm. The principal
moments about the centre of mass determine the sign, since they equal the eigenvalues only with
the correct sign. They cannot determine it if the principal axes are parallel to the frame. Then
the sign that fits the other bodies of the design is used.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Literal, NamedTuple

from ..robot.model.pose import Vector3
from ..robot.model.robot import Inertia
from ..robot.model.rotations import (
    Matrix3,
    add,
    point_inertia,
    rotate,
    rotate_inertia,
    subtract,
    transpose,
)
from ..robot.model.transform import IDENTITY, Transform
from .eigenvalues import eigenvalues
from .parts import MassSnapshot

Sign = Literal[1, -1]

MISMATCH = 1e-3
"""Maximum deviation of the principal moments from the eigenvalues, relative to the largest."""
_MIN_DEVIATION = 1e-9  # of the wrong sign, relative to the largest moment, in addition to rounding
_MAX_RATIO = 0.1  # of the deviations with the right and the wrong sign
_ROUNDING = 1e-14


class Part(NamedTuple):
    """Mass properties of a rigid body.

    Attributes:
        mass: In [kg].
        com: Centre of mass, in [m].
        inertia: About the centre of mass, in [kg·m²].
    """

    mass: float
    com: Vector3
    inertia: Matrix3


def is_usable(mass: MassSnapshot) -> bool:
    """Return whether all values are finite and the mass is positive."""
    numbers = (mass.mass, *mass.com, *mass.moments, *mass.principal)
    return all(map(math.isfinite, numbers)) and mass.mass > 0.0


def part(mass: MassSnapshot, sign: Sign) -> Part:
    """Return the mass properties with the inertia about the centre of mass.

    Args:
        mass: Mass properties with moments about the origin of the root frame.
        sign: 1 if the products are entries of the inertia matrix, -1 if they are its negatives.
    """
    xx, yy, zz, xy, yz, xz = mass.moments
    xy, yz, xz = sign * xy, sign * yz, sign * xz
    about_origin = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    return Part(
        mass.mass, mass.com, _subtract_matrix(about_origin, point_inertia(mass.mass, mass.com))
    )


def eigenvalue_error(mass: MassSnapshot, sign: Sign) -> float:
    """Return the largest deviation of the eigenvalues from the principal moments, relative."""
    largest = max(map(abs, mass.principal))
    if largest == 0.0:
        return 0.0 if not any(mass.moments) else math.inf
    pairs = zip(eigenvalues(part(mass, sign).inertia), sorted(mass.principal), strict=True)
    return max(abs(a - b) for a, b in pairs) / largest


def rounding(mass: MassSnapshot) -> float:
    """Return the contribution of rounding to `eigenvalue_error`.

    It is large for a small body far from the origin.
    """
    largest = max(map(abs, mass.principal))
    return _ROUNDING * max(map(abs, mass.moments)) / largest if largest > 0.0 else 0.0


def sign_of(mass: MassSnapshot) -> Sign | None:
    """Return the sign that fits the principal moments; None if both or none fit."""
    plus, minus = eigenvalue_error(mass, 1), eigenvalue_error(mass, -1)
    worse = max(plus, minus)
    if worse <= _MIN_DEVIATION + rounding(mass) or min(plus, minus) > _MAX_RATIO * worse:
        return None
    return 1 if plus < minus else -1


def common_sign(masses: Iterable[MassSnapshot]) -> Sign:
    """Return the sign of the products of a design by majority; 1 if it cannot be determined."""
    votes = sum(sign_of(mass) or 0 for mass in masses)
    return -1 if votes < 0 else 1


def moved(mass: MassSnapshot, T_a_b: Transform, sign: Sign) -> MassSnapshot:
    """Return the mass properties in frame a; the signs of the products stay as reported.

    Args:
        mass: Mass properties with moments about the origin of frame b.
        T_a_b: Pose of b in a.
        sign: 1 if the products are entries of the inertia matrix, -1 if they are its negatives.
    """
    if T_a_b == IDENTITY:
        return mass
    com = T_a_b.apply(mass.com)
    turned = rotate_inertia(T_a_b.R, part(mass, sign).inertia)
    shift = point_inertia(mass.mass, com)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (
        add(row, other) for row, other in zip(turned, shift, strict=True)
    )
    moments = (xx, yy, zz, sign * xy, sign * yz, sign * xz)
    return MassSnapshot(mass.mass, com, moments, mass.principal)


def total(parts: Iterable[Part]) -> Part:
    """Return the mass properties of all parts combined."""
    parts = tuple(parts)
    mass = math.fsum(p.mass for p in parts)
    if mass == 0.0:
        return Part(0.0, (0.0, 0.0, 0.0), ((0.0,) * 3, (0.0,) * 3, (0.0,) * 3))
    x, y, z = (math.fsum(p.mass * p.com[i] for p in parts) / mass for i in range(3))
    com = parts[0].com if len(parts) == 1 else (x, y, z)
    shares = [(p.inertia, point_inertia(p.mass, subtract(p.com, com))) for p in parts]
    entries = [
        [math.fsum(matrix[i][j] for share in shares for matrix in share) for j in range(3)]
        for i in range(3)
    ]
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = entries
    return Part(mass, com, ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))


def link_inertia(body: Part, T_world_link: Transform) -> Inertia:
    """Return the inertia of a body in the frame of its link."""
    R_link_world = transpose(T_world_link.R)
    x, y, z = rotate(R_link_world, subtract(body.com, T_world_link.p))
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = rotate_inertia(R_link_world, body.inertia)
    com = (x + 0.0, y + 0.0, z + 0.0)
    return Inertia(body.mass, com, xx, yy, zz, xy + 0.0, xz + 0.0, yz + 0.0)


def _subtract_matrix(A: Matrix3, B: Matrix3) -> Matrix3:
    return subtract(A[0], B[0]), subtract(A[1], B[1]), subtract(A[2], B[2])
