"""Mass properties of CAD bodies as inertia matrices, and their sums.

CAD gives the moments about the origin of the root frame, and does not say if its products are
the matrix' entries, -∫ x y dm, or ∫ x y dm. The principal moments about the centre of mass decide:
only with the right sign are they the eigenvalues. Where they cannot, as for a body whose axes are
those of the frame, the other bodies of the design decide: its sign is one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Literal, NamedTuple

from ...robot.model.pose import Vector3
from ...robot.model.robot import Inertia
from ...robot.model.rotations import (
    Matrix3,
    point_inertia,
    rotate,
    rotate_inertia,
    subtract,
    transpose,
)
from ...robot.model.transform import Transform
from ...snapshot import MassSnapshot
from .eigenvalues import eigenvalues

Sign = Literal[1, -1]

MISMATCH = 1e-3
"""Principal moments that differ by this share of the largest are those of another body."""
_TELLS = 1e-9  # by so much of the largest moment the wrong sign must miss, beyond rounding
_CLEARER = 0.1  # the right sign misses by at most this share of what the wrong one does
_ROUNDING = 1e-14


class Part(NamedTuple):
    """Mass, centre of mass and inertia about it, in one frame.

    Attributes:
        mass: In [kg].
        com: In [m].
        inertia: About the centre of mass, in [kg·m²].
    """

    mass: float
    com: Vector3
    inertia: Matrix3


def usable(mass: MassSnapshot) -> bool:
    """Return whether all numbers are finite and there is mass."""
    numbers = (mass.mass, *mass.com, *mass.moments, *mass.principal)
    return all(map(math.isfinite, numbers)) and mass.mass > 0.0


def part(mass: MassSnapshot, sign: Sign) -> Part:
    """Mass properties with their inertia about the centre of mass.

    Args:
        mass: With moments about the root's origin.
        sign: 1 where products are the matrix' entries, -1 if they are its negative.
    """
    xx, yy, zz, xy, yz, xz = mass.moments
    xy, yz, xz = sign * xy, sign * yz, sign * xz
    about_origin = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    return Part(mass.mass, mass.com, _less(about_origin, point_inertia(mass.mass, mass.com)))


def misses(mass: MassSnapshot, sign: Sign) -> float:
    """By how much the eigenvalues miss the principal moments, as a share of the largest."""
    largest = max(map(abs, mass.principal))
    if largest == 0.0:
        return 0.0 if not any(mass.moments) else math.inf
    pairs = zip(eigenvalues(part(mass, sign).inertia), sorted(mass.principal), strict=True)
    return max(abs(a - b) for a, b in pairs) / largest


def rounding(mass: MassSnapshot) -> float:
    """What rounding alone may make of `misses`: much for a small body far from the origin."""
    largest = max(map(abs, mass.principal))
    return _ROUNDING * max(map(abs, mass.moments)) / largest if largest > 0.0 else 0.0


def sign_of(mass: MassSnapshot) -> Sign | None:
    """Return the sign by the principal moments; None if they fit both, or none."""
    plus, minus = misses(mass, 1), misses(mass, -1)
    worse = max(plus, minus)
    if worse <= _TELLS + rounding(mass) or min(plus, minus) > _CLEARER * worse:
        return None
    return 1 if plus < minus else -1


def common_sign(masses: Iterable[MassSnapshot]) -> Sign:
    """The sign of a design's products, by majority; the matrix' own where nothing decides."""
    votes = sum(sign_of(mass) or 0 for mass in masses)
    return -1 if votes < 0 else 1


def total(parts: Iterable[Part]) -> Part:
    """Return all parts as one rigid body."""
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
    """Return a body in the frame of its link.

    Args:
        body: In the world frame.
        T_world_link: Pose of the link.
    """
    R_link_world = transpose(T_world_link.R)
    x, y, z = rotate(R_link_world, subtract(body.com, T_world_link.p))
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = rotate_inertia(R_link_world, body.inertia)
    com = (x + 0.0, y + 0.0, z + 0.0)
    return Inertia(body.mass, com, xx, yy, zz, xy + 0.0, xz + 0.0, yz + 0.0)


def _less(A: Matrix3, B: Matrix3) -> Matrix3:
    return subtract(A[0], B[0]), subtract(A[1], B[1]), subtract(A[2], B[2])
