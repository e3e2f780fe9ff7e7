"""Points of muscles in OpenSim: fixed, conditional and moving ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from xml.etree import ElementTree

from ....finding import Finding, Subject
from ....finding_builders import warning
from ....model.function import Function, Polynomial, constant
from ....model.muscle import Muscle, ViaPoint
from ....model.muscle_path import PointMotion
from ....model.pose import Vector3
from ....model.robot import Robot
from ...writing.xml_text import element, numbers
from .bodies import frame_path, objects
from .functions import add_function

EDGE = 1e-5
"""A conditional point is in use this far beyond its range too, in OpenSim; in [rad] or [m]."""
UNITS: tuple[Vector3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
Range = tuple[float, float]


CoordinatePaths = Mapping[str, str]
"""Where each coordinate is in the model, as its sockets want it."""


def add_points(path: ElementTree.Element, muscle: Muscle, coordinates: CoordinatePaths) -> None:
    """Add the points of a muscle to its path."""
    points = objects(path, "PathPointSet", "pathpointset")
    for k, point in enumerate(muscle.via_points, start=1):
        _add_point(points, point, f"{muscle.name}-P{k}", coordinates)


def ranges_of_points(robot: Robot) -> dict[str, Range]:
    """The ranges within which coordinates move points: OpenSim takes the coordinates' own."""
    return {move.coordinate: (move.low, move.high) for _, move in _moves(robot)}


def point_losses(robot: Robot) -> Iterator[Finding]:
    """Moving points that OpenSim does not have, and what it does otherwise."""
    limits = {c.name: (c.lower, c.upper) for c in robot.all_coordinates}
    ranges = ranges_of_points(robot)
    for muscle, move in _moves(robot):
        lower, upper = limits[move.coordinate]
        limited = math.isfinite(lower) or math.isfinite(upper)
        written = (lower, upper) if limited else ranges[move.coordinate]
        if (move.low, move.high) != written:
            problem = (
                f"OpenSim moves its points within the range of {move.coordinate!r}, "
                f"{written[0]:g} to {written[1]:g}, not {move.low:g} to {move.high:g}"
            )
            yield warning(Subject("muscle", muscle.name), "point-range-changed", problem)
        if not limited and written != (lower, upper):
            problem = (
                f"where {move.coordinate!r} is beyond {written[0]:g} to {written[1]:g} its points "
                "stand still, but OpenSim's moment arms, by which it pulls, go on as if they moved"
            )
            yield warning(Subject("muscle", muscle.name), "points-beyond-their-range", problem)
    for muscle in robot.muscles:
        subject = Subject("muscle", muscle.name)
        for k, point in enumerate(muscle.via_points, start=1):
            if point.when is not None and point.when.smoothing:
                problem = f"OpenSim's points come and go at once; smoothing left out: {k}"
                yield warning(subject, "point-smoothing-left-out", problem)
            if point.moves and not _is_moving(point):
                problem = (
                    "OpenSim moves a point along x, y and z of its link, by a function each, and "
                    f"at all times; fixed there: {k}"
                )
                yield warning(subject, "point-motion-left-out", problem)


def _moves(robot: Robot) -> Iterator[tuple[Muscle, PointMotion]]:
    for muscle in robot.muscles:
        for point in muscle.via_points:
            for move in point.moves:
                yield muscle, move


def _is_moving(point: ViaPoint) -> bool:
    """Whether it is a moving point of OpenSim's."""
    return bool(point.moves) and point.when is None and _along(point) is not None


def _along(point: ViaPoint) -> list[PointMotion | None] | None:
    """The motion along each axis of the link; None where there are others, or several along one."""
    found: list[PointMotion | None] = [None, None, None]
    for move in point.moves:
        if move.axis not in UNITS or found[UNITS.index(move.axis)] is not None:
            return None
        found[UNITS.index(move.axis)] = move
    return found


def _add_point(
    points: ElementTree.Element, point: ViaPoint, name: str, coordinates: CoordinatePaths
) -> None:
    if _is_moving(point):
        _add_moving(points, point, name, coordinates)
        return
    kind = "PathPoint" if point.when is None else "ConditionalPathPoint"
    item = element(points, kind, name=name)
    element(item, "socket_parent_frame", frame_path(point.link))
    element(item, "location", numbers(point.position))
    if point.when is not None:
        element(item, "socket_coordinate", coordinates[point.when.coordinate])
        element(item, "range", numbers((point.when.low + EDGE, point.when.high - EDGE)))


def _add_moving(
    points: ElementTree.Element, point: ViaPoint, name: str, coordinates: CoordinatePaths
) -> None:
    item = element(points, "MovingPathPoint", name=name)
    element(item, "socket_parent_frame", frame_path(point.link))
    some = point.moves[0]
    axes = _along(point) or [None, None, None]
    for letter, at, move in zip("xyz", point.position, axes, strict=True):
        function = constant(at) if move is None else _raised(move.function, at)
        element(item, f"socket_{letter}_coordinate", coordinates[(move or some).coordinate])
        add_function(element(item, f"{letter}_location"), [function])


def _raised(function: Function, by: float) -> Function:
    """The function and a constant."""
    if isinstance(function, Polynomial):
        first, *others = function.coefficients
        return Polynomial((first + by, *others))
    return replace(function, y=tuple(y + by for y in function.y))
