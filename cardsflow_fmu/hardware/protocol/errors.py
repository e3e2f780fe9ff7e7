"""Error of the hardware at the other end of a link."""

from __future__ import annotations

from addin_sdfusion.robot import SimulationError


class HardwareError(SimulationError):
    """The hardware does not answer, rejects a run, or has entered its safe state."""
