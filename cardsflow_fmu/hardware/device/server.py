"""Serves a device by UDP: in real time by absolute deadlines, or in lock step.

One thread. Frames are taken as they come; between them the device has its watchdog and its steps.
"""

from __future__ import annotations

import errno
import math
import socket
import time
from collections.abc import Callable, Hashable
from functools import partial
from types import TracebackType
from typing import Any, Protocol, Self

from cardsflow_fmu.hardware.links.datagram_wait import Waiter
from cardsflow_fmu.hardware.links.udp import resolved, udp_address
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.frame import MOST_BYTES

from .device import Device

_LONGEST_WAIT = 0.05
"""So often it looks at least whether to stop, in [s]."""
_LONGEST_LEAP = 0.05
"""Time that is made up for after a hold-up; what is beyond is left out, in [s]."""
_MOST_FRAMES = 64
"""Frames taken before the device has its turn again, so that a flood of them cannot starve it."""


class Way(Protocol):
    """What frames go through to the device and back; see `faults.FaultyWay`."""

    def send(self, data: bytes, peer: Hashable, now: float) -> None:
        """Send a frame towards the device."""

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        """The answers that come out until now, with peers."""

    @property
    def next_due(self) -> float:
        """When `due` has something to do next, in [s]."""


class DeviceServer:
    """A device at a UDP address.

    Args:
        device: What is served.
        uri: udp://HOST:PORT to listen at; port 0 takes a free one; without host on loopback only.
        way: What frames go through; straight to the device when None.

    Raises:
        InputError: It is no such address.
        HardwareError: The address cannot be listened at.

    Attributes:
        device: What is served.
        uri: Where it listens, with the port that was taken.
        slipped: Time that was left out because the machine was too slow, in [s].
    """

    def __init__(self, device: Device, uri: str, *, way: Way | None = None) -> None:
        self.device, self._way = device, way
        host, port = udp_address(uri)
        family, here = resolved(host, port, uri)
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.bind(here)
        except OSError as error:
            self._socket.close()
            remedy = "is another device running there?"
            if error.errno == errno.EADDRNOTAVAIL:
                remedy = "listen at an address of this machine; 0.0.0.0 stands for all of them"
            what = f"cannot listen at {uri}: {error.strerror or error}"
            raise HardwareError(f"{what}; {remedy}") from error
        shown = f"[{host}]" if ":" in host else host
        self.uri = f"udp://{shown}:{self._socket.getsockname()[1]}"
        self.slipped = 0.0
        self._waiter = Waiter(self._socket, partial(self._socket.recvfrom, MOST_BYTES + 1))

    def run(self, stop: Callable[[], object] = bool) -> None:
        """Serve until told to stop, then leave the device in its safe state.

        Args:
            stop: Asked at least every 50 ms; a true answer ends serving.
        """
        reached = time.monotonic()
        try:
            while not stop():
                now = time.monotonic()
                reached = self._go_on(reached, now)
                self.device.tick(now)
                if self._way is not None:
                    self._send_all(self._way.due(now))
                resting = not self.device.goes_by_clock
                self._take_frames(self._next_event(reached))
                if resting:  # what passed before the first set point is not the run's
                    reached = time.monotonic()
        finally:
            self.device.go_safe()

    def close(self) -> None:
        """Give the address back."""
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _go_on(self, reached: float, now: float) -> float:
        """Let the device take the steps that are due; returns the time that it has reached."""
        device = self.device
        if now - reached > max(_LONGEST_LEAP, 2 * device.step):
            if device.state == "running":
                self.slipped += now - reached - device.step
            reached = now - device.step
        while reached + device.step <= now:
            device.advance(device.step)
            reached += device.step
        return reached

    def _next_event(self, reached: float) -> float:
        """Until when there is nothing to do but to wait for frames."""
        device = self.device
        event = min(time.monotonic() + _LONGEST_WAIT, device.next_deadline)
        if device.goes_by_clock:
            event = min(event, reached + device.step)
        return event if self._way is None else min(event, self._way.next_due)

    def _take_frames(self, until: float) -> None:
        """Answer frames until there is something else to do."""
        device, state = self.device, self.device.state
        for _ in range(_MOST_FRAMES):
            try:
                came = self._waiter.receive(until)
            except OSError:  # a link that was answered is no longer there
                continue
            if came is None:
                return
            data, peer = came
            now = time.monotonic()
            if self._way is None:
                for answer in device.receive(data, peer, now):
                    self._send(answer, peer)
            else:
                self._way.send(data, peer, now)
                self._send_all(self._way.due(now))
            if self._way is not None or device.state is not state:
                return  # what is due next, and when, is not what it was

    def _send_all(self, frames: list[tuple[bytes, Hashable]]) -> None:
        for data, peer in frames:
            self._send(data, peer)

    def _send(self, data: bytes, peer: Any) -> None:
        try:
            self._socket.sendto(data, peer)
        except OSError:  # no way there, no room: as good as lost
            self.device.counters["not sent"] += 1


def serve(
    device: Device,
    uri: str,
    *,
    stop: Callable[[], object] = bool,
    way: Way | None = None,
    duration: float = math.inf,
    ready: Callable[[str], object] = lambda uri: None,
) -> None:
    """Serve a device until told to stop, then leave it in its safe state.

    Args:
        device: What is served.
        uri: udp://HOST:PORT to listen at; port 0 takes a free one; without host on loopback only.
        stop: Asked at least every 50 ms; a true answer ends serving.
        way: What frames go through, such as `faults.FaultyWay`; straight to the device when None.
        duration: Longest time, in [s].
        ready: Called with the address, with the port that was taken, once frames are heard.

    Raises:
        InputError: It is no such address.
        HardwareError: The address cannot be listened at.
    """
    with DeviceServer(device, uri, way=way) as server:
        ready(server.uri)
        end = time.monotonic() + duration
        server.run(lambda: stop() or time.monotonic() >= end)
