"""Checks of wrap surfaces and of the muscles' wraps over them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import groupby, pairwise
from typing import get_args

from ..finding import Finding, Subject
from ..finding_builders import all_muscles, error, unknown, warning
from ..model.muscle import Muscle, Side, Wrap, WrapShape, WrapSurface
from ..model.pose import Vector3
from ..model.robot import WORLD, Robot
from ..model.rotations import apply, inverse
from .names import named

MAX_WRAPS = 8
"""Maximum number of wraps in one segment, which the C core solves simultaneously."""
MAX_TURNS = 10**6
INSIDE = 1e-6
"""Relative depth at which a point is still on the surface, since files have rounded numbers."""


def wrap_surfaces(robot: Robot) -> Iterator[Finding]:
    """Check name, link, shape and sizes of each wrap surface."""
    links = [WORLD, *(link.name for link in robot.links)]
    link_names = set(links)
    yield from named([Subject("wrap_surface", surface.name) for surface in robot.wrap_surfaces])
    for surface in robot.wrap_surfaces:
        subject = Subject("wrap_surface", surface.name)
        if surface.link not in link_names:
            yield error(subject, "unknown-wrap-link", unknown("link", surface.link, links))
        if surface.shape not in (known_shapes := get_args(WrapShape)):
            problem = unknown("shape", surface.shape, known_shapes)
            yield error(subject, "unknown-wrap-shape", problem)
        if surface.radius <= 0.0 or surface.length <= 0.0:
            size = f"radius {surface.radius!r} and length {surface.length!r}"
            yield error(subject, "bad-wrap-size", f"{size} must be positive")
        yield from _half_axes(subject, surface)


def _half_axes(subject: Subject, surface: WrapSurface) -> Iterator[Finding]:
    axes = surface.half_axes
    if (surface.shape == "ellipsoid") != (axes is not None):
        problem = "half axes along y and z are required for ellipsoids and invalid for other shapes"
        yield error(subject, "bad-wrap-axes", problem)
    elif axes is not None and min(axes) <= 0.0:
        yield error(subject, "bad-wrap-size", f"half axes {axes!r} must be positive")


def wraps(robot: Robot) -> Iterator[Finding]:
    """Check that muscles wrap over existing surfaces, between two via points outside of them."""
    surfaces = {surface.name: surface for surface in robot.wrap_surfaces}
    for subject, muscle in all_muscles(robot):
        yield from _wraps(subject, muscle, surfaces)
        yield from _sequences(subject, muscle, surfaces)


def _wraps(
    subject: Subject, muscle: Muscle, surfaces: Mapping[str, WrapSurface]
) -> Iterator[Finding]:
    last = len(muscle.via_points) - 2
    for wrap in muscle.wraps:
        if wrap.surface not in surfaces:
            problem = unknown("wrap surface", wrap.surface, list(surfaces))
            yield error(subject, "unknown-wrap-surface", problem)
        if not 0 <= wrap.segment <= last:
            problem = f"wraps in segment {wrap.segment}; its segments are 0 to {last}"
            yield error(subject, "bad-wrap-segment", problem)
        if not wrap.segment <= wrap.last <= last and 0 <= wrap.segment <= last:
            problem = f"wraps up to segment {wrap.last}; it may be {wrap.segment} to {last}"
            yield error(subject, "bad-wrap-segment", problem)
        if wrap.side not in get_args(Side):
            problem = f"side {wrap.side!r} of {wrap.surface!r} must be -1, 0 or 1"
            yield error(subject, "bad-wrap-side", problem)
        if not 0 <= wrap.turns <= MAX_TURNS:
            problem = f"{wrap.turns} turns about {wrap.surface!r} must be from 0 to {MAX_TURNS}"
            yield error(subject, "bad-wrap-turns", problem)
        elif wrap.inside and (wrap.turns or wrap.side):
            problem = f"passes inside {wrap.surface!r}; remove its side and its turns"
            yield error(subject, "bad-wrap-inside", problem)
        elif wrap.inside:
            yield from _inside(subject, wrap, surfaces)
        elif wrap.rule != "taut":
            continue  # by these rules a path with an end inside the surface is straight
        elif 0 <= wrap.segment <= last and wrap.surface in surfaces:
            yield from _ends_inside(subject, muscle, wrap, surfaces[wrap.surface])


def _inside(subject: Subject, wrap: Wrap, surfaces: Mapping[str, WrapSurface]) -> Iterator[Finding]:
    surface = surfaces.get(wrap.surface)
    if surface and surface.shape == "cylinder" and math.isfinite(surface.length):
        problem = f"passes inside the cylinder {surface.name!r}; the cylinder's ends are ignored"
        yield warning(subject, "wrap-ends-left", problem)


def _ends_inside(
    subject: Subject, muscle: Muscle, wrap: Wrap, surface: WrapSurface
) -> Iterator[Finding]:
    """Report ends inside the surface, if they are on the surface's link; other ends move."""
    for k in (wrap.segment, wrap.segment + 1):
        point = muscle.via_points[k]
        if point.link == surface.link and _is_inside(point.position, surface):
            problem = f"via point {k + 1} is inside its wrap surface {surface.name!r}; move it out"
            yield warning(subject, "via-point-inside-wrap", problem)


def _is_inside(position: Vector3, surface: WrapSurface) -> bool:
    x, y, z = apply(inverse(surface.pose), position)
    allowed = surface.radius * (1.0 - INSIDE)
    if surface.shape == "sphere":
        return math.hypot(x, y, z) < allowed
    return math.hypot(x, y) < allowed and abs(z) < surface.length / 2.0


def _sequences(
    subject: Subject, muscle: Muscle, surfaces: Mapping[str, WrapSurface]
) -> Iterator[Finding]:
    """Check several surfaces in one segment: their number, and that they do not overlap."""
    by_segment = groupby(sorted(muscle.wraps, key=_segment), key=_segment)
    for segment, group in by_segment:
        wraps = list(group)
        if len(wraps) > MAX_WRAPS:
            problem = f"{len(wraps)} wraps in segment {segment}; use at most {MAX_WRAPS}"
            yield error(subject, "too-many-wraps", problem)
        over = [wrap for wrap in wraps if wrap.surface in surfaces and not wrap.inside]
        surfaces_in_order = [surfaces[wrap.surface] for wrap in over]
        for first, second in pairwise(surfaces_in_order):
            if _overlap(first, second):
                problem = f"wraps over {first.name!r} and {second.name!r}, which overlap"
                problem += "; the path between them is not taut; add a via point there"
                yield warning(subject, "wraps-overlap", problem)
        for wrap in wraps if len(wraps) > 1 else ():
            if wrap.side and wrap.surface in surfaces and surfaces[wrap.surface].shape == "sphere":
                problem = f"ignores the side at sphere {wrap.surface!r} and uses the shorter path"
                problem += ", since its segment has other surfaces"
                yield warning(subject, "wrap-side-left", problem)


def _segment(wrap: Wrap) -> int:
    return wrap.segment


def _overlap(first: WrapSurface, second: WrapSurface) -> bool:
    """Return whether two spheres on one link overlap.

    Other shapes return False, since the result depends on the points of contact.
    """
    if first.link != second.link or (first.shape, second.shape) != ("sphere", "sphere"):
        return False
    distance = math.dist(first.pose.position, second.pose.position)
    return distance < first.radius + second.radius
