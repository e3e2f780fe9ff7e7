"""HTML view of a result in a notebook."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from addin_sdfusion.robot import InputError

from .summary_html import summary_tables

if TYPE_CHECKING:
    from cardsflow_fmu.results.run_data import RunData

_BINS = 500


def result_html(result: RunData) -> str:
    """Return the summary, and a figure of forces, tracking and errors, as HTML."""
    size = f"<p>{len(result.rows)} rows of {len(result.names)} columns</p>"
    warnings = result.summary.get("warnings") or ()
    lines = [f"<p><strong>Warning: {escape(str(w))}</strong></p>" for w in warnings]
    return "\n".join((*lines, *summary_tables(result.summary), size, *_figure(result)))


def _figure(result: RunData) -> list[str]:
    from .figures import figure_of_panels, inline_svg
    from .panels import panels_of

    try:
        return [inline_svg(figure_of_panels(panels_of(result), bins=_BINS))]
    except InputError as error:
        return [f"<p>{escape(str(error))}</p>"]
