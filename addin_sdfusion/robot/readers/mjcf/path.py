"""Paths of tendons by MuJoCo's rules, for numbers that it finds when it reads a file.

Between two sites a tendon goes round a sphere in the plane through both and the centre, round a
cylinder in the plane across its axis with a height that rises evenly; through it where the site of
its side is inside.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from ...model.muscle import Muscle, Wrap, WrapSurface
from ...model.pose import Vector3
from ...model.rotations import add, cross, dot, normalized, rotation, subtract
from ...model.transform import Transform

Vector2 = tuple[float, float]
LEAST = 1e-15
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
SEARCH = 80


class Piece(NamedTuple):
    """A straight piece of a path, from a point on one link to a point on another.

    Attributes:
        start_link, end_link: The links that its ends move with.
        start, end: Its ends in the world, in [m].
        share: What its length counts.
    """

    start_link: str
    end_link: str
    start: Vector3
    end: Vector3
    share: float


class Path(NamedTuple):
    """A path: its straight pieces, and the length of the rest, in [m]."""

    pieces: list[Piece]
    rest: float

    @property
    def length(self) -> float:
        """In [m]."""
        straight = sum(p.share * math.dist(p.start, p.end) for p in self.pieces)
        return straight + self.rest


def path_of(
    muscle: Muscle,
    surfaces: Mapping[str, WrapSurface],
    poses: Mapping[str, Transform],
    q: Mapping[str, float],
) -> Path:
    """The path of a muscle whose wraps go by MuJoCo's rules.

    Args:
        muscle: The muscle.
        surfaces: The wrap surfaces by name.
        poses: The place of each link in the world.
        q: The values of all coordinates.
    """
    wraps = {wrap.segment: wrap for wrap in muscle.wraps}
    divisors = {branch.point: branch.divisor for branch in muscle.branches}
    pieces: list[Piece] = []
    rest = sum(term.factor * q[term.coordinate] for term in muscle.terms)
    share = 1.0
    points = [(p.link, poses[p.link].apply(p.position)) for p in muscle.via_points]
    for k, (link, point) in enumerate(points):
        divisor = divisors.get(k)
        share = share if divisor is None else 1.0 / divisor if divisor else 1.0
        if k + 1 == len(points) or k + 1 in divisors:
            continue
        end_link, end = points[k + 1]
        around = None
        if k in wraps:
            around = _around(wraps[k], surfaces[wraps[k].surface], poses, point, end)
        if around is None:
            pieces.append(Piece(link, end_link, point, end, share))
            continue
        on, leaves, arc, carrier = around
        pieces.append(Piece(link, carrier, point, on, share))
        pieces.append(Piece(carrier, end_link, leaves, end, share))
        rest += share * arc
    return Path(pieces, rest)


def _around(
    wrap: Wrap,
    surface: WrapSurface,
    poses: Mapping[str, Transform],
    start: Vector3,
    end: Vector3,
) -> tuple[Vector3, Vector3, float, str] | None:
    """Both tangent points in the world, the length between, the link; None where it is straight."""
    own = Transform(rotation(surface.pose.rpy), surface.pose.position)
    T = poses[surface.link].compose(own)
    back = T.inverse()
    a, b = back.apply(start), back.apply(end)
    x_axis, y_axis = _plane(surface, a, b)
    flat = [(dot(x_axis, p), dot(y_axis, p)) for p in (a, b)]
    side: Vector2 | None = None
    inside = False
    if wrap.side_point is not None:
        s = back.apply(poses[wrap.side_point.link].apply(wrap.side_point.position))
        inside = math.hypot(*s) < surface.radius
        side = _scaled((dot(x_axis, s), dot(y_axis, s)), surface.radius)
    find = _inside if inside else _outside
    found = find(flat[0], flat[1], side, surface.radius)
    if found is None:
        return None
    (u, v), arc = found
    on, leaves = (add(_times(x_axis, point[0]), _times(y_axis, point[1])) for point in (u, v))
    if surface.shape == "cylinder":
        before, behind = math.dist(flat[0], u), math.dist(flat[1], v)
        whole = before + arc + behind
        rise = b[2] - a[2]
        low, high = a[2] + rise * before / whole, a[2] + rise * (before + arc) / whole
        on, leaves = (on[0], on[1], low), (leaves[0], leaves[1], high)
        arc = math.hypot(arc, high - low)
    return T.apply(on), T.apply(leaves), arc, surface.link


def _plane(surface: WrapSurface, a: Vector3, b: Vector3) -> tuple[Vector3, Vector3]:
    """The axes of the plane that a path goes round in."""
    if surface.shape == "cylinder":
        return (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    first, normal = normalized(a), cross(a, b)
    if math.hypot(*normal) < LEAST:
        least = min(range(3), key=lambda k: abs(a[k]))
        normal = cross(a, (float(least == 0), float(least == 1), float(least == 2)))
    return first, cross(normalized(normal), first)


def _outside(
    a: Vector2, b: Vector2, side: Vector2 | None, r: float
) -> tuple[tuple[Vector2, Vector2], float] | None:
    """Both tangent points on a circle, and the arc between."""
    aa, bb, rr = _inner(a, a), _inner(b, b), r * r
    dx, dy = b[0] - a[0], b[1] - a[1]
    dd = dx * dx + dy * dy
    if aa < rr or bb < rr or rr < LEAST or dd < LEAST or math.isinf(aa + bb + dd):
        return None
    t = min(max(-(dx * a[0] + dy * a[1]) / dd, 0.0), 1.0)
    near = (a[0] + t * dx, a[1] + t * dy)
    if _inner(near, near) > rr and (side is None or _inner(side, near) >= 0.0):
        return None
    best: tuple[float, tuple[Vector2, Vector2], bool] | None = None
    for sign in (1.0, -1.0):
        u = _tangent(a, aa, rr, sign * r * math.sqrt(aa - rr))
        v = _tangent(b, bb, rr, -sign * r * math.sqrt(bb - rr))
        if side is not None:
            good = _inner(_scaled((u[0] + v[0], u[1] + v[1]), 1.0), side)
        else:
            good = -(math.dist(u, v) ** 2)
        if crosses(a, u, b, v):
            good = -1e4
        if best is None or good > best[0]:
            best = (good, (u, v), sign > 0.0)
    assert best is not None
    u, v = best[1]
    if crosses(a, u, b, v):
        return None
    angle = math.acos(max(-1.0, min(1.0, _inner(u, v) / rr)))
    turned = u[1] * v[0] - u[0] * v[1]
    if (turned > 0.0) != best[2]:
        angle = 2.0 * math.pi - angle
    return (u, v), r * angle


def _tangent(p: Vector2, pp: float, rr: float, root: float) -> Vector2:
    return (p[0] * rr + root * p[1]) / pp, (p[1] * rr - root * p[0]) / pp


def _inside(
    a: Vector2, b: Vector2, side: Vector2 | None, r: float
) -> tuple[tuple[Vector2, Vector2], float] | None:
    """The point of a circle that is touched from within; None where the line passes inside."""
    del side
    dx, dy = b[0] - a[0], b[1] - a[1]
    dd = dx * dx + dy * dy
    if min(math.hypot(*a), math.hypot(*b)) < r or r < LEAST or dd < LEAST:
        return None
    t = -(dx * a[0] + dy * a[1]) / dd
    if 0.0 < t < 1.0 and math.hypot(a[0] + t * dx, a[1] + t * dy) < r:
        return None
    low = math.atan2(a[1], a[0])
    turn = math.remainder(math.atan2(b[1], b[0]) - low, 2.0 * math.pi)

    def point(part: float) -> Vector2:
        return r * math.cos(low + part * turn), r * math.sin(low + part * turn)

    def length(part: float) -> float:
        return math.dist(a, point(part)) + math.dist(point(part), b)

    left, right = 0.0, 1.0
    for _ in range(SEARCH):
        c, d = right - GOLDEN * (right - left), left + GOLDEN * (right - left)
        left, right = (left, d) if length(c) < length(d) else (c, right)
    touched = point(0.5 * (left + right))
    return (touched, touched), 0.0


def crosses(a: Vector2, u: Vector2, b: Vector2, v: Vector2) -> bool:
    """Whether the lines from a to u and from b to v cross between their ends."""
    det = (v[1] - b[1]) * (u[0] - a[0]) - (v[0] - b[0]) * (u[1] - a[1])
    if abs(det) < LEAST:
        return False
    s = ((v[0] - b[0]) * (a[1] - b[1]) - (v[1] - b[1]) * (a[0] - b[0])) / det
    t = ((u[0] - a[0]) * (a[1] - b[1]) - (u[1] - a[1]) * (a[0] - b[0])) / det
    return 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0


def _inner(a: Vector2, b: Vector2) -> float:
    return a[0] * b[0] + a[1] * b[1]


def _scaled(v: Vector2, length: float) -> Vector2:
    norm = math.hypot(*v)
    return v if norm < LEAST else (v[0] / norm * length, v[1] / norm * length)


def _times(v: Vector3, factor: float) -> Vector3:
    return factor * v[0], factor * v[1], factor * v[2]


def direction(piece: Piece) -> Vector3:
    """The unit vector along a piece."""
    return normalized(subtract(piece.end, piece.start))
