"""Reading experiment.toml: every table by a function, every error with file and key."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

from addin_sdfusion.robot import InputError, Muscle, Robot, UnknownNameError
from addin_sdfusion.robot.check import require_valid
from addin_sdfusion.robot.files import read_file
from addin_sdfusion.robot.readers import Reading, read
from addin_sdfusion.robot.readers.trajectories import read_trajectory
from addin_sdfusion.robot.trajectory import Spline, Trajectory, TrajectoryPoint
from controllers.qp import DEFAULT_SOLVER, require_solver

from .experiment import (
    ControllerSettings,
    Experiment,
    PlantSettings,
    RunSettings,
    StartSettings,
)
from .ports import coordinate_signals, muscle_signals, task_signals
from .tables import Table
from .timing import whole_steps

_MAX_BYTES = 64 * 2**20
_CONTROLLERS = ("joint_space",)
_SPLINES = ("linear", "cubic", "quintic", "parabolic_blend", "samples")
_WITH_RATES = ("cubic", "quintic", "samples")
_WITH_ACCELERATIONS = ("quintic", "samples")


def read_experiment(path: Path, settings: Mapping[str, Any]) -> Experiment:
    """Read and check an experiment.

    Args:
        path: An experiment.toml, the folder that holds one, or an FMU's experiment.json.
        settings: Changes by full key.

    Raises:
        InputError: Something in it is wrong; the message names file and key.
    """
    file = path / "experiment.toml" if path.is_dir() else path
    data = _read_data(file)
    for key, value in settings.items():
        _set(data, key, value, file)
    return _experiment(Table(data, file))


def _read_data(file: Path) -> dict[str, Any]:
    """The file's content as plain data: TOML, or JSON by its suffix."""
    try:
        text = read_file(file, _MAX_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("is not UTF-8 text", file=file) from None
    try:
        data = json.loads(text) if file.suffix == ".json" else tomllib.loads(text)
    except ValueError as error:
        raise InputError(" ".join(str(error).split()), file=file) from None
    except RecursionError:
        raise InputError("is nested too deeply", file=file) from None
    if not isinstance(data, dict):
        raise InputError("must hold a table", file=file)
    return data


def _set(data: dict[str, Any], key: str, value: Any, file: Path) -> None:
    """Set a value by its full key, making tables on the way."""
    *path, last = key.split(".")
    for part in path:
        data = data.setdefault(part, {})
        if not isinstance(data, dict):
            raise InputError(f"{part!r} is not a table", file=file, key=key)
    data[last] = value


def _experiment(top: Table) -> Experiment:
    reading, robot = _robot(top.table("robot"))
    robot = _with_bounds(robot, top.table("muscles"))
    trajectory = _trajectory(top.table("reference"), reading, robot)
    run = _run(top.table("run"), trajectory)
    experiment = Experiment(
        file=top.file,
        robot=robot,
        robot_path=reading.files[0],
        robot_files=reading.files,
        trajectory=trajectory,
        start=_start(top.table("start"), robot, trajectory),
        plant=_plant(top.table("plant"), run),
        controller=_controller(top.table("controller"), robot, run),
        run=run,
        wiring=_wiring(top.table("wiring")),
    )
    top.close()
    return experiment


def _robot(table: Table) -> tuple[Reading, Robot]:
    path = table.file.parent / table.text("path")
    cable_set = table.text("cable_set", "")
    task_set = table.text("operational_space", "")
    gravity = table.numbers("gravity", 3) if "gravity" in table else None
    table.value("gravity", None)
    table.close()
    try:
        reading = read(path, cable_set or None)
    except UnknownNameError as error:
        raise table.unknown("cable_set", "cable set", error.name, error.known) from None
    robot = reading.require()
    if task_set:
        known = [s.name for s in robot.task_sets]
        if task_set not in known:
            raise table.unknown("operational_space", "operational space", task_set, known)
        robot = replace(robot, task_set=task_set)
    if gravity is not None:
        robot = replace(robot, gravity=cast(tuple[float, float, float], gravity))
    _require_port_names(table, robot)
    if not robot.coordinates:
        raise table.error("path", f"robot {robot.name!r} has no joint that moves")
    if not robot.muscles:
        raise table.error("path", f"robot {robot.name!r} has no muscles")
    return reading, robot


def _require_port_names(table: Table, robot: Robot) -> None:
    """Names that stay different as parts of FMI variable names."""
    try:
        coordinate_signals("q", robot)
        muscle_signals("f", robot)
        task_signals("y", robot)
    except InputError as error:
        raise table.error("path", error.what) from None


def _with_bounds(robot: Robot, table: Table) -> Robot:
    """The robot with the force bounds that the experiment changes."""
    muscles = list(robot.muscles)
    for index, changes in table.tables([muscle.name for muscle in muscles], "muscle"):
        muscles[index] = _bounded(muscles[index], changes)
    changed = robot.with_muscles(muscles)
    require_valid(changed)
    return changed


def _bounded(muscle: Muscle, table: Table) -> Muscle:
    f_min = table.number("f_min", muscle.f_min)
    f_max = table.number("f_max") if "f_max" in table else muscle.f_max
    table.value("f_max", None)
    table.close()
    if f_min < 0:
        raise table.error("f_min", f"must not be negative: {f_min!r}")
    if f_min > f_max:
        raise InputError(
            f"f_min {f_min!r} N is above f_max {f_max!r} N", file=table.file, key=table.path
        )
    return replace(muscle, f_min=f_min, f_max=f_max)


def _trajectory(table: Table, reading: Reading, robot: Robot) -> Trajectory:
    if "points" in table:
        return _inline_trajectory(table, robot)
    name = table.text("trajectory")
    if "file" in table:
        file = table.file.parent / table.text("file")
    else:
        file = _trajectory_file(table, reading)
    table.value("file", None)
    table.close()
    try:
        trajectory = read_trajectory(file, name)
    except UnknownNameError as error:
        raise table.unknown("trajectory", "trajectory", name, error.known) from None
    size = len(trajectory.points[0].q)
    if size != len(robot.coordinates):
        raise table.error(
            "trajectory",
            f"{name!r} moves {size} coordinates, the robot has {len(robot.coordinates)}",
        )
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
    rows = table.value("points")
    table.close()
    if not isinstance(rows, list) or len(rows) < 2:
        raise table.error("points", "must be a list of at least two points")
    points = tuple(_point(table, k, row, spline, robot) for k, row in enumerate(rows))
    times = [point.time for point in points]
    if times[0] != 0 or any(b <= a for a, b in pairwise(times)):
        raise table.error("points", f"times must begin at 0 and increase: {times}")
    return Trajectory(name, spline, points, time_step=times[-1])


def _point(table: Table, index: int, row: Any, spline: Spline, robot: Robot) -> TrajectoryPoint:
    names = [c.name for c in robot.coordinates]
    path = table.key(f"points[{index}]")
    if not isinstance(row, dict):
        raise table.error(f"points[{index}]", f"must be a table, not {row!r}")
    point = Table(row, table.file, path)
    rates, accelerations = spline in _WITH_RATES, spline in _WITH_ACCELERATIONS
    result = TrajectoryPoint(
        time=point.number("time"),
        q=point.by_name("q", "coordinate", names),
        qd=point.by_name("qd", "coordinate", names, 0.0) if rates else (),
        qdd=point.by_name("qdd", "coordinate", names, 0.0) if accelerations else (),
        blend_time=point.number("blend_time", 0.0) if spline == "parabolic_blend" else 0.0,
    )
    point.close()
    return result


def _start(table: Table, robot: Robot, trajectory: Trajectory) -> StartSettings:
    """The state at the start; where the experiment is silent, that of the reference."""
    names = [c.name for c in robot.coordinates]
    first = trajectory.points[0]
    start = StartSettings(
        q=table.by_name("q", "coordinate", names, first.q),
        qd=table.by_name("qd", "coordinate", names, first.qd or (0.0,) * len(names)),
    )
    table.close()
    for coordinate, value in zip(robot.coordinates, start.q, strict=True):
        if not coordinate.lower <= value <= coordinate.upper:
            raise table.error(
                f"q.{coordinate.name}",
                f"{value!r} is outside the limits {coordinate.lower!r} to {coordinate.upper!r}",
            )
    return start


def _run(table: Table, trajectory: Trajectory) -> RunSettings:
    step = table.positive("step", 1e-3)
    duration = table.positive("duration", trajectory.points[-1].time)
    output = table.file.parent / table.text("output", "results")
    table.close()
    _multiple(table, "duration", duration, step, "run.step")
    return RunSettings(duration, step, output)


def _plant(table: Table, run: RunSettings) -> PlantSettings:
    step = table.positive("step", run.step)
    table.close()
    _multiple(table, "step", run.step, step, "plant.step", key="run.step")
    return PlantSettings(step)


def _controller(table: Table, robot: Robot, run: RunSettings) -> ControllerSettings:
    coordinates = [c.name for c in robot.coordinates]
    muscles = [muscle.name for muscle in robot.muscles]
    settings = ControllerSettings(
        type=table.choice("type", "controller type", _CONTROLLERS, "joint_space"),
        kp=table.by_name("kp", "coordinate", coordinates),
        kd=table.by_name("kd", "coordinate", coordinates),
        period=table.positive("period", run.step),
        solver=table.text("solver", DEFAULT_SOLVER),
        weights=table.by_name("weights", "muscle", muscles, 1.0),
    )
    table.close()
    for key, values in (("kp", settings.kp), ("kd", settings.kd)):
        for name, value in zip(coordinates, values, strict=True):
            if value < 0:
                raise table.error(key, f"must not be negative: {value!r} of {name}")
    if min(settings.weights) <= 0:
        raise table.error("weights", "must be above 0")
    try:
        require_solver(settings.solver)
    except UnknownNameError as error:
        raise table.unknown("solver", "QP solver", settings.solver, error.known) from None
    _multiple(table, "period", settings.period, run.step, "run.step")
    return settings


def _wiring(table: Table) -> dict[str, str]:
    """Connections by full port names; the master checks that they exist."""
    wiring: dict[str, str] = {}
    for model in ("plant", "controller"):
        inputs = table.table(model)
        for name in table.value(model, {}):
            wiring[f"{model}.{name}"] = inputs.text(name)
    table.close()
    return wiring


def _multiple(
    table: Table, name: str, time: float, step: float, what: str, *, key: str | None = None
) -> None:
    """Refuse a time that is no whole multiple of a step, and more steps than memory has rows."""
    try:
        steps = whole_steps(time, step, what)
    except InputError as error:
        raise InputError(error.what, file=table.file, key=key or table.key(name)) from None
    if steps > 10_000_000 or not math.isfinite(time):
        raise table.error(name, f"{steps} steps are more than a run can hold (10 million)")
