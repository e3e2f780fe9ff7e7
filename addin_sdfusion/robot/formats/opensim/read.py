"""Reader of OpenSim 4 models.

Bodies become links with their frames, and joints become sequences of motions. Couplers become
couplings of coordinates. Points and frames that are held together become loop joints. Muscles of
supported classes keep their muscle law. The ground becomes the world, with y up. Differences to
OpenSim are reported as findings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from ...checks.loops import rigid_bodies
from ...errors import UnknownNameError
from ...finding import Subject
from ...finding_builders import listed, unknown
from ...model.joint import Coordinate, Joint, LimitForce
from ...model.loop import LoopJoint
from ...model.muscle import CableSet, Muscle
from ...model.pose import Vector3
from ...model.robot import MARKERS, WORLD, Robot, TaskFrame, TaskSet
from ...model.rotations import normalized
from ...model.transform import IDENTITY, Transform
from ...transforms.joint_chains import Names
from ...transforms.loop_points import Kind, LoopPoint
from ..cardsflow.extras import DEFAULT_SET
from ..reading.loops import closing_joints
from ..reading.meshes import note_missing_meshes
from ..reading.tree import parents_first
from ..reading.unique_names import with_unique_names
from ..reading.xml import ZERO, Node, Notes
from .reading.bodies import note_shapes, read_body
from .reading.coordinates import COUPLER, UNLIMITED, coordinate_ranges, with_couplings
from .reading.document import is_true, last_part, objects, read_document, text
from .reading.frames import Frames, pose_of
from .reading.joints import free_joint, read_joint, with_joint_subject
from .reading.muscles import is_muscle, read_muscle
from .reading.paths import PathContext
from .reading.tori import Torus, with_cylinders
from .reading.wraps import read_wrap_objects
from .writing.joints import has_three_rotations

Change = Callable[[Node, Coordinate], Coordinate]
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
GRAVITY = (0.0, -9.80665, 0.0)
"""Default gravity of files without gravity."""


def read_osim(file: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """Return the robot in an .osim file.

    Args:
        file: The file.
        cable_set: Cable set to activate; the only one is `cardsflow`.
        notes: Collects findings, locations and files.

    Raises:
        InputError: The file is not readable XML, not from OpenSim, or of an older format.
        UnknownNameError: The cable set does not exist.
    """
    if cable_set not in (None, DEFAULT_SET):
        raise UnknownNameError("cable set", str(cable_set), [DEFAULT_SET], file=file)
    model = read_document(file, notes)
    bodies, joint_nodes = objects(model, "BodySet"), objects(model, "JointSet")
    with_unique_names(bodies, partial(Subject, "link"))
    with_unique_names(joint_nodes, partial(Subject, "joint"))
    with_unique_names(
        [c for j in joint_nodes for c in _coordinates(j)], partial(Subject, "coordinate")
    )
    frames = Frames(model)
    links = [
        read_body(b.with_subject(Subject("link", b.attribute("name"))), frames) for b in bodies
    ]
    joints = [read_joint(with_joint_subject(node), frames) for node in joint_nodes]
    joints += _free_joints(bodies, joints)
    constraints = objects(model, "ConstraintSet")
    joints = with_couplings(joints, constraints)
    forces = objects(model, "ForceSet")
    muscles, others = [f for f in forces if is_muscle(f)], [f for f in forces if not is_muscle(f)]
    joints = parents_first(_with_joint_forces(joints, others))
    wraps = read_wrap_objects(model, frames)
    ranges = coordinate_ranges([c for node in joint_nodes for c in _coordinates(node)])
    ranges = {c.name: ranges.get(c.name, UNLIMITED) for j in joints for c in j.coordinates}
    context = PathContext(frames, wraps, ranges)
    with_unique_names(muscles, partial(Subject, "muscle"))
    read = [muscle for node in muscles if (muscle := read_muscle(node, context)) is not None]
    loops = _read_loops(constraints, frames, joints)
    note_shapes(model)
    note_missing_meshes(model, links)
    surfaces = {name: wrap.surface for name, wrap in wraps.items() if wrap is not None}
    gravity = model.vector("gravity") if model.all("gravity") else GRAVITY
    robot = Robot(
        model.subject.name,
        tuple(links),
        tuple(joints),
        (CableSet(DEFAULT_SET, tuple(read)),) if read else (),
        DEFAULT_SET if read else "",
        tuple(_markers(model, frames)),
        gravity=gravity,
        wrap_surfaces=tuple(s for s in surfaces.values() if not isinstance(s, Torus)),
        loops=loops,
    )
    robot = with_cylinders(robot, {n: s for n, s in surfaces.items() if isinstance(s, Torus)})
    _note_approximations(model, robot.muscles)
    _note_defects(model, robot)
    return robot


def _coordinates(joint: Node) -> list[Node]:
    return [c for group in joint.all("coordinates") for c in group.all("Coordinate")]


def _free_joints(bodies: list[Node], joints: list[Joint]) -> list[Joint]:
    carried = {joint.child for joint in joints}
    taken = [joint.name for joint in joints]
    named = [body.with_subject(Subject("link", body.attribute("name", ""))) for body in bodies]
    return [free_joint(body, taken) for body in named if body.subject.name not in carried]


def _markers(model: Node, frames: Frames) -> list[TaskSet]:
    nodes = with_unique_names(objects(model, "MarkerSet"), partial(Subject, "task_frame"))
    found = []
    for node in nodes:
        link, T_link_frame = frames.place(node, "socket_parent_frame", "/markerset/marker")
        where = node.vector("location")
        position = where if T_link_frame == IDENTITY else T_link_frame.apply(where)
        if link == WORLD:
            continue  # markers on the world do not belong to the robot
        found.append(TaskFrame(node.attribute("name"), link, position))
    return [TaskSet(MARKERS, tuple(found))] if found else []


def _note_approximations(model: Node, muscles: Sequence[Muscle]) -> None:
    wrapped = sum(bool(muscle.wraps) for muscle in muscles)
    if wrapped:
        problem = (
            f"{wrapped} muscles wrap along shortest paths; OpenSim's paths are longer, mostly by "
            "less than 0.1 mm, but by some mm far around cylinders and by some cm over flat "
            "ellipsoids; its moment arms are not always the derivatives of its lengths"
        )
        model.warning("wraps-exact", problem)
    several = [repr(muscle.name) for muscle in muscles if len(muscle.wraps) > 1]
    if several:
        problem = (
            f"{len(several)} muscles have several wraps: if a path touches two of them at once, "
            "OpenSim's length is up to 1 cm less than the length of the path through its points; "
            f"forces differ then: {', '.join(several[:10])}"
        )
        model.warning("wraps-in-a-row", problem)
    if any(muscle.model.kind.startswith("hill") for muscle in muscles):
        problem = "default activations and fibre lengths are omitted; an experiment sets the start"
        model.warning("start-left-out", problem)


def _note_defects(model: Node, robot: Robot) -> None:
    """Report results of OpenSim that contradict its other results, and that differ here."""
    moved = {
        muscle.name: move.coordinate
        for muscle in robot.muscles
        for point in muscle.via_points
        for move in point.moves
        if math.isfinite(move.low) or math.isfinite(move.high)
    }
    if moved:
        problem = (
            f"beyond the ranges of {listed(sorted(set(moved.values())))} moving via points are "
            "fixed; OpenSim's lengths agree, but its moment arms are computed as if the points "
            f"still moved: {listed(list(moved))}"
        )
        model.warning("points-beyond-their-range", problem)
    turning = [joint.name for joint in robot.joints if has_three_rotations(joint)]
    if turning:
        problem = (
            "three rotations follow one coordinate: OpenSim 4.6 omits a term of their "
            f"acceleration, and so of the Coriolis forces, at the joints {listed(turning)}"
        )
        model.warning("coriolis-in-opensim", problem)


def _read_loops(
    constraints: Sequence[Node], frames: Frames, joints: Sequence[Joint]
) -> tuple[LoopJoint, ...]:
    """Return the loop joints of a model; report unsupported constraints.

    Args:
        constraints: All constraints.
        frames: Frames of the model.
        joints: Joints of the tree, parents first.
    """
    names = Names(joint.name for joint in joints)
    parts: list[LoopJoint | LoopPoint] = []
    nodes: dict[str, Node] = {}
    for node in constraints:
        if node.tag == COUPLER or not is_true(node, "isEnforced", True):
            continue
        if node.tag != _WELD and node.tag not in _KINDS:
            _note_left_out(node)
            continue
        name = names.unique(node.attribute("name", "") or node.tag)
        about = nodes[name] = node.with_subject(Subject("joint", name))
        part = _weld(about, frames, name) if node.tag == _WELD else _point(about, frames, name)
        parts.append(part)
    loops, others = closing_joints(parts, nodes, rigid_bodies(joints))
    for point in others:
        _note_left_out(nodes[point.name])
    return loops


def _note_left_out(node: Node) -> None:
    given = node.attribute("name", "") or node.tag
    known = ", ".join((*_KINDS, _WELD))
    problem = (
        f"<{node.tag}> {given!r} is not supported and is ignored (known: {known}, if they form a "
        "joint); the motion of the robot differs"
    )
    node.warning("loop-left-out", problem)


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
        given = node.vector("line_direction_vec")
        direction = normalized(T.rotate(given)) if any(given) else ZERO
    if kind == "distance":
        distance = node.number("constant_distance")
    return LoopPoint(name, parent, child, kind, first, second, direction, distance)


def _place(node: Node, tag: str, T: Transform) -> Vector3:
    point = node.vector(tag) if node.all(tag) else ZERO
    return point if T == IDENTITY else T.apply(point)


def _with_joint_forces(joints: Sequence[Joint], forces: Sequence[Node]) -> list[Joint]:
    """Return the joints with the forces at their coordinates; report unsupported forces."""
    known = {c.name: c for joint in joints for c in joint.coordinates}
    left: dict[str, list[Node]] = {}
    for node in forces:
        if not is_true(node, "appliesForce", True):
            continue
        if node.tag not in CHANGES:
            left.setdefault(node.tag, []).append(node)
            continue
        name = last_part(text(node, "coordinate"))
        if name not in known:
            problem = f"<{node.tag}>: {unknown('coordinate', name, list(known))}"
            node.error("unknown-coordinate", problem)
        else:
            known[name] = CHANGES[node.tag](node, known[name])
    for tag, nodes in left.items():
        names = ", ".join(repr(node.attribute("name", "")) for node in nodes[:10])
        problem = f"<{tag}> is not supported; {len(nodes)} omitted: {names}"
        nodes[0].warning("force-left-out", problem)
    return [
        replace(joint, coordinates=tuple(known[c.name] for c in joint.coordinates))
        for joint in joints
    ]


def _motor(node: Node, c: Coordinate) -> Coordinate:
    """Return a coordinate with a motor; several motors become one with the sum of the torques."""
    if not c.is_free:
        what = "locked" if c.locked else "coupled to another"
        problem = f"coordinate {c.name!r} is {what}; its motor {node.attribute('name', '')!r}"
        node.warning("motor-left-out", f"{problem} is omitted")
        return c
    scale = node.number("optimal_force", 1.0)
    low = scale * node.number("min_control", -math.inf, infinite=True)
    high = scale * node.number("max_control", math.inf, infinite=True)
    if c.actuated:
        problem = f"a second motor at {c.name!r}; both are combined, with the sum of both torques"
        node.warning("motors-joined", problem)
        low, high = low + c.tau_min, high + c.tau_max
    return replace(c, actuated=True, tau_min=low, tau_max=high)


def _spring(node: Node, c: Coordinate) -> Coordinate:
    k, rest = node.number("stiffness", 0.0), node.number("rest_length", 0.0)
    stiffness = c.stiffness + k
    if c.stiffness and k:  # two springs are equal to one with a mean rest length
        rest = (c.stiffness * c.rest + k * rest) / stiffness
    elif c.stiffness:
        rest = c.rest
    damping = c.damping + node.number("viscosity", 0.0)
    return replace(c, stiffness=stiffness, rest=rest, damping=damping)


def _limit_force(node: Node, c: Coordinate) -> Coordinate:
    """Return a coordinate with a limit force; for rotations OpenSim uses degrees in all units."""
    degree = math.pi / 180.0 if c.unit == "rad" else 1.0
    if c.limit_force is not None:
        problem = f"a second limit force at {c.name!r} is omitted"
        node.warning("force-left-out", problem)
        return c
    force = LimitForce(
        degree * node.number("lower_limit", 0.0),
        degree * node.number("upper_limit", 0.0),
        node.number("lower_stiffness", 1.0) / degree,
        node.number("upper_stiffness", 1.0) / degree,
        node.number("damping", 0.001) / degree,
        degree * node.number("transition", 0.1),
    )
    return replace(c, limit_force=force)


CHANGES: dict[str, Change] = {
    "CoordinateActuator": _motor,
    "SpringGeneralizedForce": _spring,
    "CoordinateLimitForce": _limit_force,
}
