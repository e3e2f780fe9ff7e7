"""Settings of [robot] and [[robots]]: robot files and changes of the robots."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, Pose, Robot, UnknownNameError
from addin_sdfusion.robot.formats.kinds import Kind, kind_of
from addin_sdfusion.robot.formats.read import ABSOLUTE, Reading, read
from addin_sdfusion.robot.model.trajectory import Space
from addin_sdfusion.robot.transforms.combine import Member, combine
from cardsflow_fmu.cosim.signals.port import identifier
from cardsflow_fmu.cosim.signals.ports import (
    coordinate_signals,
    muscle_signals,
    task_names,
    task_signals,
)
from cardsflow_fmu.experiment.config.names import Names
from cardsflow_fmu.experiment.config.table import Context, Table, Text, Vector3, setting
from cardsflow_fmu.experiment.robot_overrides import KINDS, with_overrides

Overrides = dict[str, dict[str, Any]]

_IN_FOLDER = "muscles in a cardsflow.xml in the same folder"
_DRIVES: Mapping[Kind, str] = {
    "sdf": _IN_FOLDER,
    "urdf": f"efforts above 0 in the limits of its joints, or {_IN_FOLDER}",
    "mjcf": "motors of joints or tendons, or muscles, in <actuator>",
    "osim": "muscles or CoordinateActuators in its ForceSet",
    "caspr": "cables in its cables file",
}
"""Elements that define drives, by file format."""
_LEFT_OUT = "actuator-left-out"


def _changes(parts: str) -> Any:
    return setting(f"changes of {parts} of the robot, by name", {})


class RobotSettings(Table):
    """The robot."""

    path: Text = setting(
        "robot file (.sdf, .urdf, .osim, MJCF .xml, *_bodies.xml) or its folder, "
        "relative to this file"
    )
    cable_set: Text = setting("name of the active cable set (default: as in the robot file)", None)
    operational_space: Text = setting(
        "name of the active set of task coordinates y (default: as in the robot file)", None
    )
    gravity: Vector3 = setting(
        "gravity in the world frame, in m/s² (default: as in the robot file)", None
    )
    links: Overrides = _changes("links")
    joints: Overrides = _changes("joints")
    coordinates: Overrides = _changes("coordinates")
    muscles: Overrides = _changes("muscles")
    task_frames: Overrides = _changes("task frames")
    wrap_surfaces: Overrides = _changes("wrap surfaces")

    @property
    def overrides(self) -> dict[str, Any]:
        """Changes of the robot, by kind and name of the part."""
        return {kind: changes for kind in KINDS if (changes := getattr(self, kind))}


class PartSettings(RobotSettings):
    """Robot in an experiment with several robots."""

    name: Text = setting("name of the robot: letters, digits, underscores")
    position: Vector3 = setting(
        "position of the robot's world frame in the common world frame, in m", (0.0, 0.0, 0.0)
    )
    rpy: Vector3 = setting("roll, pitch and yaw of that frame, in rad", (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class RobotPart:
    """Robot in an experiment with several robots, and its files.

    Attributes:
        robot: The robot, with its active sets, gravity and changes.
        pose: Pose of the world frame of the robot in the common world frame.
        files: All files of the robot, the main file first.
        overrides: Changes by the experiment; see `robot_overrides`.
    """

    name: str
    robot: Robot
    pose: Pose
    files: tuple[Path, ...]
    overrides: Mapping[str, Any] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Folder of the main file."""
        return self.files[0].parent


def _simplify_path(path: Path) -> Path:
    """Return the path without `folder/..`, for messages.

    The path is returned unchanged if symbolic links make the two paths differ.
    """
    short = Path(os.path.normpath(path))
    try:
        return short if short.samefile(path) else path
    except (OSError, ValueError):
        return path


def read_robot(
    settings: RobotSettings, context: Context, key: str = "robot", reading: Reading | None = None
) -> tuple[Reading, Robot]:
    """Return the robot of [robot], and the result of reading its files if it is not given."""
    try:
        if reading is None:
            path = _simplify_path(context.file.parent / settings.path)
            reading = read(path, settings.cable_set)
    except UnknownNameError as error:
        context.require(f"{key}.cable_set", "cable set", error.name, error.known)
        raise
    robot = reading.require()
    for finding in reading.findings:
        if finding.code == ABSOLUTE:
            raise InputError(finding.message, file=finding.file, line=finding.line)
    if (tasks := settings.operational_space) is not None:
        spaces = [s.name for s in robot.task_sets]
        context.require(f"{key}.operational_space", "operational space", tasks, spaces)
        robot = replace(robot, task_set=tasks)
    if settings.gravity is not None:
        robot = replace(robot, gravity=settings.gravity)
    robot = with_overrides(robot, settings.overrides, context.file, key)
    with context.at(f"{key}.path"):  # names must stay different as parts of FMI variable names
        coordinate_signals("q", robot)
        muscle_signals("f", robot)
        task_signals("y", robot)
        require_movable(robot, reading)
    return reading, robot


def require_movable(robot: Robot, reading: Reading) -> None:
    """Check that a robot has movable joints and drives.

    Raises:
        InputError: The robot has none; the message states how its file defines them.
    """
    if not robot.coordinates:
        problem = f"robot {robot.name!r} has no movable joints: all are fixed or locked; free one"
        raise InputError(problem)
    if robot.muscles or robot.motors:
        return
    file = reading.files[0]
    problem = f"robot {robot.name!r} has no muscles and no motors; add muscles with `cardsflow "
    problem += f"edit {file}`, {_DRIVES[kind_of(file) or 'sdf']}, or motors in an experiment.toml: "
    problem += "[robot.joints.NAME] motor = true"
    omitted = [finding.message for finding in reading.findings if finding.code == _LEFT_OUT]
    if omitted:
        problem += f" (omitted drives: {len(omitted)}, such as: {omitted[0]})"
    raise InputError(problem)


def read_parts(rows: Sequence[PartSettings], context: Context) -> tuple[RobotPart, ...]:
    """Read the robots of [[robots]]."""
    parts = []
    for k, row in enumerate(rows):
        key = f"robots[{k}]"
        if identifier(row.name) != row.name:
            problem = f"must consist of letters, digits and underscores, not {row.name!r}"
            raise context.error(f"{key}.name", problem)
        reading, robot = read_robot(row, context, key)
        pose = Pose(row.position, row.rpy)
        parts.append(RobotPart(row.name, robot, pose, reading.files, row.overrides))
    return tuple(parts)


def combine_robots(
    parts: Sequence[RobotPart], context: Context, named: tuple[Path, ...] = ()
) -> tuple[Reading, Robot]:
    """Combine all robots into one; each may use its own meshes and explicitly named files."""
    members = [
        Member(part.name, part.robot, part.pose, part.folder, (context.file.parent, *named))
        for part in parts
    ]
    name = "_and_".join(part.robot.name for part in parts[:3]) + ("_etc" if parts[3:] else "")
    with context.at("robots"):
        robot = combine(name, members)
    return Reading(robot, (), tuple(file for part in parts for file in part.files)), robot


def robot_data(robot: Robot, path: Path, overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table [robot] of a robot, with all keys."""
    data: dict[str, Any] = {"path": str(path), "gravity": list(robot.gravity)}
    if robot.cable_set:
        data["cable_set"] = robot.cable_set
    if robot.task_set:
        data["operational_space"] = robot.task_set
    return data | dict(overrides)


def part_data(part: RobotPart) -> dict[str, Any]:
    """Return the row of [[robots]] of a robot, with all keys."""
    pose = {"position": list(part.pose.position), "rpy": list(part.pose.rpy)}
    return {"name": part.name, **pose, **robot_data(part.robot, part.files[0], part.overrides)}


def robot_names(robot: Robot, space: Space = "joint") -> dict[str, Names]:
    """Return the names of all parts, by kind."""
    coordinates = Names("coordinate", [c.name for c in robot.coordinates])
    groups = {f.name: [f"{f.name}.{axis}" for axis in f.axes] for f in robot.task_frames}
    sets = " or ".join(repr(task_set.name) for task_set in robot.task_sets)
    missing = f"set its operational_space to {sets}" if sets else "add task points to its files"
    tasks = Names("task coordinate", task_names(robot), groups, "" if groups else missing)
    muscles = [muscle.name for muscle in robot.muscles]
    motors = [coordinate.name for coordinate in robot.motors]
    points = [frame.name for frame in robot.task_frames if not frame.is_orientation]
    return {
        "coordinate": coordinates,
        "task coordinate": tasks,
        "followed": coordinates if space == "joint" else tasks,
        "muscle": Names("muscle", muscles),
        "motor": Names("motor", motors),
        "actuator": Names("muscle or motor", [*muscles, *motors]),
        "link": Names("link", [link.name for link in robot.links]),
        "point": Names("task frame that is a point", points),
    }
