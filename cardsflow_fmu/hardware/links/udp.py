"""Link by UDP. The socket is connected, so that the system drops frames of other senders."""

from __future__ import annotations

import ipaddress
import socket
import time
from functools import partial
from typing import Any
from urllib.parse import urlsplit

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.frame import MAX_BYTES

from .datagram_wait import AdaptiveReceiver
from .framed_link import FramedLink

_FORM = "the form is udp://HOST:PORT, such as udp://127.0.0.1:5005"
_BROADCAST = "255.255.255.255"
_MAX_DESCRIPTORS = 1024
"""Limit of `select`, which supports only smaller file descriptors."""


class UdpLink(FramedLink):
    """Link by UDP, with one frame per datagram.

    Args:
        uri: Address of the form udp://HOST:PORT.
        key: Pre-shared key, or None for unsigned frames.
        bind: Address of this machine to send from. If empty, the system chooses the address of the
            route to the device, which is loopback for a device on the same machine.
        timeout: Maximum time for which `open` waits, in [s].
    """

    def __init__(
        self, uri: str, *, key: bytes | None = None, bind: str = "", timeout: float = 2.0
    ) -> None:
        super().__init__(uri, key=key, timeout=timeout)
        self._host, self._port = udp_address(uri)
        if self._port == 0:
            raise InputError(f"invalid UDP address {uri!r}: the port must not be 0; {_FORM}")
        self._bind = bind
        self._socket: socket.socket | None = None
        self._receiver: AdaptiveReceiver[bytes] | None = None

    def _connect(self) -> None:
        family, address = resolve_host(self._host, self._port, self.uri)
        line = socket.socket(family, socket.SOCK_DGRAM)
        try:
            line.setblocking(False)
            if self._bind:
                line.bind((self._bind, 0))
            line.connect(address)
            if line.fileno() >= _MAX_DESCRIPTORS:
                raise OSError("this process has too many open files")
        except OSError as error:
            line.close()
            problem = f"cannot connect to {self.uri}: {error.strerror or error}"
            raise HardwareError(problem) from error
        self._socket = line
        self._receiver = AdaptiveReceiver(line, partial(line.recv, MAX_BYTES + 1))

    def _disconnect(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = self._receiver = None

    def _send(self, data: bytes) -> None:
        if self._socket is None:
            return
        try:
            self._socket.send(data)
            self.counters["sent"] += 1
        except OSError:  # no listener, no route or no buffer: treat the frame as lost
            self.counters["not sent"] += 1

    def _receive(self, deadline: float) -> bytes | None:
        receiver = self._receiver
        while receiver is not None:
            try:
                return receiver.receive(deadline)
            except OSError:  # the system reports that an earlier frame had no receiver
                self.counters["refused"] += 1
                if time.monotonic() >= deadline:
                    break
        return None


def udp_address(uri: str) -> tuple[str, int]:
    """Return the host and the port of udp://HOST:PORT. The default host is 127.0.0.1."""
    try:
        parts = urlsplit(uri)
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise InputError(f"invalid UDP address {uri!r}; {_FORM}") from error
    rest = parts.path.strip("/") or parts.query or parts.fragment or parts.username
    if parts.scheme != "udp" or port is None or rest:
        raise InputError(f"invalid UDP address {uri!r}; {_FORM}")
    return host or "127.0.0.1", port


def resolve_host(host: str, port: int, uri: str) -> tuple[int, Any]:
    """Return the address family and the socket address of a host.

    Raises:
        HardwareError: The host is unknown, or the address is a multicast or broadcast address.
    """
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or error
        raise HardwareError(f"unknown host {host!r} in {uri}: {why}") from error
    family, _, _, _, address = addresses[0]
    number = str(address[0]).partition("%")[0]  # without the zone of IPv6
    if number == _BROADCAST or ipaddress.ip_address(number).is_multicast:
        raise HardwareError(f"{uri} must be the address of one machine, not of a group")
    return family, address
