"""Masses and inertias in MJCF, which must be positive or omitted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ...checks.masses import density_matrix
from ...model.robot import Inertia, Link, Robot
from ...model.rotations import Matrix3, cross, dot

MIN_INERTIA = 1e-14
"""In [kg·m²]; MuJoCo rejects moments of inertia below 1e-15."""
MIN_SHARE = 1e-12
"""Minimum moment relative to the largest entry, above rounding errors."""
MIN_MASS = 1e-12
"""In [kg]; MuJoCo rejects moving bodies with a mass below 1e-15."""
STEPS = (0.0, 1.0, 10.0, 100.0, 1e3, 1e4)
"""Increments of the moments of inertia to test, as multiples of the minimum."""


def mjcf_inertia(link: Link, *, moving: bool) -> Inertia | None:
    """Return the inertia to write, increased to the minimum of MuJoCo; None to write none.

    Args:
        link: A link for which `missing_inertia` does not return None.
        moving: Whether the parent joint has motions.
    """
    inertia = link.inertia
    if not moving and inertia.mass == 0.0 and not any(map(any, inertia.matrix)):
        return None
    return _increase_inertia(
        replace(inertia, mass=max(inertia.mass, MIN_MASS)), missing_inertia(inertia) or 0
    )


def written_inertias(robot: Robot) -> Iterator[tuple[Link, Inertia]]:
    """Yield the links with an inertia in MJCF, and that inertia."""
    moving = {joint.child: bool(joint.motions) for joint in robot.joints}
    for link in robot.links:
        written = mjcf_inertia(link, moving=moving[link.name])
        if written is not None:
            yield link, written


def missing_inertia(inertia: Inertia) -> float | None:
    """Return the increment of the moments that MuJoCo needs, in [kg·m²]; None if too large."""
    smallest = max(MIN_INERTIA, MIN_SHARE * max(abs(x) for row in inertia.matrix for x in row))
    for step in STEPS:
        matrix = _increase_inertia(inertia, step * smallest).matrix
        if _exceeds(matrix, smallest / 2) and _exceeds(density_matrix(matrix), smallest / 8):
            return step * smallest
    return None


def _increase_inertia(inertia: Inertia, by: float) -> Inertia:
    return replace(inertia, ixx=inertia.ixx + by, iyy=inertia.iyy + by, izz=inertia.izz + by)


def _exceeds(A: Matrix3, bound: float) -> bool:
    """Return whether all eigenvalues of A exceed a bound, by the leading minors of A - bound."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = A
    xx, yy, zz = xx - bound, yy - bound, zz - bound
    x, y, z = (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)
    return xx > 0.0 and xx * yy - xy * xy > 0.0 and dot(x, cross(y, z)) > 0.0
