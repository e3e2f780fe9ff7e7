"""Figures of a run, by matplotlib without a display."""

from __future__ import annotations

import io
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .ports import coordinate_signals, muscle_signals
from .results import Result

FIGURE = "tracking"

# Text stays text in an SVG, and equal results give equal files.
_STYLE: Any = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "svg.fonttype": "none",
    "svg.hashsalt": "cardsflow",
}


def tracking_figure(result: Result) -> Figure:
    """Force commands, and joint positions against the dotted reference: the paper's figure 10.

    Args:
        result: A run with at least one row.
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(7.0, 5.6), layout="constrained")
        forces, positions = figure.subplots(2, 1, sharex=True)
        _draw_forces(forces, result)
        _draw_positions(positions, result)
        positions.set_xlabel("time [s]")
        if not result.complete:
            figure.suptitle("incomplete run")
    return figure


def tracking_images(result: Result) -> dict[str, bytes]:
    """The tracking figure as PNG and SVG files, by name.

    Args:
        result: A run with at least one row.
    """
    figure = tracking_figure(result)
    images: dict[str, bytes] = {}
    with mpl.rc_context(_STYLE):
        for kind, metadata in (("png", {"Software": None}), ("svg", {"Date": None})):
            memory = io.BytesIO()
            figure.savefig(memory, format=kind, dpi=150, metadata=metadata)
            images[f"{FIGURE}.{kind}"] = memory.getvalue()
    return images


def _draw_forces(axes: Axes, result: Result) -> None:
    time = result["time"]
    for name in muscle_signals("f", result.experiment.robot):
        axes.plot(time, result[name], label=name, linewidth=1.2)
    axes.set_ylabel("force command [N]")
    _legend(axes)


def _draw_positions(axes: Axes, result: Result) -> None:
    time, robot = result["time"], result.experiment.robot
    names = zip(coordinate_signals("q", robot), coordinate_signals("q_d", robot), strict=True)
    for name, desired in names:
        (line,) = axes.plot(time, result[name], label=name, linewidth=1.2)
        axes.plot(time, result[desired], ":", color="black", linewidth=1.4)
        line.set_zorder(1)
    axes.plot([], [], ":", color="black", label="reference")
    units = "/".join(dict.fromkeys(c.unit for c in robot.coordinates))
    axes.set_ylabel(f"joint position [{units}]")
    _legend(axes)


def _legend(axes: Axes) -> None:
    count = len(axes.get_lines())
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), ncols=1 + count // 16, frameon=False)
