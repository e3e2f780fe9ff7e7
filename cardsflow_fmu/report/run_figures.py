"""The figures that a run writes: tracking, path, world."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from addin_sdfusion.robot.model.tension_laws import law_of
from cardsflow_fmu.results.run_data import ExperimentRunData
from cardsflow_fmu.results.summary import present
from cardsflow_fmu.signals.muscles import (
    command_signals,
    driven_muscles,
    modelled_muscles,
    tension_signals,
)
from cardsflow_fmu.signals.ports import Followed, followed_signals, muscle_signals

from .downsample import downsample, every_few
from .figures import STYLE, image

TRACKING, PATH, WORLD = "tracking", "path", "world"


def run_images(result: ExperimentRunData) -> dict[str, bytes]:
    """The figures of a run as PNG and SVG files, by name."""
    images = _images(TRACKING, tracking_figure(result))
    if _point(result) is not None:
        images |= _images(PATH, path_figure(result))
    if _objects(result) or _contacts(result):
        images |= _images(WORLD, world_figure(result))
    return images


def tracking_figure(result: ExperimentRunData) -> Figure:
    """Force commands, and positions against the dotted reference: the paper's figures 10 and 12.

    Of muscles with laws, their commands and their tensions, with dots where these were to be.
    """
    groups = _commands(result)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.0, 5.6 + 2.2 * len(groups)), layout="constrained")
        forces, *commands, positions = figure.subplots(2 + len(groups), 1, sharex=True)
        _draw_forces(forces, result)
        for axes, (label, names) in zip(commands, groups.items(), strict=True):
            _draw_commands(axes, result, label, names)
        _draw_positions(positions, result)
        positions.set_xlabel("time [s]")
        _mark_incomplete(figure, result)
    return figure


def world_figure(result: ExperimentRunData) -> Figure:
    """How far each object went along x, y and z, and the size of each contact force.

    Args:
        result: A run with at least one row, with an object or a contact force.
    """
    objects, contacts = _objects(result), _contacts(result)
    rows = [part for part in (objects, contacts) if part]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.0, 0.6 + 2.5 * len(rows)), layout="constrained")
        places = list(np.atleast_1d(figure.subplots(len(rows), 1, sharex=True)))
        places[-1].set_xlabel("time [s]")
        if objects:
            _draw_displacements(places.pop(0), result, objects)
        if contacts:
            _draw_contacts(places.pop(0), result, contacts)
        _mark_incomplete(figure, result)
    return figure


def path_figure(result: ExperimentRunData) -> Figure:
    """The path of the first task point in space, against the dotted reference.

    Args:
        result: A run with at least one row, of a robot with a task point of x, y and z.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.8, 5.2))
        # no layout engine knows how far the labels of a 3-D axis reach
        axes: Any = figure.add_axes((0.02, 0.06, 0.84, 0.9), projection="3d")
        followed = _point(result)
        assert followed is not None
        rows = every_few(len(result.rows))
        axes.plot(*result.columns(followed.actual)[rows].T, label="path", linewidth=1.2)
        axes.plot(*result.columns(followed.desired)[rows].T, ":", color="black", label="reference")
        for axis, name in zip("xyz", followed.actual, strict=True):
            getattr(axes, f"set_{axis}label")(f"{name} [m]")
        axes.set_aspect("equal", adjustable="datalim")
        axes.legend(loc="upper left", frameon=False)
        _mark_incomplete(figure, result)
    return figure


def _images(name: str, figure: Figure) -> dict[str, bytes]:
    return {f"{name}.{form}": image(figure, form, mark=None) for form in ("png", "svg")}


def _followed(result: ExperimentRunData) -> Followed:
    """The positions that are followed, as far as the run recorded them."""
    experiment = result.experiment
    followed = followed_signals(experiment.robot, experiment.reference.space)
    return present(followed, result.names)


def _point(result: ExperimentRunData) -> Followed | None:
    """The first task point that is followed with all its coordinates; None if there is none."""
    if result.experiment.reference.space == "joint":
        return None
    followed, first = _followed(result), 0
    if len(followed.actual) < sum(len(f.axes) for f in result.experiment.robot.task_frames):
        return None
    for frame in result.experiment.robot.task_frames:
        last = first + len(frame.axes)
        if frame.axes == ("x", "y", "z"):
            part = slice(first, last)
            return Followed(
                followed.actual[part],
                followed.desired[part],
                followed.units[part],
                followed.turns[part],
            )
        first = last
    return None


def _mark_incomplete(figure: Figure, result: ExperimentRunData) -> None:
    if not result.complete:
        figure.suptitle("incomplete run")


def _draw_forces(axes: Axes, result: ExperimentRunData) -> None:
    time, robot = result["time"], result.experiment.robot
    desired = dict(zip(tension_signals(robot), muscle_signals("f", robot), strict=True))
    names = [name for name in desired if name in result.names]
    if len(names) > 10:
        axes.set_prop_cycle(color=mpl.colormaps["tab20"].colors)  # type: ignore[attr-defined]
    for name in names:
        (line,) = axes.plot(*downsample(time, result[name]), label=name, linewidth=1.2)
        if desired[name] != name and desired[name] in result.names:
            axes.plot(
                *downsample(time, result[desired[name]]), ":", color=line.get_color(), linewidth=1.0
            )
    modelled = bool(modelled_muscles(robot))
    if modelled:
        axes.plot([], [], ":", color="black", label="desired")
    axes.set_ylabel("tension [N]" if modelled else "force command [N]")
    _legend(axes)


def _commands(result: ExperimentRunData) -> dict[str, list[str]]:
    """The recorded commands of muscles with laws, by what they are."""
    robot = result.experiment.robot
    groups: dict[str, list[str]] = {}
    for name, k in zip(command_signals(robot), driven_muscles(robot), strict=True):
        command = law_of(robot.muscles[k].model).command
        if command is not None and name in result.names:
            unit = f" [{command.unit}]" if command.unit != "1" else ""
            groups.setdefault(f"{command.name.replace('_', ' ')}{unit}", []).append(name)
    return groups


def _draw_commands(axes: Axes, result: ExperimentRunData, label: str, names: list[str]) -> None:
    for name in names:
        axes.plot(*downsample(result["time"], result[name]), label=name, linewidth=1.2)
    axes.set_ylabel(label)
    _legend(axes)


def _draw_positions(axes: Axes, result: ExperimentRunData) -> None:
    time, followed = result["time"], _followed(result)
    for name, desired in zip(followed.actual, followed.desired, strict=True):
        (line,) = axes.plot(*downsample(time, result[name]), label=name, linewidth=1.2)
        axes.plot(*downsample(time, result[desired]), ":", color="black", linewidth=1.4)
        line.set_zorder(1)
    axes.plot([], [], ":", color="black", label="reference")
    units = "/".join(dict.fromkeys(followed.units)) or "-"
    what = "joint" if result.experiment.reference.space == "joint" else "task"
    axes.set_ylabel(f"{what} position [{units}]")
    _legend(axes)


def _legend(axes: Axes) -> None:
    count = len(axes.get_lines())
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), ncols=1 + count // 16, frameon=False)


def _objects(result: ExperimentRunData) -> list[str]:
    """Names of the objects that are recorded: `object.<name>`."""
    return _groups(result, "object", "x")


def _contacts(result: ExperimentRunData) -> list[str]:
    """Names of the bodies whose contact forces are recorded: `contact.<name>`."""
    return _groups(result, "contact", "fx")


def _groups(result: ExperimentRunData, prefix: str, axis: str) -> list[str]:
    ending = f".{axis}"
    named = [n for n in result.names if n.startswith(f"{prefix}.") and n.endswith(ending)]
    return [name.removesuffix(ending) for name in named]


def _draw_displacements(axes: Axes, result: ExperimentRunData, objects: Sequence[str]) -> None:
    for name in objects:
        for axis in "xyz":
            position = result[f"{name}.{axis}"]
            axes.plot(result["time"], position - position[0], label=f"{name}.{axis}", linewidth=1.2)
    axes.set_ylabel("displacement of objects [m]")
    axes.legend(loc="upper left", fontsize=7, ncols=3)


def _draw_contacts(axes: Axes, result: ExperimentRunData, contacts: Sequence[str]) -> None:
    for name in contacts:
        force = np.linalg.norm([result[f"{name}.f{axis}"] for axis in "xyz"], axis=0)
        axes.plot(result["time"], force, label=name, linewidth=1.2)
    axes.set_ylabel("size of contact force [N]")
    axes.legend(loc="upper left", fontsize=7, ncols=3)
