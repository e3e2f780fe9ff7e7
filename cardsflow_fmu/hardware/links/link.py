"""The link to hardware, as those see it who use it; `open_link` makes one of an address."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.emulator.faults import Faults
from cardsflow_fmu.hardware.protocol.clock import Clock
from cardsflow_fmu.hardware.protocol.handshake import Hello as Hello

if TYPE_CHECKING:
    from cardsflow_fmu.hardware.device.device import Device

FloatArray = NDArray[np.float64]

FORMS = "udp://HOST:PORT, serial:///dev/ttyACM0?baud=2000000, loopback:, emulated:"


class Exchange(NamedTuple):
    """What came of a set point; a tuple because one is made in each step, and quickly.

    Attributes:
        state: Newest state, shape (states,), in SI units; None if nothing new came.
        seq: Sequence number of the set point that the newest state answers; 0 before any came.
        age: Time since the newest state was received, in [s]; infinite before any came.
        round_trip: From the sending of that set point until its state came, in [s]; NaN if nothing
            new came.
        device_flags: Flags of the newest state, bits of `frame.Flag`.
    """

    state: FloatArray | None
    seq: int
    age: float
    round_trip: float
    device_flags: int


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


def open_link(
    uri: str,
    *,
    key: bytes | None = None,
    bind: str = "",
    loopback: Callable[[], Device] | None = None,
    faults: Faults | None = None,
) -> HardwareLink:
    """The link of an address; its `open` is the first to speak to the device.

    Args:
        uri: udp://HOST:PORT, serial:///dev/ttyACM0?baud=2000000, loopback: or emulated:
        key: The pre-shared key that frames are signed with; unsigned when None.
        bind: Address of this machine to send from; found by the device's when empty.
        loopback: Makes the device of loopback: and emulated:
        faults: What happens to frames of emulated: on their way; nothing when None.

    Raises:
        InputError: The address cannot be understood.
    """
    scheme = uri.partition(":")[0]
    if scheme == "udp":
        from .udp import UdpLink

        return UdpLink(uri, key=key, bind=bind)
    if scheme == "serial":
        from .serial import SerialLink

        return SerialLink(uri, key=key)
    if scheme == "loopback":
        from cardsflow_fmu.hardware.emulator.loopback_link import LoopbackLink

        if loopback is None:
            raise InputError("loopback: needs a device in this process; here is none")
        return LoopbackLink(loopback, key=key)
    if scheme == "emulated":
        from cardsflow_fmu.hardware.emulator.emulated_link import EmulatedLink, EmulatedWorld

        if loopback is None:
            raise InputError("emulated: needs a device in this process; here is none")
        return EmulatedLink(EmulatedWorld(loopback(), faults or Faults()), key=key)
    raise InputError(f"no hardware at {uri!r}: an address is one of {FORMS}")
