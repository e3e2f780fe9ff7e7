"""Reference, initial state, and gains along the reference of an experiment."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.checks.plausible import is_in_degrees
from addin_sdfusion.robot.formats.read import read_trajectory, trajectories_file
from addin_sdfusion.robot.model.trajectory import Space, Trajectory, TrajectoryPoint
from cardsflow_fmu.experiment.config.names import Names
from cardsflow_fmu.experiment.config.table import Context
from sim_dart.dynamics.core import CoreDynamics

from .motion.feedback import MotionFeedback, gains_file, read_feedback, require_same_motion
from .packed_files import require_packable
from .recorded_motion import motion_of_rows, read_motion
from .settings.controller import ControllerSettings
from .settings.plant import StartSettings
from .settings.reference import FlowerSettings, ReferenceSettings, ReferenceTable

OPTIMISED_MOTION = "motion.csv"
"""Default name of the file of an optimal motion."""

_REACHABLE = 1e-3  # tolerance of a reference at the edge of the workspace, in [m] or [rad]


def read_reference(
    data: Mapping[str, Any],
    start: Mapping[str, Any],
    space: Space,
    context: Context,
    robot_path: Path,
    robot: Robot,
    in_file: Sequence[str] = (),
    dynamics: CoreDynamics | None = None,
    *,
    has_free_start: bool = False,
) -> tuple[StartSettings, ReferenceSettings]:
    """Read the initial state and the reference.

    Args:
        data: The table [reference].
        space: Space that the controller controls.
        context: File and names, for messages.
        in_file: Names of all coordinates in the robot file, including locked ones.
        dynamics: Dynamics that close the loops of the start pose; None without loops.
        has_free_start: Whether an optimal motion chooses its start.
    """
    table = ReferenceTable.read(data, context, "reference")
    if table.type is not None:
        if has_free_start and table.type == "optimised":
            start = _start_in_file(table, context)
        return _start_of_motion(table, start, space, context, robot, dynamics)
    curve = _read_curve(table, space, context, robot_path, in_file, robot)
    space = curve.space if isinstance(curve, Trajectory) else "operational"
    first, approach = _first_point(curve), table.approach
    if approach is None:
        return _read_start(
            start, context, robot, curve, first, dynamics=dynamics
        ), ReferenceSettings(space, curve)
    if approach.start is not None:
        size = len(_names(space, context).names)
        if len(approach.start) != size:
            problem = f"must be a list of {size} numbers, not {list(approach.start)!r}"
            raise context.error("reference.approach.start", problem)
        settings = _read_start(
            start, context, robot, curve, approach.start, at_rest=True, dynamics=dynamics
        )
    else:
        settings = _read_start(start, context, robot, curve, None, dynamics=dynamics)
        begin = settings.q if space == "joint" else _task_position(robot, settings.q)
        approach = approach.copy_with(start=begin)
    if space == "operational":
        with context.at("reference"):
            _inverse_kinematics(robot, first, settings.q, tolerance=_REACHABLE)
    return settings, ReferenceSettings(space, curve, approach)


def _start_of_motion(
    table: ReferenceTable,
    data: Mapping[str, Any],
    space: Space,
    context: Context,
    robot: Robot,
    dynamics: CoreDynamics | None,
) -> tuple[StartSettings, ReferenceSettings]:
    """Return the start, and a rest at the start or the optimal motion from there."""
    start = _read_start(data, context, robot, None, None, dynamics=dynamics)
    first = start.q if space == "joint" else _task_position(robot, start.q)
    if table.type == "rest":
        points = TrajectoryPoint(0.0, first), TrajectoryPoint(1.0, first)
        return start, ReferenceSettings(space, Trajectory("rest", "linear", points, 1.0, space))
    file = optimised_file(table, context)
    command = f"`cardsflow optimise {shlex.quote(str(context.file))}`"
    with context.at("reference.file"):
        if not file.is_file():
            raise InputError(f"{file} does not exist; compute it: {command}")
        motion = read_motion(file, {space: _names(space, context)}, None)
        if not np.allclose(motion.points[0].q, first, rtol=0.0, atol=_REACHABLE):
            problem = f"{file.name} begins at another pose than [start]"
            raise InputError(f"{problem}; compute it again: {command}")
    return start, ReferenceSettings(space, motion)


def _start_in_file(table: ReferenceTable, context: Context) -> dict[str, Any]:
    """Return the first state of an optimal motion as the table [start]."""
    file = optimised_file(table, context)
    if not file.is_file():
        return {}
    assert context.names is not None
    with context.at("reference.file"):
        motion = read_motion(file, {"joint": context.names["coordinate"]}, None)
    first = motion.points[0]
    return {"q": list(first.q), "qd": list(first.qd)} if first.qd else {"q": list(first.q)}


def optimised_file(table: ReferenceTable, context: Context) -> Path:
    """Return the file of the optimal motion of an experiment (default: next to it)."""
    return context.file.parent / OPTIMISED_MOTION if table.file is None else table.file


def read_controller_gains(
    controller: ControllerSettings,
    table: ReferenceTable | None,
    reference: ReferenceSettings,
    context: Context,
    robot: Robot,
    roots: tuple[Path, ...],
) -> tuple[ControllerSettings, MotionFeedback | None]:
    """Read the forces and gains of a controller along an optimal motion.

    Args:
        table: The table [reference]; with the type "rest", the motion does not exist yet.
        context: File and names, for messages.
        roots: Folders of files that may be packed.

    Returns:
        The controller with the file of its gains, and their content; None if it does not use them.
    """
    if not controller.uses_gains or (table is not None and table.type == "rest"):
        return controller, None
    key, file = "controller.gains", controller.gains
    if file is None:
        if table is None or table.type != "optimised":
            raise context.error(key, 'missing; set it, or set reference.type = "optimised"')
        file = gains_file(optimised_file(table, context))
    else:
        require_packable(file, roots, key)
    with context.at(key):
        feedback = read_feedback(file, robot, context.file)
        curve, first = reference.curve, None
        if reference.space == "joint" and isinstance(curve, Trajectory):
            first = np.array(curve.points[0].q)
        require_same_motion(feedback, controller.period, first, reference.duration)
    return controller.copy_with(gains=file), feedback


def _names(space: Space, context: Context) -> Names:
    assert context.names is not None
    return context.names["coordinate" if space == "joint" else "task coordinate"]


def _first_point(curve: Trajectory | FlowerSettings) -> tuple[float, ...]:
    if isinstance(curve, Trajectory):
        return curve.points[0].q
    return tuple(c + curve.radius * u for c, u in zip(curve.centre, curve.axes[0], strict=True))


def _read_curve(
    table: ReferenceTable,
    space: Space,
    context: Context,
    robot_path: Path,
    in_file: Sequence[str],
    robot: Robot,
) -> Trajectory | FlowerSettings:
    if table.points is not None:
        return table.trajectory_of_points()
    if table.is_recorded:
        return _recorded_motion(table, space, context, robot)
    if table.flower is None:
        return _named_trajectory(table, space, context, robot_path, in_file)
    names = _names("operational", context).names
    if len(names) != 3 or any(not name.endswith(f".{a}") for name, a in zip(names, "xyz")):  # noqa: B905
        problem = "requires an end-effector point with axes x, y, z, not "
        raise context.error("reference.flower.centre", problem + (", ".join(names) or "none"))
    return table.flower


def _recorded_motion(
    table: ReferenceTable, space: Space, context: Context, robot: Robot
) -> Trajectory:
    other: Space = "operational" if space == "joint" else "joint"
    spaces = {each: _names(each, context) for each in (space, other)}
    if table.samples is None:
        with context.at("reference.file"):
            lengths = [c.name for c in robot.coordinates if c.unit == "m"]
            return read_motion(table.file, spaces, table.noise, lengths)
    with context.at("reference.samples"):
        return motion_of_rows(table.samples, spaces, table.noise)


def _named_trajectory(
    table: ReferenceTable, space: Space, context: Context, robot_path: Path, in_file: Sequence[str]
) -> Trajectory:
    name, file, key = table.trajectory, table.file, "reference.trajectory"
    if file is None:
        file = trajectories_file(robot_path)
        if file is None:
            problem = f"missing; there is no trajectories file in the folder of {robot_path}"
            raise context.error("reference.file", problem)
    try:
        trajectory = read_trajectory(file, name, space)
    except UnknownNameError as error:
        context.require(key, "trajectory", name, error.known)
        raise
    size, rows = len(trajectory.points[0].q), _names(trajectory.space, context)
    if trajectory.space == "joint" and size == len(in_file):
        return _select_coordinates(trajectory, [in_file.index(name) for name in rows.names])
    if size != len(rows.names):
        problem = f"{name!r} moves {size} {rows.kind}s, the robot has {len(rows.names)}"
        raise context.error(key, problem)
    return trajectory


def _select_coordinates(trajectory: Trajectory, left: Sequence[int]) -> Trajectory:
    """Return the trajectory without locked coordinates."""

    def of(row: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(row[k] for k in left) if row else row

    points = tuple(
        replace(point, q=of(point.q), qd=of(point.qd), qdd=of(point.qdd))
        for point in trajectory.points
    )
    return replace(trajectory, points=points)


def _read_start(
    data: Mapping[str, Any],
    context: Context,
    robot: Robot,
    curve: Trajectory | FlowerSettings | None,
    begin: tuple[float, ...] | None,
    *,
    at_rest: bool = False,
    dynamics: CoreDynamics | None = None,
) -> StartSettings:
    """Return the initial state (default: first point of the reference)."""
    initial = tuple(c.initial for c in robot.coordinates)
    rest = (0.0,) * len(initial)
    if begin is not None and isinstance(curve, Trajectory) and curve.space == "joint":
        rates = rest if at_rest else curve.points[0].qd or rest
        start = StartSettings.read(
            data, replace(context, defaults={"q": begin, "qd": rates}), "start"
        )
        for error in start.inapplicable_keys(["q", "qd"]):
            error.file, error.key = context.file, f"start.{error.key}"
            raise error
        q = start.q
    else:
        defaults = {"q": initial, "seed": initial}
        start = StartSettings.read(data, replace(context, defaults=defaults), "start")
        q, y = start.q, start.y or begin
        if "q" not in data and y is not None:
            with context.at("start.y" if start.y else "start.q"):
                q = _inverse_kinematics(robot, y, start.seed)
    if dynamics is not None:
        with context.at("start.q"):
            q = tuple(dynamics.closed(q).tolist())
    for coordinate, value in zip(robot.coordinates, q, strict=True):
        if not coordinate.lower <= value <= coordinate.upper:
            limits = f"{coordinate.lower!r} to {coordinate.upper!r}"
            problem = f"must be within the joint limits {limits}, not {value!r}"
            problem += "; is it in degrees?" if is_in_degrees(coordinate, value) else ""
            raise context.error(f"start.q.{coordinate.name}", problem)
    return StartSettings(q=q, qd=start.qd)


def _inverse_kinematics(
    robot: Robot, y: tuple[float, ...], seed: tuple[float, ...], **settings: Any
) -> tuple[float, ...]:
    from controllers.analysis.kinematics import inverse_kinematics
    from sim_dart import control_dynamics

    solution = inverse_kinematics(control_dynamics(robot), np.array(y), np.array(seed), **settings)
    return tuple(solution.q.tolist())


def _task_position(robot: Robot, q: tuple[float, ...]) -> tuple[float, ...]:
    from sim_dart import control_dynamics

    return tuple(control_dynamics(robot).task_position(np.array(q)).tolist())
