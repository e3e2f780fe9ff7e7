"""Interface between a session and a link to hardware."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from cardsflow_fmu.hardware.protocol.clock import Clock
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.handshake import Handshake
from cardsflow_fmu.utils.arrays import FloatArray


class HardwareLink(Protocol):
    """Interface of a link to a device, for one run at a time.

    Attributes:
        run_id: Id of the run, or 0 before `open`.
        agreed: Parameters of the run, or None before `open`.
        start_state: State of the device when it accepted the run, shape (states,), in SI units.
    """

    clock: Clock
    run_id: int
    agreed: Handshake | None
    start_state: FloatArray

    @property
    def counters(self) -> Mapping[str, int]:
        """Number of frames sent, received, and dropped (by reason)."""

    def open(self, handshake: Handshake) -> None:
        """Start a run by a handshake. The robot does not move before the first set point.

        Raises:
            HardwareError: The device does not answer in time, or rejects the run.
        """

    def exchange(self, t: float, command: FloatArray, deadline: float) -> Exchange:
        """Send a set point and wait for the state that answers it.

        A lost frame does not raise an error.

        Args:
            t: Time of the run, in [s].
            command: Set point, shape (commands,), in SI units.
            deadline: End of the wait on the link's clock, in [s].
        """

    def stop(self) -> bool:
        """Stop the device. Return whether it confirms the stop."""

    def close(self) -> None:
        """Stop the device if a run is in progress, and close the link. Further calls do nothing."""
