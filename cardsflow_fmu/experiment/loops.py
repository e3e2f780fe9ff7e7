"""Coordinates without a reference: closed loops or springs determine their motion."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, Robot
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.dynamics.independent import control_dynamics, dependent_coordinates


def with_dependent(data: Mapping[str, Any], robot: Robot, file: Path) -> Mapping[str, Any]:
    """Set controller.dependent for every coordinate of a robot with closed loops.

    Raises:
        InputError: No coordinate is independent, or the engine does not support loops.
    """
    controller = data.get("controller")
    flags_given = controller.get("dependent", {}) if isinstance(controller, Mapping) else None
    if not (isinstance(controller, Mapping) and isinstance(flags_given, Mapping)):
        return data  # invalid; the reader of the whole file reports it
    names, flags = [c.name for c in robot.coordinates], flags_given
    flags_given = {n: value for n, value in flags.items() if n in names and isinstance(value, bool)}
    if not robot.loops:
        for name in (name for name, value in flags_given.items() if value):
            problem = f"{name} is not part of a closed loop"
            raise InputError(problem, file=file, key=f"controller.dependent.{name}")
        return data
    if controller.get("engine") == "dart":
        problem = f"joint {robot.loops[0].name!r} closes a loop, which requires engine = 'core'"
        raise InputError(problem, file=file, key="controller.engine")
    try:
        chosen = dependent_coordinates(
            robot,
            [name for name, value in flags_given.items() if value],
            [name for name, value in flags_given.items() if not value],
        )
    except InputError as error:
        error.file, error.key = file, "controller.dependent"
        raise
    flags = {**flags, **dict(zip(names, chosen, strict=True))}
    return {**data, "controller": {**controller, "dependent": flags}}


def closing_dynamics(data: Mapping[str, Any], robot: Robot) -> CoreDynamics | None:
    """Return dynamics for closing the loops of poses; None for a robot without loops."""
    flags = data["controller"].get("dependent", {})
    if not robot.loops or not isinstance(flags, Mapping):
        return None
    chosen = [flags.get(c.name) is True for c in robot.coordinates]
    return control_dynamics(robot, chosen, may_be_singular=True)


def with_resting_points(data: Mapping[str, Any], robot: Robot) -> Any:
    """Return the reference with positions for coordinates that its points may omit."""
    reference, controller = data.get("reference", {}), data["controller"]
    points = reference.get("points") if isinstance(reference, Mapping) else None
    free = [controller.get(key) for key in ("passive", "dependent")]
    tables = [table for table in free if isinstance(table, Mapping)]
    if not tables or not isinstance(points, list):
        return reference
    resting = {name for table in tables for name, value in table.items() if value is True}
    rest = {c.name: c.initial for c in robot.coordinates if c.name in resting}
    filled = [
        {**point, "q": rest | point["q"]}
        if isinstance(point, Mapping) and isinstance(point.get("q"), Mapping)
        else point
        for point in points
    ]
    return {**reference, "points": filled}
