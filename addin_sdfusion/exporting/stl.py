"""Writer of binary STL files.

STL holds 32-bit floats: a coordinate is rounded by up to 6e-8 of itself.
"""

from __future__ import annotations

import math
import struct
from array import array
from collections.abc import Sequence

from ..robot.errors import InputError

HEADER = b"binary STL in metres, in the frame of the link".ljust(80)
"""Neither a date nor a name, so that the same mesh is always the same file; it may not begin with
`solid`, which marks the other kind of STL."""

_COUNT = struct.Struct("<I")
_TRIANGLE = struct.Struct("<12fH")
_MAX_TRIANGLES = 2**32 - 1


def stl_bytes(nodes: Sequence[float], triangles: Sequence[int]) -> bytes:
    """Return the content of a binary STL file.

    Triangles of which two corners coincide once rounded are left out: a closed surface stays
    closed without them. Others without area stay, as their neighbours' edges need them.

    Args:
        nodes: x, y, z of every node, in [m].
        triangles: Three indices of nodes for every triangle, counter-clockwise seen from outside.

    Raises:
        InputError: There are more triangles than STL holds, or a node too far out for its floats.
    """
    rounded = array("f", nodes)
    if not all(map(math.isfinite, rounded)):
        raise InputError("a mesh reaches further than STL's numbers do")
    corners = list(zip(rounded[0::3], rounded[1::3], rounded[2::3], strict=True))
    parts = []
    indices = iter(triangles)
    for i, j, k in zip(indices, indices, indices, strict=True):
        a, b, c = corners[i], corners[j], corners[k]
        if a != b and b != c and c != a:
            parts.append(_TRIANGLE.pack(*_normal(a, b, c), *a, *b, *c, 0))
    if len(parts) > _MAX_TRIANGLES:
        raise InputError("a mesh has more triangles than STL holds")
    return b"".join((HEADER, _COUNT.pack(len(parts)), *parts))


Corner = tuple[float, float, float]


def _normal(a: Corner, b: Corner, c: Corner) -> Corner:
    """Return the unit normal of a triangle; zero, as STL has it, if there is none."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    norm = math.hypot(x, y, z)
    if norm == 0.0 or not math.isfinite(norm):
        return 0.0, 0.0, 0.0
    return x / norm, y / norm, z / norm
