"""Losses that several formats share, as findings."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Iterator
from dataclasses import replace

from ...errors import RobotError
from ...finding import Finding, Subject
from ...finding_builders import all_muscles, error, listed, warning
from ...model.joint import Joint
from ...model.muscle import Muscle
from ...model.robot import MARKERS, Robot

UNNAMED = ("", "cardsflow", MARKERS)
"""Names of sets that files without them are read with."""


def refuse(findings: Iterable[Finding], format_: str) -> None:
    """Refuse to write if there are errors.

    Args:
        findings: What the format cannot hold.
        format_: Its name in `convert`.

    Raises:
        RobotError: One of the findings is an error.
    """
    found = list(findings)
    if any(finding.is_error for finding in found):
        raise RobotError(found, format_=format_)


def with_markers(robot: Robot) -> Robot:
    """The robot with its markers as the points that are written, where it has no others."""
    found = [group.name for group in robot.task_sets if group.name == MARKERS]
    return replace(robot, task_set=MARKERS) if found and not robot.task_set else robot


def other_sets(robot: Robot, format_: str) -> Iterator[Finding]:
    """Cable sets and task sets beside the active ones."""
    cables = [group.name for group in robot.cable_sets if group.name != robot.cable_set]
    if cables:
        problem = f"{format_} holds one cable set; left out: {', '.join(cables)}"
        yield warning(Subject("robot", robot.name), "cable-sets-left-out", problem)
    tasks = [group.name for group in robot.task_sets if group.name != robot.task_set]
    if tasks:
        problem = f"{format_} holds one operational space; left out: {', '.join(tasks)}"
        yield warning(Subject("robot", robot.name), "task-sets-left-out", problem)


def names(
    robot: Robot, format_: str, joints: Iterable[Joint] = (), *, sets: bool = True
) -> Iterator[Finding]:
    """Names that are not written.

    Args:
        robot: The robot.
        format_: What the format is called.
        joints: Those that have the names of their coordinates there, or none.
        sets: Whether the active sets have no names.
    """
    lost = {
        "names no sets": [
            name for name in (robot.cable_set, robot.task_set) if name not in UNNAMED and sets
        ],
        "names joints as their coordinates": [
            joint.name
            for joint in joints
            if joint.name not in [coordinate.name for coordinate in joint.coordinates]
        ],
    }
    problems = [f"{why}: {listed(them, len(them))}" for why, them in lost.items() if them]
    if problems:
        problem = f"{format_} {'; it '.join(problems)} left out"
        yield warning(Subject("robot", robot.name), "names-left-out", problem)


def cables(robot: Robot, format_: str, held: Container[str] = ()) -> Iterator[Finding]:
    """What cables are beyond ideal ones between fixed points."""
    for muscle in robot.muscles:
        subject = Subject("muscle", muscle.name)
        if muscle.model.kind != "ideal" and muscle.model.kind not in held:
            problem = f"{format_} has no cable {muscle.model.kind!r}; written as an ideal one"
            yield warning(subject, "cable-model-left-out", problem)
        elif muscle.model.kind == "ideal" and muscle.model.parameters:
            given = ", ".join(name for name, _ in muscle.model.parameters)
            problem = f"{format_} has no {given} of a cable; left out"
            yield warning(subject, "cable-parameters-left-out", problem)
        if muscle.pulley is not None:
            problem = f"{format_} has no swivelling pulley; its fixed location is a via point"
            yield warning(subject, "pulley-left-out", problem)
        yield from cable_friction(subject, muscle, format_)


def cable_friction(subject: Subject, muscle: Muscle, format_: str) -> Iterator[Finding]:
    """Friction of a cable on its guides, for formats without."""
    if muscle.friction or muscle.bend_friction:
        problem = f"{format_} has no friction of a cable on its guides; left out"
        yield warning(subject, "cable-friction-left-out", problem)


def muscle_paths(
    robot: Robot,
    format_: str,
    held: Container[str] = (),
    rules: Container[str] = ("taut",),
    *,
    every_set: bool = False,
) -> Iterator[Finding]:
    """What paths have beside fixed points and wraps by the format's own rules.

    Args:
        robot: The robot.
        format_: What the format is called.
        held: What of `conditions`, `moves`, `branches` and `terms` it holds.
        rules: The rules of wraps that it holds.
        every_set: Whether it holds the cable sets beside the active one.
    """
    active = [(Subject("muscle", muscle.name), muscle) for muscle in robot.muscles]
    for subject, muscle in all_muscles(robot) if every_set else active:
        conditions = [k for k, p in enumerate(muscle.via_points, 1) if p.when is not None]
        if conditions and "conditions" not in held:
            problem = f"{format_} has no points that are in use at times; always in use there: "
            problem += ", ".join(map(str, conditions))
            yield warning(subject, "point-condition-left-out", problem)
        moving = [k for k, p in enumerate(muscle.via_points, 1) if p.moves]
        if moving and "moves" not in held:
            problem = f"{format_} has no points that move on their links; fixed there: "
            yield warning(subject, "point-motion-left-out", problem + ", ".join(map(str, moving)))
        if muscle.branches and "branches" not in held:
            problem = f"{format_} has no branches of a tendon; its path is one piece there"
            yield warning(subject, "branches-left-out", problem)
        if muscle.terms and "terms" not in held:
            problem = f"{format_} has no lengths in proportion to coordinates"
            lost = warning if muscle.via_points else error
            yield lost(subject, "terms-left-out", f"{problem}; left out")
        foreign = [wrap for wrap in muscle.wraps if wrap.rule not in rules]
        if foreign:
            problem = f"{format_} has no wraps by the rules of {foreign[0].rule}; those over "
            problem += ", ".join(repr(wrap.surface) for wrap in foreign)
            yield warning(subject, "wrap-rule-left-out", problem + " go by its own")


def ellipsoids(robot: Robot, format_: str) -> Iterator[Finding]:
    """Ellipsoids, for formats that do not have them."""
    for surface in robot.wrap_surfaces:
        if surface.shape == "ellipsoid":
            problem = f"{format_} wraps over no ellipsoids; it is left out, with its wraps"
            yield warning(Subject("wrap_surface", surface.name), "ellipsoid-left-out", problem)


def driven_joints(robot: Robot, format_: str) -> Iterator[Finding]:
    """Functions, couplings and locks between coordinates and motions, which are not written."""
    for joint in robot.driven_joints:
        problem = (
            f"{format_} is not written with motions that follow functions of coordinates, nor with "
            "coupled or locked ones; write sdf, or hold its coordinates at a value"
        )
        yield error(Subject("joint", joint.name), "driven-joint", problem)


def loops(robot: Robot, format_: str, held: Container[str] = ()) -> Iterator[Finding]:
    """Loop joints that a format does not have: the robot moves otherwise without.

    Args:
        robot: The robot.
        format_: What the format is called.
        held: The types that it has.
    """
    lost = [loop for loop in robot.loops if loop.type not in held]
    if lost:
        named = listed([f"{loop.name} ({loop.type})" for loop in lost])
        problem = (
            f"{format_} has no joints that close such loops; left out, and open there: {named}"
        )
        yield warning(Subject("robot", robot.name), "loop-left-out", problem)


def loop_types(robot: Robot, format_: str, held: Container[str]) -> Iterator[Finding]:
    """Loop joints of types that a format does not have.

    Args:
        robot: The robot.
        format_: What the format is called.
        held: The types that it has.
    """
    for loop in robot.loops:
        if loop.type not in held:
            problem = f"{format_} has no {loop.type} joint that closes a loop"
            yield error(Subject("joint", loop.name), "loop-type", problem)


def coordinate_forces(
    robot: Robot, format_: str, *, armature: bool = False, limit_force: bool = False
) -> Iterator[Finding]:
    """Armatures and limit forces, which are not written.

    Args:
        robot: The robot.
        format_: What the format is called.
        armature: Whether it holds armatures.
        limit_force: Whether it holds limit forces.
    """
    for c in robot.all_coordinates:
        subject = Subject("coordinate", c.name)
        if c.armature and not armature:
            yield warning(subject, "armature-left-out", f"{format_} has no armature; left out")
        if c.limit_force and not limit_force:
            problem = f"{format_} is not written with forces beyond a range; left out"
            yield warning(subject, "limit-force-left-out", problem)


def motor_bounds(robot: Robot, format_: str) -> Iterator[Finding]:
    """Bounds of torques that no motor makes, for formats whose actuators hold them."""
    for c in robot.coordinates:
        if not c.actuated and (c.tau_min, c.tau_max) != (-math.inf, math.inf):
            problem = f"{format_} has bounds of a motor only with one, and it has none; left out"
            yield warning(Subject("coordinate", c.name), "motor-bounds-left-out", problem)


def task_axes(robot: Robot, format_: str) -> Iterator[Finding]:
    """Which axes of the task frames count."""
    if robot.task_frames:
        problem = (
            f"{format_} holds the points of the task frames, not their order nor which of their "
            "axes count"
        )
        yield warning(Subject("robot", robot.name), "task-axes-left-out", problem)


def link_ends(robot: Robot, format_: str) -> Iterator[Finding]:
    """Far ends of links, which are for drawing only."""
    if any(link.end is not None for link in robot.links):
        problem = f"{format_} does not hold the far ends of links; they were for drawing only"
        yield warning(Subject("robot", robot.name), "link-ends-left-out", problem)


def chained_joints(robot: Robot, format_: str) -> Iterator[Finding]:
    """Joints of several motions that become chains of single ones."""
    for joint in robot.joints:
        if len(joint.motions) > 1:
            yield chained_joint(joint, format_)


def chained_joint(joint: Joint, format_: str) -> Finding:
    """A joint that becomes a chain of single ones."""
    moved = (motion for motion in joint.motions if not motion.is_fixed)
    order = ", ".join(joint.coordinates[motion.coordinate].name for motion in moved)
    problem = (
        f"{format_} gets its {len(joint.motions)} motions as single joints, with links without "
        f"mass between them; their order is {order}"
    )
    return warning(Subject("joint", joint.name), "joint-in-a-chain", problem)
