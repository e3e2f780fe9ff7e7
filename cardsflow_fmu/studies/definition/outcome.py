"""The outcome of a run: its metrics, or its error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

LEADING_COLUMNS, TRAILING_COLUMNS = ("run", "hash"), ("status", "error")
"""Columns of a study's table before and behind those of variations and metrics."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a run.

    Attributes:
        metrics: By name; None if a run has no such thing. Empty of a failed run.
        error: Why it failed; None of a complete run.
        wall_time: Time of the simulation itself, in [s].
        overhead: Time for everything else: reading, building, looking at the results, in [s].
    """

    metrics: Mapping[str, Any]
    error: str | None = None
    wall_time: float = 0.0
    overhead: float = 0.0

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return self.error is None
