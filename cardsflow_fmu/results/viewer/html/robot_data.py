"""Names, limits and recorded signals of a robot, for the panels of a page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.ports import (
    coordinate_signals,
    muscle_signals,
    task_names,
    task_signals,
    task_units,
)
from cardsflow_fmu.results.viewer.scene import colours
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.scene.shapes import Colour
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.utils.arrays import FloatArray

from .tables import TableSequence


def robot_data(act: Act, tables: TableSequence) -> dict[str, Any]:
    """Return muscles, joints, tasks, kinds of arrows, and the entries of the signals."""
    stage = act.stage
    return {
        "muscles": _muscles(stage.robot),
        "joints": _joints(stage.robot),
        "tasks": _tasks(stage.robot),
        "arrows": list(_arrows(stage)),
        "signals": {
            name: tables.add(values[:, np.newaxis]) for name, values in _signals(act).items()
        },
    }


def _signals(act: Act) -> dict[str, FloatArray]:
    """Return recorded signals, at least joint positions and tensions, by name."""
    stage = act.stage
    found = dict(zip(coordinate_signals("q", stage.robot), stage.motion.q.T, strict=True))
    if stage.motion.tensions is not None:
        names = muscle_signals("tension", stage.robot)
        found |= dict(zip(names, stage.motion.tensions.T, strict=True))
    return {**found, **act.signals}


def _muscles(robot: Robot) -> list[dict[str, Any]]:
    signals = (muscle_signals(prefix, robot) for prefix in ("l", "tension", "f", "u"))
    return [
        {
            "name": muscle.name,
            "f_min": muscle.f_min,
            "f_max": _finite(muscle.f_max),
            **dict(zip(("length", "tension", "force", "command"), names, strict=True)),
        }
        for muscle, *names in zip(robot.muscles, *signals, strict=True)
    ]


def _joints(robot: Robot) -> list[dict[str, Any]]:
    signals = zip(coordinate_signals("q", robot), coordinate_signals("q_d", robot), strict=True)
    return [
        {"name": c.name, "unit": c.unit, "actual": actual, "desired": desired}
        for c, (actual, desired) in zip(robot.coordinates, signals, strict=True)
    ]


def _tasks(robot: Robot) -> list[dict[str, Any]]:
    rows = zip(
        task_names(robot),
        task_units(robot),
        task_signals("y", robot),
        task_signals("y_d", robot),
        strict=True,
    )
    return [
        {"name": name, "unit": unit, "actual": actual, "desired": desired}
        for name, unit, actual, desired in rows
    ]


def _arrows(stage: Stage) -> Iterator[dict[str, Any]]:
    """Yield the kinds of arrows with their colours and the values of the longest ones."""
    motion = stage.motion
    if stage.robot.muscles and motion.tensions is not None:
        yield _arrow("muscle force", colours.FORCE, stage.max_tension, "N")
    torques = motion.torques
    if torques is not None and torques.shape[1]:
        for unit, kind, name in (("rad", "motor torque", "N·m"), ("m", "motor force", "N")):
            same = [j for j, motor in enumerate(stage.robot.motors) if motor.unit == unit]
            if same:
                largest = float(np.nanmax(np.abs(torques[:, same]), initial=0.0))
                yield _arrow(kind, colours.MOTOR, largest, name)
    if motion.contacts:
        largest = max(
            float(np.nanmax(np.abs(force), initial=0.0)) for force in motion.contacts.values()
        )
        yield _arrow("contact force", colours.CONTACT, largest, "N")


def _arrow(name: str, colour: Colour, longest: float, unit: str) -> dict[str, Any]:
    return {"name": name, "colour": list(colour), "longest": longest, "unit": unit}


def _finite(value: float) -> float | None:
    """Return a number, or None if it is infinite, because JSON has no infinity."""
    return value if np.isfinite(value) else None
