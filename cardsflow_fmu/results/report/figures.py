"""Figures of results by topic: `cardsflow plot` and `Result.plot`."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Figure
from matplotlib.font_manager import findfont, get_font

from addin_sdfusion.robot import UnknownNameError
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.results.verdict import failure_text
from cardsflow_fmu.utils.overwrite import MARK, output_file, write_output

from .curve_selection import curve_colours, select_curves, shorten
from .downsample import BINS, downsample
from .panels import Panel, panels_of

FORMATS = ("png", "svg", "pdf")

# SVG files contain text. Names are not parsed as formulas. Equal results have equal files.
STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "svg.fonttype": "none",
    "text.parse_math": False,
    "svg.hashsalt": "cardsflow",
}


def plot(
    result: RunData,
    file: str | Path,
    panels: Sequence[str] = (),
    columns: Sequence[str] = (),
    *,
    overwrite: bool = False,
) -> Path:
    """Write a figure of a result.

    Args:
        file: A .png, .svg or .pdf file.
        panels: Panels, such as `forces` and `tracking` (default: forces, tracking and errors).
        columns: Patterns of column names, such as `q.*`.
        overwrite: Whether to replace a file that CARDSFlow did not write.
    """
    target = figure_file(file, overwrite=overwrite)
    return write_figure(target, figure_of(result, panels, columns))


def figure_file(file: str | Path, *, overwrite: bool = False) -> Path:
    """Check that a figure may be written: call it before the work starts.

    Raises:
        InputError: The suffix is not allowed, or the file exists and CARDSFlow did not write it.
    """
    file = Path(file)
    form = file.suffix.lower().removeprefix(".")
    if form not in FORMATS:
        raise UnknownNameError("kind of figure", form, FORMATS, file=file)
    return output_file(file, [f".{form}"], overwrite=overwrite)


def write_figure(file: Path, figure: Figure) -> Path:
    """Write a figure to a file from `figure_file`."""
    return write_output(file, image(figure, file.suffix.lower().removeprefix(".")))


def figure_of(result: RunData, panels: Sequence[str] = (), columns: Sequence[str] = ()) -> Figure:
    """Return a figure of a result. Arguments and errors as for `plot`."""
    selected = panels_of(result, panels, columns)
    return figure_of_panels(selected, title=figure_title(result))


def figure_title(result: RunData) -> str:
    """Return the title of a figure: why a run failed or ended early, otherwise empty."""
    if result.summary.get("status") == "incomplete":
        return "incomplete run"
    return failure_text(result.summary) or ""


def figure_of_panels(panels: Sequence[Panel], *, title: str = "", bins: int = BINS) -> Figure:
    """Return a figure with stacked panels and a common time axis.

    Args:
        panels: At least one panel.
        title: Title of the figure; empty for none.
        bins: Number of bins for downsampling long curves.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 0.6 + 2.4 * len(panels)), layout="constrained")
        all_axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, panel in zip(all_axes, panels, strict=True):
            _draw(axes, panel, bins)
        all_axes[-1].set_xlabel("time [s]")
        if title:
            figure.suptitle(title)
    return figure


def image(figure: Figure, form: str, *, salt: str = "cardsflow", mark: str | None = MARK) -> bytes:
    """Return the content of a figure file without a date; equal figures have equal files.

    Args:
        form: One of `FORMATS`.
        salt: Text that makes the ids in an SVG differ from those of other figures in a page.
        mark: Creator in the metadata; files with `MARK` may be overwritten.
    """
    dates = {"svg": "Date", "pdf": "CreationDate"}
    metadata = {"Software" if form == "png" else "Creator": mark}
    if form in dates:
        metadata[dates[form]] = None
    memory = io.BytesIO()
    large = np.errstate(over="ignore", invalid="ignore")  # axes of runs that diverged
    with mpl.rc_context(STYLE | {"svg.hashsalt": salt}), large, warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph", UserWarning)  # see `missing_characters`
        figure.savefig(memory, format=form, dpi=150, metadata=metadata)
    figure.set_layout_engine("none")  # the layout stays valid for other formats
    return memory.getvalue()


def missing_characters(result: RunData) -> str:
    """Return the characters of column names that the font of figures does not contain."""
    font = get_font(findfont(STYLE["font.family"]))
    characters = dict.fromkeys(character for name in result.names for character in name)
    return "".join(c for c in characters if not font.get_char_index(ord(c)))


def inline_svg(figure: Figure, *, salt: str = "cardsflow") -> str:
    """Return a figure as inline SVG without metadata; `salt` as for `image`."""
    svg = image(figure, "svg", salt=salt).decode()
    return re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)


def _draw(axes: Axes, panel: Panel, bins: int) -> None:
    drawn = select_curves(panel)
    names = [curve.name for curve in drawn.curves]
    colours = dict(zip(names, curve_colours(names), strict=True))
    for curve in drawn.curves:
        points = downsample(curve.time, curve.values, bins)
        axes.plot(*points, color=colours[curve.name], linewidth=1.1)
    lines, labels = [*axes.lines], [_printable(shorten(name)) for name in names]
    for curve in drawn.references:
        points = downsample(curve.time, curve.values, bins)
        colour = curve.colour or colours[curve.of]
        axes.plot(*points, ":", color=colour, linewidth=1.3)
    if drawn.references:
        lines.append(axes.lines[len(names)])
        labels.append(panel.dotted)
    if drawn.omitted:
        comparison = "with less change" if panel.by_change else "smaller"
        lines += axes.plot([], [], " ")
        labels.append(f"{drawn.omitted} {comparison} not shown")
    axes.set_ylabel(_printable(panel.label))
    # explicit labels, because matplotlib ignores line labels that begin with an underscore
    where = (1.0, 0.5)
    axes.legend(
        lines, labels, loc="center left", bbox_to_anchor=where, frameon=False, fontsize="small"
    )


def _printable(text: str) -> str:
    """Replace control characters, which SVG does not support."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
