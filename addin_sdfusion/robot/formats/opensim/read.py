"""Reader of OpenSim 4 models.

Bodies become links with their frames, and joints become sequences of motions. Couplers become
couplings of coordinates. Points and frames that are held together become loop joints. Muscles of
supported classes keep their muscle law. The ground becomes the world, with y up. Differences to
OpenSim are reported as findings.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from ...errors import UnknownNameError
from ...finding import Subject
from ...finding_builders import listed
from ...model.joint import Joint
from ...model.muscle import CableSet, Muscle
from ...model.robot import DEFAULT_SET, MARKERS, WORLD, Robot, TaskFrame, TaskSet
from ...model.transform import IDENTITY
from ..reading.meshes import note_missing_meshes
from ..reading.tree import parents_first
from ..reading.unique_names import with_unique_names
from ..reading.xml import Node, Notes
from .reading.bodies import note_shapes, read_body
from .reading.coordinates import UNLIMITED, coordinate_ranges, with_couplings
from .reading.document import objects, read_document
from .reading.forces import with_joint_forces
from .reading.frames import Frames
from .reading.joints import free_joint, read_joint
from .reading.loops import read_loops
from .reading.muscles import is_muscle, read_muscle
from .reading.paths import PathContext
from .reading.tori import Torus, with_cylinders
from .reading.wraps import read_wrap_objects
from .writing.joints import has_three_rotations

GRAVITY = (0.0, -9.80665, 0.0)
"""Default gravity of files without gravity."""


def read_osim(file: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """Return the robot in an .osim file. Its only cable set is `cardsflow`.

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
    links = [read_body(b.named("link"), frames) for b in bodies]
    joints = [read_joint(node.named("joint"), frames) for node in joint_nodes]
    joints += _free_joints(bodies, joints)
    constraints = objects(model, "ConstraintSet")
    joints = with_couplings(joints, constraints)
    forces = objects(model, "ForceSet")
    muscles, others = [f for f in forces if is_muscle(f)], [f for f in forces if not is_muscle(f)]
    joints = parents_first(with_joint_forces(joints, others))
    wraps = read_wrap_objects(model, frames)
    ranges = coordinate_ranges([c for node in joint_nodes for c in _coordinates(node)])
    ranges = {c.name: ranges.get(c.name, UNLIMITED) for j in joints for c in j.coordinates}
    context = PathContext(frames, wraps, ranges)
    with_unique_names(muscles, partial(Subject, "muscle"))
    read = [muscle for node in muscles if (muscle := read_muscle(node, context)) is not None]
    loops = read_loops(constraints, frames, joints)
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
    used_names = [joint.name for joint in joints]
    named = [body.with_subject(Subject("link", body.attribute("name", ""))) for body in bodies]
    return [free_joint(body, used_names) for body in named if body.subject.name not in carried]


def _markers(model: Node, frames: Frames) -> list[TaskSet]:
    nodes = with_unique_names(objects(model, "MarkerSet"), partial(Subject, "task_frame"))
    markers = []
    for node in nodes:
        link, T_link_frame = frames.place(node, "socket_parent_frame", "/markerset/marker")
        where = node.vector("location")
        position = where if T_link_frame == IDENTITY else T_link_frame.apply(where)
        if link == WORLD:
            continue  # markers on the world do not belong to the robot
        markers.append(TaskFrame(node.attribute("name"), link, position))
    return [TaskSet(MARKERS, tuple(markers))] if markers else []


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
