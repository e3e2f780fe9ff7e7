"""Figure of the failures of muscles and motors that a motion survives."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from cardsflow_fmu.results.analysis.failures import Failure

from .figures import STYLE


def failure_figure(results: Sequence[Failure]) -> Figure:
    """Return a figure of the strength over time that the motion needs after each single failure."""
    single = [failure for failure in results if len(failure.actuators) <= 1]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 3.6), layout="constrained")
        axes = figure.subplots()
        for failure in single:
            name = failure.actuators[0] if failure.actuators else "(intact)"
            finite = np.where(np.isfinite(failure.strength), failure.strength, np.nan)
            width = 1.5 if failure.actuators else 2.5
            (line,) = axes.plot(failure.times, 100.0 * finite, label=name, linewidth=width)
            impossible = failure.times[~np.isfinite(failure.strength)]
            axes.plot(impossible, np.full(len(impossible), 100.0), "x", color=line.get_color())
        axes.axhline(100.0, color="black", linestyle=":")
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("time [s]")
        axes.set_ylabel("required strength [% of the limits]")
        axes.set_title("without one muscle or motor; x: impossible")
        axes.legend(ncols=2, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure
