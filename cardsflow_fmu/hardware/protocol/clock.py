"""What tells the time: the world's clock, or one of an emulated world that passes as it is used."""

from __future__ import annotations

from typing import Protocol


class Clock(Protocol):
    """What the module `time` has of it."""

    def monotonic(self) -> float:
        """The time, in [s]."""

    def monotonic_ns(self) -> int:
        """The time, in [ns]."""

    def sleep(self, seconds: float, /) -> None:
        """Let time pass, in [s]."""
