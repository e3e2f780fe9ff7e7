"""Reader of MJCF, which is compiled by MuJoCo.

Bodies become links with their frames. The joints of a body become the motions of one joint.
Spatial and fixed tendons with an actuator become muscles, joint equalities become exact couplings,
and body equalities become loop joints. Differences to MuJoCo are reported as findings.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from ...checks.check import check
from ...checks.loops import rigid_bodies
from ...errors import UnknownNameError
from ...finding import Subject
from ...finding_builders import listed
from ...model.coupling import all_values
from ...model.joint import Coordinate, Joint
from ...model.link_poses import initial_poses
from ...model.muscle import CableSet, Muscle, Wrap, WrapSurface
from ...model.pose import Pose, Vector3
from ...model.robot import (
    DEFAULT_SET,
    MARKERS,
    SHAPE_SIZES,
    WORLD,
    Inertia,
    Link,
    Mesh,
    Robot,
    Shape,
    TaskFrame,
    TaskSet,
    find,
)
from ...model.rotations import compose, rotate_inertia
from ...model.transform import IDENTITY
from ...transforms.joint_chains import Names
from ..reading.meshes import note_missing_meshes
from ..reading.xml import Notes
from .compiled import Compiled, Row, compile_document, rotation_of, transform, vector
from .document import Document
from .read_equalities import with_couplings, with_loops
from .read_joints import read_joints
from .read_muscles import MuscleReader

COLLISION_GROUP = 4
"""Geom group of collision meshes in files written by this package."""
ALWAYS_ACTIVE = ("constraint", "equality", "frictionloss", "limit", "spring", "damper", "clampctrl",
          "actuation")  # fmt: skip
"""Features that a model may disable in MuJoCo, but that stay active here."""


def read_mjcf(file: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """Return the robot in an MJCF file and its includes; None if MuJoCo rejects it.

    The only cable set is `cardsflow`.

    Raises:
        InputError: A file is not readable XML or not MJCF, or MuJoCo is not installed or crashes.
        UnknownNameError: The cable set does not exist.
    """
    if cable_set not in (None, DEFAULT_SET):
        raise UnknownNameError("cable set", str(cable_set), [DEFAULT_SET], file=file)
    document = Document(file, notes)
    notes.roots.clear()  # MuJoCo's compiler reads all elements and rejects unknown ones
    if any(finding.is_error for finding in notes.findings):
        return None
    compiled = compile_document(document)
    if compiled is None:
        return None
    for key in compiled.read:
        document.note_read(key)
    _name_elements(compiled)
    return _robot(document, compiled)


def _robot(document: Document, compiled: Compiled) -> Robot:
    joints = with_couplings(read_joints(document, compiled), document, compiled)
    reader = MuscleReader(document, compiled, joints)
    muscles, by_name = reader.read()
    joints = [joint.map_coordinates(lambda c: by_name[c.name]) for joint in joints]
    links = [_link(document, compiled, number) for number in range(1, len(compiled.bodies))]
    _note_missing_masses(document, compiled, joints)
    _note_omitted(document, compiled)
    note_missing_meshes(document.root, links)
    robot = Robot(
        document.root.subject.name,
        tuple(links),
        tuple(joints),
        (CableSet(DEFAULT_SET, muscles),) if muscles else (),
        DEFAULT_SET if muscles else "",
        tuple(_markers(compiled, reader.used_sites)),
        gravity=_gravity(document, compiled),
        wrap_surfaces=_used_surfaces(reader, muscles),
    )
    _note_inside_wraps(document, robot)
    robot = with_loops(robot, document, compiled)
    return _with_followers(_with_keyframe(robot, document, compiled))


def _name_elements(compiled: Compiled) -> None:
    """Set names of elements without a name."""
    for rows, word in (
        (compiled.bodies, "body_"),
        (compiled.joints, "joint_"),
        (compiled.tendons, "tendon_"),
    ):
        first = 0 if rows is compiled.bodies else 1  # body 0 is the world
        names = Names(row["name"] for row in rows if row["name"])
        for k, row in enumerate(rows, start=first):
            row["name"] = row["name"] or names.unique(f"{word}{k}")


def _link(document: Document, compiled: Compiled, number: int) -> Link:
    body = compiled.bodies[number]
    document.node_at(body["line"]).with_subject(Subject("link", body["name"]))
    geoms = [row for row in compiled.geoms if row["bodyid"] == number]
    meshes = [mesh for row in geoms for mesh in _meshes(document, compiled, row)]
    shapes = [_shape(row) for row in geoms if _is_shape(row)]
    return Link(body["name"], _inertia(body), meshes=tuple(meshes), shapes=tuple(shapes))


def _inertia(body: Row) -> Inertia:
    com, R = vector(body["ipos"]), rotation_of(body["iquat"])
    xx, yy, zz = body["inertia"]
    if not any((body["mass"], xx, yy, zz)):
        return Inertia(0.0)
    diagonal = Inertia(body["mass"], com, xx, yy, zz)
    if R == IDENTITY.R:
        return diagonal
    return Inertia.of(body["mass"], com, rotate_inertia(R, diagonal.matrix))


def _meshes(document: Document, compiled: Compiled, row: Row) -> Iterator[Mesh]:
    """Yield the mesh of a geom; MuJoCo moves compiled meshes into the frame of their inertia."""
    name = row.get("mesh", "")
    if row["type"] == "mesh" and name in document.uris:
        T = transform(row)
        if row["dataid"] >= 0:
            T = T.compose(transform(compiled.meshes[name]).inverse())
        role = "collision" if row["group"] == COLLISION_GROUP else "visual"
        scale = vector(compiled.scales[name])
        yield Mesh(role, document.uris[name], T.pose(), scale, name)  # type: ignore[arg-type]


def _is_shape(row: Row) -> bool:
    """Return whether a geom is a collision shape in a file written by this package."""
    return row["group"] == COLLISION_GROUP and row["type"] in SHAPE_SIZES


def _shape(row: Row) -> Shape:
    """Return the shape of a geom; MJCF stores half the edges and lengths."""
    kind, (first, *others) = row["type"], row["size"]
    sizes = [first if kind != "box" else 2.0 * first, *(2.0 * size for size in others)]
    return Shape(kind, tuple(sizes[: SHAPE_SIZES[kind]]), transform(row).pose())


def _used_surfaces(reader: MuscleReader, muscles: Sequence[Muscle]) -> tuple[WrapSurface, ...]:
    names = {wrap.surface for muscle in muscles for wrap in muscle.wraps}
    return tuple(surface for name, surface in reader.surfaces.items() if name in names)


def _gravity(document: Document, compiled: Compiled) -> Vector3:
    option, node = compiled.option, document.first("option")
    for word in ("density", "viscosity", "wind"):
        values = option[word] if word == "wind" else [option[word]]
        if any(values):
            node.warning("fluid-left-out", f"the {word} of the surrounding fluid is omitted")
    disabled = [word for word in option["disabled"] if word in ALWAYS_ACTIVE]
    if disabled:
        problem = f"the file disables {', '.join(disabled)} in MuJoCo; here they stay active"
        node.warning("option-left-out", problem)
    if option["disabled_groups"]:
        node.warning("option-left-out", "disabled groups of actuators are active here")
    return (0.0, 0.0, 0.0) if "gravity" in option["disabled"] else vector(option["gravity"])


def _with_keyframe(robot: Robot, document: Document, compiled: Compiled) -> Robot:
    """Return the robot with the initial values of the keyframe `initial`, if it exists."""
    values, names = compiled.initial, [c.name for c in robot.all_coordinates]
    if values is None:
        return robot
    if len(values) != len(names):
        problem = "the keyframe 'initial' has quaternions; omitted"
        document.first("key").warning("part-left-out", problem)
        return robot
    at = dict(zip(names, values, strict=True))
    return _with_initials(robot, {name: at[name] for name in names})


def _with_followers(robot: Robot) -> Robot:
    """Return the robot with initial values of coupled coordinates that satisfy the couplings."""
    coupled = [c.name for c in robot.all_coordinates if c.coupling]
    if not coupled or any(finding.is_error for finding in check(robot)):
        return robot
    at = all_values(robot, {c.name: c.initial for c in robot.coordinates})
    return _with_initials(robot, {name: at[name] for name in coupled})


def _with_initials(robot: Robot, at: Mapping[str, float]) -> Robot:
    def moved(c: Coordinate) -> Coordinate:
        return replace(c, initial=at.get(c.name, c.initial))

    return replace(robot, joints=tuple(joint.map_coordinates(moved) for joint in robot.joints))


def _markers(compiled: Compiled, on_tendons: set[int]) -> Iterator[TaskSet]:
    """Yield the named sites that no tendon and no equality uses, as a set of markers."""
    used = on_tendons | {
        row[end]
        for row in compiled.equalities
        for end in ("obj1id", "obj2id")
        if row["objtype"] == "site"
    }
    frames = [
        TaskFrame(row["name"], compiled.bodies[row["bodyid"]]["name"], vector(row["pos"]))
        for number, row in enumerate(compiled.sites)
        if row["name"] and number not in used and row["bodyid"]
    ]
    if frames:
        yield TaskSet(MARKERS, tuple(frames))


def _note_missing_masses(document: Document, compiled: Compiled, joints: Sequence[Joint]) -> None:
    """Report bodies whose mass comes from missing meshes; an error if they move."""
    rigid = rigid_bodies(joints)
    for number, body in enumerate(compiled.bodies):
        files = [
            document.uris[row["mesh"]]
            for row in compiled.geoms
            if row["bodyid"] == number and row.get("missing")
        ]
        if not files:
            continue
        node = document.node_at(body["line"]).with_subject(Subject("link", body["name"]))
        listed = ", ".join(map(repr, dict.fromkeys(files[:5])))
        problem = f"its mass comes from meshes that do not exist or are not read: {listed}"
        if rigid[body["name"]] != WORLD:
            advice = "add the files or an <inertial>"
            node.error("mass-from-mesh", f"{problem}; {advice}")
        else:
            node.warning("mass-from-mesh", f"{problem}; it does not move")


def _note_inside_wraps(document: Document, robot: Robot) -> None:
    """Report muscles that pass inside a wrap geom at the initial pose."""
    poses = initial_poses(robot)
    inside = [
        muscle.name
        for muscle in robot.muscles
        if any(_is_inside(wrap, robot, poses) for wrap in muscle.wraps)
    ]
    if inside:
        problem = (
            f"{len(inside)} muscles pass inside wrap geoms: MuJoCo computes these contacts to "
            "1e-6 rad, so its forces differ by up to 5e-8 of their value: " + listed(inside)
        )
        document.root.warning("inside-wraps", problem)


def _is_inside(wrap: Wrap, robot: Robot, poses: Mapping[str, Pose]) -> bool:
    if wrap.side_point is None:
        return False
    surface = find("wrap surface", wrap.surface, robot.wrap_surfaces)
    centre = compose(poses[surface.link], surface.pose).position
    side = compose(poses[wrap.side_point.link], Pose(wrap.side_point.position)).position
    return math.dist(centre, side) < surface.radius


def _note_omitted(document: Document, compiled: Compiled) -> None:
    seen = [row for row in compiled.geoms if row["type"] != "mesh" and not _is_shape(row)]
    if seen:
        problem = (
            f"{len(seen)} geoms are used only for masses and wraps; they are neither shown nor "
            "used for contacts"
        )
        document.node_at(seen[0]["line"]).warning("geometry-left-out", problem)
    compensated = [row for row in compiled.bodies if row["gravcomp"]]
    if compensated:
        names = ", ".join(repr(row["name"]) for row in compensated[:10])
        node = document.node_at(compensated[0]["line"])
        node.warning("gravity-not-off", f"gravity compensation is ignored on {names}")
    mocap = [row for row in compiled.bodies if row["mocapid"] >= 0]
    if mocap:
        names = ", ".join(repr(row["name"]) for row in mocap[:10])
        node = document.node_at(mocap[0]["line"])
        node.warning("mocap-left-out", f"motion capture bodies do not move: {names}")
