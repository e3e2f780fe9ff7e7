"""Reading [reference] and [start]: what is to be followed, and where the robot begins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.model.trajectory import Space, Spline, Trajectory, TrajectoryPoint
from addin_sdfusion.robot.readers import Reading
from addin_sdfusion.robot.readers.caspr.trajectories import read_trajectory
from cardsflow_fmu.config.table import Table
from cardsflow_fmu.signals.ports import task_names

from .experiment import ApproachSettings, FlowerSettings, ReferenceSettings, StartSettings

_SPLINES = ("linear", "cubic", "quintic", "parabolic_blend", "samples")
_WITH_RATES = ("cubic", "quintic", "samples")
_WITH_ACCELERATIONS = ("quintic", "samples")
_RIGHT_ANGLE = 1e-9
_REACHABLE = 1e-3  # in [m] or [rad]: nearer than this to the robot's reach, a reference is in it

_X, _Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class _Rows:
    """What a point of a reference holds: its letter, and the names of its numbers.

    Attributes:
        letter: `q` or `y`.
        kind: What the names name.
        names: Of coordinates or task coordinates, in order.
        groups: Task frames with their task coordinates.
    """

    letter: str
    kind: str
    names: tuple[str, ...]
    groups: Mapping[str, Sequence[str]]

    @property
    def space(self) -> Space:
        return "joint" if self.letter == "q" else "operational"

    def read(self, table: Table, ending: str = "", default: Any = None) -> tuple[float, ...]:
        """The numbers under `q`, `qd`, `qdd`, or the same of y."""
        key = self.letter + ending
        if default is None:
            return table.by_name(key, self.kind, self.names, groups=self.groups)
        return table.by_name(key, self.kind, self.names, default, self.groups)


def read_reference(
    start_table: Table, table: Table, space: Space, reading: Reading, robot: Robot
) -> tuple[StartSettings, ReferenceSettings]:
    """The state at the start and the reference.

    Args:
        start_table: The table [start].
        table: The table [reference].
        space: Where a trajectory that is given by name is to be found.
        reading: Where the robot comes from.
        robot: The robot, with its operational space.

    Raises:
        InputError: Something is wrong, or the start cannot be reached.
    """
    approach = table.table("approach") if "approach" in table else None
    table.value("approach", None)
    curve = _curve(table, space, reading, robot)
    space = "operational" if isinstance(curve, FlowerSettings) else curve.space
    rows = _rows(robot, space)
    first = _first(curve)
    if approach is None:
        return _start(start_table, robot, curve, first), ReferenceSettings(space, curve)
    duration = approach.positive("duration")
    if "start" in approach:
        begin = approach.numbers("start", len(rows.names))
        start = _start(start_table, robot, curve, begin, at_rest=True)
    else:
        start = _start(start_table, robot, curve, None)
        begin = start.q if space == "joint" else _task_position(robot, start.q)
    approach.value("start", None)
    approach.close()
    if space == "operational":
        _require_reach(table, robot, first, start.q)
    return start, ReferenceSettings(space, curve, ApproachSettings(duration, begin))


def _rows(robot: Robot, space: Space) -> _Rows:
    if space == "joint":
        return _Rows("q", "coordinate", tuple(c.name for c in robot.coordinates), {})
    groups = {f.name: [f"{f.name}.{axis}" for axis in f.axes] for f in robot.task_frames}
    return _Rows("y", "task coordinate", task_names(robot), groups)


def _first(curve: Trajectory | FlowerSettings) -> tuple[float, ...]:
    """Where the reference begins."""
    if isinstance(curve, Trajectory):
        return curve.points[0].q
    return tuple(c + curve.radius * u for c, u in zip(curve.centre, curve.axes[0], strict=True))


def _curve(
    table: Table, space: Space, reading: Reading, robot: Robot
) -> Trajectory | FlowerSettings:
    if "flower" in table:
        flower = table.table("flower")
        table.close()
        return _flower(flower, robot)
    if "points" in table:
        return _inline_trajectory(table, robot)
    return _named_trajectory(table, space, reading, robot)


def _flower(table: Table, robot: Robot) -> FlowerSettings:
    names = task_names(robot)
    if len(names) != 3 or any(not name.endswith(f".{a}") for name, a in zip(names, "xyz")):  # noqa: B905
        found = ", ".join(names) or "none"
        raise table.error("centre", f"a flower needs a task point with axes x, y, z; found {found}")
    rows = table.value("axes", [_X, _Z])
    if not isinstance(rows, list) or len(rows) != 2:
        raise table.error("axes", "must be two vectors of three numbers")
    both = Table({"u": rows[0], "v": rows[1]}, table.file, table.key("axes"))
    u, v = (np.array(both.numbers(key, 3)) for key in "uv")
    if max(abs(u @ u - 1.0), abs(v @ v - 1.0), abs(u @ v)) > _RIGHT_ANGLE:
        raise table.error("axes", "must be two unit vectors at a right angle")
    settings = FlowerSettings(
        centre=table.numbers("centre", 3),
        axes=(tuple(u.tolist()), tuple(v.tolist())),
        radius=table.positive("radius"),
        petals=table.whole("petals", 5),
        duration=table.positive("duration", 30.0),
    )
    table.close()
    if settings.petals < 1:
        raise table.error("petals", f"must be at least 1, not {settings.petals}")
    return settings


def _named_trajectory(table: Table, space: Space, reading: Reading, robot: Robot) -> Trajectory:
    name = table.text("trajectory")
    if "file" in table:
        file = table.file.parent / table.text("file")
    else:
        file = _trajectory_file(table, reading)
    table.value("file", None)
    table.close()
    try:
        trajectory = read_trajectory(file, name, space)
    except UnknownNameError as error:
        raise table.unknown("trajectory", "trajectory", name, error.known) from None
    rows = _rows(robot, trajectory.space)
    size = len(trajectory.points[0].q)
    if size != len(rows.names):
        what = f"{name!r} moves {size} {rows.kind}s, the robot has {len(rows.names)}"
        raise table.error("trajectory", what)
    return trajectory


def _trajectory_file(table: Table, reading: Reading) -> Path:
    """CASPR's trajectories beside the robot's bodies."""
    bodies = reading.files[0]
    file = bodies.with_name(bodies.name.removesuffix("_bodies.xml") + "_trajectories.xml")
    if file == bodies or not file.is_file():
        raise table.error("file", f"missing, and there is no trajectories file beside {bodies}")
    return file


def _inline_trajectory(table: Table, robot: Robot) -> Trajectory:
    name = table.text("name", "reference")
    spline = cast(Spline, table.choice("spline", "kind of spline", _SPLINES))
    points = table.value("points")
    table.close()
    if not isinstance(points, list) or len(points) < 2:
        raise table.error("points", "must be a list of at least two points")
    first = points[0]
    space: Space = "operational" if isinstance(first, dict) and "y" in first else "joint"
    rows = _rows(robot, space)
    read = tuple(_point(table, k, point, spline, rows) for k, point in enumerate(points))
    times = [point.time for point in read]
    if times[0] != 0 or any(b <= a for a, b in pairwise(times)):
        raise table.error("points", f"times must begin at 0 and increase: {times}")
    for k, (before, point) in enumerate(pairwise(read), 1):
        if 2.0 * point.blend_time >= point.time - before.time:
            what = f"{point.blend_time!r} s is not below half the way to the point"
            raise table.error(f"points[{k}].blend_time", what)
    return Trajectory(name, spline, read, time_step=times[-1], space=space)


def _point(table: Table, index: int, row: Any, spline: Spline, rows: _Rows) -> TrajectoryPoint:
    if not isinstance(row, dict):
        raise table.error(f"points[{index}]", f"must be a table, not {row!r}")
    point = table.element("points", index, row)
    rates, accelerations = spline in _WITH_RATES, spline in _WITH_ACCELERATIONS
    blends = spline == "parabolic_blend" and index > 0
    result = TrajectoryPoint(
        time=point.number("time"),
        q=rows.read(point),
        qd=rows.read(point, "d", 0.0) if rates else (),
        qdd=rows.read(point, "dd", 0.0) if accelerations else (),
        blend_time=point.positive("blend_time") if blends else 0.0,
    )
    point.close()
    return result


def _start(
    table: Table,
    robot: Robot,
    curve: Trajectory | FlowerSettings,
    begin: tuple[float, ...] | None,
    *,
    at_rest: bool = False,
) -> StartSettings:
    """The state at the start; where the experiment is silent, that of the reference.

    Args:
        table: The table [start].
        robot: The robot.
        curve: What is followed.
        begin: Where the reference begins, q or y; None if an approach leads there from anywhere.
        at_rest: Whether it begins at rest, as an approach does.
    """
    names = [c.name for c in robot.coordinates]
    initial = tuple(c.initial for c in robot.coordinates)
    rest = (0.0,) * len(names)
    in_joints = isinstance(curve, Trajectory) and curve.space == "joint"
    if in_joints and begin is not None:
        first = cast(Trajectory, curve).points[0]
        q = table.by_name("q", "coordinate", names, begin)
        qd = table.by_name("qd", "coordinate", names, rest if at_rest else first.qd or rest)
    else:
        q = _start_by_task(table, robot, begin, initial)
        qd = table.by_name("qd", "coordinate", names, rest)
    table.close()
    for coordinate, value in zip(robot.coordinates, q, strict=True):
        if not coordinate.lower <= value <= coordinate.upper:
            raise table.error(
                f"q.{coordinate.name}",
                f"{value!r} is outside the limits {coordinate.lower!r} to {coordinate.upper!r}",
            )
    return StartSettings(q, qd)


def _start_by_task(
    table: Table, robot: Robot, begin: tuple[float, ...] | None, initial: tuple[float, ...]
) -> tuple[float, ...]:
    """A pose: as given, or found by inverse kinematics onto `start.y` or the reference's begin."""
    names = [c.name for c in robot.coordinates]
    seed = table.by_name("seed", "coordinate", names, initial)
    rows = _rows(robot, "operational")
    y = rows.read(table) if "y" in table else begin
    table.value("y", None)
    if "q" in table or y is None:
        return table.by_name("q", "coordinate", names, initial)
    table.value("q", None)
    return _inverse_kinematics(table, robot, y, seed)


def _inverse_kinematics(
    table: Table, robot: Robot, y: tuple[float, ...], seed: tuple[float, ...]
) -> tuple[float, ...]:
    from controllers.analysis.kinematics import inverse_kinematics
    from sim_dart import DartDynamics

    try:
        found = inverse_kinematics(DartDynamics(robot), np.array(y), np.array(seed))
    except InputError as error:
        raise table.error("y" if "y" in table else "q", error.what) from None
    return tuple(found.q.tolist())


def _require_reach(table: Table, robot: Robot, y: tuple[float, ...], q: tuple[float, ...]) -> None:
    """That an approach leads somewhere."""
    from controllers.analysis.kinematics import inverse_kinematics
    from sim_dart import DartDynamics

    try:
        inverse_kinematics(DartDynamics(robot), np.array(y), np.array(q), tolerance=_REACHABLE)
    except InputError as error:
        raise InputError(error.what, file=table.file, key=table.path) from None


def _task_position(robot: Robot, q: tuple[float, ...]) -> tuple[float, ...]:
    from sim_dart import DartDynamics

    return tuple(DartDynamics(robot).task_position(np.array(q)).tolist())
