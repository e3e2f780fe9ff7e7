"""Figures of a run: tracking, path, world."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from addin_sdfusion.robot.model.muscle_laws import law_of
from cardsflow_fmu.cosim.signals.muscles import (
    command_signals,
    driven_muscles,
    tension_signals,
)
from cardsflow_fmu.cosim.signals.ports import identifier, muscle_signals
from cardsflow_fmu.cosim.signals.tracked_signals import TrackedSignal, tracked_signals_by_name
from cardsflow_fmu.results.run_data import ExperimentRunData

from .downsample import evenly_spaced
from .figures import STYLE, figure_of_panels, figure_title, image
from .panels import KINDS, Curve, Panel

TRACKING, PATH, WORLD = "tracking", "path", "world"


def run_images(result: ExperimentRunData) -> dict[str, bytes]:
    """Return the figures of a run as PNG and SVG files, by name."""
    figures = {TRACKING: tracking_figure(result)}
    point = _point(result)
    if point:
        figures[PATH] = _path_figure(result, point)
    world = _world_panels(result)
    if world:
        figures[WORLD] = figure_of_panels(world, title=figure_title(result))
    return {
        f"{name}.{form}": image(figure, form, mark=None)
        for name, figure in figures.items()
        for form in ("png", "svg")
    }


def tracking_figure(result: ExperimentRunData) -> Figure:
    """Return force commands, and positions with dotted references: figures 10 and 12 of the paper.

    The figure also contains the torques of joint motors. For muscles with muscle laws, it contains
    commands, and tensions with dotted desired tensions.
    """
    panels = [_forces(result), *_commands(result)]
    panels += [*KINDS["torques"](result), *KINDS["tracking"](result)]
    return figure_of_panels([p for p in panels if p.curves], title=figure_title(result))


def _path_figure(result: ExperimentRunData, point: list[TrackedSignal]) -> Figure:
    """Return the path of an end-effector point with its dotted reference."""
    actual, desired = [f.actual for f in point], [f.desired for f in point]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.8, 5.2))
        # layout engines do not support labels of 3-D axes
        axes: Any = figure.add_axes((0.02, 0.06, 0.84, 0.9), projection="3d")
        rows = evenly_spaced(len(result.rows))
        axes.plot(*result.columns(actual)[rows].T, label="path", linewidth=1.2)
        axes.plot(*result.columns(desired)[rows].T, ":", color="black", label="reference")
        for axis, name in zip("xyz", actual, strict=True):
            getattr(axes, f"set_{axis}label")(f"{name} [m]")
        axes.set_aspect("equal", adjustable="datalim")
        axes.legend(loc="upper left", frameon=False)
        figure.suptitle(figure_title(result))
    return figure


def _point(result: ExperimentRunData) -> list[TrackedSignal]:
    """Return the signals of the first controlled point with x, y and z; empty if there is none."""
    followed = tracked_signals_by_name(result.names, result.units)
    for frame in result.experiment.robot.task_frames:
        prefix = f"y.{identifier(frame.name)}."
        point = [signal for signal in followed if signal.actual.startswith(prefix)]
        if frame.axes == ("x", "y", "z") and len(point) == 3:
            return point
    return []


def _forces(result: ExperimentRunData) -> Panel:
    """Return muscle tensions, and desired tensions of muscles with muscle laws."""
    time, robot = result["time"], result.experiment.robot
    desired = dict(
        zip(tension_signals(robot, result.names), muscle_signals("f", robot), strict=True)
    )
    names = [name for name in desired if name in result.names]
    curves = [Curve(name, time, result[name]) for name in names]
    curves += [
        Curve(desired[name], time, result[desired[name]], of=name)
        for name in names
        if desired[name] != name and desired[name] in result.names
    ]
    is_command = list(desired) == list(desired.values())
    return Panel("force command [N]" if is_command else "tension [N]", curves)


def _commands(result: ExperimentRunData) -> list[Panel]:
    """Return recorded commands of muscles with muscle laws, one panel per kind."""
    robot = result.experiment.robot
    groups: dict[str, list[Curve]] = {}
    for name, k in zip(command_signals(robot), driven_muscles(robot), strict=True):
        command = law_of(robot.muscles[k].model).command
        if command is not None and name in result.names:
            unit = f" [{command.unit}]" if command.unit != "1" else ""
            label = f"{command.name.replace('_', ' ')}{unit}"
            groups.setdefault(label, []).append(Curve(name, result["time"], result[name]))
    return [Panel(label, curves) for label, curves in groups.items()]


def _world_panels(result: ExperimentRunData) -> list[Panel]:
    """Return displacements of objects along x, y, z, and magnitudes of contact forces."""
    time = result["time"]
    displacements = [
        Curve(name, time, result[name] - result[name][0])
        for item in _bodies(result, "object", "x")
        for name in (f"{item}.{axis}" for axis in "xyz")
    ]
    forces = [
        Curve(body, time, np.linalg.norm([result[f"{body}.f{axis}"] for axis in "xyz"], axis=0))
        for body in _bodies(result, "contact", "fx")
    ]
    panels = [
        Panel("displacement of objects [m]", displacements),
        Panel("contact force [N]", forces),
    ]
    return [panel for panel in panels if panel.curves]


def _bodies(result: ExperimentRunData, prefix: str, axis: str) -> list[str]:
    """Return the names of recorded objects or bodies."""
    ending = f".{axis}"
    named = [n for n in result.names if n.startswith(f"{prefix}.") and n.endswith(ending)]
    return [name.removesuffix(ending) for name in named]
