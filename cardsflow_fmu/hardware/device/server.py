"""A UDP server of a device, in real time with absolute deadlines, or in lockstep.

One thread: between frames it checks the watchdog and advances the robot.
"""

from __future__ import annotations

import errno
import ipaddress
import math
import socket
import time
from collections.abc import Callable, Hashable
from functools import partial
from typing import Any, Protocol, Self

from cardsflow_fmu.hardware.links.datagram_wait import AdaptiveReceiver
from cardsflow_fmu.hardware.links.udp import resolved, udp_address
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.frame import MAX_BYTES

from .device import Device

_MAX_WAIT = 0.05
"""Longest time between two checks of `stop`, in [s]."""
_MAX_LEAP = 0.05
"""Longest delay that is caught up with; what is beyond is left out, in [s]."""
_MAX_FRAMES = 64
"""Frames answered before the device is advanced again, so that a flood cannot starve it."""


class Line(Protocol):
    """A line to the device and back; see `faults.FaultyLine`."""

    def send(self, data: bytes, peer: Hashable, now: float) -> None:
        """Send a frame towards the device."""

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        """Return the answers due until now, with their peers."""

    @property
    def next_due(self) -> float:
        """When `due` has something to do next, in [s]."""


class DeviceServer:
    """A device at a UDP address.

    Args:
        device: The device.
        uri: udp://HOST:PORT to listen at; port 0 takes a free one; without host on loopback only.
        line: Line between socket and device; none when None.

    Raises:
        InputError: It is no such address.
        HardwareError: The address cannot be listened at.

    Attributes:
        device: The device.
        uri: Its address, with the port that was taken.
        own_uri: The same for programs on this machine.
        is_open: Whether other machines can reach it.
        slipped: Time that was left out because the machine was too slow, in [s].
    """

    def __init__(self, device: Device, uri: str, *, line: Line | None = None) -> None:
        self.device, self._line = device, line
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
                remedy = "listen at an address of this machine; 0.0.0.0 is all of them"
            what = f"cannot listen at {uri}: {error.strerror or error}"
            raise HardwareError(f"{what}; {remedy}") from error
        address, port, *_ = self._socket.getsockname()
        self.uri = f"udp://{_shown(host)}:{port}"
        self.own_uri = f"udp://{_shown(_reached(address))}:{port}"
        self.is_open = not ipaddress.ip_address(address.partition("%")[0]).is_loopback
        self.slipped = 0.0
        self._receiver = AdaptiveReceiver(
            self._socket, partial(self._socket.recvfrom, MAX_BYTES + 1)
        )

    def run(self, stop: Callable[[], object] = bool) -> None:
        """Serve until `stop`, then leave the device in its safe state.

        Args:
            stop: Called at least every 50 ms; a true result ends serving.
        """
        reached = time.monotonic()
        try:
            while not stop():
                now = time.monotonic()
                reached = self._advance(reached, now)
                self.device.tick(now)
                if self._line is not None:
                    self._send_all(self._line.due(now))
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

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _advance(self, reached: float, now: float) -> float:
        """Advance the device by the steps that are due; returns the time that it has reached."""
        device = self.device
        if now - reached > max(_MAX_LEAP, 2 * device.step):
            if device.state == "running":
                self.slipped += now - reached - device.step
            reached = now - device.step
        while reached + device.step <= now:
            device.advance(device.step)
            reached += device.step
        return reached

    def _next_event(self, reached: float) -> float:
        """Return the time of the next step, watchdog check or delayed frame."""
        device = self.device
        event = min(time.monotonic() + _MAX_WAIT, device.next_deadline)
        if device.goes_by_clock:
            event = min(event, reached + device.step)
        return event if self._line is None else min(event, self._line.next_due)

    def _take_frames(self, until: float) -> None:
        """Answer frames until the next event."""
        device, state = self.device, self.device.state
        for _ in range(_MAX_FRAMES):
            try:
                came = self._receiver.receive(until)
            except OSError:  # an earlier answer had no receiver
                continue
            if came is None:
                return
            data, peer = came
            now = time.monotonic()
            if self._line is None:
                for answer in device.receive(data, peer, now):
                    self._send(answer, peer)
            else:
                self._line.send(data, peer, now)
                self._send_all(self._line.due(now))
            if self._line is not None or device.state is not state:
                return  # the next event has changed

    def _send_all(self, frames: list[tuple[bytes, Hashable]]) -> None:
        for data, peer in frames:
            self._send(data, peer)

    def _send(self, data: bytes, peer: Any) -> None:
        try:
            self._socket.sendto(data, peer)
        except OSError:  # no route, no buffer: as good as lost
            self.device.counters["not sent"] += 1


def _shown(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _reached(address: str) -> str:
    """Return the address at which this machine reaches what listens at one."""
    return {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(address, address)


def serve(
    device: Device,
    uri: str,
    *,
    stop: Callable[[], object] = bool,
    line: Line | None = None,
    duration: float = math.inf,
    ready: Callable[[str], object] = lambda uri: None,
) -> None:
    """Serve a device until `stop`, then leave it in its safe state.

    Args:
        device: As for `DeviceServer`.
        uri: As for `DeviceServer`.
        stop: As for `DeviceServer.run`.
        line: As for `DeviceServer`.
        duration: Longest time, in [s].
        ready: Called with the address, with the port that was taken, once it listens.

    Raises:
        InputError: It is no such address.
        HardwareError: The address cannot be listened at.
    """
    with DeviceServer(device, uri, line=line) as server:
        ready(server.uri)
        end = time.monotonic() + duration
        server.run(lambda: stop() or time.monotonic() >= end)
