"""Geometry of muscle paths: lines for drawing, and the forces of muscles on links."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import Muscle, Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.library import Core
from sim_dart.core.path_fields import first_points, ordered_wraps, pulley_muscles
from sim_dart.muscles.geodesics import PlacedEllipsoid, geodesic_line

_NUMBERS = 22
_IN_USE = 0.5
"""Smallest activation of a via point with which it is drawn."""
ARC_STEP = math.radians(5.0)
"""Largest angle between neighbouring points of a drawn arc, in [rad]."""


class PointForces(NamedTuple):
    """Forces of muscles on links, in the world frame.

    Attributes:
        muscles: Index of the muscle of each force, shape (k,).
        links: Name of the link on which each force acts.
        points: Points of application, shape (k, 3), in [m].
        forces: Forces, shape (k, 3), in [N].
    """

    muscles: np.ndarray
    links: tuple[str, ...]
    points: FloatArray
    forces: FloatArray


class _Contact(NamedTuple):
    """Contact of a muscle with a wrap surface or a pulley; see `core_trace` in core.h."""

    link: str
    begin: FloatArray
    entering: FloatArray
    end: FloatArray
    leaving: FloatArray
    touch: FloatArray
    lift: FloatArray
    axis: FloatArray
    angle: float
    centre: FloatArray
    is_pulley: bool
    ellipsoid: PlacedEllipsoid | None = None


class PathShapes:
    """Geometry of the muscle paths of a robot at the last q of the core.

    Args:
        core: The core of this robot.
    """

    def __init__(self, robot: Robot, core: Core) -> None:
        self._muscles = robot.muscles
        self._core = core
        self._firsts = first_points(robot)
        self._wraps = ordered_wraps(robot)
        self._pulleys = pulley_muscles(robot)
        self._radii = {
            k: self._muscles[k].pulley.radius[0]  # type: ignore[union-attr]
            for k in self._pulleys
        }
        surfaces = {surface.name: k for k, surface in enumerate(robot.wrap_surfaces)}
        self._surfaces = [surfaces[each.wrap.surface] for each in self._wraps]
        self._half_axes = [
            np.array([s.radius, *s.half_axes]) if s.half_axes else None for s in robot.wrap_surfaces
        ]
        self._across = core.array("surface_across", len(surfaces), 3)
        self._links = [robot.wrap_surfaces[k].link for k in self._surfaces]
        self._points = core.array("points", sum(len(m.via_points) for m in robot.muscles), 3)
        self._places = core.array("surface_places", len(surfaces), 6)
        self._before = core.array("wrap_before", len(self._wraps))
        self._rank = core.array("wrap_rank", len(self._wraps))
        self._shares = core.array("point_share", sum(len(m.via_points) for m in robot.muscles))
        self._wrap_numbers = core.array("wrap_contacts", len(self._wraps), _NUMBERS)
        self._pulley_numbers = core.array("pulley_contacts", len(self._pulleys), _NUMBERS)

    def lines(self) -> list[FloatArray]:
        """Return a polyline along each muscle path, shape (k, 3), in [m]."""
        return [
            np.array(list(self._line(first, muscle, by_segment))).reshape(-1, 3)
            for first, muscle, by_segment in self._paths()
        ]

    def forces(self, tensions: FloatArray) -> PointForces:
        """Return the forces of the muscles on links, one pair per straight segment of a path.

        Args:
            tensions: Tensions f, shape (m,), in [N].
        """
        rows = [
            (k, link, point, tensions[k] * direction)
            for k, (first, muscle, by_segment) in enumerate(self._paths())
            for link, point, direction in self._pulls(first, muscle, by_segment)
        ]
        muscles, links, points, forces = zip(*rows, strict=True) if rows else ((), (), (), ())
        shape = (len(rows), 3)
        return PointForces(
            np.array(muscles, dtype=int),
            tuple(links),
            np.array(points, dtype=np.float64).reshape(shape),
            np.array(forces, dtype=np.float64).reshape(shape),
        )

    def _paths(self) -> Iterator[tuple[int, Muscle, dict[int, list[_Contact]]]]:
        """Iterate over the muscles: first point, muscle, and contacts by the point before them."""
        self._core.trace(self._core.handle)
        contacts: dict[int, list[_Contact]] = {}
        for k, numbers in zip(self._pulleys, self._pulley_numbers, strict=True):
            link = self._muscles[k].via_points[0].link
            contacts[self._firsts[k]] = [_pulley_contact(link, numbers, self._radii[k])]
        for k in np.lexsort((self._rank, self._before)):
            surface = self._surfaces[k]
            contact = _contact(self._links[k], self._wrap_numbers[k], self._places[surface, :3])
            contact = contact._replace(ellipsoid=self._ellipsoid(surface))
            contacts.setdefault(int(self._before[k]), []).append(contact)
        for first, muscle in zip(self._firsts, self._muscles, strict=True):
            yield first, muscle, contacts

    def _ellipsoid(self, surface: int) -> PlacedEllipsoid | None:
        half_axes = self._half_axes[surface]
        if half_axes is None:
            return None
        centre, z = self._places[surface, :3].copy(), self._places[surface, 3:].copy()
        x = self._across[surface].copy()
        return PlacedEllipsoid(centre, np.column_stack([x, np.cross(z, x), z]), half_axes)

    def _line(
        self, first: int, muscle: Muscle, contacts: dict[int, list[_Contact]]
    ) -> Iterator[FloatArray]:
        for point in range(first, first + len(muscle.via_points)):
            if self._shares[point] < _IN_USE:
                continue
            yield self._points[point].copy()
            for contact in contacts.get(point, ()):
                if contact.angle:
                    yield from _arc(contact)

    def _pulls(
        self, first: int, muscle: Muscle, contacts: dict[int, list[_Contact]]
    ) -> Iterator[tuple[str, FloatArray, FloatArray]]:
        """Iterate over the unit forces of a muscle on links: link, point and direction."""
        for i, j, share in self._segments(first, muscle):
            first_link, second_link = muscle.via_points[i].link, muscle.via_points[j].link
            A, B = self._points[first + i].copy(), self._points[first + j].copy()
            touched = [c for c in contacts.get(first + i, ()) if c.angle]
            if not touched:
                length = np.linalg.norm(B - A)
                if length:
                    yield first_link, A, share * (B - A) / length
                    yield second_link, B, share * (A - B) / length
                continue
            for link, point, direction in _span_pulls(first_link, A, touched, second_link, B):
                yield link, point, share * direction

    def _segments(self, first: int, muscle: Muscle) -> Iterator[tuple[int, int, float]]:
        """Iterate over the segments of a path: both point indices and the weight of the length."""
        share, divisor = self._shares[first : first + len(muscle.via_points)], 1.0
        divisors = {branch.point: branch.divisor for branch in muscle.branches}
        for i in range(len(share)):
            divisor = divisors.get(i, divisor)
            left = float(share[i])
            for j in range(i + 1, len(share)):
                if not left or j in divisors:
                    break
                if share[j]:
                    yield i, j, left * float(share[j]) / divisor
                left *= 1.0 - float(share[j])


def _span_pulls(
    first_link: str, A: FloatArray, touched: list[_Contact], second_link: str, B: FloatArray
) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    """Iterate over the unit forces at the ends of all spans between two via points."""
    if not touched[0].is_pulley:
        yield first_link, A, touched[0].entering
    for c in touched:
        if not c.is_pulley:
            yield c.link, _point_on_force_line(c.touch, c.begin, c.entering), -c.entering
        yield c.link, _point_on_force_line(c.lift, c.end, c.leaving), c.leaving
    yield second_link, B, -touched[-1].leaving


def _point_on_force_line(
    preferred: FloatArray, point: FloatArray, direction: FloatArray
) -> FloatArray:
    """Return the preferred point if it is on the line of a force, otherwise the other point."""
    aside = np.cross(preferred - point, direction)
    near = np.linalg.norm(aside) <= 1e-14 * np.linalg.norm(preferred - point)
    return preferred if near else point


def _arc(contact: _Contact) -> Iterator[FloatArray]:
    """Generate points from touch to lift, including both; one point if these are equal."""
    if np.array_equal(contact.touch, contact.lift):
        yield contact.touch
        return
    if contact.ellipsoid is not None:
        ends = (contact.touch, contact.lift)
        yield from geodesic_line(contact.ellipsoid, *ends, contact.entering, contact.angle)
        return
    n, steps = contact.axis, max(1, math.ceil(contact.angle / ARC_STEP))
    start = contact.touch - contact.centre
    across = start - (start @ n) * n
    aside = np.cross(n, across)
    climb = (contact.lift - contact.touch) @ n
    yield contact.touch
    for k in range(1, steps):
        angle = contact.angle * k / steps
        turned = math.cos(angle) * across + math.sin(angle) * aside
        yield contact.centre + turned + (start @ n + climb * k / steps) * n
    yield contact.lift


def _contact(
    link: str, numbers: FloatArray, centre: FloatArray, *, is_pulley: bool = False
) -> _Contact:
    begin, entering, end, leaving, touch, lift, axis = numbers[:-1].reshape(7, 3).copy()
    ends = (begin, entering, end, leaving, touch, lift, axis)
    return _Contact(link, *ends, float(numbers[-1]), centre.copy(), is_pulley)


def _pulley_contact(link: str, numbers: FloatArray, radius: float) -> _Contact:
    """Return a contact with a pulley. Its centre is perpendicular to the incoming cable."""
    contact = _contact(link, numbers, np.zeros(3), is_pulley=True)
    if np.array_equal(contact.lift, contact.end) and contact.angle:  # the cable ends inside it
        chord = float(np.linalg.norm(contact.lift - contact.touch))
        radius = chord / (2 * math.sin(contact.angle / 2))
    across = np.cross(contact.axis, contact.entering)
    return contact._replace(centre=contact.touch + radius * across)
