"""Results of a run: columns by port name, units, and a summary; written as CSV and JSON."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.table_forms import TableForm
from cardsflow_fmu.signals.ports import identifier
from cardsflow_fmu.utils.arrays import FloatArray

from .summary_text import describe_summary

if TYPE_CHECKING:
    from pandas import DataFrame

    from cardsflow_fmu.report.figures import Figure


_BLOCK = 4096
TABLE = "results.csv"
PARQUET = "results.parquet"
UNITS = "results.units.json"
SUMMARY = "summary.json"
SOLVE_TIMES = "solve_times.csv"


@dataclass
class SystemResult:
    """What the run of coupled participants gave.

    Attributes:
        names: Name of every column; the first is `time`.
        rows: Values, shape (rows, len(names)).
        units: Unit of every column; empty for a number without one.
        summary: Tracking, forces, infeasible ticks, speed, status, versions.
        files: What was written, by its kind.
        solve_times: Time of each tick and how long the controller took for it, in [s], shape
            (ticks, 2); no rows where that is not known.
    """

    names: tuple[str, ...]
    rows: FloatArray
    units: Mapping[str, str]
    summary: dict[str, Any]
    files: dict[str, Path] = field(default_factory=dict)
    solve_times: FloatArray = field(default_factory=lambda: np.empty((0, 2)))

    @staticmethod
    def load(path: str | Path) -> SystemResult:
        """The result in a folder that a run has written, or in a table alone.

        Args:
            path: The folder, a .csv or a .parquet.

        Raises:
            InputError: A file is missing or damaged.
        """
        from .saved_run import read_results

        return read_results(Path(path))

    def __getitem__(self, name: str) -> FloatArray:
        """The column of that name, shape (rows,), in its unit.

        Raises:
            UnknownNameError: There is none; the message names the nearest.
        """
        if name not in self.names:
            prefix, _, rest = name.partition(".")
            cleaned = f"{prefix}.{identifier(rest)}" if rest else name
            if cleaned not in self.names:
                raise UnknownNameError("column", name, self.names)
            name = cleaned
        column: FloatArray = self.rows[:, self.names.index(name)]
        return column

    def columns(self, names: list[str]) -> FloatArray:
        """Several columns, shape (rows, len(names))."""
        return np.stack([self[name] for name in names], axis=1)

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return bool(self.summary["status"] == "complete")

    def contents(self, form: TableForm = "csv") -> dict[str, str | bytes]:
        """The files of a result by name: table, units and summary.

        Args:
            form: Of the table.

        Raises:
            InputError: Parquet is asked for, and pyarrow is missing.
        """
        return {**self.table_file(form), **self.notes()}

    def notes(self) -> dict[str, str | bytes]:
        """The files beside the table by name: units and summary, and times where there are any."""
        times = self.solve_times
        files: dict[str, str | bytes] = {
            UNITS: json.dumps(dict(self.units), indent=1) + "\n",
            SUMMARY: json.dumps(self.summary, indent=1) + "\n",
        }
        if len(times):
            files[SOLVE_TIMES] = csv_text(("time", "solve_time"), times)
        return files

    def table_file(self, form: TableForm = "csv") -> dict[str, str | bytes]:
        """The table alone, by the name of its file. Arguments and errors as for `contents`."""
        if form == "csv":
            return {TABLE: csv_text(self.names, self.rows)}
        from .parquet import parquet_bytes

        return {PARQUET: parquet_bytes(self)}

    def describe(self) -> str:
        """A short summary for people, a line a topic."""
        lines = describe_summary(self.summary)
        lines += [f"{kind:<14} {path}" for kind, path in sorted(self.files.items())]
        return "\n".join(lines)

    def to_pandas(self) -> DataFrame:
        """The columns as a DataFrame over `time`; `attrs["units"]` holds their units.

        Raises:
            InputError: pandas is missing.
        """
        try:
            import pandas as pd
        except ImportError:
            what = "needs pandas: pip install 'cardsflow[pandas]'"
            raise InputError(what, key="to_pandas") from None
        frame = pd.DataFrame(self.rows, columns=list(self.names)).set_index("time")
        frame.attrs["units"] = dict(self.units)
        return frame

    def plot(self, what: Sequence[str] = (), columns: Sequence[str] = ()) -> Figure:
        """A figure of the result.

        Args:
            what: Such as `forces` and `tracking`; what there is when empty.
            columns: Patterns of names, such as `q.*`, drawn besides, or alone.

        Raises:
            InputError: The result has nothing of it to draw.
        """
        from cardsflow_fmu.report.figures import figure_of

        return figure_of(self, what, columns)

    def _repr_html_(self) -> str:
        """The summary and a figure, for a notebook."""
        from cardsflow_fmu.report.notebook import result_html

        return result_html(self)


@dataclass
class Result(SystemResult):
    """What the run of an experiment gave.

    Attributes:
        experiment: What was run.
        release: Removes the robot's files, where they were unpacked for this result; they go with
            it otherwise.
    """

    experiment: Experiment = field(kw_only=True)
    release: Callable[[], object] = field(kw_only=True, default=lambda: None, repr=False)

    @staticmethod
    def load(path: str | Path) -> Result:
        """The result that a run of an experiment has written, with the experiment.

        Args:
            path: The folder of the run, or the table in it.

        Raises:
            InputError: Something is missing or damaged.
        """
        from .saved_run import load_run

        return load_run(path)


def csv_text(names: Sequence[str], rows: FloatArray) -> str:
    """A table as CSV, every float such that it reads back exactly.

    Args:
        names: Name of every column.
        rows: Values, shape (rows, len(names)).
    """
    blocks = [",".join(names)]
    for first in range(0, len(rows), _BLOCK):  # as Python floats, all would be large
        blocks.append("\n".join(map(row_text, rows[first : first + _BLOCK])))
    return "\n".join(blocks) + "\n"


def row_text(row: FloatArray) -> str:
    """A row as CSV, without the end of the line.

    Args:
        row: Values, shape (columns,).
    """
    return ",".join(map(repr, row.tolist()))
