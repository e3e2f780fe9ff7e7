"""Figure and report of an optimal motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from cardsflow_fmu.results.viewer.html.page import replay_script
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.arrays import BoolArray

from .figures import figure_of_panels
from .html import collapsible_section, page, section, table
from .page import captioned, replay
from .panels import Curve, Panel

_PANELS = {
    "q": "position [rad, m]",
    "qd": "velocity [rad/s, m/s]",
    "f": "force [N]",
    "tau": "torque [N·m, N]",
}
_MAX_BOUNDS = 10  # in the figure

ActiveBounds = Mapping[str, tuple[FloatArray, BoolArray]]
"""Times, in [s], and whether a motion is at a bound then, by name of the bound."""


def motion_figure(
    times: FloatArray,
    columns: Mapping[str, FloatArray],
    title: str,
    bounds: Mapping[str, tuple[float, float]] = {},
) -> Figure:
    """Return a figure of joint positions, velocities and forces over time.

    Args:
        times: Times of the samples, shape (k,), in [s].
        columns: Samples by name, such as `q.elbow`.
        bounds: Smallest and largest values by name, which are dotted where the curve is near.
    """
    panels = []
    for letter, label in _PANELS.items():
        names = [name for name in columns if name.startswith(f"{letter}.")]
        if names:
            curves = [Curve(name, times, columns[name]) for name in names]
            panels.append(Panel(label, [*curves, *_limits(curves, bounds)], dotted="bounds"))
    return figure_of_panels(panels, title=title)


def _limits(curves: Sequence[Curve], bounds: Mapping[str, tuple[float, float]]) -> list[Curve]:
    """Return the bounds that lie within the range of some curves, as their references."""
    low = min(float(np.nanmin(curve.values)) for curve in curves)
    high = max(float(np.nanmax(curve.values)) for curve in curves)
    near, lines = 0.1 * (high - low), dict[float, Curve]()
    for curve in curves:
        for value in bounds.get(curve.name, ()):
            if low - near <= value <= high + near:
                level = np.full(len(curve.time), value)
                lines.setdefault(value, Curve(f"{curve.name} bound", curve.time, level, curve.name))
    return list(lines.values())


def motion_page(
    name: str,
    outcome: str,
    warnings: Sequence[str],
    act: Act,
    figure: Figure,
    bounds: ActiveBounds,
    history: Sequence[Sequence[Any]],
) -> str:
    """Return the report of an optimal motion as an HTML page without external addresses.

    Args:
        outcome: Line about status, cost and duration.
        warnings: Lines about the motion.
        bounds: Bounds at which the motion is, those of the longest time first.
        history: Iteration, cost, infeasibility, step, substeps and time of each iteration.
    """
    parts = [captioned(figure, "motion"), captioned(_iterations(history), "convergence")]
    if bounds:
        parts.insert(1, captioned(_over_time(bounds), "active bounds"))
    shares = [(bound, 100.0 * float(is_at.mean())) for bound, (_, is_at) in bounds.items()]
    notices = [f'<p class="notice">Warning: {escape(line)}</p>' for line in warnings]
    kind = "verdict" if warnings else "verdict good"
    heads = ("iteration", "cost", "infeasibility", "step", "substeps", "time [s]")
    return page(
        f"{name}: optimal motion",
        f"<h1>{escape(name)}</h1>",
        *notices,
        f'<p class="{kind}">{escape(outcome)}</p>',
        section("Replay", replay(act)),
        section("Figures", *parts),
        collapsible_section("Active bounds", table(("bound", "share of the time [%]"), shares)),
        collapsible_section("Iterations", table(heads, history)),
        scripts=(replay_script(),),
    )


def _over_time(bounds: ActiveBounds) -> Figure:
    """Return a figure with a line for each bound while the motion is at it."""
    curves = [
        Curve(name, times, np.where(is_at, float(-k), np.nan))
        for k, (name, (times, is_at)) in enumerate(list(bounds.items())[:_MAX_BOUNDS])
    ]
    figure = figure_of_panels([Panel("at the bound", curves)])
    figure.axes[0].set_yticks([])
    for line in figure.axes[0].lines:
        line.set_marker("s")
        line.set_markersize(3.0)
    return figure


def _iterations(history: Sequence[Sequence[Any]]) -> Figure:
    """Return a figure of cost and infeasibility after each iteration."""
    count = np.arange(float(len(history)))
    panels = [
        Panel("cost", [Curve("cost", count, np.array([float(row[1]) for row in history]))]),
        Panel(
            "infeasibility",
            [Curve("infeasibility", count, np.array([float(row[2]) for row in history]))],
        ),
    ]
    figure = figure_of_panels(panels)
    figure.axes[-1].set_yscale("log")
    figure.axes[-1].set_xlabel("iteration")
    return figure
