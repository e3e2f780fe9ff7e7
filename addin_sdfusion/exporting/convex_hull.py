"""Convex hull of points by the quickhull algorithm with exact predicates.

Points are rounded to a grid that is 2⁵⁰ times finer than their extent. The test whether a facet is
visible from a point is exact: it uses floats if their sign is certain, otherwise integers.
Therefore the hull is a closed surface even for coplanar, collinear or duplicate points. Points
within the tolerance of the hull are skipped, so that flat faces remain flat.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from ..robot.model.pose import Vector3

TOLERANCE = 1e-11
"""Maximum distance of a point outside the hull, relative to half the extent of all points."""
FLAT = 1e-9
"""Minimum ratio of thickness to length of a body with volume."""

_GRID = 2.0**49
_ROUNDING = 2.0**-46
"""Upper bound of the rounding error of a plane equation, relative to its largest terms."""

_MIN_REACH = 1e-200
"""Minimum extent, in [m]; the scale of smaller extents could exceed the range of floats."""

_Triple = tuple[int, int, int]


class Hull(NamedTuple):
    """A closed convex surface.

    Attributes:
        corners: Input points that are corners, in their original order.
        triangles: Three indices of corners per triangle, counter-clockwise seen from outside.
    """

    corners: tuple[Vector3, ...]
    triangles: tuple[_Triple, ...]


def convex_hull(points: Iterable[Vector3]) -> Hull | None:
    """Return the convex hull of points.

    Args:
        points: Finite points in any order, in [m].

    Returns:
        The hull; None for fewer than four points, or collinear or coplanar points.
    """
    distinct = list(dict.fromkeys(points))
    on_grid = _on_grid(distinct)
    places = {point: i for i, point in reversed(list(enumerate(on_grid)))}
    unique = sorted(places)
    start = _tetrahedron(unique)
    if start is None:
        return None
    facets = _Quickhull(unique, start).facets()
    order = sorted({places[unique[i]] for facet in facets for i in facet})
    numbers = {place: number for number, place in enumerate(order)}
    triangles = (
        _normalize_triangle(*(numbers[places[unique[i]]] for i in facet)) for facet in facets
    )
    return Hull(tuple(distinct[i] for i in order), tuple(sorted(triangles)))


def _normalize_triangle(a: int, b: int, c: int) -> _Triple:
    """Return a triangle that begins with its smallest index."""
    return min((a, b, c), (b, c, a), (c, a, b))


def _on_grid(points: Sequence[Vector3]) -> list[_Triple]:
    """Return points as integers of at most ±2⁴⁹ relative to the centre."""
    if not points:
        return []
    lows = [min(axis) for axis in zip(*points, strict=True)]
    highs = [max(axis) for axis in zip(*points, strict=True)]
    mx, my, mz = (0.5 * low + 0.5 * high for low, high in zip(lows, highs, strict=True))
    reach = max(0.5 * high - 0.5 * low for low, high in zip(lows, highs, strict=True))
    if reach < _MIN_REACH:
        return [(0, 0, 0)] * len(points)
    scale = math.ldexp(_GRID, -math.frexp(reach)[1])  # a power of two scales without rounding
    return [
        (round((x - mx) * scale), round((y - my) * scale), round((z - mz) * scale))
        for x, y, z in points
    ]


def _tetrahedron(points: Sequence[_Triple]) -> tuple[int, int, int, int] | None:
    """Return four distant points, the first three counter-clockwise seen from outside.

    Returns None if the points have no volume.
    """
    if len(points) < 4:
        return None
    among = range(len(points))
    first = min(among, key=points.__getitem__)
    second = max(among, key=lambda i: _square(_minus(points[i], points[first])))
    along = _minus(points[second], points[first])
    size = math.sqrt(_square(along))

    def from_line(i: int) -> int:
        return _square(_cross(along, _minus(points[i], points[first])))

    third = max(among, key=from_line)
    if math.sqrt(from_line(third)) <= FLAT * size * size:
        return None
    normal = _cross(along, _minus(points[third], points[first]))

    def from_plane(i: int) -> int:
        return _dot(normal, _minus(points[i], points[first]))

    fourth = max(among, key=lambda i: abs(from_plane(i)))
    height = from_plane(fourth)
    if abs(height) <= FLAT * size * math.sqrt(_square(normal)):
        return None
    if height > 0:
        second, third = third, second
    return first, second, third, fourth


class _Facet:
    """A triangle of the hull.

    Attributes:
        corners: Indices of points, counter-clockwise seen from outside.
        neighbours: Adjacent facet at the edge from corner k to the next corner.
        above: Remaining points from which the facet is visible; each point is in one list only.
        height: Largest distance of these points from the plane, times the length of the normal.
        farthest: Index of the point with the largest distance.
        plane: Normal and offset; `n · p - offset` is positive if the facet is visible from p.
        doubt: Bound of the values whose sign is uncertain because of rounding.
        exact: Normal and offset as integers, computed on demand.
        is_removed: Whether the facet is removed from the hull.
    """

    __slots__ = (
        "above",
        "corners",
        "doubt",
        "exact",
        "farthest",
        "height",
        "is_removed",
        "neighbours",
        "plane",
    )

    def __init__(self, corners: _Triple, points: Sequence[Vector3]) -> None:
        self.corners = corners
        self.neighbours: list[_Facet] = []
        self.above: list[int] = []
        self.height = -math.inf
        self.farthest = -1
        self.exact: tuple[_Triple, int] | None = None
        self.is_removed = False
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (points[i] for i in corners)
        ux, uy, uz = bx - ax, by - ay, bz - az
        vx, vy, vz = cx - ax, cy - ay, cz - az
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        self.plane = (x, y, z, x * ax + y * ay + z * az)
        longest = max(abs(ux), abs(uy), abs(uz)) * max(abs(vx), abs(vy), abs(vz))
        self.doubt = _ROUNDING * longest * _GRID

    def stands_out(self, height: float) -> bool:
        """Return whether a point of this height exceeds the tolerance and becomes a corner."""
        x, y, z, _ = self.plane
        return height > TOLERANCE * _GRID * math.sqrt(x * x + y * y + z * z)


class _Quickhull:
    """Computation of one hull.

    Args:
        points: Unique points on the grid.
        start: Corners of the initial hull, the first three counter-clockwise seen from outside.
    """

    def __init__(self, points: Sequence[_Triple], start: tuple[int, int, int, int]) -> None:
        self._points_on_grid = points
        self._points: list[Vector3] = [(float(x), float(y), float(z)) for x, y, z in points]
        a, b, c, d = start
        triples = ((a, b, c), (a, d, b), (b, d, c), (c, d, a))
        first, ab, bc, ca = (_Facet(corners, self._points) for corners in triples)
        first.neighbours = [ab, bc, ca]
        ab.neighbours = [ca, bc, first]
        bc.neighbours = [ab, ca, first]
        ca.neighbours = [bc, ab, first]
        self._start = [first, ab, bc, ca]
        self._assign((i for i in range(len(points)) if i not in start), self._start)

    def facets(self) -> list[_Triple]:
        """Return the triangles of the hull."""
        live = dict.fromkeys(self._start)
        waiting = deque(self._start)
        while waiting:  # the oldest first, so that all sides of the hull grow evenly
            facet = waiting.popleft()
            point = None if facet.is_removed else self._next(facet)
            if point is not None:
                seen, new = self._add(facet, point)
                for other in seen:
                    del live[other]
                live.update(dict.fromkeys(new))
                waiting.extend(other for other in new if other.above)
        return [facet.corners for facet in live]

    def _next(self, facet: _Facet) -> int | None:
        """Return the next point to add above a facet; discard points within the tolerance."""
        if facet.stands_out(facet.height):
            return facet.farthest
        while facet.above:  # they may exceed the tolerance of other facets
            point = facet.above.pop()
            seen = self._visible_facets(facet, point)
            if any(other.stands_out(self._height(other, point)) for other in seen):
                return point
        return None

    def _add(self, facet: _Facet, point: int) -> tuple[list[_Facet], list[_Facet]]:
        """Add a point as a corner; return the removed facets and the new facets."""
        seen = self._visible_facets(facet, point)
        for other in seen:
            other.is_removed = True
        new = self._cone(seen, point)
        self._assign((i for other in seen for i in other.above if i != point), new)
        for other in seen:
            other.above, other.neighbours = [], []  # break reference cycles
        return seen, new

    def _visible_facets(self, facet: _Facet, point: int) -> list[_Facet]:
        """Return the connected facets that are visible from a point, starting from one of them."""
        seen, visited = [facet], {facet}
        for other in seen:
            for neighbour in other.neighbours:
                if neighbour not in visited:
                    visited.add(neighbour)
                    if self._height(neighbour, point) > 0.0:
                        seen.append(neighbour)
        return seen

    def _cone(self, seen: Sequence[_Facet], point: int) -> list[_Facet]:
        """Return new facets from a point to the boundary of the removed facets."""
        starts: dict[int, _Facet] = {}
        for old in seen:
            for k, outer in enumerate(old.neighbours):
                if not outer.is_removed:
                    a, b = old.corners[k], old.corners[k - 2]
                    facet = starts[a] = _Facet((a, b, point), self._points)
                    facet.neighbours = [outer]
                    outer.neighbours[outer.corners.index(b)] = facet
        for facet in starts.values():
            facet.neighbours.append(starts[facet.corners[1]])
        for facet in starts.values():
            facet.neighbours[1].neighbours.append(facet)
        return list(starts.values())

    def _assign(self, points: Iterable[int], facets: Sequence[_Facet]) -> None:
        """Add each point to the list of one visible facet; drop points inside the hull."""
        where = self._points
        planes = [(*facet.plane, facet.doubt, facet) for facet in facets]
        for i in points:
            px, py, pz = where[i]
            for x, y, z, offset, doubt, facet in planes:
                height = x * px + y * py + z * pz - offset
                if height > doubt or (height >= -doubt and self._exact_height(facet, i) > 0):
                    facet.above.append(i)
                    if height > facet.height:
                        facet.height, facet.farthest = height, i
                    break

    def _height(self, facet: _Facet, point: int) -> float:
        """Return the height of a point above a facet, times the normal's length, exact in sign."""
        x, y, z, offset = facet.plane
        px, py, pz = self._points[point]
        height = x * px + y * py + z * pz - offset
        return height if abs(height) > facet.doubt else float(self._exact_height(facet, point))

    def _exact_height(self, facet: _Facet, point: int) -> int:
        if facet.exact is None:
            a, b, c = (self._points_on_grid[i] for i in facet.corners)
            normal = _cross(_minus(b, a), _minus(c, a))
            facet.exact = normal, _dot(normal, a)
        normal, offset = facet.exact
        return _dot(normal, self._points_on_grid[point]) - offset


def _minus(a: _Triple, b: _Triple) -> _Triple:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a: _Triple, b: _Triple) -> _Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: _Triple, b: _Triple) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _square(a: _Triple) -> int:
    return _dot(a, a)
