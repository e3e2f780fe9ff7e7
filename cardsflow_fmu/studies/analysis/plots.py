"""Figures of a study, as SVG texts that stand in its report."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from cardsflow_fmu.utils.arrays import FloatArray

# Text stays text, and equal results give equal files.
_STYLE: Any = {
    "font.size": 8,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "svg.fonttype": "none",
    "svg.hashsalt": "cardsflow",
}
_MOST_BINS = 40
_NARROWEST = 1e-9  # part of the values that a histogram is wide at least
_TINY = 1e-100


def histogram(name: str, unit: str, values: FloatArray) -> str:
    """How a metric is distributed.

    Args:
        name: Of the metric.
        unit: Its unit.
        values: Finite, at least one, and none so large that axes cannot have it.
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(4.2, 2.4), layout="constrained")
        axes = figure.subplots()
        bins = min(_MOST_BINS, max(5, int(np.sqrt(len(values)))))
        axes.hist(values, bins=bins, range=_range(values), color="#1f77b4")
        axes.axvline(float(np.median(values)), color="black", linewidth=1.0, linestyle=":")
        axes.set_xlabel(f"{name} [{unit or '-'}]")
        axes.set_ylabel("runs")
        return _svg(figure)


def _range(values: FloatArray) -> tuple[float, float]:
    """From the least to the largest; wider where bins would be as narrow as rounding."""
    low, high = float(values.min()), float(values.max())
    least = max(_NARROWEST * max(abs(low), abs(high)), _TINY)
    return (low, high) if high - low >= least else (low - least, high + least)


def sensitivity_bars(metric: str, parts: Mapping[str, Mapping[str, float]]) -> str:
    """How much each variation counts for a metric.

    Args:
        metric: Name of the metric.
        parts: By the name of the variation, `first` and `total`, or `rank` and `share`.
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(6.0, 0.9 + 0.28 * len(parts)), layout="constrained")
        axes = figure.subplots()
        places = np.arange(len(parts))
        kinds = list(dict.fromkeys(kind for part in parts.values() for kind in part))
        for k, kind in enumerate(kinds):
            height = 0.8 / len(kinds)
            values = [part.get(kind, 0.0) for part in parts.values()]
            axes.barh(places + k * height, values, height=height, label=kind)
        axes.set_yticks(places + 0.4 - 0.4 / len(kinds), list(parts))
        axes.invert_yaxis()
        axes.set_title(metric)
        axes.legend(frameon=False)
        return _svg(figure)


def search_history(objective: str, unit: str, best: Mapping[str, Sequence[float]]) -> str:
    """The best of an optimisation over its generations, a line a search.

    Args:
        objective: Name of the metric.
        unit: Its unit.
        best: By the name of the search; NaN before anything meets the constraints.
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(5.6, 2.8), layout="constrained")
        axes = figure.subplots()
        for name, values in best.items():
            axes.plot(np.arange(1, len(values) + 1), values, label=name)
        axes.set_xlabel("generation")
        axes.set_ylabel(f"{objective} [{unit or '-'}]")
        axes.legend(frameon=False)
        return _svg(figure)


def _svg(figure: Figure) -> str:
    memory = io.StringIO()
    figure.savefig(memory, format="svg", metadata={"Date": None})
    text = memory.getvalue()
    return text[text.index("<svg") :]
