"""Clock interface for real and virtual time."""

from __future__ import annotations

from typing import Protocol


class Clock(Protocol):
    """Functions of the module `time` that links and sessions use."""

    def monotonic(self) -> float:
        """Return the time, in [s]."""

    def monotonic_ns(self) -> int:
        """Return the time, in [ns]."""

    def sleep(self, seconds: float, /) -> None:
        """Wait for a time, in [s]."""
