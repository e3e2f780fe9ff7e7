"""The link by UDP: one connected socket, so that the system drops frames of other senders."""

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

_FORM = "an address by UDP is udp://HOST:PORT, such as udp://127.0.0.1:5005"
_EVERYBODY = "255.255.255.255"
_MAX_SELECTED = 1024
"""`select` takes file descriptors below this."""


class UdpLink(FramedLink):
    """Frames as datagrams.

    Args:
        uri: udp://HOST:PORT
        key: The pre-shared key; unsigned frames when None.
        bind: Address of this machine to send from; when empty, the one of the route to the device:
            loopback for a device on this machine.
        timeout: How long `open` waits, in [s].

    Raises:
        InputError: The address or the key cannot be used.
    """

    def __init__(
        self, uri: str, *, key: bytes | None = None, bind: str = "", timeout: float = 2.0
    ) -> None:
        super().__init__(uri, key=key, timeout=timeout)
        self._host, self._port = udp_address(uri)
        if self._port == 0:
            raise InputError(f"port 0 of {uri!r} cannot be sent to: {_FORM}")
        self._bind = bind
        self._socket: socket.socket | None = None
        self._receiver: AdaptiveReceiver[bytes] | None = None

    def _connect(self) -> None:
        family, there = resolved(self._host, self._port, self.uri)
        line = socket.socket(family, socket.SOCK_DGRAM)
        try:
            line.setblocking(False)
            if self._bind:
                line.bind((self._bind, 0))
            line.connect(there)
            if line.fileno() >= _MAX_SELECTED:
                raise HardwareError("too many files are open in this process for another link")
        except OSError as error:
            line.close()
            raise HardwareError(f"no link to {self.uri}: {error.strerror or error}") from error
        except HardwareError:
            line.close()
            raise
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
        except OSError:  # no listener, no route, no buffer: as good as lost
            self.counters["not sent"] += 1

    def _receive(self, deadline: float) -> bytes | None:
        receiver = self._receiver
        while receiver is not None:
            try:
                return receiver.receive(deadline)
            except OSError:  # an earlier frame had no receiver
                self.counters["refused"] += 1
                if time.monotonic() >= deadline:
                    break
        return None


def udp_address(uri: str) -> tuple[str, int]:
    """Host and port of udp://HOST:PORT; without a host it is this machine's loopback.

    Raises:
        InputError: It is no such address.
    """
    try:
        parts = urlsplit(uri)
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise InputError(f"cannot use {uri!r}: {_FORM}") from error
    rest = parts.path.strip("/") or parts.query or parts.fragment or parts.username
    if parts.scheme != "udp" or port is None or rest:
        raise InputError(f"cannot use {uri!r}: {_FORM}")
    return host or "127.0.0.1", port


def resolved(host: str, port: int, uri: str) -> tuple[int, Any]:
    """Family and address of a host.

    Raises:
        HardwareError: It is unknown, or an address of many machines.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or error
        raise HardwareError(f"no host {host!r}, in {uri}: {why}") from error
    family, _, _, _, address = found[0]
    number = _without_zone(str(address[0]))
    if number == _EVERYBODY or ipaddress.ip_address(number).is_multicast:
        raise HardwareError(f"{uri} is not the address of one machine")
    return family, address


def _without_zone(host: str) -> str:
    """Return an IPv6 address without its zone."""
    return host.partition("%")[0]
