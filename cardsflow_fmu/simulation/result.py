"""Results of runs, with methods to load, plot and display them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from addin_sdfusion.robot import InputError
from cardsflow_fmu.results.run_data import ExperimentRunData, RunData
from cardsflow_fmu.results.saved_run import load_run, read_results
from cardsflow_fmu.results.summary_text import describe_summary
from cardsflow_fmu.utils.extras import install

if TYPE_CHECKING:
    from pandas import DataFrame

    from cardsflow_fmu.results.report.figures import Figure
    from cardsflow_fmu.results.viewer.inline import ShownPage


class SystemResult(RunData):
    """Result of a run of coupled participants; attributes as for `RunData`."""

    @staticmethod
    def load(path: str | Path) -> SystemResult:
        """Read the result in a results folder, or in a single table.

        Args:
            path: The folder, or a .csv file.

        Raises:
            InputError: A file is missing or damaged.
        """
        return SystemResult(**vars(read_results(Path(path))))

    def describe(self, *, every: bool = False) -> str:
        """Return a summary as text.

        Args:
            every: Whether to include all signals instead of the worst of each kind.
        """
        lines = describe_summary(self.summary, every=every)
        if self.files:
            folder = next(iter(self.files.values())).parent
            lines.append(f"files       {folder}: {', '.join(sorted(self.files))}")
        return "\n".join(lines)

    def to_pandas(self) -> DataFrame:
        """Return the columns as a DataFrame over `time`; `attrs["units"]` contains their units.

        Raises:
            InputError: pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            problem = f"requires pandas: {install('pandas')}"
            raise InputError(problem, key="to_pandas") from None
        frame = pd.DataFrame(self.rows, columns=list(self.names)).set_index("time")
        frame.attrs["units"] = dict(self.units)
        return frame

    def plot(self, panels: Sequence[str] = (), columns: Sequence[str] = ()) -> Figure:
        """Return a figure of the result.

        Args:
            panels: Panels, such as `forces` and `tracking` (default: forces, tracking and errors).
            columns: Patterns of additional columns, such as `q.*`.

        Raises:
            InputError: The result has no such data.
        """
        from cardsflow_fmu.results.report.figures import figure_of

        return figure_of(self, panels, columns)

    def _repr_html_(self) -> str:
        """Return the summary and a figure for a notebook."""
        from cardsflow_fmu.results.report.notebook import result_html

        return result_html(self)


class Result(SystemResult, ExperimentRunData):
    """Result of a run of an experiment; attributes as for `ExperimentRunData`."""

    def show(self) -> ShownPage:
        """Return the replay, which a notebook displays; outside of notebooks, open the browser.

        Raises:
            InputError: The run has no rows.
        """
        from cardsflow_fmu.results.viewer.inline import show

        return show(self)

    @staticmethod
    def load(path: str | Path) -> Result:
        """Read the result of a run with its experiment.

        Args:
            path: The results folder, or the table in it.

        Raises:
            InputError: A file is missing or damaged.
        """
        return Result(**vars(load_run(path)))
