"""Writer of MJCF files that run in MuJoCo.

Links become bodies with their frames, and coordinates become hinges and slides. A body with several
of them moves like a joint with several motions. Muscles become spatial tendons through a site at
every via point (`<muscle>:<index>`) and over wrap geoms, or fixed tendons. MuJoCo muscles and
springs are written as such. All other muscles get a motor with gear -1, so that a control is a
tension in [N], in the order of the muscles. The motors of the joints follow. Task frames become
sites. The keyframe `initial` contains the initial values. Equal limits become an equality
constraint. Joint limits and friction are as stiff as MuJoCo allows.

Collisions are disabled, as in this simulation.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

from ...model.coupling import all_values
from ...model.robot import WORLD, Robot
from ...transforms.joint_chains import Names
from ..capability import require_writable
from ..writing.file_names import write_document
from ..writing.plain_paths import with_markers, with_plain_paths
from ..writing.xml_text import document, element, numbers
from .capabilities import PATH_FEATURES, MeshFiles, mjcf_losses
from .write_bodies import add_body, coordinate_order
from .write_constraints import add_constraints, add_loops
from .write_meshes import add_meshes, add_shapes
from .write_muscles import MUSCLE, SPRING, muscle_attributes
from .write_tendons import add_tendons, add_wrap_geoms


def write_mjcf(
    robot: Robot, folder: str | Path, name: str | None = None, meshes: MeshFiles | None = None
) -> list[Path]:
    """Write `<name>.xml`; returns and raises as `write_document`.

    Args:
        folder: Output folder; created if it does not exist.
        name: File name without suffix; the name of the robot if None.
        meshes: Mesh file by URI, absolute or relative to the folder. Other meshes are omitted,
            because MuJoCo rejects a model if any mesh file is missing.
    """

    def text(valid: Robot) -> str:
        return _mjcf(with_plain_paths(with_markers(valid), PATH_FEATURES), dict(meshes or {}))

    return write_document(robot, folder, name, "xml", text)


def _mjcf(robot: Robot, meshes: MeshFiles) -> str:
    require_writable(mjcf_losses(robot, meshes), "mjcf")
    root = element(None, "mujoco", model=robot.name)
    flags = {"angle": "radian", "eulerseq": "XYZ", "autolimits": "false"}
    element(root, "compiler", None, **flags, inertiafromgeom="false")
    add_constraints(robot, root)
    assets = element(root, "asset")
    bodies = {WORLD: element(root, "worldbody")}
    for joint in robot.joints:
        bodies[joint.child] = add_body(robot, joint, bodies[joint.parent])
    add_meshes(robot, meshes, assets, bodies)
    add_shapes(robot, bodies)
    sites = _task_sites(robot, bodies)
    add_wrap_geoms(robot, bodies)
    add_loops(robot, root, bodies, sites)
    add_tendons(robot, root, bodies, sites)
    _actuators(robot, root)
    _initial(robot, root)
    return document(root)


def _task_sites(robot: Robot, bodies: dict[str, ElementTree.Element]) -> Names:
    for frame in robot.task_frames:
        element(bodies[frame.link], "site", name=frame.name, pos=numbers(frame.position))
    return Names(frame.name for frame in robot.task_frames)


def _actuators(robot: Robot, root: ElementTree.Element) -> None:
    node = element(root, "actuator")
    names = Names()
    for muscle in robot.muscles:
        if muscle.model.kind == SPRING:
            continue
        name = names.unique(muscle.name)
        if muscle.model.kind == MUSCLE:
            element(
                node, "general", None, name=name, tendon=muscle.name, **muscle_attributes(muscle)
            )
            continue
        limits = _control_range(muscle.f_min, muscle.f_max)
        element(node, "motor", None, name=name, tendon=muscle.name, gear="-1", **limits)
    for c in robot.motors:
        limits = _control_range(c.tau_min, c.tau_max)
        element(node, "motor", None, name=names.unique(c.name), joint=c.name, **limits)


def _control_range(low: float, high: float) -> dict[str, str]:
    if low == high or (low, high) == (-math.inf, math.inf):
        return {}
    return {"ctrllimited": "true", "ctrlrange": numbers((low, high))}


def _initial(robot: Robot, root: ElementTree.Element) -> None:
    initial = all_values(robot, {c.name: c.initial for c in robot.coordinates})
    values = []
    for motion_joint in coordinate_order(robot):
        q = initial[motion_joint.coordinate.name]
        values.append(q if motion_joint.is_home else motion_joint.motion.displacement(q))
    if values:
        element(element(root, "keyframe"), "key", name="initial", qpos=numbers(values))
