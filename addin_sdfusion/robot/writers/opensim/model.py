"""Writer of OpenSim 4 models.

Links are bodies with their own frames, coordinates belong to pins and sliders: joints of one degree
of freedom in offset frames are the ones that keep every axis and pose exactly. A joint of several
motions becomes a chain, see `joint_chains`, with 1e-12 kg for each link in between. Muscles are
PathActuators through every via point and over wrap objects; their controls are tensions in [N].
Muscles of Hill's type and ligaments are OpenSim's own.
Joints have motors (`<coordinate>_motor`) and dampers with springs (`<coordinate>_damping`)
where the robot has them.
Task frames are markers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

from ...finding import Finding, Subject
from ...finding_builders import warning
from ...model.robot import WORLD, Robot
from ...transforms.joint_chains import Names, single_joints
from ..common_losses import (
    cables,
    chained_joints,
    coordinate_forces,
    driven_joints,
    link_ends,
    loops,
    motor_bounds,
    muscle_paths,
    names,
    other_sets,
    refuse,
    task_axes,
)
from ..file_names import write_document
from ..wrap_ends import ends_inside
from ..xml_text import document, element, numbers
from .bodies import LEAST_MASS, add_body, add_joint, add_massless, frame_path, objects
from .forces import ENDLESS, add_joint_forces, add_muscle, add_surfaces, surface_names
from .muscles import CLASSES, law_losses
from .names import GROUND, renamed, with_legal_names

VERSION = "40000"
"""Of the file format; OpenSim 4.0 and all that follow it read this one."""

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
    return write_document(
        robot, folder, name, "osim", lambda valid: _osim(with_legal_names(valid), meshes or {})
    )


def osim_losses(robot: Robot) -> list[Finding]:
    """What OpenSim cannot hold of a valid robot; errors where it is not written."""
    return [
        *renamed(robot),
        *driven_joints(robot, "OpenSim"),
        *loops(robot, "OpenSim"),
        *coordinate_forces(robot, "OpenSim"),
        *chained_joints(robot, "OpenSim"),
        *_masses(robot),
        *_limits(robot),
        *_friction(robot),
        *motor_bounds(robot, "OpenSim"),
        *muscle_paths(robot, "OpenSim"),
        *_wraps(robot),
        *ends_inside(robot, "OpenSim"),
        *_meshes(robot),
        *cables(robot, "OpenSim", CLASSES),
        *law_losses(robot),
        *task_axes(robot, "OpenSim"),
        *link_ends(robot, "OpenSim"),
        *other_sets(robot, "OpenSim"),
        *names(robot, "OpenSim", (joint for joint in robot.joints if joint.motions)),
    ]


def _masses(robot: Robot) -> Iterator[Finding]:
    for link in robot.links:
        if link.inertia.mass < LEAST_MASS:
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


def _wraps(robot: Robot) -> Iterator[Finding]:
    for surface in robot.wrap_surfaces:
        if surface.shape == "cylinder" and surface.length > ENDLESS:
            problem = f"cylinder {surface.name!r} ends in OpenSim: it is {ENDLESS!r} m long"
            yield warning(Subject("robot", robot.name), "cylinder-has-ends", problem)
    cylinders = {s.name for s in robot.wrap_surfaces if s.shape == "cylinder"}
    for muscle in robot.muscles:
        subject = Subject("muscle", muscle.name)
        outer = [wrap for wrap in muscle.wraps if not wrap.inside]
        over = [repr(wrap.surface) for wrap in outer if wrap.surface in cylinders]
        if over:
            problem = (
                f"OpenSim approximates paths over cylinders, mostly to 1e-4 m and their moment "
                f"arms to 1e-2 m, and does not taper their ends: {', '.join(over)}"
            )
            yield warning(subject, "wrap-approximated", problem)
        if len({wrap.segment for wrap in outer}) < len(outer):
            problem = "OpenSim approximates paths over several surfaces in one segment"
            yield warning(subject, "wrap-approximated", problem)
        for wrap in muscle.wraps:
            if wrap.inside:
                problem = f"OpenSim has no path inside {wrap.surface!r}; this wrap is left out"
                yield warning(subject, "wrap-left-out", problem)
            elif wrap.turns:
                problem = (
                    f"OpenSim has no whole turns; {wrap.turns} about {wrap.surface!r} left out"
                )
                yield warning(subject, "turns-left-out", problem)
            elif wrap.side:
                problem = (
                    f"a half of {wrap.surface!r} marks the side on which it passes; it is "
                    "chosen for the initial coordinates"
                )
                yield warning(subject, "side-by-place", problem)


def _meshes(robot: Robot) -> Iterator[Finding]:
    for link in robot.links:
        if any(mesh.name for mesh in link.meshes):
            problem = "OpenSim numbers its meshes; their names are left out"
            yield warning(Subject("link", link.name), "mesh-names-left-out", problem)
        if link.shapes or any(mesh.role == "collision" for mesh in link.meshes):
            problem = "OpenSim gets the meshes to be seen only; what collides is left out"
            yield warning(Subject("link", link.name), "collisions-left-out", problem)


def _osim(robot: Robot, meshes: MeshFiles) -> str:
    refuse(driven_joints(robot, "OpenSim"), "osim")
    root = element(None, "OpenSimDocument", Version=VERSION)
    model = element(root, "Model", name=robot.name)
    element(model, "gravity", numbers(robot.gravity))
    bodies = {WORLD: element(model, "Ground", name=GROUND)}
    body_set = objects(model, "BodySet", "bodyset")
    for link in robot.links:
        bodies[link.name] = add_body(body_set, link, meshes)
    joint_set = objects(model, "JointSet", "jointset")
    for single in single_joints(robot):
        if single.child not in bodies:
            add_massless(body_set, single.child)
        add_joint(joint_set, single)
    add_surfaces(robot, bodies)
    forces = objects(model, "ForceSet", "forceset")
    surfaces = surface_names(robot)
    for muscle in robot.muscles:
        add_muscle(forces, muscle, surfaces)
    add_joint_forces(forces, robot, Names(muscle.name for muscle in robot.muscles))
    markers = objects(model, "MarkerSet", "markerset")
    for frame in robot.task_frames:
        marker = element(markers, "Marker", name=frame.name)
        element(marker, "socket_parent_frame", frame_path(frame.link))
        element(marker, "location", numbers(frame.position))
    return document(root)
