"""Link by a serial line, with COBS framing."""

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

_FORM = "the form is serial:///dev/ttyACM0?baud=2000000"
_DEFAULT_BAUD = 115200
_CHUNK = 4096


class SerialLink(FramedLink):
    """Link by a serial line with 8 data bits, no parity and one stop bit.

    Args:
        uri: Address of the form serial:///dev/ttyACM0?baud=2000000. The default is 115200 baud.
        key: Pre-shared key, or None for unsigned frames.
        timeout: Maximum time for which `open` waits, in [s].
    """

    def __init__(self, uri: str, *, key: bytes | None = None, timeout: float = 2.0) -> None:
        super().__init__(uri, key=key, timeout=timeout)
        self._path, self._baud = serial_address(uri)
        self._line: serial.Serial | None = None

    def _connect(self) -> None:
        try:
            import serial
        except ImportError as error:
            problem = f"a serial link needs pyserial: {install('serial')}"
            raise HardwareError(problem) from error
        try:
            self._line = serial.Serial(self._path, self._baud, timeout=0, exclusive=True)
        except (OSError, ValueError) as error:
            raise HardwareError(f"cannot connect to {self.uri}: {error}") from error
        self._line.reset_input_buffer()
        self._is_last_complete = False  # the next frame begins with a zero, which ends earlier data
        self._unstuffer = Unstuffer(MAX_BYTES)
        self._frames: deque[bytes] = deque()

    def _disconnect(self) -> None:
        if self._line is not None:
            self._line.close()
            self._line = None

    def _send(self, data: bytes) -> None:
        if self._line is None:
            return
        stuffed = encode(data) if self._is_last_complete else b"\0" + encode(data)
        try:
            written = os.write(self._line.fileno(), stuffed)
        except OSError:  # unplugged or no buffer: treat the frame as lost
            written = 0
        self._is_last_complete = written == len(stuffed)
        self.counters["sent" if self._is_last_complete else "not sent"] += 1

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
        """Wait for bytes and return them. Return no bytes if none arrive in time."""
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
    """Return the path and the baud rate of an address such as serial:///dev/ttyACM0?baud=2000000."""
    parts = urlsplit(uri)
    query = parse_qs(parts.query, keep_blank_values=True)
    baud = query.pop("baud", [str(_DEFAULT_BAUD)])[-1]
    has_path = parts.scheme == "serial" and not parts.netloc and len(parts.path) > 1
    if not has_path or query or parts.fragment or not re.fullmatch("[0-9]{1,10}", baud):
        raise InputError(f"invalid serial address {uri!r}; {_FORM}")
    if not 0 < int(baud) < 2**31:
        raise InputError(f"invalid baud rate {baud}; {_FORM}")
    return parts.path, int(baud)
