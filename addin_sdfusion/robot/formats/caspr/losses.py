"""Losses in CASPR: errors where it would be another robot, warnings elsewhere."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from ...caspr_vocabulary import CASPR_CABLES, CASPR_PULLEYS, cable_tag
from ...checks.names import named
from ...finding import Finding, Subject, errors_first
from ...finding_builders import all_muscles, all_task_frames, error, warning
from ...model.joint import Joint
from ...model.muscle import BasePulley, Muscle
from ...model.pose import IDENTITY
from ...model.robot import GRAVITY, WORLD, Robot
from ...model.trajectory import Trajectory
from ..writing.common_losses import cable_friction, loops, muscle_paths
from .joints import CASPR_JOINTS, caspr_word
from .write_tasks import task_items
from .write_trajectories import TIME_TOLERANCE

XML_ID = re.compile(r"[^\W\d][\w.-]*")
"""A name without spaces that begins with a letter or an underscore."""


def losses(robot: Robot, trajectories: Sequence[Trajectory] = ()) -> list[Finding]:
    """Everything that CASPR's files cannot hold.

    Returns:
        Errors, for which it is not written, then warnings for what is left out or doubtful.
    """
    found = [
        *_whole_robot(robot),
        *(finding for joint in robot.joints for finding in _joint(joint)),
        *loops(robot, "CASPR"),
        *_links(robot),
        *(finding for member in all_muscles(robot) for finding in _muscle(*member)),
        *muscle_paths(robot, "CASPR", every_set=True),
        *_tasks(robot),
        *_ids(robot),
        *trajectory_losses(robot, trajectories),
    ]
    return errors_first(found)


def _whole_robot(robot: Robot) -> Iterator[Finding]:
    subject = Subject("robot", robot.name)
    if robot.gravity != GRAVITY:
        yield error(subject, "caspr-gravity", f"CASPR's gravity is {GRAVITY}, not {robot.gravity}")
    without = [link.name for link in robot.links if link.end is None]
    if without:
        problem = (
            f"CASPR needs far ends of links, for drawing; 0 0 0 for {', '.join(map(repr, without))}"
        )
        yield warning(subject, "caspr-link-ends", problem)
    renamed = {
        f"{name!r} becomes {given}": None
        for i, joint in enumerate(robot.joints, start=1)
        for name, given in _names(joint, f"joint_{i}")
        if name != given
    }
    if renamed:
        problem = f"CASPR names no joints nor coordinates; {', '.join(renamed)}"
        yield warning(subject, "caspr-joint-names", problem)


def _names(joint: Joint, given: str) -> Iterator[tuple[str, str]]:
    """The names of a joint and its coordinates, each with the one that it is read back under."""
    yield joint.name, given
    words = [j.suffixes for j in CASPR_JOINTS.values() if j.motions == joint.motions]
    suffixes = words[0] if words else ("",) * len(joint.coordinates)
    for coordinate, suffix in zip(joint.coordinates, suffixes, strict=False):
        yield coordinate.name, f"{given}_{suffix}" if suffix else given


def _joint(joint: Joint) -> Iterator[Finding]:
    subject = Subject("joint", joint.name)
    if joint.type == "fixed":
        problem = f"CASPR has no fixed joints; merge link {joint.child!r} into {joint.parent!r}"
        yield error(subject, "caspr-fixed-joint", problem)
    elif caspr_word(joint.motions) is None:
        problem = "CASPR has no joint with these motions; make it of several joints"
        yield error(subject, "caspr-joint-type", problem)
    elif not joint.is_plain:
        problem = "CASPR has no coupled or locked coordinates; hold them at a value"
        yield error(subject, "caspr-driven-joint", problem)
    if any(joint.T_parent_joint.rpy) or any(joint.T_child_joint.rpy):
        problem = "turns a frame at q = 0, and CASPR has no turned frames; align the frames"
        yield error(subject, "caspr-turned-frame", problem)
    elif joint.T_child_joint != IDENTITY:
        problem = f"in CASPR the frame of link {joint.child!r} is the joint's; move it there"
        yield error(subject, "caspr-link-frame", problem)
    if len({coordinate.actuated for coordinate in joint.coordinates}) > 1:
        problem = "in CASPR all of a joint's coordinates are actuated or none is; split the joint"
        yield error(subject, "caspr-mixed-actuation", problem)
    if any((c.tau_min, c.tau_max) != (-math.inf, math.inf) for c in joint.coordinates):
        problem = "CASPR has no bounds of motors; they are left out"
        yield warning(subject, "caspr-motor-bounds", problem)
    if any(coordinate.damping for coordinate in joint.coordinates):
        yield warning(subject, "caspr-damping", "CASPR has no damping; it is left out")
    if any(c.stiffness or c.friction or c.armature or c.limit_force for c in joint.coordinates):
        problem = "CASPR has no springs, friction, armature or limit forces in joints; left out"
        yield warning(subject, "caspr-spring", problem)


def _links(robot: Robot) -> Iterator[Finding]:
    for link in robot.links:
        if link.meshes:
            problem = f"CASPR has no meshes; {len(link.meshes)} left out"
            yield warning(Subject("link", link.name), "caspr-meshes", problem)
        if link.shapes:
            problem = f"CASPR has no shapes to collide with; {len(link.shapes)} left out"
            yield warning(Subject("link", link.name), "caspr-meshes", problem)
    for surface in robot.wrap_surfaces:
        problem = "CASPR has no wrap surfaces; it is left out, and cables run straight"
        yield warning(Subject("wrap_surface", surface.name), "caspr-wrap", problem)


def _muscle(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    if muscle.f_max == math.inf:
        problem = "f_max is written as inf, which CASPR's solvers may refuse; give a number"
        yield warning(subject, "caspr-infinite-force", problem)
    if muscle.wraps:
        yield warning(subject, "caspr-wrap", "CASPR has no wrapping; the cable runs straight")
    given = [name for name, _ in muscle.model.parameters]
    tag = cable_tag(muscle.model.kind)
    cable = CASPR_CABLES[tag]
    if cable.kind != muscle.model.kind:
        problem = f"CASPR has no {muscle.model.kind}; written as an ideal cable with force limits"
        yield warning(subject, "caspr-tension-law", problem)
        given = []
    known: list[str] = []
    for item in cable.properties:
        names = [item.name(k) for k in range(1, (item.size or len(given)) + 1)]
        known += names
        if item.required and not set(names) <= set(given):
            problem = f"CASPR's <{tag}> needs {', '.join(names)}; add them to the model"
            yield error(subject, "caspr-cable-property", problem)
    unknown = [name for name in given if name not in known]
    if unknown:
        problem = f"CASPR's <{tag}> has no {', '.join(unknown)}; left out"
        yield warning(subject, "caspr-cable-property", problem)
    if muscle.pulley is not None:
        if [p.link for p in muscle.via_points[:1]] != [WORLD]:
            problem = "CASPR has pulleys at the base only; put its first via point there"
            yield error(subject, "pulley-not-at-base", problem)
        yield from _pulley(subject, muscle.pulley)
    yield from cable_friction(subject, muscle, "CASPR")


def _pulley(subject: Subject, pulley: BasePulley) -> Iterator[Finding]:
    tag, words = next(p for p in CASPR_PULLEYS.items() if p[1].kind == pulley.kind)
    sizes = {name: len(values) for name, values in pulley.parameters}
    for item in words.properties:
        if sizes.get(item.tag) != item.size:
            problem = f"CASPR's <{tag}> needs {item.size} numbers {item.tag}; add them"
            yield error(subject, "caspr-pulley-property", problem)
    unknown = sorted(set(sizes) - {item.tag for item in words.properties})
    if unknown:
        problem = f"CASPR's <{tag}> has no {', '.join(unknown)}; left out"
        yield warning(subject, "caspr-pulley-property", problem)


def _tasks(robot: Robot) -> Iterator[Finding]:
    for task_set in robot.task_sets:
        counts = Counter(item.link for item in task_items(task_set.frames))
        for link, count in counts.items():
            if count > 1:
                problem = f"has {count} items on link {link!r}; CASPR loads a set with one a link"
                yield warning(Subject("task_set", task_set.name), "caspr-one-item-a-link", problem)
    for subject, frame in all_task_frames(robot):
        if frame.is_orientation and any(frame.position):
            problem = "an orientation has no point in CASPR; it is left out"
            yield warning(subject, "caspr-orientation-point", problem)


def _ids(robot: Robot) -> Iterator[Finding]:
    yield from _id_spelling("cable_set", [group.name for group in robot.cable_sets])
    yield from _id_spelling("task_set", [group.name for group in robot.task_sets])


def _id_spelling(kind: str, names: Iterable[str]) -> Iterator[Finding]:
    for name in names:
        if not XML_ID.fullmatch(name):
            problem = "is no XML ID; begin with a letter, go on with letters, digits, '_', '.', '-'"
            yield warning(Subject(kind, name), "caspr-id", problem)


def trajectory_losses(robot: Robot, trajectories: Sequence[Trajectory]) -> Iterator[Finding]:
    """What CASPR cannot hold of trajectories, and those that are none of the robot."""
    names = [trajectory.name for trajectory in trajectories]
    yield from _id_spelling("trajectory", names)
    yield from named([Subject("trajectory", name) for name in names])
    for trajectory in trajectories:
        yield from _trajectory(robot, trajectory)


def _trajectory(robot: Robot, trajectory: Trajectory) -> Iterator[Finding]:
    subject = Subject("trajectory", trajectory.name)
    size = len(trajectory.points[0].q)
    if trajectory.space == "joint" and size != len(robot.coordinates):
        problem = f"has {size} values a point; the robot has {len(robot.coordinates)} coordinates"
        yield error(subject, "caspr-trajectory-size", problem)
    if trajectory.space == "operational":
        sizes = {sum(len(f.axes) for f in group.frames) for group in robot.task_sets}
        if size not in sizes:
            problem = f"has {size} values a point; no operational space has so many axes"
            yield warning(subject, "caspr-trajectory-size", problem)
        if trajectory.spline not in ("linear", "quintic"):
            problem = f"CASPR has no {trajectory.spline} trajectories in operational space"
            yield warning(subject, "caspr-operational-spline", problem)
    if trajectory.spline == "samples" and not _on_time(trajectory):
        problem = f"its samples are not {trajectory.time_step!r} s apart, as CASPR wants them"
        yield error(subject, "caspr-sample-times", problem)


def _on_time(trajectory: Trajectory) -> bool:
    return all(
        abs(point.time - k * trajectory.time_step) <= TIME_TOLERANCE
        for k, point in enumerate(trajectory.points)
    )
