"""Reading [controller]: which law, its gains and weights, and what stands around it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, cast, get_args

from addin_sdfusion.robot import Robot, UnknownNameError
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.config.table import Table
from cardsflow_fmu.signals.ports import task_names
from controllers.laws.operational_space import LIMIT_BANDWIDTH
from controllers.qp.solver import DEFAULT_SOLVER, require_solver

from .controller_types import TYPES, ControlType
from .experiment import (
    ControllerSettings,
    Engine,
    PostureSettings,
    ReferenceSettings,
    RunSettings,
    StartSettings,
    TaskSettings,
)
from .schema import EXACT

_INFINITY = -1.0  # in tables, which hold finite numbers only
_POSTURE_KP, _POSTURE_KD = 25.0, 10.0


def followed_space(table: Table) -> Space:
    """What the controller is going to follow, before the rest of its table can be read."""
    type_ = TYPES.get(str(table.value("type", None)))
    return "joint" if type_ is None else type_.space


def read_controller(
    table: Table,
    robot: Robot,
    run: RunSettings,
    reference: ReferenceSettings,
    start: StartSettings,
) -> ControllerSettings:
    """The controller's settings.

    Args:
        table: The table [controller].
        robot: The robot, with its operational space.
        run: The co-simulation.
        reference: What the controller is to follow.
        start: Where the robot begins.

    Raises:
        InputError: Something in it is wrong.
    """
    fitting = [name for name, known in TYPES.items() if known.space == reference.space]
    type_ = table.choice("type", "controller type", list(TYPES), fitting[0])
    if type_ not in fitting:
        what = f"{type_!r} does not follow a reference in {reference.space} space"
        raise table.error("type", f"{what}; use {' or '.join(map(repr, fitting))}")
    kind, names, groups = _followed(robot, reference.space)
    muscles = [muscle.name for muscle in robot.muscles]
    operational = reference.space == "operational"
    settings = ControllerSettings(
        type=type_,
        kp=table.by_name("kp", kind, names, groups=groups),
        kd=table.by_name("kd", kind, names, groups=groups),
        period=table.positive("period", run.step),
        solver=_solver(table),
        weights=table.by_name("weights", "muscle", muscles, TYPES[type_].force_weight),
        ki=table.by_name("ki", kind, names, 0.0, groups),
        observer=table.number("observer", 0.0),
        delay=table.whole("delay", 0),
        predict=table.flag("predict", True),
        tasks=_tasks(table, robot, start, TYPES[type_]) if operational else None,
        muscle_horizon=table.number("muscle_horizon", 0.0),
        engine=cast(Engine, table.choice("engine", "engine", get_args(Engine), "auto")),
    )
    table.close()
    _check(table, settings, names)
    table.multiple("period", settings.period, run.step, "run.step")
    return settings


def _followed(robot: Robot, space: Space) -> tuple[str, Sequence[str], Mapping[str, Sequence[str]]]:
    """What gains are given for: kind, names, and groups of names."""
    if space == "joint":
        return "coordinate", [c.name for c in robot.coordinates], {}
    groups = {f.name: [f"{f.name}.{axis}" for axis in f.axes] for f in robot.task_frames}
    return "task coordinate", task_names(robot), groups


def _solver(table: Table) -> str:
    name = table.text("solver", DEFAULT_SOLVER)
    try:
        return require_solver(name)
    except UnknownNameError as error:
        raise table.unknown("solver", "QP solver", name, error.known) from None


def _tasks(table: Table, robot: Robot, start: StartSettings, type_: ControlType) -> TaskSettings:
    kind, names, groups = _followed(robot, "operational")
    coordinates = [c.name for c in robot.coordinates]
    muscles = [muscle.name for muscle in robot.muscles]
    return TaskSettings(
        posture=_posture(table, coordinates, start),
        task_weights=_task_weights(table, kind, names, groups, type_.task_weight),
        priorities=table.by_name("priorities", kind, names, 1.0, groups),
        acceleration_weights=table.by_name("acceleration_weights", "coordinate", coordinates, 1.0),
        force_rate_weights=table.by_name("force_rate_weights", "muscle", muscles, 0.0),
        pretension=table.by_name("pretension", "muscle", muscles, 0.0),
        limit_bandwidth=_limit_bandwidth(table),
    )


def _posture(
    table: Table, coordinates: Sequence[str], start: StartSettings
) -> PostureSettings | None:
    """Where `posture` is false, the paper's literal eq. (4); else a spring to the start pose."""
    if table.value("posture", {}) is False:
        return None
    posture = table.table("posture")
    settings = PostureSettings(
        kp=posture.by_name("kp", "coordinate", coordinates, _POSTURE_KP),
        kd=posture.by_name("kd", "coordinate", coordinates, _POSTURE_KD),
        q0=posture.by_name("q0", "coordinate", coordinates, start.q),
    )
    posture.close()
    for key in ("kp", "kd"):
        _not_negative(posture, key, getattr(settings, key), coordinates)
    return settings


def _task_weights(
    table: Table,
    kind: str,
    names: Sequence[str],
    groups: Mapping[str, Sequence[str]],
    default: float | None,
) -> tuple[float, ...]:
    """W; the word `exact` stands for infinity."""
    key, usual = "task_weights", _INFINITY if default is None else default
    numbers = {key: _without_exact(table, key, table.value(key, usual))}
    given = Table(numbers, table.file, table.path)
    weights = given.by_name(key, kind, names, usual, groups)
    return tuple(math.inf if w == _INFINITY else w for w in weights)


def _without_exact(table: Table, key: str, given: Any) -> Any:
    """The same with a number for every `exact`; weights that are not above 0 are refused."""
    if isinstance(given, dict):
        return {name: _without_exact(table, key, value) for name, value in given.items()}
    if isinstance(given, list):
        return [_without_exact(table, key, value) for value in given]
    if key in table and isinstance(given, (int, float)) and given <= 0:
        raise table.error(key, f"must be above 0, or {EXACT!r}: {given!r}")
    return _INFINITY if given == EXACT else given


def _limit_bandwidth(table: Table) -> float | None:
    if table.value("limit_bandwidth", LIMIT_BANDWIDTH) is False:
        return None
    return table.positive("limit_bandwidth", LIMIT_BANDWIDTH)


def _check(table: Table, settings: ControllerSettings, names: Sequence[str]) -> None:
    for name, value in zip(names, settings.kp, strict=True):
        if value <= 0:
            raise table.error("kp", f"must be above 0: {value!r} of {name}")
    for key in ("kd", "ki"):
        _not_negative(table, key, getattr(settings, key), names)
    if min(settings.weights) <= 0:
        raise table.error("weights", "must be above 0")
    if settings.observer < 0:
        raise table.error("observer", f"must not be negative: {settings.observer!r}")
    if settings.muscle_horizon < 0:
        what = f"must not be negative: {settings.muscle_horizon!r}"
        raise table.error("muscle_horizon", what)
    if settings.delay not in (0, 1):
        raise table.error("delay", f"must be 0 or 1 periods, not {settings.delay}")
    tasks = settings.tasks
    if tasks is None:
        return
    if min(tasks.priorities) < 1 or any(p != int(p) for p in tasks.priorities):
        raise table.error("priorities", f"must be whole numbers from 1 on: {tasks.priorities}")
    if min(tasks.acceleration_weights) <= 0:
        raise table.error("acceleration_weights", "must be above 0")
    for key in ("force_rate_weights", "pretension"):
        if min(getattr(tasks, key)) < 0:
            raise table.error(key, "must not be negative")


def _not_negative(table: Table, key: str, values: Sequence[float], names: Sequence[str]) -> None:
    for name, value in zip(names, values, strict=True):
        if value < 0:
            raise table.error(key, f"must not be negative: {value!r} of {name}")
