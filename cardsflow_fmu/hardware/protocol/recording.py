"""Recordings of all exchanges with hardware.

A recording is written record by record, so that it is readable even if the process is killed. All
numbers are little-endian:

    0   8 bytes   b"CFHWREC" and a zero
    8   u32       version, 1
    12  u32       length of the header in bytes
    16  u32       CRC-32 of the header
    20  header    JSON: names, units, signature, step, scale, run id, versions

Records of 40 + 8 (commands + states) bytes each follow:

    0   f64       t, time of the run at the beginning of the step, in [s]
    8   f64       age of the newest state, in [s]
    16  f64       round trip time, in [s]; NaN if no answer has arrived
    24  u32       sequence number
    28  u32       flags: bits 0 to 15 are the device's; bit 16: no new state has arrived
    32  f64s      commands, then states, in SI units; states are NaN if no state has arrived
    end u32       record number, from 0;  u32  CRC-32 of the record before this field

Reading stops at the first truncated or damaged record and returns the records before it.
"""

from __future__ import annotations

import json
import math
import struct
import sys
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.errors import MachineError
from addin_sdfusion.robot.files import file_error, open_file, read_file
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import require_table

from .exchange import Exchange
from .recording_header import RecordingHeader as RecordingHeader
from .recording_header import header_data, header_of

MISSED = 1 << 16
"""Flag of a record without a new state."""

_MAGIC = b"CFHWREC\0"
_VERSION = 1
_PREAMBLE = struct.Struct("<8sIII")
_FIXED = struct.Struct("<dddII")
_ENDING = struct.Struct("<II")
_MAX_HEADER = 2**20


class Recorder:
    """Writer of a recording, also a context manager that closes the file.

    Each record is written without buffering, so that no record is lost if the process is killed. A
    full disk ends the recording but not the run; `failure` contains the reason.

    Args:
        file: The file to write. An existing recording is overwritten.

    Raises:
        InputError: The file cannot be written, or exists and is not a recording.

    Attributes:
        records: Number of records written.
        failure: Reason why recording has ended early, or None.
    """

    def __init__(self, file: str | Path, header: RecordingHeader) -> None:
        self.file = Path(file)
        self.records = 0
        self.failure: str | None = None
        self._header = header
        self._no_state = np.full(header.states, math.nan)
        content = json_text(header_data(header), indent=1).encode()
        preamble = _PREAMBLE.pack(_MAGIC, _VERSION, len(content), zlib.crc32(content))
        try:
            _require_recording(self.file)
            self._stream = self.file.open("wb", buffering=0)
        except (OSError, ValueError) as error:
            raise file_error(error, "cannot be written", self.file) from None
        if not self._append(preamble + content):
            self._stream.close()
            raise MachineError(f"cannot be written: {self.failure}", self.file)

    def write(self, t: float, command: FloatArray, exchange: Exchange) -> None:
        """Write a record.

        Args:
            t: Time of the run at the beginning of the step, in [s].
            command: Set point that was sent, shape (commands,), in SI units.
        """
        missed = exchange.state is None
        state = self._no_state if exchange.state is None else exchange.state
        assert command.shape == (self._header.commands,)
        assert state.shape == (self._header.states,)
        flags = (exchange.device_flags & 0xFFFF) | (MISSED if missed else 0)
        body = (
            _FIXED.pack(t, exchange.age, exchange.round_trip, exchange.seq & 0xFFFFFFFF, flags)
            + command.astype("<f8").tobytes()
            + state.astype("<f8").tobytes()
            + (self.records & 0xFFFFFFFF).to_bytes(4, "little")
        )
        record = body + zlib.crc32(body).to_bytes(4, "little")
        self.records += self._append(record)

    def close(self) -> None:
        """Close the file. Further calls do nothing."""
        self._stream.close()

    def _append(self, data: bytes) -> bool:
        """Write bytes without buffering. Return whether all bytes are written."""
        if self.failure is None and not self._stream.closed:
            try:
                if self._stream.write(data) == len(data):
                    return True
                self.failure = "the disk is full"
            except OSError as error:
                self.failure = error.strerror or str(error)
        return False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


@dataclass(frozen=True)
class HardwareRecording:
    """Contents of a recording, with one row per exchange.

    Attributes:
        t: Time of the run at the beginning of the step, shape (rows,), in [s].
        commands: Set points, shape (rows, commands), in SI units.
        states: States, shape (rows, states), in SI units; NaN if no state has arrived.
        seq: Sequence numbers, shape (rows,).
        age: Age of the newest state, shape (rows,), in [s].
        round_trip: Round trip times, shape (rows,), in [s]; NaN if no answer has arrived.
        flags: Flags, shape (rows,): the device's flags in the lower 16 bits, and `MISSED`.
        lost_bytes: Number of bytes after the last valid record, which are truncated or damaged.
    """

    header: RecordingHeader
    t: FloatArray
    commands: FloatArray
    states: FloatArray
    seq: NDArray[np.uint32]
    age: FloatArray
    round_trip: FloatArray
    flags: NDArray[np.uint32]
    lost_bytes: int

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.t)


def read_recording(file: str | Path) -> HardwareRecording:
    """Read a recording.

    Raises:
        InputError: The file is not a recording, has an unsupported version, or has a damaged
            header.
    """
    file = Path(file)
    data = read_file(file, limits.RECORDING)
    header, begin = _read_header(data, file)
    rows = np.dtype(
        [
            *((name, "<f8") for name in ("t", "age", "round_trip")),
            *((name, "<u4") for name in ("seq", "flags")),
            ("commands", "<f8", (header.commands,)),
            ("states", "<f8", (header.states,)),
            *((name, "<u4") for name in ("number", "checksum")),
        ]
    )
    count = _count_valid_records(data, begin, rows.itemsize)
    table = np.frombuffer(data, rows, count, begin)
    require_table(["time"], table["t"][:, np.newaxis], file, kind="hardware recording")
    return HardwareRecording(
        header=header,
        **{
            name: np.array(table[name])
            for name in ("t", "commands", "states", "seq", "age", "round_trip", "flags")
        },
        lost_bytes=len(data) - begin - count * rows.itemsize,
    )


def _count_valid_records(data: bytes, begin: int, length: int) -> int:
    """Return the number of records before the first truncated, damaged or misplaced record."""
    view = memoryview(data)
    count = (len(data) - begin) // length
    for k in range(count):
        first, end = begin + k * length, begin + (k + 1) * length
        number, checksum = _ENDING.unpack_from(data, end - _ENDING.size)
        if number != k & 0xFFFFFFFF or checksum != zlib.crc32(view[first : end - 4]):
            return k
    return count


def _read_header(data: bytes, file: Path) -> tuple[RecordingHeader, int]:
    """Return the header, and the position of the first record."""
    if len(data) < _PREAMBLE.size or not data.startswith(_MAGIC):
        raise InputError("is not a hardware recording", file=file)
    _, version, length, checksum = _PREAMBLE.unpack_from(data)
    if version != _VERSION:
        problem = f"has the unsupported version {version}; supported: {_VERSION}"
        raise InputError(problem, file=file)
    begin = _PREAMBLE.size + length
    content = data[_PREAMBLE.size : begin]
    if length > _MAX_HEADER or len(content) < length or zlib.crc32(content) != checksum:
        raise InputError("its header is damaged", file=file)
    try:
        return header_of(json.loads(content)), begin
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        problem = f"its header is invalid: {' '.join(str(error).split())}"
        raise InputError(problem, file=file) from None


def _require_recording(file: Path) -> None:
    """Reject an existing file that is not a recording, so that it is not overwritten."""
    if not file.exists():
        return
    if not file.is_file():
        raise InputError("is not a regular file", file=file)
    if not is_recording(file):
        raise InputError("already exists and is not a hardware recording", file=file)


def is_recording(file: Path) -> bool:
    """Return whether a file begins like a recording.

    An empty file is a recording too: it remains if a process is killed early.
    """
    with open_file(file, sys.maxsize) as stream:
        return stream.read(len(_MAGIC)) in (b"", _MAGIC)
