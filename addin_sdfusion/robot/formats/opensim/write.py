"""Writer of OpenSim 4 models.

Links are bodies with their own frames; their joints are CustomJoints, see `joints`, which keep
every axis and pose exactly, and a link in between has 1e-12 kg. Couplings are couplers; of loop
joints, balls hold points together, and fixed ones are welds. Muscles are
PathActuators through every via point and over wrap objects; their controls are tensions in [N].
Muscles of Hill's type and ligaments are OpenSim's own.
Joints have motors (`<coordinate>_motor`) and dampers with springs (`<coordinate>_damping`)
where the robot has them.
Task frames are markers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

from ...finding import Finding, Subject
from ...finding_builders import warning
from ...model.robot import WORLD, Robot
from ...transforms.joint_chains import Names
from ..writing.common_losses import (
    cables,
    coordinate_forces,
    link_ends,
    loops,
    motor_bounds,
    muscle_paths,
    names,
    other_sets,
    refuse,
    task_axes,
    with_markers,
)
from ..writing.file_names import write_document
from ..writing.plain_paths import with_plain_paths
from ..writing.wrap_ends import ends_inside
from ..writing.xml_text import document, element, numbers
from .writing.bodies import LEAST_MASS, add_body, frame_path, objects, standing_links
from .writing.forces import add_joint_forces, add_muscle
from .writing.joints import add_couplers, add_joints, coordinate_paths, is_one_joint, joint_losses
from .writing.loops import CONSTRAINTS, add_loop
from .writing.muscles import CLASSES, law_losses
from .writing.names import GROUND, renamed, with_legal_names
from .writing.points import point_losses, ranges_of_points
from .writing.wraps import RULE, add_surfaces, wrap_losses, wrap_names

VERSION = "40000"
"""Of the file format; OpenSim 4.0 and all that follow it read this one."""

HELD = ("conditions", "moves")
"""What OpenSim's paths can depend on."""

MeshFiles = Mapping[str, str | Path]


def write_osim(
    robot: Robot, folder: str | Path, name: str | None = None, meshes: MeshFiles | None = None
) -> list[Path]:
    """Write `<name>.osim`; returns and raises as `write_document`.

    Args:
        robot: What to write.
        folder: Where to; made if it does not exist.
        name: How the file is called; the robot's name if None.
        meshes: The file of each mesh by its uri; the uri itself where there is none.
    """

    def text(valid: Robot) -> str:
        plain = with_plain_paths(with_markers(valid), HELD)
        return _osim(with_legal_names(plain), meshes or {})

    return write_document(robot, folder, name, "osim", text)


def osim_losses(robot: Robot) -> list[Finding]:
    """What OpenSim cannot hold of a valid robot; errors where it is not written."""
    tasks = list(task_axes(robot, "OpenSim"))
    robot = with_markers(robot)
    return [
        *renamed(robot),
        *joint_losses(robot),
        *loops(robot, "OpenSim", CONSTRAINTS),
        *coordinate_forces(robot, "OpenSim", limit_force=True),
        *_masses(robot),
        *_limits(robot),
        *_friction(robot),
        *motor_bounds(robot, "OpenSim"),
        *muscle_paths(robot, "OpenSim", HELD, ("taut", RULE)),
        *point_losses(robot),
        *wrap_losses(robot),
        *ends_inside(robot, "OpenSim"),
        *_meshes(robot),
        *cables(robot, "OpenSim", CLASSES),
        *law_losses(robot),
        *tasks,
        *link_ends(robot, "OpenSim"),
        *other_sets(robot, "OpenSim"),
        *names(robot, "OpenSim", (joint for joint in robot.joints if not is_one_joint(joint))),
    ]


def _add_constraints(model: ElementTree.Element, robot: Robot) -> None:
    held = [loop for loop in robot.loops if loop.type in CONSTRAINTS]
    if held or any(c.coupling for c in robot.all_coordinates):
        constraints = objects(model, "ConstraintSet", "constraintset")
        names = add_couplers(constraints, robot)
        for loop in held:
            add_loop(constraints, replace(loop, name=names.give(loop.name)))


def _masses(robot: Robot) -> Iterator[Finding]:
    standing = standing_links(robot)
    for link in robot.links:
        if link.inertia.mass < LEAST_MASS and link.name not in standing:
            problem = f"OpenSim needs masses; it gets {LEAST_MASS!r} kg"
            yield warning(Subject("link", link.name), "mass-increased", problem)


def _limits(robot: Robot) -> Iterator[Finding]:
    if any(math.isfinite(c.lower) or math.isfinite(c.upper) for c in robot.coordinates):
        problem = "limits are ranges in OpenSim and stop nothing in a simulation"
        yield warning(Subject("robot", robot.name), "limits-are-ranges", problem)


def _friction(robot: Robot) -> Iterator[Finding]:
    for c in robot.coordinates:
        if c.friction:
            problem = "OpenSim has no Coulomb friction in joints; left out"
            yield warning(Subject("coordinate", c.name), "friction-left-out", problem)


def _meshes(robot: Robot) -> Iterator[Finding]:
    for link in robot.links:
        if any(mesh.name for mesh in link.meshes):
            problem = "OpenSim numbers its meshes; their names are left out"
            yield warning(Subject("link", link.name), "mesh-names-left-out", problem)
        if link.shapes or any(mesh.role == "collision" for mesh in link.meshes):
            problem = "OpenSim gets the meshes to be seen only; what collides is left out"
            yield warning(Subject("link", link.name), "collisions-left-out", problem)


def _osim(robot: Robot, meshes: MeshFiles) -> str:
    refuse(joint_losses(robot), "osim")
    root = element(None, "OpenSimDocument", Version=VERSION)
    model = element(root, "Model", name=robot.name)
    element(model, "gravity", numbers(robot.gravity))
    bodies = {WORLD: element(model, "Ground", name=GROUND)}
    body_set = objects(model, "BodySet", "bodyset")
    standing = standing_links(robot)
    for link in robot.links:
        least = 0.0 if link.name in standing else LEAST_MASS
        bodies[link.name] = add_body(body_set, link, meshes, least)
    joint_set = objects(model, "JointSet", "jointset")
    add_joints(joint_set, body_set, robot, ranges_of_points(robot))
    _add_constraints(model, robot)
    add_surfaces(robot, bodies)
    forces = objects(model, "ForceSet", "forceset")
    surfaces, coordinates = wrap_names(robot), coordinate_paths(joint_set)
    for muscle in robot.muscles:
        add_muscle(forces, muscle, surfaces, coordinates)
    add_joint_forces(forces, robot, Names(muscle.name for muscle in robot.muscles))
    markers = objects(model, "MarkerSet", "markerset")
    for frame in robot.task_frames:
        marker = element(markers, "Marker", name=frame.name)
        element(marker, "socket_parent_frame", frame_path(frame.link))
        element(marker, "location", numbers(frame.position))
    return document(root)
