"""Writer of OpenSim 4 models.

Links become bodies with their frames. Their joints become CustomJoints, see `joints`, which keep
all axes and poses exactly; a link in between has a mass of 1e-12 kg. Couplings become couplers.
Ball loop joints become point constraints, and fixed loop joints become fixed_roots. Muscles become
PathActuators through every via point and over wrap objects; their controls are tensions in [N].
Muscles of Hill's type and ligaments keep their class in OpenSim. Joints get motors
(`<coordinate>_motor`) and springs with dampers (`<coordinate>_damping`) as in the robot. Task
frames become markers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

from ...checks.loops import rigid_bodies
from ...model.robot import WORLD, Robot
from ...transforms.joint_chains import Names
from ..capability import require_writable
from ..writing.file_names import write_document
from ..writing.plain_paths import with_markers, with_plain_paths
from ..writing.xml_text import document, element, numbers
from .capabilities import PATH_FEATURES, osim_losses
from .writing.bodies import MIN_MASS, add_body, frame_path, objects
from .writing.forces import add_joint_forces, add_muscle
from .writing.joints import add_couplers, add_joints, coordinate_paths
from .writing.loops import SUPPORTED, add_loop
from .writing.names import GROUND, with_legal_names
from .writing.points import ranges_of_points
from .writing.wraps import add_surfaces, wrap_names

VERSION = "40000"
"""Version of the file format, which OpenSim 4.0 and later versions read."""

MeshFiles = Mapping[str, str | Path]


def write_osim(
    robot: Robot, folder: str | Path, name: str | None = None, meshes: MeshFiles | None = None
) -> list[Path]:
    """Write `<name>.osim`; returns and raises as `write_document`.

    Args:
        folder: Output folder; created if it does not exist.
        name: File name without suffix; the name of the robot if None.
        meshes: Mesh file by URI; the URI itself if missing.
    """

    def text(valid: Robot) -> str:
        plain = with_plain_paths(with_markers(valid), PATH_FEATURES)
        return _osim(with_legal_names(plain), meshes or {})

    return write_document(robot, folder, name, "osim", text)


def _add_constraints(model: ElementTree.Element, robot: Robot) -> None:
    supported = [loop for loop in robot.loops if loop.type in SUPPORTED]
    if supported or any(c.coupling for c in robot.all_coordinates):
        constraints = objects(model, "ConstraintSet", "constraintset")
        names = add_couplers(constraints, robot)
        for loop in supported:
            add_loop(constraints, replace(loop, name=names.unique(loop.name)), names)


def _osim(robot: Robot, meshes: MeshFiles) -> str:
    require_writable(osim_losses(robot), "osim")
    root = element(None, "OpenSimDocument", Version=VERSION)
    model = element(root, "Model", name=robot.name)
    element(model, "gravity", numbers(robot.gravity))
    bodies = {WORLD: element(model, "Ground", name=GROUND)}
    body_set = objects(model, "BodySet", "bodyset")
    rigid = rigid_bodies(robot.joints)
    for link in robot.links:
        # OpenSim supports links without mass if they are fixed to the world.
        min_mass = 0.0 if rigid[link.name] == WORLD else MIN_MASS
        bodies[link.name] = add_body(body_set, link, meshes, min_mass)
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
