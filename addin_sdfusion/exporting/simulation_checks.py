"""Checks whether an exported robot can be simulated."""

from __future__ import annotations

from collections.abc import Iterator

from ..robot.finding import Finding, Subject
from ..robot.finding_builders import warning
from ..robot.identifier import identifier
from ..robot.model.robot import Robot


def can_simulate(robot: Robot) -> bool:
    """Return whether the robot has a movable joint and a muscle."""
    return bool(robot.coordinates and robot.muscles)


def simulation_findings(robot: Robot) -> Iterator[Finding]:
    """Yield warnings if the robot cannot be simulated, or if an experiment rejects its names."""
    subject = Subject("robot", robot.name)
    if not can_simulate(robot):
        missing = "no muscles" if robot.coordinates else "no movable joints"
        problem = f"it has {missing}, so it cannot be simulated and has no experiment.toml"
        yield warning(subject, "no-experiment", problem)
        return
    for kind, names in (
        ("coordinate", [c.name for c in robot.coordinates]),
        ("muscle", [muscle.name for muscle in robot.muscles]),
        ("task_frame", [frame.name for frame in robot.task_frames]),
    ):
        first: dict[str, str] = {}
        for name in names:
            other = first.setdefault(identifier(name), name)
            if other != name:
                problem = f"has the same variable name in the simulation as {other!r}; rename one"
                yield warning(Subject(kind, name), "experiment-names", problem)
