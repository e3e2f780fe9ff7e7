"""Reader of the paths of OpenSim muscles: three kinds of points, and wraps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ....finding_builders import unknown
from ....model.function import is_constant, value
from ....model.muscle import ViaPoint, Wrap
from ....model.muscle_path import PointCondition, PointMotion
from ....model.transform import IDENTITY, Transform
from ...reading.xml import Node
from ..writing.points import EDGE
from .document import inner_element, last_part, objects, text
from .frames import Frames
from .functions import read_terms
from .wraps import WrapObject


@dataclass(frozen=True)
class PathContext:
    """Data of the model that its paths are read with."""

    frames: Frames
    wraps: Mapping[str, WrapObject | None]
    coordinates: Mapping[str, tuple[float, float]]


def geometry_path(node: Node) -> Node | None:
    """Return the path of a muscle; None, with a warning, if it has no path through points."""
    for holder in (node, *node.all("path")):
        for path in holder.all("GeometryPath"):
            return path
    others = [child.tag for child in node.all() if child.tag.endswith("Path")]
    element = f"a <{others[0]}>" if others else "no <GeometryPath>"
    problem = f"has {element}; only paths through points are supported; omitted"
    node.warning("muscle-left-out", problem)
    return None


def read_points(path: Node, context: PathContext) -> list[ViaPoint]:
    """Return the points of a path, in order.

    A point at the position of the point before it is ignored, unless wraps refer to points by
    their indices.
    """
    nodes = objects(path, "PathPointSet")
    points = [_point(node, context) for node in nodes]
    if objects(path, "PathWrapSet"):
        return points
    repeated = [k for k in range(1, len(points)) if points[k] == points[k - 1]]
    for k in repeated:
        problem = (
            f"point {nodes[k].attribute('name', '')!r} has the position of the point before it"
        )
        nodes[k].warning("repeated-via-point", f"{problem}; ignored")
    return [point for k, point in enumerate(points) if k not in repeated]


def read_wraps(path: Node, context: PathContext, points: int) -> Iterator[Wrap]:
    """Yield the wraps of a path, in order, without disabled ones."""
    for node in objects(path, "PathWrapSet"):
        name = text(node, "wrap_object")
        if name not in context.wraps:
            problem = unknown("wrap object", name, list(context.wraps))
            node.error("unknown-wrap-surface", problem)
            continue
        wrap = context.wraps[name]
        if wrap is None:
            continue
        child = node.optional("range")
        first, last = (-1.0, -1.0) if child is None else child.numbers(2)
        start = 0 if first < 1.0 else int(min(first, points)) - 1
        end = points - 1 if last < 1.0 else int(min(last, points)) - 1
        if end <= start:
            problem = f"its range {child and child.text!r} contains no segment"
            node.warning("wrap-range-empty", problem)
            continue
        segments = None if end == start + 1 else end - 1
        yield Wrap(
            name,
            start,
            rule="opensim",
            quadrant=wrap.quadrant,
            last_segment=segments,
        )


def _point(node: Node, context: PathContext) -> ViaPoint:
    link, T_link_frame = context.frames.place(node, "socket_parent_frame", "/forceset/muscle/point")
    if node.tag == "MovingPathPoint":
        return _moving(node, context, link, T_link_frame)
    where = node.vector("location")
    position = where if T_link_frame == IDENTITY else T_link_frame.apply(where)
    if node.tag == "ConditionalPathPoint":
        return ViaPoint(link, position, _condition(node, context))
    if node.tag != "PathPoint":
        node.error("unsupported-via-point", f"<{node.tag}> is not supported")
    return ViaPoint(link, position)


def _condition(node: Node, context: PathContext) -> PointCondition | None:
    coordinate = _coordinate(node, "socket_coordinate", context)
    child = node.optional("range")
    low, high = (0.0, 0.0) if child is None else child.numbers(2, infinite=True)
    return None if coordinate is None else PointCondition(coordinate, low - EDGE, high + EDGE)


def _coordinate(node: Node, tag: str, context: PathContext) -> str | None:
    socket = node.optional(tag) or node.optional(f"{tag}_connectee_name")
    name = "" if socket is None else last_part(socket.text)
    if name not in context.coordinates:
        problem = f"<{tag}>: {unknown('coordinate', name, list(context.coordinates))}"
        node.error("unknown-coordinate", problem)
        return None
    return name


def _moving(node: Node, context: PathContext, link: str, T_link_frame: Transform) -> ViaPoint:
    """Return a point whose coordinates are functions of coordinates within their ranges."""
    position = [0.0, 0.0, 0.0]
    moves = []
    for k, letter in enumerate("xyz"):
        coordinate = _coordinate(node, f"socket_{letter}_coordinate", context)
        function = inner_element(node, f"{letter}_location")
        if coordinate is None or function is None:
            continue
        low, high = context.coordinates[coordinate]
        for name, f in read_terms(function, [coordinate]):
            if name and not is_constant(f):
                axis = T_link_frame.axis(k)
                moves.append(PointMotion(axis, coordinate, f, low, high))
            else:
                position[k] += value(f, 0.0)
    x, y, z = position
    return ViaPoint(link, T_link_frame.apply((x, y, z)), moves=tuple(moves))
