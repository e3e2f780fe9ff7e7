"""Writer of the points of muscles in OpenSim: fixed, conditional and moving ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from xml.etree import ElementTree

from ....finding import Subject
from ....model.function import Function, Polynomial, constant
from ....model.muscle import Muscle, ViaPoint
from ....model.muscle_path import PointMotion
from ....model.pose import AXES
from ....model.robot import Robot
from ...capability import FeaturePlace
from ...writing.xml_text import element, numbers
from .bodies import frame_path, objects
from .functions import add_function

EDGE = 1e-5
"""A conditional point is also active this far beyond its range in OpenSim; in [rad] or [m]."""
Range = tuple[float, float]


CoordinatePaths = Mapping[str, str]
"""Path of each coordinate in the model, as used in sockets."""


def add_points(path: ElementTree.Element, muscle: Muscle, coordinates: CoordinatePaths) -> None:
    """Add the points of a muscle to its path."""
    points = objects(path, "PathPointSet", "pathpointset")
    for k, point in enumerate(muscle.via_points, start=1):
        _add_point(points, point, f"{muscle.name}-P{k}", coordinates)


def ranges_of_points(robot: Robot) -> dict[str, Range]:
    """Return the ranges in which coordinates move points; OpenSim uses ranges of coordinates."""
    return {move.coordinate: (move.low, move.high) for _, move in _moves(robot)}


def changed_ranges(robot: Robot) -> Iterator[FeaturePlace]:
    """Report moving points with a range that differs from the coordinate's range in OpenSim."""
    for muscle, move in _moves(robot):
        low, high = _written_range(robot, move)
        if (move.low, move.high) != (low, high):
            words = {"coordinate": move.coordinate, "low": low, "high": high}
            words |= {"own_low": move.low, "own_high": move.high}
            yield FeaturePlace(Subject("muscle", muscle.name), words)


def ranges_without_limits(robot: Robot) -> Iterator[FeaturePlace]:
    """Report motions of points with a range whose coordinate has no limits."""
    for muscle, move in _moves(robot):
        low, high = _written_range(robot, move)
        if (low, high) != (-math.inf, math.inf) and not _limits(robot, move):
            words = {"coordinate": move.coordinate, "low": low, "high": high}
            yield FeaturePlace(Subject("muscle", muscle.name), words)


def _written_range(robot: Robot, move: PointMotion) -> Range:
    return _limits(robot, move) or ranges_of_points(robot)[move.coordinate]


def _limits(robot: Robot, move: PointMotion) -> Range | None:
    """Return the limits of the coordinate that moves a point, or None."""
    c = next(c for c in robot.all_coordinates if c.name == move.coordinate)
    return (c.lower, c.upper) if c.is_limited else None


def loses_motion(point: ViaPoint) -> bool:
    """Return whether a point moves in this simulation but not in OpenSim."""
    return bool(point.moves) and not _is_moving(point)


def _moves(robot: Robot) -> Iterator[tuple[Muscle, PointMotion]]:
    for muscle in robot.muscles:
        for point in muscle.via_points:
            for move in point.moves:
                yield muscle, move


def _is_moving(point: ViaPoint) -> bool:
    """Return whether OpenSim can hold the point as a moving point."""
    return bool(point.moves) and point.when is None and _axis_motions(point) is not None


def _axis_motions(point: ViaPoint) -> list[PointMotion | None] | None:
    """Return the motion along each axis of the link, or None if OpenSim cannot hold them."""
    motions: list[PointMotion | None] = [None, None, None]
    for move in point.moves:
        if move.axis not in AXES or motions[AXES.index(move.axis)] is not None:
            return None
        motions[AXES.index(move.axis)] = move
    return motions


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
    axes = _axis_motions(point) or [None, None, None]
    for letter, at, move in zip("xyz", point.position, axes, strict=True):
        function = constant(at) if move is None else _plus_constant(move.function, at)
        element(item, f"socket_{letter}_coordinate", coordinates[(move or some).coordinate])
        add_function(element(item, f"{letter}_location"), [function])


def _plus_constant(function: Function, by: float) -> Function:
    if isinstance(function, Polynomial):
        first, *others = function.coefficients
        return Polynomial((first + by, *others))
    return replace(function, y=tuple(y + by for y in function.y))
