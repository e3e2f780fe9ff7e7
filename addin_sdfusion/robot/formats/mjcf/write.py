"""Writer of MJCF, ready to run in MuJoCo.

Links are bodies with their own frames, coordinates are hinges and slides: a body with several of
them moves as a joint of several motions does. Muscles are spatial tendons through a site at every
via point (`<muscle>:<index>`) and over wrap geoms, or fixed ones; MuJoCo's own muscles and springs
are themselves, each other one has a motor with gear -1, so that a control is a tension in [N], in
the order of the muscles. Motors of the joints follow. Task frames are
sites. The keyframe `initial` has the initial values. Equal limits become an equality constraint;
stops and friction are as hard as MuJoCo can be.

Nothing touches: collision meshes have collisions off, as in this simulation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree

from ...finding import Finding, Subject
from ...finding_builders import warning
from ...model.coupling import all_values
from ...model.robot import WORLD, Robot
from ...transforms.joint_chains import Names
from ..writing.common_losses import (
    cables,
    coordinate_forces,
    ellipsoids,
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
from .write_bodies import add_body, coordinate_order, depth_losses
from .write_constraints import (
    EQUALITIES,
    add_constraints,
    add_loops,
    constraint_losses,
    driven_losses,
    loop_losses,
)
from .write_inertia import inertia_losses
from .write_meshes import add_meshes, add_shapes, mesh_losses
from .write_muscles import LAWS, MUSCLE, SPRING, muscle_words
from .write_tendons import RULE, add_tendons, add_wrap_geoms, wrap_losses

HELD = ("branches", "terms")
"""What MuJoCo's tendons can depend on."""

MeshFiles = Mapping[str, str | Path]


def write_mjcf(
    robot: Robot, folder: str | Path, name: str | None = None, meshes: MeshFiles | None = None
) -> list[Path]:
    """Write `<name>.xml`; returns and raises as `write_document`.

    Args:
        robot: What to write.
        folder: Where to; made if it does not exist.
        name: How the file is called; the robot's name if None.
        meshes: The file of each mesh by its uri, absolute or from the folder. MuJoCo opens all
            meshes at once and fails without: those that are not here are left out.
    """

    def text(valid: Robot) -> str:
        return _mjcf(with_plain_paths(with_markers(valid), HELD), dict(meshes or {}))

    return write_document(robot, folder, name, "xml", text)


def mjcf_losses(robot: Robot, meshes: MeshFiles | None = None) -> list[Finding]:
    """What MJCF cannot hold of a valid robot; errors where MuJoCo refuses it.

    Args:
        robot: A valid robot.
        meshes: As for `write_mjcf`.
    """
    tasks = list(task_axes(robot, "MJCF"))
    robot = with_markers(robot)
    return [
        *driven_losses(robot),
        *loops(robot, "MJCF", EQUALITIES),
        *loop_losses(robot),
        *coordinate_forces(robot, "MJCF", armature=True),
        *depth_losses(robot),
        *inertia_losses(robot),
        *constraint_losses(robot),
        *_order(robot),
        *_equal_forces(robot),
        *motor_bounds(robot, "MJCF"),
        *muscle_paths(robot, "MJCF", HELD, ("taut", RULE)),
        *_terms(robot),
        *ellipsoids(robot, "MJCF"),
        *wrap_losses(robot),
        *ends_inside(robot, "MuJoCo"),
        *mesh_losses(robot, meshes or {}),
        *cables(robot, "MJCF", LAWS),
        *tasks,
        *link_ends(robot, "MJCF"),
        *other_sets(robot, "MJCF"),
        *names(robot, "MJCF", robot.joints),
    ]


def _order(robot: Robot) -> Iterator[Finding]:
    order = [mover.coordinate for mover in coordinate_order(robot) if mover.is_home]
    if order != list(robot.all_coordinates):
        names = ", ".join(coordinate.name for coordinate in order)
        problem = f"MuJoCo's order of the coordinates is another: {names}"
        yield warning(Subject("robot", robot.name), "coordinate-order", problem)


def _equal_forces(robot: Robot) -> Iterator[Finding]:
    for muscle in robot.muscles:
        if muscle.model.kind in LAWS:
            if muscle.f_min > 0.0 or muscle.f_max < math.inf:
                problem = "MuJoCo's muscles have no bounds of their force; f_min and f_max left out"
                yield warning(Subject("muscle", muscle.name), "force-limits-left-out", problem)
        elif muscle.f_min == muscle.f_max:
            problem = f"MuJoCo has no equal limits of a control; command {muscle.f_min!r} N"
            yield warning(Subject("muscle", muscle.name), "force-limits-left-out", problem)
    for motor in robot.motors:
        if motor.tau_min == motor.tau_max:
            problem = f"MuJoCo has no equal limits of a control; command {motor.tau_min!r}"
            yield warning(Subject("coordinate", motor.name), "force-limits-left-out", problem)


def _terms(robot: Robot) -> Iterator[Finding]:
    for muscle in robot.muscles:
        if muscle.terms and muscle.via_points:
            problem = "MuJoCo's tendons have a path, or lengths in proportion to joints; left out"
            yield warning(Subject("muscle", muscle.name), "terms-left-out", problem)


def _mjcf(robot: Robot, meshes: MeshFiles) -> str:
    refuse(mjcf_losses(robot, meshes), "mjcf")
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
        name = names.give(muscle.name)
        if muscle.model.kind == MUSCLE:
            element(node, "general", None, name=name, tendon=muscle.name, **muscle_words(muscle))
            continue
        limits = _control_range(muscle.f_min, muscle.f_max)
        element(node, "motor", None, name=name, tendon=muscle.name, gear="-1", **limits)
    for c in robot.motors:
        limits = _control_range(c.tau_min, c.tau_max)
        element(node, "motor", None, name=names.give(c.name), joint=c.name, **limits)


def _control_range(low: float, high: float) -> dict[str, str]:
    if low == high or (low, high) == (-math.inf, math.inf):
        return {}
    return {"ctrllimited": "true", "ctrlrange": numbers((low, high))}


def _initial(robot: Robot, root: ElementTree.Element) -> None:
    known = all_values(robot, {c.name: c.initial for c in robot.coordinates})
    values = []
    for mover in coordinate_order(robot):
        q = known[mover.coordinate.name]
        values.append(q if mover.is_home else mover.motion.way(q))
    if values:
        element(element(root, "keyframe"), "key", name="initial", qpos=numbers(values))
