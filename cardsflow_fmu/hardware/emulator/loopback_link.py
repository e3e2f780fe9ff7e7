"""Link to a device in the same process."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.links.framed_link import FramedLink

_PEER = "loopback"
_MAX_CATCH_UP = 0.1
"""Maximum time by which a device is advanced at once, in [s]."""


class LoopbackLink(FramedLink):
    """Link that advances its device by the elapsed time, or in lockstep.

    Args:
        make_device: Function that creates the device. It is called once, at the first `open`.
        key: Pre-shared key, or None for unsigned frames.
        timeout: Maximum time for which `open` waits, in [s].

    Raises:
        InputError: The key is too short.

    Attributes:
        device: The device, or None before `open`.
    """

    def __init__(
        self, make_device: Callable[[], Device], *, key: bytes | None = None, timeout: float = 2.0
    ) -> None:
        super().__init__("loopback:", key=key, timeout=timeout)
        self._make_device = make_device
        self.device: Device | None = None
        self._answers: deque[bytes] = deque()
        self._connected = False

    def _connect(self) -> None:
        if self.device is None:
            self.device = self._make_device()
        self._answers.clear()
        self._reached = time.monotonic()
        self._connected = True

    def _disconnect(self) -> None:
        self._connected = False

    def _send(self, data: bytes) -> None:
        if self.device is None or not self._connected:
            return
        now = time.monotonic()
        self._advance(self.device, now)
        self._answers.extend(self.device.receive(data, _PEER, now))
        self.counters["sent"] += 1

    def _receive(self, deadline: float) -> bytes | None:
        if self._answers:
            return self._answers.popleft()
        time.sleep(max(deadline - time.monotonic(), 0.0))
        return None

    def _advance(self, device: Device, now: float) -> None:
        """Advance the device to the current time, in whole steps of the device."""
        steps = int(min(now - self._reached, _MAX_CATCH_UP) / device.step)
        for _ in range(steps):
            device.advance(device.step)
        left = now - self._reached - steps * device.step
        self._reached = now - min(left, device.step)
