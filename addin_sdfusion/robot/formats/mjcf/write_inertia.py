"""Masses and inertias in MJCF: positive ones, or none at all."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ...checks.masses import density_matrix
from ...model.robot import Inertia, Link, Robot
from ...model.rotations import Matrix3, cross, dot

MIN_INERTIA = 1e-14
"""In [kg·m²]: a safe distance from the 1e-15 below which MuJoCo rejects a moment."""
MIN_SHARE = 1e-12
"""The same as a share of the largest entry, a safe distance from rounding."""
MIN_MASS = 1e-12
"""In [kg]; MuJoCo rejects moving bodies below 1e-15."""
STEPS = (0.0, 1.0, 10.0, 100.0, 1e3, 1e4)
"""What may be added to the moments of inertia, as multiples of the least."""


def mjcf_inertia(link: Link, *, moving: bool) -> Inertia | None:
    """The inertia to write, with what little MuJoCo needs; None if nothing is to be written.

    Args:
        link: A link of which nothing is `missing` that cannot be added.
        moving: Whether its joint has motions.
    """
    inertia = link.inertia
    if not moving and inertia.mass == 0.0 and not any(map(any, inertia.matrix)):
        return None
    return _increased(replace(inertia, mass=max(inertia.mass, MIN_MASS)), missing(inertia) or 0)


def written_inertias(robot: Robot) -> Iterator[tuple[Link, Inertia]]:
    """The links with an inertia in MJCF, and that inertia."""
    moving = {joint.child: bool(joint.motions) for joint in robot.joints}
    for link in robot.links:
        written = mjcf_inertia(link, moving=moving[link.name])
        if written is not None:
            yield link, written


def missing(inertia: Inertia) -> float | None:
    """The least to add to the moments so that MuJoCo takes them, in [kg·m²]; None if too much."""
    least = max(MIN_INERTIA, MIN_SHARE * max(abs(x) for row in inertia.matrix for x in row))
    for step in STEPS:
        matrix = _increased(inertia, step * least).matrix
        if _exceeds(matrix, least / 2) and _exceeds(density_matrix(matrix), least / 8):
            return step * least
    return None


def _increased(inertia: Inertia, by: float) -> Inertia:
    return replace(inertia, ixx=inertia.ixx + by, iyy=inertia.iyy + by, izz=inertia.izz + by)


def _exceeds(A: Matrix3, bound: float) -> bool:
    """Whether all eigenvalues of a symmetric matrix exceed a bound: leading minors of A - bound."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = A
    xx, yy, zz = xx - bound, yy - bound, zz - bound
    x, y, z = (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)
    return xx > 0.0 and xx * yy - xy * xy > 0.0 and dot(x, cross(y, z)) > 0.0
