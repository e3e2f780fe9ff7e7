"""Paths of OpenSim's muscles: points of three kinds, and what they wrap over."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ....finding_builders import unknown
from ....model.function import is_constant, value
from ....model.muscle import ViaPoint, Wrap
from ....model.muscle_path import PointCondition, PointMotion
from ....model.transform import IDENTITY, Transform
from ...reading.xml import Node
from .document import inner, last_name, objects, text
from .frames import Frames
from .functions import read_terms
from .wraps import WrapObject

EDGE = 1e-5
"""A conditional point is in use this far beyond its range too, as in OpenSim; in [rad] or [m]."""


@dataclass(frozen=True)
class Surroundings:
    """What a path is read with.

    Attributes:
        frames: The frames of the model.
        wraps: Its wrap objects.
        coordinates: The ranges of its coordinates by name, those that stop nothing as well.
    """

    frames: Frames
    wraps: Mapping[str, WrapObject | None]
    coordinates: Mapping[str, tuple[float, float]]


def geometry_path(node: Node) -> Node | None:
    """Return the path of a muscle; if there is none, or one of another kind, that is noted."""
    for holder in (node, *node.all("path")):
        for path in holder.all("GeometryPath"):
            return path
    others = [child.tag for child in node.all() if child.tag.endswith("Path")]
    what = f"a <{others[0]}>" if others else "no <GeometryPath>"
    problem = f"it has {what}; only paths through points are supported: it is left out"
    node.warning("muscle-left-out", problem)
    return None


def read_points(path: Node, around: Surroundings) -> list[ViaPoint]:
    """Return the points of a path, in order."""
    return [_point(node, around) for node in objects(path, "PathPointSet")]


def read_wraps(path: Node, around: Surroundings, points: int) -> Iterator[Wrap]:
    """What a path wraps over, in order, but for what is switched off."""
    for node in objects(path, "PathWrapSet"):
        name = text(node, "wrap_object")
        if name not in around.wraps:
            problem = unknown("wrap object", name, list(around.wraps))
            node.error("unknown-wrap-surface", problem)
            continue
        wrap = around.wraps[name]
        if wrap is None:
            continue
        child = node.optional("range")
        first, last = (-1.0, -1.0) if child is None else child.numbers(2)
        start = 0 if first < 1.0 else int(min(first, points)) - 1
        end = points - 1 if last < 1.0 else int(min(last, points)) - 1
        if end <= start:
            node.warning("wrap-range-empty", f"its range {child and child.text!r} has no segment")
            continue
        segments = None if end == start + 1 else end - 1
        yield Wrap(
            name,
            start,
            rule="opensim",
            quadrant=wrap.quadrant,
            last_segment=segments,
        )


def _point(node: Node, around: Surroundings) -> ViaPoint:
    link, T_link_frame = around.frames.place(node, "socket_parent_frame", "/forceset/muscle/point")
    if node.tag == "MovingPathPoint":
        return _moving(node, around, link, T_link_frame)
    where = node.vector("location")
    position = where if T_link_frame == IDENTITY else T_link_frame.apply(where)
    if node.tag == "ConditionalPathPoint":
        return ViaPoint(link, position, _condition(node, around))
    if node.tag != "PathPoint":
        node.error("unsupported-via-point", f"<{node.tag}> is not supported")
    return ViaPoint(link, position)


def _condition(node: Node, around: Surroundings) -> PointCondition | None:
    coordinate = _coordinate(node, "socket_coordinate", around)
    child = node.optional("range")
    low, high = (0.0, 0.0) if child is None else child.numbers(2, infinite=True)
    return None if coordinate is None else PointCondition(coordinate, low - EDGE, high + EDGE)


def _coordinate(node: Node, tag: str, around: Surroundings) -> str | None:
    socket = node.optional(tag) or node.optional(f"{tag}_connectee_name")
    name = "" if socket is None else last_name(socket.text)
    if name not in around.coordinates:
        problem = f"<{tag}>: {unknown('coordinate', name, list(around.coordinates))}"
        node.error("unknown-coordinate", problem)
        return None
    return name


def _moving(node: Node, around: Surroundings, link: str, T_link_frame: Transform) -> ViaPoint:
    """A point whose place along each axis is a function of a coordinate, kept to its range."""
    position = [0.0, 0.0, 0.0]
    moves = []
    for k, letter in enumerate("xyz"):
        coordinate = _coordinate(node, f"socket_{letter}_coordinate", around)
        function = inner(node, f"{letter}_location")
        if coordinate is None or function is None:
            continue
        low, high = around.coordinates[coordinate]
        for name, f in read_terms(function, [coordinate]):
            if name and not is_constant(f):
                axis = T_link_frame.axis(k)
                moves.append(PointMotion(axis, coordinate, f, low, high))
            else:
                position[k] += value(f, 0.0)
    x, y, z = position
    return ViaPoint(link, T_link_frame.apply((x, y, z)), moves=tuple(moves))
