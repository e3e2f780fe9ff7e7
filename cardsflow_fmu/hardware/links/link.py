"""The interface between a session and a link to hardware."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from cardsflow_fmu.hardware.protocol.clock import Clock
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.handshake import Hello
from cardsflow_fmu.utils.arrays import FloatArray


class HardwareLink(Protocol):
    """The way to a device and back, for one run at a time.

    Attributes:
        run_id: Number of the run; 0 before `open`.
        agreed: What the device has agreed to; None before `open`.
        start_state: The device's state when it agreed, shape (states,), in SI units.
        counters: How many frames were sent, received, and dropped for what reason.
        clock: What tells the time.
    """

    clock: Clock
    run_id: int
    agreed: Hello | None
    start_state: FloatArray

    @property
    def counters(self) -> Mapping[str, int]:
        """How many frames were sent, received, and dropped for what reason."""

    def open(self, hello: Hello) -> None:
        """Agree with the device on a run; nothing moves before the first set point.

        Raises:
            HardwareError: Nobody answers in time, or the device refuses.
        """

    def exchange(self, t: float, command: FloatArray, deadline: float) -> Exchange:
        """Send a set point and wait for the state that answers it; losses do not raise.

        Args:
            t: Time of the run, in [s].
            command: Shape (commands,), in SI units.
            deadline: Until when to wait, on the link's clock, in [s].
        """

    def stop(self) -> bool:
        """Ask the device to go to its safe state; whether it has confirmed."""

    def close(self) -> None:
        """Stop if need be, and give the line back; a second time does nothing."""
