"""Writer for binary STL files.

STL uses 32-bit floats: the relative rounding error of a coordinate is up to 6e-8.
"""

from __future__ import annotations

import math
import struct
from array import array
from collections.abc import Sequence

from ..robot.errors import InputError
from ..robot.model.rotations import cross, normalized, subtract

HEADER = b"binary STL in metres, in the frame of the link".ljust(80)
"""Header without date and name, so that equal meshes result in equal files. It must not begin with
`solid`, which marks an ASCII STL file."""

_COUNT = struct.Struct("<I")
_TRIANGLE = struct.Struct("<12fH")
_MAX_TRIANGLES = 2**32 - 1


def stl_bytes(nodes: Sequence[float], triangles: Sequence[int]) -> bytes:
    """Return the content of a binary STL file.

    Triangles with two corners that coincide after rounding are not written; the surface remains
    closed. Other triangles without area are written, because adjacent triangles share their edges.

    Args:
        nodes: x, y, z of every node, in [m].
        triangles: Three node indices per triangle, counter-clockwise seen from outside.

    Raises:
        InputError: The mesh exceeds the range of 32-bit floats or the maximum number of triangles.
    """
    rounded = array("f", nodes)
    if not all(map(math.isfinite, rounded)):
        raise InputError("a mesh exceeds the range of 32-bit floats in STL")
    corners = list(zip(rounded[0::3], rounded[1::3], rounded[2::3], strict=True))
    parts = []
    indices = iter(triangles)
    for i, j, k in zip(indices, indices, indices, strict=True):
        a, b, c = corners[i], corners[j], corners[k]
        if a != b and b != c and c != a:
            normal = normalized(cross(subtract(b, a), subtract(c, a)))
            parts.append(_TRIANGLE.pack(*normal, *a, *b, *c, 0))
    if len(parts) > _MAX_TRIANGLES:
        raise InputError(f"a mesh has more triangles than STL allows ({_MAX_TRIANGLES})")
    return b"".join((HEADER, _COUNT.pack(len(parts)), *parts))
