"""Reading [[robots]]: several robots in one plant, in the place of [robot]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, Pose, Robot
from addin_sdfusion.robot.readers import Reading
from addin_sdfusion.robot.transforms.combine import Member, combine
from cardsflow_fmu.config.table import Table
from cardsflow_fmu.signals.port import identifier


@dataclass(frozen=True)
class RobotPart:
    """One of several robots, and where it comes from.

    Attributes:
        name: Its name.
        robot: The robot as it was read, with its active sets and gravity.
        pose: Of its world in the common one.
        files: Every file that makes it up, the main one first.
        changes: What the experiment changes of them; see `robot_changes`.
    """

    name: str
    robot: Robot
    pose: Pose
    files: tuple[Path, ...]
    changes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Where its main file stands."""
        return self.files[0].parent


def read_parts(rows: Sequence[Table], read_robot: Any) -> tuple[RobotPart, ...]:
    """The robots of [[robots]].

    Args:
        rows: Its tables.
        read_robot: Reads a table as [robot] is read: gives a reading, the robot, its changes.

    Raises:
        InputError: Something in them is wrong.
    """
    parts = []
    for row in rows:
        name = row.text("name")
        if identifier(name) != name:
            raise row.error("name", f"{name!r} is no plain name: letters, digits, underscores")
        pose = Pose(_vector(row, "position"), _vector(row, "rpy"))
        reading, robot, changes = read_robot(row)
        parts.append(RobotPart(name, robot, pose, reading.files, changes))
    return tuple(parts)


def combined(parts: Sequence[RobotPart], table: Table) -> tuple[Reading, Robot]:
    """All robots as one, and what it was read from.

    Args:
        parts: The robots.
        table: The table they stand in, for messages.

    Raises:
        InputError: They do not go together.
    """
    members = [Member(part.name, part.robot, part.pose, part.folder) for part in parts]
    name = "_and_".join(part.robot.name for part in parts[:3]) + ("_etc" if parts[3:] else "")
    try:
        robot = combine(name, members)
    except InputError as error:
        raise table.error("robots", error.what) from None
    return Reading(robot, (), tuple(file for part in parts for file in part.files)), robot


def parts_data(parts: Sequence[RobotPart]) -> list[dict[str, Any]]:
    """What [[robots]] says of robots, complete; paths as they are."""
    return [
        {
            "name": part.name,
            "path": str(part.files[0]),
            "position": list(part.pose.position),
            "rpy": list(part.pose.rpy),
            "cable_set": part.robot.cable_set,
            "gravity": list(part.robot.gravity),
        }
        | ({"operational_space": part.robot.task_set} if part.robot.task_set else {})
        | dict(part.changes)
        for part in parts
    ]


def _vector(table: Table, key: str) -> tuple[float, float, float]:
    x, y, z = table.numbers(key, 3, (0.0, 0.0, 0.0))
    return x, y, z
