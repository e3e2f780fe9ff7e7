"""Results of a run: columns by port name, units, and a summary; written as CSV and JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import UnknownNameError

from .experiment import Experiment
from .ports import identifier
from .summary_text import describe_summary

FloatArray = NDArray[np.float64]

_BLOCK = 4096
TABLE = "results.csv"
UNITS = "results.units.json"
SUMMARY = "summary.json"


@dataclass
class SystemResult:
    """What the run of coupled participants gave.

    Attributes:
        names: Name of every column; the first is `time`.
        rows: Values, shape (rows, len(names)).
        units: Unit of every column; empty for a number without one.
        summary: Tracking, forces, infeasible ticks, speed, status, versions.
        files: What was written, by its kind.
    """

    names: tuple[str, ...]
    rows: FloatArray
    units: Mapping[str, str]
    summary: dict[str, Any]
    files: dict[str, Path] = field(default_factory=dict)

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

    def contents(self) -> dict[str, str | bytes]:
        """The files of a result by name: table, units and summary."""
        return {
            TABLE: self._table(),
            UNITS: json.dumps(dict(self.units), indent=1) + "\n",
            SUMMARY: json.dumps(self.summary, indent=1) + "\n",
        }

    def describe(self) -> str:
        """A short summary for people, a line a topic."""
        lines = describe_summary(self.summary)
        lines += [f"{kind:<14} {path}" for kind, path in sorted(self.files.items())]
        return "\n".join(lines)

    def _table(self) -> str:
        """The columns as CSV, every float such that it reads back exactly."""
        blocks = [",".join(self.names)]
        for first in range(0, len(self.rows), _BLOCK):  # as Python floats, all would be large
            rows = self.rows[first : first + _BLOCK].tolist()
            blocks.append("\n".join(",".join(map(repr, row)) for row in rows))
        return "\n".join(blocks) + "\n"


@dataclass
class Result(SystemResult):
    """What the run of an experiment gave.

    Attributes:
        experiment: What was run.
    """

    experiment: Experiment = field(kw_only=True)
