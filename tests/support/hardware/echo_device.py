"""Device whose robot does nothing, for measuring round trip times. It prints its address.

With the argument "bare" it only answers each datagram with one of the size of a state frame.
"""

from __future__ import annotations

import select
import socket
import sys
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.device.server import DeviceServer
from cardsflow_fmu.hardware.protocol.frame import HEADER_BYTES

COMMANDS, STATES = 4, 12
SIGNATURE = 0x0123_4567_89AB_CDEF


class EchoRobot:
    """Robot whose state is its last command."""

    commands, states = COMMANDS, STATES

    def __init__(self) -> None:
        self._state = np.zeros(STATES)

    def apply(self, command: NDArray[np.float64]) -> None:
        self._state[:COMMANDS] = command

    def advance(self, dt: float) -> None:
        pass

    def state(self) -> NDArray[np.float64]:
        return self._state

    def safe(self) -> None:
        pass

    def reset(self) -> None:
        pass


def echo() -> NoReturn:
    """Answer datagrams without a device: the lower limit of the time for a device in Python."""
    answer = bytes(HEADER_BYTES + 8 * STATES)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.setblocking(False)
        line.bind(("127.0.0.1", 0))
        print(f"udp://127.0.0.1:{line.getsockname()[1]}", flush=True)
        while True:
            select.select([line], (), ())
            _, peer = line.recvfrom(4096)
            line.sendto(answer, peer)


if __name__ == "__main__":
    if sys.argv[1:] == ["bare"]:
        echo()
    key = bytes.fromhex(sys.argv[1]) if len(sys.argv) > 1 else None
    device = Device(EchoRobot(), SIGNATURE, 1e-3, key=key, watchdog=1.0, f_min=10.0, f_max=500.0)
    with DeviceServer(device, "udp://127.0.0.1:0") as server:
        print(server.uri, flush=True)
        server.run()
