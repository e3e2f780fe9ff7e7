"""Reader of MuJoCo's MJCF.

Bodies are links with their own frames, the joints of a body the motions of one joint. Spatial and
fixed tendons with an actuator are muscles, equalities of joints exact couplings, those of bodies
loop joints. What acts otherwise than in MuJoCo, or is left out, is a finding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from ...checks.check import check
from ...errors import UnknownNameError
from ...finding import Subject
from ...formats.cardsflow.beside import DEFAULT_SET
from ...formats.reading.distinct import distinct
from ...formats.reading.meshes import note_missing_meshes
from ...formats.reading.xml import Node, Notes
from ...model.coupling import all_values
from ...model.joint import Coordinate, Joint
from ...model.muscle import CableSet
from ...model.pose import Vector3
from ...model.robot import MARKERS, WORLD, Link, Robot, TaskFrame, TaskSet
from .actuators import ActuatorReader
from .bodies import Body, read_bodies
from .compiler import numbers, read_compiler
from .document import Document
from .drives import read_drives
from .equality import with_equalities
from .found import with_found
from .inertia import read_inertias
from .joints import JointReader
from .loops import with_loops
from .meshes import MeshAssets, collision_kind
from .shapes import shape_of
from .tendons import TendonReader

GRAVITY = (0.0, 0.0, -9.81)
INITIAL = "initial"
"""The keyframe of our own files with the initial values."""
LEFT_OUT = ("sensor", "contact", "deformable", "extension", "keyframe")


def read_mjcf(file: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """The robot in an MJCF file, with all files that it includes.

    Args:
        file: The file.
        cable_set: The cable set to make active: there is one, `cardsflow`.
        notes: Where findings, places and files go.

    Raises:
        InputError: A file is not readable XML, or not MJCF.
        UnknownNameError: There is no such cable set.
    """
    if cable_set not in (None, DEFAULT_SET):
        raise UnknownNameError("cable set", str(cable_set), [DEFAULT_SET], file=file)
    document = Document(file, notes)
    compiler = read_compiler(document)
    bodies = read_bodies(document, compiler)
    meshes = MeshAssets(document, compiler)
    reader = JointReader(compiler, bodies)
    carried = [body for body in bodies if body.name != WORLD]
    joints = [reader.read(body) for body in carried]
    joints = with_equalities(joints, document)
    inertias = read_inertias(bodies, compiler, meshes)
    _note_meshes(carried, joints, meshes)
    links = [
        Link(
            b.name, inertias[b.name], meshes=tuple(meshes.seen(b)), shapes=tuple(meshes.collide(b))
        )
        for b in carried
    ]
    names = [c.name for joint in joints for c in joint.coordinates]
    tendons = TendonReader(document, compiler, bodies, names)
    found, drives = tendons.read(), read_drives(document)
    actuators = ActuatorReader(compiler, found)
    joints = actuators.with_motors(drives, joints)
    muscles = tuple(actuators.muscles(drives, joints))
    _note_left_out(document, bodies)
    note_missing_meshes(document.root, links)
    wrapped = {wrap.surface for muscle in muscles for wrap in muscle.wraps}
    robot = Robot(
        document.root.subject.name,
        tuple(links),
        tuple(joints),
        (CableSet(DEFAULT_SET, muscles),) if muscles else (),
        DEFAULT_SET if muscles else "",
        tuple(_sites(document, bodies, tendons)),
        gravity=_gravity(document),
        wrap_surfaces=tuple(s for name, s in tendons.surfaces.items() if name in wrapped),
    )
    robot = with_loops(with_found(robot, actuators.nodes), document, bodies, compiler)
    return _with_followers(replace(robot, joints=tuple(_started(document, robot.joints))))


def _gravity(document: Document) -> Vector3:
    gravity: Vector3 = GRAVITY
    for option in document.sections("option"):
        if option.has("gravity"):
            gravity = option.vector_attribute("gravity")
        for word in ("density", "viscosity", "wind"):
            if any(numbers(option, word)):
                problem = f"the {word} of the surrounding fluid is left out"
                option.warning("fluid-left-out", problem)
    for option in document.sections("option"):
        for flag in document.children(option, "flag"):
            if flag.attribute("gravity", "enable") == "disable":
                gravity = (0.0, 0.0, 0.0)
    return gravity


def _started(document: Document, joints: Sequence[Joint]) -> list[Joint]:
    """The joints with the initial values of our own files' keyframe."""
    for key in document.parts("keyframe", "key"):
        values = numbers(key, "qpos")
        names = [c.name for joint in joints for c in joint.coordinates]
        if key.attribute("name", "") == INITIAL and len(values) == len(names):
            at = dict(zip(names, values, strict=True))
            return [
                replace(
                    joint,
                    coordinates=tuple(replace(c, initial=at[c.name]) for c in joint.coordinates),
                )
                for joint in joints
            ]
    return list(joints)


def _with_followers(robot: Robot) -> Robot:
    """The robot with coordinates that follow others where these have them."""
    if not any(c.coupling for c in robot.all_coordinates):
        return robot
    if any(finding.is_error for finding in check(robot)):
        return robot
    at = all_values(robot, {c.name: c.initial for c in robot.coordinates})

    def moved(c: Coordinate) -> Coordinate:
        return replace(c, initial=at[c.name]) if c.coupling else c

    joints = (replace(j, coordinates=tuple(map(moved, j.coordinates))) for j in robot.joints)
    return replace(robot, joints=tuple(joints))


def _sites(document: Document, bodies: Sequence[Body], tendons: TendonReader) -> list[TaskSet]:
    """The sites that no tendon passes, as points that are only looked at."""
    used = {
        node.attribute(word, "")
        for section in document.parts("tendon", "spatial")
        for node in document.children(section)
        for word in ("site", "sidesite")
    }
    used |= {
        node.attribute(word, "")
        for node in document.parts("equality")
        for word in ("site1", "site2")
    }
    nodes = [part.node for body in bodies for part in body.sites]
    named = [n for n in nodes if n.attribute("name", "") and n.attribute("name", "") not in used]
    frames = []
    for node in distinct(named, partial(Subject, "task_frame")):
        name = node.attribute("name")
        point = tendons.sites.get(name)
        if point is not None and point.link != WORLD:
            frames.append(TaskFrame(name, point.link, point.position))
    return [TaskSet(MARKERS, tuple(frames))] if frames else []


def _note_meshes(bodies: Sequence[Body], joints: Sequence[Joint], meshes: MeshAssets) -> None:
    """Bodies whose mass would come from meshes that are not there: refused where they move."""
    moving = {WORLD: False}
    for joint in joints:
        moving[joint.child] = bool(joint.motions) or moving.get(joint.parent, False)
    for body in bodies:
        files = meshes.missing.get(body.name, [])
        if not files:
            continue
        listed = ", ".join(map(repr, dict.fromkeys(files[:5])))
        problem = f"its mass comes from meshes that are not there, or not read: {listed}"
        if moving[body.name]:
            more = "put them there (and install the extra `viewer`), or give it an <inertial>"
            body.node.error("mass-from-mesh", f"{problem}; {more}")
        else:
            body.node.warning("mass-from-mesh", f"{problem}; it does not move")


def _note_left_out(document: Document, bodies: Sequence[Body]) -> None:
    for section in LEFT_OUT:
        parts = [p for p in document.parts(section) if p.attribute("name", "") != INITIAL]
        if parts:
            names = ", ".join(repr(part.attribute("name", part.tag)) for part in parts[:10])
            parts[0].warning("part-left-out", f"{len(parts)} of <{section}> left out: {names}")
    seen = [
        p.node
        for b in bodies
        for p in b.geoms
        if shape_of(p.node) != "mesh" and collision_kind(p) is None
    ]
    if seen:
        problem = (
            f"{len(seen)} geoms count for masses and wraps only: they are neither seen, nor do "
            "they touch anything"
        )
        seen[0].warning("geometry-left-out", problem)
    lifted: list[Node] = [b.node for b in bodies if b.node.number_attribute("gravcomp", 0.0)]
    if lifted:
        names = ", ".join(repr(node.attribute("name", "")) for node in lifted[:10])
        lifted[0].warning("gravity-not-off", f"gravity acts in full on {names}")
