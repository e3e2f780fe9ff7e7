"""Checks of names (not empty, printable, unique) and of the active sets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from ..finding import Finding, Subject, member
from ..finding_builders import error, unknown
from ..model.robot import WORLD, Robot


def names(robot: Robot) -> Iterator[Finding]:
    """Check that names are unique in their group, not empty, printable and not padded."""
    yield from named([Subject("robot", robot.name)])
    yield from named([Subject("link", link.name) for link in robot.links])
    joints = [joint.name for joint in robot.joints] + [loop.name for loop in robot.loops]
    yield from named([Subject("joint", name) for name in joints])
    yield from named([Subject("coordinate", c.name) for c in robot.all_coordinates])
    yield from named([Subject("cable_set", group.name) for group in robot.cable_sets])
    yield from named([Subject("task_set", group.name) for group in robot.task_sets])
    for cable_set in robot.cable_sets:
        yield from _members(
            "muscle", [m.name for m in cable_set.muscles], cable_set.name, robot.cable_set
        )
    for task_set in robot.task_sets:
        yield from _members(
            "task_frame", [f.name for f in task_set.frames], task_set.name, robot.task_set
        )


def world_is_reserved(robot: Robot) -> Iterator[Finding]:
    """Check that no link has the name of the fixed frame."""
    for link in robot.links:
        if link.name == WORLD:
            problem = "the name is reserved for the fixed frame; rename the link"
            yield error(Subject("link", link.name), "reserved-name", problem)


def active_sets(robot: Robot) -> Iterator[Finding]:
    """Check that the active cable set and the active task set exist."""
    cable_sets = [group.name for group in robot.cable_sets]
    if robot.cable_set and robot.cable_set not in cable_sets:
        problem = unknown("cable set", robot.cable_set, cable_sets)
        yield error(Subject("robot", robot.name), "unknown-cable-set", problem)
    task_sets = [group.name for group in robot.task_sets]
    if robot.task_set and robot.task_set not in task_sets:
        problem = unknown("operational space", robot.task_set, task_sets)
        yield error(Subject("robot", robot.name), "unknown-task-set", problem)


def _members(kind: str, members: list[str], of: str, active: str) -> Iterator[Finding]:
    for name in members:
        yield from spelling(member(kind, name, of, active), name)
    yield from unique([member(kind, name, of, active) for name in members])


def named(subjects: Sequence[Subject]) -> Iterator[Finding]:
    """Check the names of objects of one kind."""
    for subject in subjects:
        yield from spelling(subject, subject.name)
    yield from unique(subjects)


def spelling(subject: Subject, name: str) -> Iterator[Finding]:
    """Report a name that is empty, not printable or padded with spaces."""
    if not name:
        yield error(subject, "bad-name", "the name is empty")
    elif not name.isprintable() or name != name.strip():
        problem = "a name must not begin or end with a space or contain control characters"
        yield error(subject, "bad-name", problem)


def unique(subjects: Iterable[Subject]) -> Iterator[Finding]:
    """Report names that are used more than once."""
    for subject, count in Counter(subjects).items():
        if count > 1:
            problem = f"the name is used {count} times; rename all but one"
            yield error(subject, f"duplicate-{subject.kind.replace('_', '-')}", problem)
