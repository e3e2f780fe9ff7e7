"""Geometry of muscle paths: lines for drawing, and the forces of muscles on links."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import Muscle, Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.library import Core
from sim_dart.core.path_fields import pulley_muscles
from sim_dart.core.route_fields import first_points, ordered_wraps

_NUMBERS = 22


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
    angle: float
    is_pulley: bool


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
        surfaces = {surface.name: k for k, surface in enumerate(robot.wrap_surfaces)}
        self._links = [
            robot.wrap_surfaces[surfaces[each.wrap.surface]].link for each in self._wraps
        ]
        self._points = core.array("points", sum(len(m.via_points) for m in robot.muscles), 3)
        self._before = core.array("wrap_before", len(self._wraps))
        self._rank = core.array("wrap_rank", len(self._wraps))
        self._shares = core.array("point_share", sum(len(m.via_points) for m in robot.muscles))
        self._wrap_numbers = core.array("wrap_contacts", len(self._wraps), _NUMBERS)
        self._pulley_numbers = core.array("pulley_contacts", len(self._pulleys), _NUMBERS)
        self._drawn = np.empty((1000, 3))

    def lines(self) -> list[FloatArray]:
        """Return a polyline along each muscle path, shape (k, 3), in [m]."""
        sizes = np.zeros(len(self._muscles), dtype=np.int32)

        def draw() -> int:
            core, places = self._core, (sizes.ctypes.data, self._drawn.ctypes.data)
            return int(core.lines(core.handle, *places, len(self._drawn)))

        if (count := draw()) > len(self._drawn):
            self._drawn = np.empty((count, 3))
            draw()
        ends = np.cumsum(sizes)
        return [self._drawn[end - n : end].copy() for end, n in zip(ends, sizes, strict=True)]

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
            contacts[self._firsts[k]] = [_contact(link, numbers, is_pulley=True)]
        for k in np.lexsort((self._rank, self._before)):
            contact = _contact(self._links[k], self._wrap_numbers[k])
            contacts.setdefault(int(self._before[k]), []).append(contact)
        for first, muscle in zip(self._firsts, self._muscles, strict=True):
            yield first, muscle, contacts

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


def _contact(link: str, numbers: FloatArray, *, is_pulley: bool = False) -> _Contact:
    begin, entering, end, leaving, touch, lift, _ = numbers[:-1].reshape(7, 3).copy()
    ends = (begin, entering, end, leaving, touch, lift)
    return _Contact(link, *ends, float(numbers[-1]), is_pulley)
