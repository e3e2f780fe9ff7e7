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
from dataclasses import replace
from typing import Literal

from ..robot.model.robot import Inertia
from ..robot.model.rotations import subtract, transpose
from ..robot.model.transform import IDENTITY, Transform
from .eigenvalues import eigenvalues
from .parts import MassSnapshot

Sign = Literal[1, -1]

MISMATCH = 1e-3
"""Maximum deviation of the principal moments from the eigenvalues, relative to the largest."""
_MIN_DEVIATION = 1e-9  # of the wrong sign, relative to the largest moment, in addition to rounding
_MAX_RATIO = 0.1  # of the deviations with the right and the wrong sign
_ROUNDING = 1e-14


def is_usable(mass: MassSnapshot) -> bool:
    """Return whether all values are finite and the mass is positive."""
    numbers = (mass.mass, *mass.com, *mass.moments, *mass.principal)
    return all(map(math.isfinite, numbers)) and mass.mass > 0.0


def part(mass: MassSnapshot, sign: Sign) -> Inertia:
    """Return the mass properties with the inertia about the centre of mass.

    Args:
        mass: Mass properties with moments about the origin of the root frame.
        sign: 1 if the products are entries of the inertia matrix, -1 if they are its negatives.
    """
    xx, yy, zz, xy, yz, xz = mass.moments
    xy, yz, xz = sign * xy, sign * yz, sign * xz
    about_origin = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    return Inertia.of_origin(mass.mass, mass.com, about_origin)


def eigenvalue_error(mass: MassSnapshot, sign: Sign) -> float:
    """Return the largest deviation of the eigenvalues from the principal moments, relative."""
    largest = max(map(abs, mass.principal))
    if largest == 0.0:
        return 0.0 if not any(mass.moments) else math.inf
    pairs = zip(eigenvalues(part(mass, sign).matrix), sorted(mass.principal), strict=True)
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
    body = part(mass, sign).moved(T_a_b)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.about((0.0, 0.0, 0.0))
    moments = (xx, yy, zz, sign * xy, sign * yz, sign * xz)
    return MassSnapshot(mass.mass, body.com, moments, mass.principal)


def link_inertia(body: Inertia, T_world_link: Transform) -> Inertia:
    """Return the inertia of a body in the frame of its link."""
    R_link_world = Transform(transpose(T_world_link.R), (0.0, 0.0, 0.0))
    inertia = replace(body, com=subtract(body.com, T_world_link.p)).moved(R_link_world)
    x, y, z = inertia.com
    products = (entry + 0.0 for entry in inertia.entries[3:])  # -0.0 becomes 0.0
    return Inertia(body.mass, (x + 0.0, y + 0.0, z + 0.0), *inertia.entries[:3], *products)
