"""Results of runs: their data with loading, plotting and views."""

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


class SystemResult(RunData):
    """The result of a run of coupled participants; attributes as of `RunData`."""

    @staticmethod
    def load(path: str | Path) -> SystemResult:
        """The result in a folder that a run has written, or in a table alone.

        Args:
            path: The folder, a .csv or a .parquet.

        Raises:
            InputError: A file is missing or damaged.
        """
        return SystemResult(**vars(read_results(Path(path))))

    def describe(self, *, every: bool = False) -> str:
        """A summary for people, a line a topic.

        Args:
            every: Whether all signals are in it; else the worst of each kind.
        """
        lines = describe_summary(self.summary, every=every)
        if self.files:
            folder = next(iter(self.files.values())).parent
            lines.append(f"files       {folder}: {', '.join(sorted(self.files))}")
        return "\n".join(lines)

    def to_pandas(self) -> DataFrame:
        """The columns as a DataFrame over `time`; `attrs["units"]` holds their units.

        Raises:
            InputError: pandas is missing.
        """
        try:
            import pandas as pd
        except ImportError:
            what = f"needs pandas: {install('pandas')}"
            raise InputError(what, key="to_pandas") from None
        frame = pd.DataFrame(self.rows, columns=list(self.names)).set_index("time")
        frame.attrs["units"] = dict(self.units)
        return frame

    def plot(self, what: Sequence[str] = (), columns: Sequence[str] = ()) -> Figure:
        """A figure of the result.

        Args:
            what: Such as `forces` and `tracking`; all available when empty.
            columns: Patterns of names, such as `q.*`, drawn besides, or alone.

        Raises:
            InputError: The result has nothing of it to draw.
        """
        from cardsflow_fmu.results.report.figures import figure_of

        return figure_of(self, what, columns)

    def _repr_html_(self) -> str:
        """The summary and a figure, for a notebook."""
        from cardsflow_fmu.results.report.notebook import result_html

        return result_html(self)


class Result(SystemResult, ExperimentRunData):
    """The result of a run of an experiment; attributes as of `ExperimentRunData`."""

    @staticmethod
    def load(path: str | Path) -> Result:
        """The result that a run of an experiment has written, with the experiment.

        Args:
            path: The folder of the run, or the table in it.

        Raises:
            InputError: Something is missing or damaged.
        """
        return Result(**vars(load_run(path)))
