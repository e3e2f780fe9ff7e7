"""The error of hardware at the other end of a link."""

from __future__ import annotations

from addin_sdfusion.robot import SimulationError


class HardwareError(SimulationError):
    """Hardware does not answer, rejects, or has gone to its safe state."""
