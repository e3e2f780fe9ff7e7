"""The link by a serial line: frames in COBS."""

from __future__ import annotations

import os
import re
import select
import time
from collections import deque
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, urlsplit

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.protocol.cobs import Unstuffer, encode
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.frame import MAX_BYTES
from cardsflow_fmu.utils.extras import install

from .framed_link import FramedLink

if TYPE_CHECKING:
    import serial

_FORM = "a serial address is serial:///dev/ttyACM0?baud=2000000"
_BAUD = 115200
_CHUNK = 4096


class SerialLink(FramedLink):
    """Frames over a serial line, 8 data bits, no parity, one stop bit.

    Args:
        uri: serial:///dev/ttyACM0?baud=2000000; 115200 baud unless given.
        key: The pre-shared key; unsigned frames when None.
        timeout: How long `open` waits, in [s].

    Raises:
        InputError: The address or the key cannot be used.
    """

    def __init__(self, uri: str, *, key: bytes | None = None, timeout: float = 2.0) -> None:
        super().__init__(uri, key=key, timeout=timeout)
        self._path, self._baud = serial_address(uri)
        self._line: serial.Serial | None = None

    def _connect(self) -> None:
        try:
            import serial
        except ImportError as error:
            what = f"a serial link needs pyserial: {install('serial')}"
            raise HardwareError(what) from error
        try:
            self._line = serial.Serial(self._path, self._baud, timeout=0, exclusive=True)
        except (OSError, ValueError) as error:
            raise HardwareError(f"no link to {self.uri}: {error}") from error
        self._line.reset_input_buffer()
        self._is_whole = False  # a zero ends what was sent before
        self._unstuffer = Unstuffer(MAX_BYTES)
        self._frames: deque[bytes] = deque()

    def _disconnect(self) -> None:
        if self._line is not None:
            self._line.close()
            self._line = None

    def _send(self, data: bytes) -> None:
        if self._line is None:
            return
        stuffed = encode(data) if self._is_whole else b"\0" + encode(data)
        try:
            written = os.write(self._line.fileno(), stuffed)
        except OSError:  # unplugged, or no buffer: as good as lost
            written = 0
        self._is_whole = written == len(stuffed)
        self.counters["sent" if self._is_whole else "not sent"] += 1

    def _receive(self, deadline: float) -> bytes | None:
        while not self._frames:
            remaining = max(deadline - time.monotonic(), 0.0)
            chunk = self._read(remaining)
            if not chunk:
                return None
            self._frames.extend(self._unstuffer.take(chunk))
            self.counters["stuffing"] = self._unstuffer.damaged
        return self._frames.popleft()

    def _read(self, seconds: float) -> bytes:
        """Return the bytes received, after a wait for some; empty if none come."""
        line = self._line
        if line is None:
            return b""
        try:
            if not select.select([line], (), (), seconds)[0]:
                return b""
            return bytes(line.read(_CHUNK))
        except OSError:  # unplugged
            self.counters["refused"] += 1
            time.sleep(seconds)
            return b""


def serial_address(uri: str) -> tuple[str, int]:
    """Path and baud rate of serial:///dev/ttyACM0?baud=2000000.

    Raises:
        InputError: It is no such address.
    """
    parts = urlsplit(uri)
    query = parse_qs(parts.query, keep_blank_values=True)
    baud = query.pop("baud", [str(_BAUD)])[-1]
    good = parts.scheme == "serial" and not parts.netloc and len(parts.path) > 1
    if not good or query or parts.fragment or not re.fullmatch("[0-9]{1,10}", baud):
        raise InputError(f"cannot use {uri!r}: {_FORM}")
    if not 0 < int(baud) < 2**31:
        raise InputError(f"cannot use {baud} baud: {_FORM}")
    return parts.path, int(baud)
