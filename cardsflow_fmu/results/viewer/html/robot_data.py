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
from cardsflow_fmu.results.viewer.scene import colours, shapes
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
    signals = dict(zip(coordinate_signals("q", stage.robot), stage.motion.q.T, strict=True))
    if stage.motion.tensions is not None:
        names = muscle_signals("tension", stage.robot)
        signals |= dict(zip(names, stage.motion.tensions.T, strict=True))
    return {**signals, **act.signals}


def _muscles(robot: Robot) -> list[dict[str, Any]]:
    signals = (muscle_signals(prefix, robot) for prefix in ("l", "tension", "f", "u"))
    return [
        {
            "name": muscle.name,
            "f_min": muscle.f_min,
            "f_max": muscle.f_max,
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


def links_of_shapes(robot: Robot, stage: Stage) -> Iterator[tuple[str, str]]:
    """Yield the name of each shape that moves with a link, and the link."""
    children = {joint.name: joint.child for joint in robot.joints}
    parts = {
        shapes.WRAP_SURFACES: {s.name: s.link for s in robot.wrap_surfaces},
        shapes.VIA_POINTS: {
            f"{muscle.name}/{v}": point.link
            for muscle in robot.muscles
            for v, point in enumerate(muscle.via_points)
        },
        shapes.LINK_FRAMES: {link.name: link.name for link in robot.links},
        shapes.JOINT_FRAMES: children,
        shapes.JOINT_VALUES: {c.name: j.child for j in robot.joints for c in j.coordinates},
        shapes.LINKS: {f"joint {name}": child for name, child in children.items()},
    }
    names = [link.name for link in robot.links]
    for shape in stage.scene(0):
        link = parts.get(shape.group, {}).get(shape.key)
        if link is None and shape.group == shapes.LINKS:
            link = shape.key.rpartition("/")[0]
        if link in names:
            yield shape.name, link
