"""The link to a device in this process."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.links.framed_link import FramedLink

_PEER = "loopback"
_MAX_LEAP = 0.1
"""Longest time that a device is advanced by at once, in [s]."""


class LoopbackLink(FramedLink):
    """A link that advances its device by the time that has passed, or in lockstep.

    Args:
        make_device: Makes the device; called once, at the first `open`.
        key: The pre-shared key; unsigned frames when None.
        timeout: How long `open` waits, in [s].

    Raises:
        InputError: The key is too short.

    Attributes:
        device: The device; None before `open`.
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
        """Advance the device to the present, in whole steps of its own."""
        steps = int(min(now - self._reached, _MAX_LEAP) / device.step)
        for _ in range(steps):
            device.advance(device.step)
        left = now - self._reached - steps * device.step
        self._reached = now - min(left, device.step)
