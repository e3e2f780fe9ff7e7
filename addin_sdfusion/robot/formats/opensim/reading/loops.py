"""Reader of OpenSim constraints that close loops: conditions on points, welded frames."""

from __future__ import annotations

from collections.abc import Sequence

from ....checks.loops import rigid_bodies
from ....finding import Subject
from ....model.joint import Joint
from ....model.loop import LoopJoint
from ....model.pose import Vector3
from ....model.rotations import normalized
from ....model.transform import IDENTITY, Transform
from ....transforms.joint_chains import Names
from ....transforms.loop_points import Kind, LoopPoint
from ...reading.loops import closing_joints
from ...reading.xml import ZERO, Node
from .coordinates import COUPLER
from .document import is_true
from .frames import Frames, pose_of

_WELD = "WeldConstraint"
_KINDS: dict[str, Kind] = {
    "PointConstraint": "point",
    "PointOnLineConstraint": "line",
    "ConstantDistanceConstraint": "distance",
}
_SOCKETS = {
    "line": ("socket_line_body", "socket_follower_body"),
    "point": ("socket_body_1", "socket_body_2"),
}
_PLACES = {
    "line": ("point_on_line", "point_on_follower"),
    "point": ("location_body_1", "location_body_2"),
}


def read_loops(
    constraints: Sequence[Node], frames: Frames, joints: Sequence[Joint]
) -> tuple[LoopJoint, ...]:
    """Return the loop joints of a model; report unsupported constraints."""
    names = Names(joint.name for joint in joints)
    closings: list[LoopJoint | LoopPoint] = []
    nodes: dict[str, Node] = {}
    for node in constraints:
        if node.tag == COUPLER or not is_true(node, "isEnforced", True):
            continue
        if node.tag != _WELD and node.tag not in _KINDS:
            _note_left_out(node)
            continue
        name = names.unique(node.attribute("name", "") or node.tag)
        about = nodes[name] = node.with_subject(Subject("joint", name))
        loop = _weld(about, frames, name) if node.tag == _WELD else _point(about, frames, name)
        closings.append(loop)
    loops, others = closing_joints(closings, nodes, rigid_bodies(joints))
    for point in others:
        _note_left_out(nodes[point.name])
    return loops


def _note_left_out(node: Node) -> None:
    name = node.attribute("name", "") or node.tag
    problem = (
        f"<{node.tag}> {name!r} is not supported or forms no joint, and is ignored; the motion of "
        "the robot differs"
    )
    node.warning("loop-left-out", problem, (*_KINDS, _WELD))


def _weld(node: Node, frames: Frames, name: str) -> LoopJoint:
    path = f"/constraintset/{node.attribute('name', '')}"
    (parent, T_parent), (child, T_child) = (
        frames.place(node, f"socket_frame{k}", path) for k in (1, 2)
    )
    return LoopJoint(name, parent, child, "fixed", (), pose_of(T_parent), pose_of(T_child))


def _point(node: Node, frames: Frames, name: str) -> LoopPoint:
    kind = _KINDS[node.tag]
    words = "line" if kind == "line" else "point"
    path = f"/constraintset/{node.attribute('name', '')}"
    placed = [frames.place(node, tag, path) for tag in _SOCKETS[words]]
    (parent, T), (child, _) = placed
    first, second = (
        _place(node, tag, T) for tag, (_, T) in zip(_PLACES[words], placed, strict=True)
    )
    direction, distance = ZERO, 0.0
    if kind == "line":
        line = node.vector("line_direction_vec")
        direction = normalized(T.rotate(line)) if any(line) else ZERO
    if kind == "distance":
        distance = node.number("constant_distance")
    return LoopPoint(name, parent, child, kind, first, second, direction, distance)


def _place(node: Node, tag: str, T: Transform) -> Vector3:
    point = node.vector(tag) if node.all(tag) else ZERO
    return point if T == IDENTITY else T.apply(point)
