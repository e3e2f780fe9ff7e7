"""Reader of MJCF equalities: exact couplings of joints, and loop joints between bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ...checks.loops import rigid_bodies
from ...finding import Subject
from ...finding_builders import unknown
from ...model.function import Polynomial, taylor
from ...model.joint import Coordinate, Joint, Term
from ...model.loop import LoopJoint
from ...model.pose import Pose
from ...model.robot import Robot
from ...model.transform import Transform
from ...transforms.joint_chains import Names
from ...transforms.loop_points import LoopPoint
from ..reading.loops import closing_joints
from ..reading.xml import Node
from .compiled import Compiled, Row, rotation_of, transform, vector
from .document import Document, note_equality

CONNECT, WELD = "connect", "weld"
"""Equalities between bodies."""


def with_couplings(joints: Sequence[Joint], document: Document, compiled: Compiled) -> list[Joint]:
    """Return the joints with coordinates coupled or locked by joint equalities."""
    coordinates = {c.name: c for joint in joints for c in joint.coordinates}
    coupled: list[Node] = []
    for row in compiled.equalities:
        node = document.node_at(row["line"])
        if not row["active0"] or row["type"] in (CONNECT, WELD) or is_distance(row, compiled):
            continue
        if row["type"] != "joint":
            note_equality(node)
        elif _couple(row, node, compiled, coordinates):
            coupled.append(node)
    _note_exact(coupled, "joints")
    return [joint.map_coordinates(lambda c: coordinates[c.name]) for joint in joints]


def _couple(row: Row, node: Node, compiled: Compiled, by_name: dict[str, Coordinate]) -> bool:
    """Couple joint 1 to joint 2, or lock it; return whether this succeeded.

    q1 - ref1 = c0 + c1 (q2 - ref2) + ... + c4 (q2 - ref2)⁴, or c0 if joint 2 is not set.
    """
    first = compiled.joints[row["obj1id"]]["name"]
    second = compiled.joints[row["obj2id"]]["name"] if row["obj2id"] >= 0 else ""
    for name in (first, second) if second else (first,):
        if name not in by_name:
            node.error(
                "unknown-coordinate", unknown("joint of one coordinate", name, list(by_name))
            )
            return False
    c, powers = by_name[first], row["data"][:5]
    if c.coupling or c.locked:
        problem = f"{first!r} is already coupled or locked; omitted"
        node.warning("equality-left-out", problem)
        return False
    if not second:
        by_name[first] = replace(c, locked=True, initial=c.initial + powers[0])
        return True
    shifted = list(taylor(powers, -by_name[second].initial))
    while len(shifted) > 1 and shifted[-1] == 0.0:
        shifted.pop()
    function = Polynomial((shifted[0] + c.initial, *shifted[1:]))
    open_ = replace(c, lower=-math.inf, upper=math.inf, actuated=False)
    by_name[first] = replace(open_, coupling=(Term(second, function),))
    return True


def with_loops(robot: Robot, document: Document, compiled: Compiled) -> Robot:
    """Return the robot with loop joints from equalities, which are exact here."""
    names = Names(joint.name for joint in robot.joints)
    constraints: list[LoopJoint | LoopPoint] = []
    nodes: dict[str, Node] = {}
    exact: dict[str, Node] = {}
    for row in compiled.equalities:
        is_part = row["type"] in (CONNECT, WELD) or is_distance(row, compiled)
        if is_part and row["active0"]:
            name = names.unique(row["name"] or row["type"])
            nodes[name] = document.node_at(row["line"]).with_subject(Subject("joint", name))
            constraints.append(_constraint(row, name, compiled))
            exact[name] = document.node_at(row["line"])
    bodies = rigid_bodies(robot.joints)
    loops, others = closing_joints(constraints, nodes, bodies)
    for point in others:
        note_equality(exact[point.name])
    used = [c for c in constraints if c not in others]
    moving = [c.name for c in used if bodies.get(c.parent) != bodies.get(c.child)]
    _note_exact([exact[name] for name in moving], "loops")
    return replace(robot, loops=loops)


def is_distance(row: Row, compiled: Compiled) -> bool:
    """Return whether an equality keeps the distance of two sites: a tendon of constant length."""
    if row["type"] != "tendon" or row["obj2id"] >= 0:
        return False
    return [wrap["type"] for wrap in _path(row, compiled)] == ["site", "site"]


def _path(row: Row, compiled: Compiled) -> Sequence[Row]:
    tendon = compiled.tendons[row["obj1id"]]
    return compiled.wraps[tendon["adr"] : tendon["adr"] + tendon["num"]]


def _constraint(row: Row, name: str, compiled: Compiled) -> LoopJoint | LoopPoint:
    if row["type"] == "tendon":
        (parent, at_parent), (child, at_child) = (
            _site(compiled, wrap["objid"], True) for wrap in _path(row, compiled)
        )
        length = compiled.tendons[row["obj1id"]]["length0"] + row["data"][0]
        places = at_parent.position, at_child.position
        return LoopPoint(name, parent, child, "distance", *places, distance=length)
    first, second = row["obj1id"], row["obj2id"]
    is_point = row["type"] == CONNECT
    if row["objtype"] == "site":
        ends = _site(compiled, first, is_point), _site(compiled, second, is_point)
    else:
        first_frame, second_frame = _ends(row["data"], is_point)
        names = [compiled.bodies[k]["name"] for k in (first, second)]
        ends = (names[0], first_frame), (names[1], second_frame)
    (parent, T_parent), (child, T_child) = ends
    if is_point:
        return LoopPoint(name, parent, child, "point", T_parent.position, T_child.position)
    return LoopJoint(name, parent, child, "fixed", (), T_parent, T_child)


def _site(compiled: Compiled, number: int, is_point: bool) -> tuple[str, Pose]:
    row = compiled.sites[number]
    pose = Pose(vector(row["pos"])) if is_point else transform(row).pose()
    return compiled.bodies[row["bodyid"]]["name"], pose


def _ends(data: Sequence[float], is_point: bool) -> tuple[Pose, Pose]:
    """Return the coinciding frames of two bodies: the anchors, or the relative pose of a weld."""
    if is_point:
        return Pose(vector([*data[:3]])), Pose(vector([*data[3:6]]))
    anchor = vector([*data[:3]])
    T_first_second = Transform(rotation_of([*data[6:10]]), vector([*data[3:6]]))
    return T_first_second.pose(), Pose(anchor)


def _note_exact(nodes: Sequence[Node], kind: str) -> None:
    """Report equalities that are soft in MuJoCo."""
    if nodes:
        problem = (
            f"{len(nodes)} equalities of {kind} are exact here; in MuJoCo they are soft springs "
            "with a time constant"
        )
        nodes[0].warning("exact-equality", problem)
