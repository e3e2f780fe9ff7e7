"""The interface between a session and a link to hardware."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from cardsflow_fmu.hardware.protocol.clock import Clock
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.handshake import Handshake
from cardsflow_fmu.utils.arrays import FloatArray


class HardwareLink(Protocol):
    """A link to a device, for one run at a time.

    Attributes:
        run_id: Number of the run; 0 before `open`.
        agreed: Parameters of the run; None before `open`.
        start_state: The device's state when it agreed, shape (states,), in SI units.
        clock: Clock of both ends.
    """

    clock: Clock
    run_id: int
    agreed: Handshake | None
    start_state: FloatArray

    @property
    def counters(self) -> Mapping[str, int]:
        """Number of frames sent, received, and dropped by reason."""

    def open(self, handshake: Handshake) -> None:
        """Agree with the device on a run; nothing moves before the first set point.

        Raises:
            HardwareError: There is no answer in time, or the device rejects.
        """

    def exchange(self, t: float, command: FloatArray, deadline: float) -> Exchange:
        """Send a set point and wait for the state that answers it; losses do not raise.

        Args:
            t: Time of the run, in [s].
            command: Shape (commands,), in SI units.
            deadline: End of the wait, on the link's clock, in [s].
        """

    def stop(self) -> bool:
        """Stop the device; returns whether it has confirmed."""

    def close(self) -> None:
        """Stop the device if a run is under way, and close the line; may be repeated."""
