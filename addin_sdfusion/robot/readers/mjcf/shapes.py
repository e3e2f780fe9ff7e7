"""Geoms as bodies of even density: volume, place, moments of inertia."""

from __future__ import annotations

import math

from ...formats.reading.xml import Node
from ...model.pose import Vector3
from ...model.rotations import subtract
from ...model.transform import Transform
from .bodies import Part
from .compiler import Compiler, numbers, to_z

SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
"""How many sizes a shape has."""
FROM_TO = ("capsule", "cylinder", "ellipsoid", "box")
WITHOUT_MASS = ("plane", "hfield")


def shape_of(geom: Node) -> str:
    """The kind of a geom; one with a mesh and another type is that type, fitted to the mesh."""
    return geom.attribute("type", "sphere")


def sizes_of(geom: Node) -> tuple[float, ...]:
    """The sizes of a shape, half lengths as MJCF has them."""
    kind, size = shape_of(geom), numbers(geom, "size")
    if geom.has("fromto") and kind in FROM_TO:
        half = math.dist(*_ends(geom)) / 2.0
        size = (*size[:1], half) if SIZES[kind] == 2 else (*size[:1], *size[:1], half)
    count = SIZES.get(kind, 0)
    if len(size) < count:
        geom.error("bad-vector", f"a {kind} has {count} sizes, not {len(size)}")
        size = (*size, *(0.0,) * (count - len(size)))
    return size[:count]


def place_of(part: Part, compiler: Compiler) -> Transform:
    """Where a geom or site is on its body."""
    node = part.node
    if node.has("fromto"):
        start, end = _ends(node)
        middle = tuple(0.5 * (a + b) for a, b in zip(start, end, strict=True))
        R = to_z(subtract(start, end)) if start != end else to_z((0.0, 0.0, 1.0))
        return part.T.compose(Transform(R, (middle[0], middle[1], middle[2])))
    own = compiler.place(node)
    return part.T.compose(own)


def volume(kind: str, size: tuple[float, ...]) -> float:
    """In [m³]."""
    if kind == "sphere":
        return 4.0 / 3.0 * math.pi * size[0] * size[0] * size[0]
    if kind == "capsule":
        r, h = size[0], 2.0 * size[1]
        return math.pi * (r * r * h + 4.0 / 3.0 * r * r * r)
    if kind == "cylinder":
        return math.pi * size[0] * size[0] * 2.0 * size[1]
    if kind == "ellipsoid":
        return 4.0 / 3.0 * math.pi * size[0] * size[1] * size[2]
    return 8.0 * size[0] * size[1] * size[2]


def moments(kind: str, size: tuple[float, ...], mass: float) -> Vector3:
    """Moments of inertia about the middle, along the shape's axes, in [kg·m²]."""
    if kind == "sphere":
        own = 0.4 * mass * size[0] * size[0]
        return own, own, own
    if kind == "capsule":
        return _of_capsule(size[0], 2.0 * size[1], mass)
    if kind == "cylinder":
        r, h = size[0], 2.0 * size[1]
        across = mass * (3.0 * r * r + h * h) / 12.0
        return across, across, 0.5 * mass * r * r
    x, y, z = (s * s * mass / (5.0 if kind == "ellipsoid" else 3.0) for s in size)
    return y + z, x + z, x + y


def shell(kind: str, size: tuple[float, ...]) -> tuple[float, Vector3] | None:
    """The area of a shape's surface, and its moments for a mass of 1 kg/m² on it.

    None for an ellipsoid, whose area has no closed form.
    """
    if kind == "sphere":
        area = 4.0 * math.pi * size[0] ** 2
        return area, (2.0 / 3.0 * area * size[0] ** 2,) * 3
    if kind == "box":
        a, b, c = (edge * edge for edge in size)
        x, y, z = (8.0 * size[j] * size[k] for j, k in ((1, 2), (0, 2), (0, 1)))
        own = (
            x * (b + c) / 3.0 + y * (b + c / 3.0) + z * (c + b / 3.0),
            y * (a + c) / 3.0 + x * (a + c / 3.0) + z * (c + a / 3.0),
            z * (a + b) / 3.0 + x * (a + b / 3.0) + y * (b + a / 3.0),
        )
        return x + y + z, own
    if kind not in ("capsule", "cylinder"):
        return None
    r, h = size[0], 2.0 * size[1]
    side = 2.0 * math.pi * r * h
    across, along = side * (r * r / 2.0 + h * h / 12.0), side * r * r
    if kind == "capsule":
        ends = 4.0 * math.pi * r * r
        across += ends * (5.0 / 12.0 * r * r + (h + r) ** 2 / 4.0)
        along += ends * 2.0 / 3.0 * r * r
    else:
        ends = 2.0 * math.pi * r * r
        across += ends * (r * r + h * h) / 4.0
        along += ends * r * r / 2.0
    return side + ends, (across, across, along)


def _of_capsule(r: float, h: float, mass: float) -> Vector3:
    """A cylinder, and two half balls at its ends."""
    if r <= 0.0:
        return mass * h * h / 12.0, mass * h * h / 12.0, 0.0
    ball = mass * 4.0 * r / (4.0 * r + 3.0 * h)
    rod = mass - ball
    across = rod * (3.0 * r * r + h * h) / 12.0
    across += 0.4 * ball * r * r + ball * h * (3.0 * r + 2.0 * h) / 8.0
    return across, across, 0.5 * rod * r * r + 0.4 * ball * r * r


def _ends(geom: Node) -> tuple[Vector3, Vector3]:
    a, b, c, d, e, f = geom.numbers_attribute("fromto", 6)
    return (a, b, c), (d, e, f)
