"""Figures of a run, by matplotlib without a display."""

from __future__ import annotations

import io
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .envelope import envelope, every_few
from .ports import Followed, followed_signals, muscle_signals
from .results import Result
from .summary import present

TRACKING, PATH = "tracking", "path"

# Text stays text in an SVG, and equal results give equal files.
_STYLE: Any = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "svg.fonttype": "none",
    "svg.hashsalt": "cardsflow",
}


def run_images(result: Result) -> dict[str, bytes]:
    """The figures of a run as PNG and SVG files, by name.

    Args:
        result: A run with at least one row.
    """
    images = _images(TRACKING, tracking_figure(result))
    if _point(result) is not None:
        images |= _images(PATH, path_figure(result))
    return images


def tracking_figure(result: Result) -> Figure:
    """Force commands, and positions against the dotted reference: the paper's figures 10 and 12.

    Args:
        result: A run with at least one row.
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(7.0, 5.6), layout="constrained")
        forces, positions = figure.subplots(2, 1, sharex=True)
        _draw_forces(forces, result)
        _draw_positions(positions, result)
        positions.set_xlabel("time [s]")
        _mark_incomplete(figure, result)
    return figure


def path_figure(result: Result) -> Figure:
    """The way of the first task point in space, against the dotted reference.

    Args:
        result: A run with at least one row, of a robot with a task point of x, y and z.
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(5.8, 5.2))
        # no layout engine knows how far the labels of a 3-D axis reach
        axes: Any = figure.add_axes((0.02, 0.06, 0.84, 0.9), projection="3d")
        followed = _point(result)
        assert followed is not None
        rows = every_few(len(result.rows))
        axes.plot(*result.columns(followed.actual)[rows].T, label="way", linewidth=1.2)
        axes.plot(*result.columns(followed.desired)[rows].T, ":", color="black", label="reference")
        for axis, name in zip("xyz", followed.actual, strict=True):
            getattr(axes, f"set_{axis}label")(f"{name} [m]")
        axes.set_aspect("equal", adjustable="datalim")
        axes.legend(loc="upper left", frameon=False)
        _mark_incomplete(figure, result)
    return figure


def _images(name: str, figure: Figure) -> dict[str, bytes]:
    images: dict[str, bytes] = {}
    with mpl.rc_context(_STYLE):
        for kind, metadata in (("png", {"Software": None}), ("svg", {"Date": None})):
            memory = io.BytesIO()
            figure.savefig(memory, format=kind, dpi=150, metadata=metadata)
            images[f"{name}.{kind}"] = memory.getvalue()
    return images


def _followed(result: Result) -> Followed:
    """The positions that are followed, as far as the run recorded them."""
    experiment = result.experiment
    followed = followed_signals(experiment.robot, experiment.reference.space)
    return present(followed, result.names)


def _point(result: Result) -> Followed | None:
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


def _mark_incomplete(figure: Figure, result: Result) -> None:
    if not result.complete:
        figure.suptitle("incomplete run")


def _draw_forces(axes: Axes, result: Result) -> None:
    time = result["time"]
    names = [n for n in muscle_signals("f", result.experiment.robot) if n in result.names]
    if len(names) > 10:
        axes.set_prop_cycle(color=mpl.colormaps["tab20"].colors)  # type: ignore[attr-defined]
    for name in names:
        axes.plot(*envelope(time, result[name]), label=name, linewidth=1.2)
    axes.set_ylabel("force command [N]")
    _legend(axes)


def _draw_positions(axes: Axes, result: Result) -> None:
    time, followed = result["time"], _followed(result)
    for name, desired in zip(followed.actual, followed.desired, strict=True):
        (line,) = axes.plot(*envelope(time, result[name]), label=name, linewidth=1.2)
        axes.plot(*envelope(time, result[desired]), ":", color="black", linewidth=1.4)
        line.set_zorder(1)
    axes.plot([], [], ":", color="black", label="reference")
    units = "/".join(dict.fromkeys(followed.units)) or "-"
    what = "joint" if result.experiment.reference.space == "joint" else "task"
    axes.set_ylabel(f"{what} position [{units}]")
    _legend(axes)


def _legend(axes: Axes) -> None:
    count = len(axes.get_lines())
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), ncols=1 + count // 16, frameon=False)
