"""Figures for the report of a study, as SVG."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from cardsflow_fmu.results.report.figures import STYLE, inline_svg
from cardsflow_fmu.utils.arrays import FloatArray

_MAX_BINS = 40
_MAX_TICKS = 8
_MAX_VECTORS = 500  # dots as vectors; more dots become an image, which limits the size of the SVG
_MIN_WIDTH = 1e-9  # smallest width of a histogram, relative to the values
_TINY = 1e-100


def histogram(name: str, unit: str, values: FloatArray) -> str:
    """Return a histogram of a metric.

    Args:
        values: At least one finite value, small enough for the axes of a figure.
    """

    def draw(axes: Axes) -> None:
        bins = min(_MAX_BINS, max(5, int(np.sqrt(len(values)))))
        axes.hist(values, bins=bins, range=_range(values), color="#1f77b4")
        axes.axvline(float(np.median(values)), color="black", linewidth=1.0, linestyle=":")
        axes.set_xlabel(f"{name} [{unit or '-'}]")
        axes.set_ylabel("runs")

    return _svg((4.2, 2.4), draw, name)


def _range(values: FloatArray) -> tuple[float, float]:
    """Return the range of values; wider if bins would be narrower than rounding errors."""
    low, high = float(values.min()), float(values.max())
    width = max(_MIN_WIDTH * max(abs(low), abs(high)), _TINY)
    return (low, high) if high - low >= width else (low - width, high + width)


def heat_map(
    names: tuple[str, str],
    x: FloatArray,
    y: FloatArray,
    metric: tuple[str, str],
    values: FloatArray,
) -> str:
    """Return a figure of a metric over two variations.

    If the variations form a grid, the figure shows cells, otherwise dots.

    Args:
        names: Names of the variations along x and y.
        x: Finite values of the first variation in each run.
        y: Finite values of the second variation in each run.
        metric: Name and unit of the metric.
        values: Value of the metric in each run, small enough for the axes of a figure; NaN for a
            failed run.
    """
    columns, rows = np.unique(x), np.unique(y)
    is_grid = len(columns) * len(rows) <= len(values)

    def draw(axes: Axes) -> None:
        drawn: ScalarMappable
        if is_grid:
            cells = mean_cells(x, y, values)
            drawn = axes.imshow(cells, origin="lower", aspect="auto", cmap="viridis")
            axes.set_xticks(*_ticks(columns))
            axes.set_yticks(*_ticks(rows))
            axes.grid(False)
        else:
            many = len(values) > _MAX_VECTORS
            drawn = axes.scatter(x, y, c=values, s=14.0, cmap="viridis", rasterized=many)
        axes.set_facecolor("#d0d4da")
        axes.set_xlabel(names[0])
        axes.set_ylabel(names[1])
        axes.figure.colorbar(drawn, ax=axes, label=f"{metric[0]} [{metric[1] or '-'}]")

    return _svg((4.8, 3.2), draw, f"heat map {metric[0]}")


def mean_cells(x: FloatArray, y: FloatArray, values: FloatArray) -> FloatArray:
    """Return the mean of the finite values at each pair of different y and x, shape (n_y, n_x)."""
    columns, i = np.unique(x, return_inverse=True)
    rows, j = np.unique(y, return_inverse=True)
    is_finite = np.isfinite(values)
    sums, counts = np.zeros((len(rows), len(columns))), np.zeros((len(rows), len(columns)))
    np.add.at(sums, (j[is_finite], i[is_finite]), values[is_finite])
    np.add.at(counts, (j[is_finite], i[is_finite]), 1.0)
    means: FloatArray = np.full_like(sums, np.nan)
    return np.divide(sums, counts, out=means, where=counts > 0.0)


def _ticks(values: FloatArray) -> tuple[list[int], list[str]]:
    """Return the indices of at most `_MAX_TICKS` cells, and the labels of their values."""
    places = list(range(0, len(values), -(-len(values) // _MAX_TICKS)))
    return places, [f"{values[k]:.4g}" for k in places]


def sensitivity_bars(metric: str, influences: Mapping[str, Mapping[str, float]]) -> str:
    """Return a bar chart of the influence of each variation on a metric.

    Args:
        influences: `first` and `total`, or `rank` and `share`, by the name of the variation.
    """

    def draw(axes: Axes) -> None:
        rows = np.arange(len(influences))
        kinds = list(dict.fromkeys(kind for influence in influences.values() for kind in influence))
        height = 0.8 / len(kinds)
        for k, kind in enumerate(kinds):
            values = [influence.get(kind, 0.0) for influence in influences.values()]
            axes.barh(rows + k * height, values, height=height, label=kind)
        axes.set_yticks(rows + 0.4 - 0.4 / len(kinds), list(influences))
        axes.invert_yaxis()
        axes.set_title(metric)
        axes.legend(frameon=False)

    return _svg((6.0, 0.9 + 0.28 * len(influences)), draw, f"sensitivity {metric}")


def search_history(objective: str, unit: str, best: Mapping[str, Sequence[float]]) -> str:
    """Return a figure of the best value over the generations, with a line for each search.

    Args:
        objective: Name of the metric.
        best: Best value after each generation, by the name of the search; NaN before a run
            satisfies the constraints.
    """

    def draw(axes: Axes) -> None:
        for name, values in best.items():
            axes.plot(np.arange(1, len(values) + 1), values, label=name)
        axes.set_xlabel("generation")
        axes.set_ylabel(f"{objective} [{unit or '-'}]")
        axes.legend(frameon=False)

    return _svg((5.6, 2.8), draw, "history")


def _svg(size: tuple[float, float], draw: Callable[[Axes], None], salt: str) -> str:
    with mpl.rc_context(STYLE | {"font.size": 8}):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure.subplots())
        return inline_svg(figure, salt=salt)
