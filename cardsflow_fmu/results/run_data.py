"""Data of a run: columns, units, summary, and experiment."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import UnknownNameError
from cardsflow_fmu.cosim.signals.ports import identifier
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray


@dataclass
class RunData:
    """Data of a run of coupled participants.

    Attributes:
        names: Names of the columns; the first is `time`.
        rows: Values, shape (rows, len(names)).
        units: Units of the columns; empty for dimensionless columns.
        summary: Tracking, forces, infeasible ticks, speed, status, versions.
        files: Written files, by name.
        solve_times: Time of each tick and its computation time, in [s], shape (ticks, 2); no rows
            if unknown.
    """

    names: tuple[str, ...]
    rows: FloatArray
    units: Mapping[str, str]
    summary: dict[str, Any]
    files: dict[str, Path] = field(default_factory=dict)
    solve_times: FloatArray = field(default_factory=lambda: np.empty((0, 2)))

    def __getitem__(self, name: str) -> FloatArray:
        """Return a column, shape (rows,), in its unit.

        Raises:
            UnknownNameError: The column does not exist; the message suggests the nearest name.
        """
        if name not in self.names:
            prefix, _, suffix = name.partition(".")
            cleaned = f"{prefix}.{identifier(suffix)}" if suffix else name
            if cleaned not in self.names:
                raise UnknownNameError("column", name, self.names)
            name = cleaned
        column: FloatArray = self.rows[:, self.names.index(name)]
        return column

    def columns(self, names: list[str]) -> FloatArray:
        """Return columns, shape (rows, len(names))."""
        return np.stack([self[name] for name in names], axis=1)

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return bool(self.summary["status"] != "incomplete")


def _keep_files() -> None:
    """Do nothing; a function with a name, so that results can be pickled."""


@dataclass
class ExperimentRunData(RunData):
    """Data of a run of an experiment.

    Copies and pickled data do not include the unpacked robot files, which are deleted with the
    original.

    Attributes:
        release: Function that deletes the unpacked robot files. If it is not called, they are
            deleted together with the experiment.
    """

    experiment: Experiment = field(kw_only=True)
    release: Callable[[], object] = field(kw_only=True, default=_keep_files, repr=False)
