"""UDP server of a device, in real time with absolute deadlines or in lockstep.

The server uses one thread. Between frames it checks the watchdog and advances the robot.
"""

from __future__ import annotations

import errno
import ipaddress
import socket
import time
from collections.abc import Callable, Hashable
from functools import partial
from typing import Any, Protocol, Self

from cardsflow_fmu.hardware.links.datagram_wait import AdaptiveReceiver
from cardsflow_fmu.hardware.links.udp import resolve_host, udp_address
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.frame import MAX_BYTES

from .device import Device

_MAX_WAIT = 0.05
"""Maximum time between two checks of `stop`, in [s]."""
_MAX_CATCH_UP = 0.05
"""Maximum delay of the simulation that the server makes up, in [s]. Longer delays are skipped."""
_MAX_FRAMES = 64
"""Maximum number of frames answered between two steps, so that a flood cannot stop the robot."""


class Line(Protocol):
    """Interface of a two-way line to a device; see `faults.FaultyLine`."""

    def send(self, data: bytes, peer: Hashable, now: float) -> None:
        """Send a frame to the device."""

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        """Return the answers that have arrived by now, with their peers."""

    @property
    def next_due(self) -> float:
        """Arrival time of the next frame in either direction, in [s]."""


class DeviceServer:
    """Server of a device at a UDP address.

    Args:
        uri: Address to listen on, udp://HOST:PORT. Port 0 selects a free port. Without a host, the
            server listens on the loopback interface only.
        line: Line between socket and device, or None for a direct connection.

    Raises:
        InputError: The address is invalid.
        HardwareError: The server cannot listen on the address.

    Attributes:
        uri: Address of the server, with the selected port.
        own_uri: Address of the server for programs on the same machine.
        is_open: Whether other machines can reach the server.
        slipped: Time that was skipped because the machine was too slow, in [s].
        lateness: Maximum lateness of the robot's steps in the current run, in [s].
    """

    def __init__(self, device: Device, uri: str, *, line: Line | None = None) -> None:
        self.device, self._line = device, line
        host, port = udp_address(uri)
        family, local_address = resolve_host(host, port, uri)
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.bind(local_address)
        except OSError as error:
            self._socket.close()
            remedy = "does another device use this address?"
            if error.errno == errno.EADDRNOTAVAIL:
                remedy = "use an address of this machine, or 0.0.0.0 for all its addresses"
            problem = f"cannot listen on {uri}: {error.strerror or error}"
            raise HardwareError(f"{problem}; {remedy}") from error
        address, port, *_ = self._socket.getsockname()
        self.uri = f"udp://{_uri_host(host)}:{port}"
        self.own_uri = f"udp://{_uri_host(_local_host(address))}:{port}"
        self.is_open = not ipaddress.ip_address(address.partition("%")[0]).is_loopback
        self.slipped = self.lateness = 0.0
        self._receiver = AdaptiveReceiver(
            self._socket, partial(self._socket.recvfrom, MAX_BYTES + 1)
        )

    def run(self, stop: Callable[[], object] = bool) -> None:
        """Serve the device until `stop` returns a true value, then bring it to its safe state.

        Args:
            stop: Function that is called at least every 50 ms.
        """
        reached = time.monotonic()
        try:
            while not stop():
                now = time.monotonic()
                reached = self._advance(reached, now)
                self.device.tick(now)
                if self._line is not None:
                    self._send_all(self._line.due(now))
                is_at_rest = not self.device.moves_in_real_time
                self._answer_frames(self._next_event(reached))
                if is_at_rest:  # time before the first set point is not simulated
                    reached = time.monotonic()
        finally:
            self.device.go_safe()

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _advance(self, reached: float, now: float) -> float:
        """Advance the device by all due steps. Return the time up to which it is simulated."""
        device = self.device
        if device.state == "ready":
            self.lateness = 0.0
        elif device.moves_in_real_time:
            self.lateness = max(self.lateness, now - reached - device.step)
        if now - reached > max(_MAX_CATCH_UP, 2 * device.step):
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
        if device.moves_in_real_time:
            event = min(event, reached + device.step)
        return event if self._line is None else min(event, self._line.next_due)

    def _answer_frames(self, until: float) -> None:
        """Answer frames until the next event."""
        device, state = self.device, self.device.state
        for _ in range(_MAX_FRAMES):
            try:
                received = self._receiver.receive(until)
            except OSError:  # the system reports that an earlier answer was not delivered
                continue
            if received is None:
                return
            data, peer = received
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
        except OSError:  # no route or no buffer: treat the frame as lost
            self.device.counters["not sent"] += 1


def _uri_host(host: str) -> str:
    """Return the host as written in a URI, with brackets around an IPv6 address."""
    return f"[{host}]" if ":" in host else host


def _local_host(address: str) -> str:
    """Return the address by which programs on this machine reach a server."""
    return {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(address, address)
