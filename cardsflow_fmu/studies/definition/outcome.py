"""Outcome of a run: its metrics or its error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

LEADING_COLUMNS, TRAILING_COLUMNS = ("run", "hash"), ("status", "error")
"""Columns of a study's table before and after the columns of variations and metrics."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a run.

    Attributes:
        metrics: Metrics by name, with None for unavailable ones; empty for a failed run.
        error: Error message of a failed run, or None.
        wall_time: Time of the simulation, in [s].
        overhead: Time for reading, building and evaluation, in [s].
    """

    metrics: Mapping[str, Any]
    error: str | None = None
    wall_time: float = 0.0
    overhead: float = 0.0

    @property
    def complete(self) -> bool:
        """Whether the run was completed."""
        return self.error is None
