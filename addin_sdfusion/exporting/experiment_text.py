"""Experiment file of an export: a small motion that `cardsflow run` simulates."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Iterator, Sequence

from ..robot.finding import Finding, Subject
from ..robot.finding_builders import warning
from ..robot.identifier import identifier
from ..robot.json_text import json_text
from ..robot.model.joint import Coordinate
from ..robot.model.robot import Robot
from ..robot.model.trajectory import Trajectory, TrajectoryPoint

DURATION = 4.0
"""Duration of the motion to the target and back, in [s]."""
STEP = 0.001
"""Step of the simulation, in [s]."""
REACH = {"rad": 0.1, "m": 0.01}
"""Maximum motion of a coordinate, by its unit."""

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def gentle_motion(robot: Robot) -> Trajectory:
    """Return a quintic motion to a pose near the initial pose and back, at rest at every point.

    A coordinate moves in the direction of the more distant limit, by at most half the distance. An
    initial value outside its limits is moved to the nearest limit.
    """
    starts = [min(max(c.initial, c.lower), c.upper) for c in robot.coordinates]
    ends = [_nearby(c, q) for c, q in zip(robot.coordinates, starts, strict=True)]
    rest = (0.0,) * len(starts)
    points = [
        TrajectoryPoint(time, tuple(q), rest, rest)
        for time, q in ((0.0, starts), (0.5 * DURATION, ends), (DURATION, starts))
    ]
    return Trajectory("reference", "quintic", tuple(points), STEP)


def can_run(robot: Robot) -> bool:
    """Return whether the robot can be simulated: it has a movable joint and a muscle."""
    return bool(robot.coordinates and robot.muscles)


def experiment_findings(robot: Robot) -> Iterator[Finding]:
    """Yield warnings if no experiment is written or if a run will reject it."""
    subject = Subject("robot", robot.name)
    if not can_run(robot):
        missing = "no muscles" if robot.coordinates else "no movable joints"
        problem = f"it has {missing}, so no experiment.toml is written"
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


def experiment_text(robot: Robot, trajectory: Trajectory) -> str:
    """Return the text of an experiment.toml next to model.sdf, for a robot with muscles."""
    muscle = robot.muscles[0]
    lines = [
        "# `cardsflow run .` in this folder simulates the robot. You may edit this file: a later",
        "# export keeps your version and writes the new version to experiment.new.toml.",
        "",
        "[robot]",
        'path = "model.sdf"          # relative to this file',
        "",
        "# Force limits of a muscle, if they differ from the limits in the robot:",
        f"# [muscles.{toml_key(muscle.name)}]",
        f"# f_min = {muscle.f_min!r}   # [N]",
        f"# f_max = {100.0 if muscle.f_max == math.inf else muscle.f_max!r}   # [N]",
        "",
        "# The reference: a motion from the pose of the design to a nearby pose and back. Add",
        "# points as needed, in the order of their times. With tables `qd` and `qdd` like `q`, the",
        "# robot does not have to stop at a point.",
        "[reference]",
        f'spline = "{trajectory.spline}"          # or "linear", "cubic"',
        *point_lines(robot.coordinates, trajectory.points),
        "",
        "[controller]",
        'type = "joint_space"        # computed torque',
        "kp = 2000.0                 # [1/s²]; one for all, or { name = ..., ... }",
        "kd = 90.0                   # [1/s]",
        f"period = {STEP!r}              # [s]; a whole multiple of run.step",
        "",
        "[plant]",
        f"step = {STEP!r}                # [s]; run.step is a whole multiple of it",
        "",
        "[run]",
        f"step = {STEP!r}                # [s]",
        f"duration = {DURATION!r}              # [s]",
        'output = "results"          # relative to this file',
    ]
    return "\n".join(lines) + "\n"


def point_lines(
    coordinates: Sequence[Coordinate],
    points: Iterable[TrajectoryPoint],
    without: Collection[str] = (),
) -> Iterator[str]:
    """Yield the lines of one TOML table per point, with units, and with limits at the first one.

    Args:
        coordinates: Coordinates of the points, in order.
        points: Points of the reference.
        without: Names of coordinates that are not written.
    """
    keys = [toml_key(c.name) for c in coordinates]
    for i, point in enumerate(points):
        yield ""
        yield "[[reference.points]]"
        yield f"time = {point.time!r}  # [s]"
        yield "[reference.points.q]"
        for c, key, q in zip(coordinates, keys, point.q, strict=True):
            if c.name in without:
                continue
            yield f"{key} = {q!r}  # [{c.unit}]" + ("" if i else _limits(c))


def _limits(c: Coordinate) -> str:
    if not (math.isfinite(c.lower) or math.isfinite(c.upper)):
        return ""
    return f", limits {c.lower!r} to {c.upper!r}"


def _nearby(c: Coordinate, q: float) -> float:
    up, down = (min(REACH[c.unit], 0.5 * room) for room in (c.upper - q, q - c.lower))
    return q + up if up >= down else q - down


def toml_key(name: str) -> str:
    """Return a name as a TOML key."""
    return name if _BARE.fullmatch(name) else json_text(name, ensure_ascii=False)
