"""Frames between a simulation and a device: packing, unpacking, checksum, authentication.

All numbers are little-endian. docs/reference/hardware_protocol.md describes frames for firmware.

    0   u32  magic, b"CFHW"          24  u64  sender's monotonic clock, in [ns]
    4   u8   version, 1              32  u64  copy of bytes 24 to 31 of the answered frame, or 0
    5   u8   kind                    40  u16  n
    6   u16  flags                   42  u16  reserved, 0
    8   u32  run id                  44  u32  CRC-32 of the frame with this field 0
    12  u32  sequence number         48  n f64
    16  f64  time of the run in [s]  if signed: 32 bytes HMAC-SHA256 of all preceding bytes
"""

from __future__ import annotations

import hmac
import math
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.arrays import FloatArray

from .errors import HardwareError

MAGIC = 0x57484643
VERSION = 1
HEADER = struct.Struct("<IBBHIIdQQHHI")
HEADER_BYTES = HEADER.size
MAC_BYTES = 32
MIN_KEY = 16
MAX_VALUES = 4096
MAX_BYTES = HEADER_BYTES + 8 * MAX_VALUES + MAC_BYTES

_CHECKSUM = struct.Struct("<I")
_CHECKSUM_AT = 44
_KIND_AT = 5
_RUN_ID = slice(8, 12)
_NO_CHECKSUM = bytes(4)
_FLOAT64 = np.dtype("<f8")
_RUN_ID_AND_NONCE = struct.Struct("<IQ")


class Kind(IntEnum):
    """Kind of a frame."""

    HELLO = 1
    HELLO_ACK = 2
    SETPOINT = 3
    STATE = 4
    STOP = 5
    STOPPED = 6
    ERROR = 7
    PING = 8
    PONG = 9


class Flag(IntFlag):
    """Bits of the flags of a frame. Senders set the other bits to 0; receivers ignore them."""

    SIGNED = 1
    """An HMAC follows the values."""
    LOCKSTEP = 2
    """The device advances by one step for each set point."""
    SAFE = 4
    """The device is in its safe state and does not follow set points."""
    FAULT = 8
    """The robot of the device has failed."""
    CLAMPED = 16
    """The set point was out of bounds and has been clamped."""


SIGNED = int(Flag.SIGNED)

_KINDS = {int(kind): kind for kind in Kind}
_WITH_PRE_SHARED_KEY = frozenset((Kind.HELLO, Kind.HELLO_ACK, Kind.ERROR))


class FrameError(HardwareError):
    """A frame is invalid.

    Args:
        reason: Reason: "length", "magic", "version", "type", "checksum", "signature", "unsigned" or
            "not finite".
    """

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(f"a frame was rejected: {reason}")


class Frame(NamedTuple):
    """Contents of a frame. It is a tuple, since both sides create one in every exchange.

    Attributes:
        flags: Bits of `Flag`. `pack` sets the bit of the signature.
        run_id: Id of the run, 32 bits.
        seq: Sequence number, 32 bits.
        t_sim: Time of the run, in [s].
        t_send_ns: Time of sending on the sender's monotonic clock, in [ns].
        echo_ns: `t_send_ns` of the answered frame, or 0.
    """

    kind: Kind
    flags: int
    run_id: int
    seq: int
    t_sim: float
    t_send_ns: int
    echo_ns: int
    values: Sequence[float] | FloatArray


def pack(frame: Frame, key: bytes | None = None) -> bytes:
    """Return the bytes of a frame.

    Args:
        key: Key of the signature, or None for an unsigned frame.

    Raises:
        FrameError: A number is not finite, or there are too many values.
    """
    values = np.asarray(frame.values, _FLOAT64)
    if len(values) > MAX_VALUES:
        raise FrameError("length")
    writer = FrameWriter(len(values))
    writer.values[:] = values
    return writer.pack(*frame[:-1], key)


class FrameWriter:
    """Writer of frames with a fixed number of values, with a reusable buffer.

    Attributes:
        values: Values of the next frame, shape (count,). The caller writes into this array.
    """

    def __init__(self, count: int) -> None:
        self._bytes = bytearray(HEADER_BYTES + 8 * count)
        self._count = count
        self.values: FloatArray = np.frombuffer(self._bytes, _FLOAT64, count, HEADER_BYTES)

    def pack(
        self,
        kind: int,
        flags: int,
        run_id: int,
        seq: int,
        t_sim: float,
        t_send_ns: int,
        echo_ns: int,
        key: bytes | None,
        *,
        are_finite: bool = False,
    ) -> bytes:
        """Return the bytes of a frame with the current values.

        `Frame` describes the other arguments.

        Args:
            flags: Bits of `Flag`.
            t_sim: Time of the run, in [s].
            t_send_ns: Time of sending, in [ns].
            echo_ns: `t_send_ns` of the answered frame, or 0.
            key: Key of the signature, or None for an unsigned frame.
            are_finite: Whether time and values are already checked to be finite.

        Raises:
            FrameError: A number is not finite.
        """
        if not (are_finite or (math.isfinite(t_sim) and all_finite(self.values))):
            raise FrameError("not finite")
        flags = flags & ~SIGNED if key is None else flags | SIGNED
        data = self._bytes
        count, unused, checksum = self._count, 0, 0
        HEADER.pack_into(
            data, 0,
            MAGIC, VERSION, kind, flags, run_id, seq, t_sim, t_send_ns, echo_ns,
            count, unused, checksum,
        )  # fmt: skip
        _CHECKSUM.pack_into(data, _CHECKSUM_AT, zlib.crc32(data))
        packed = bytes(data)
        return packed if key is None else packed + hmac.digest(key, packed, "sha256")


def unpack(data: bytes, key: bytes | None = None) -> Frame:
    """Return the frame in the given bytes. The array of its values is a view of the bytes.

    Args:
        data: Bytes of one complete frame.
        key: Key of the signature, or None. Without a key, the frame must be unsigned.

    Raises:
        FrameError: The bytes are not a frame, are damaged, or are not signed with this key.
    """
    if len(data) < HEADER_BYTES:
        raise FrameError("length")
    magic, version, kind, flags, run_id, seq, t_sim, sent, echo, count, _, checksum = (
        HEADER.unpack_from(data)
    )
    if magic != MAGIC:
        raise FrameError("magic")
    if version != VERSION:
        raise FrameError("version")
    if kind not in _KINDS:
        raise FrameError("type")
    end = HEADER_BYTES + 8 * count
    signed = flags & SIGNED
    if count > MAX_VALUES or len(data) != (end + MAC_BYTES if signed else end):
        raise FrameError("length")
    summed = b"".join((data[:_CHECKSUM_AT], _NO_CHECKSUM, data[HEADER_BYTES:end]))
    if checksum != zlib.crc32(summed):
        raise FrameError("checksum")
    if key is not None and not signed:
        raise FrameError("unsigned")
    if signed and (
        key is None or not hmac.compare_digest(hmac.digest(key, data[:end], "sha256"), data[end:])
    ):
        raise FrameError("signature")
    values: FloatArray = np.frombuffer(data, _FLOAT64, count, HEADER_BYTES)
    if not (math.isfinite(t_sim) and all_finite(values)):
        raise FrameError("not finite")
    return Frame(_KINDS[kind], flags, run_id, seq, t_sim, sent, echo, values)


@dataclass(frozen=True, slots=True)
class Keys:
    """Keys for signing the frames of a run.

    The pre-shared key signs the handshake and rejections. The run key signs all other frames.

    Attributes:
        pre_shared: Key that both sides share, or None for unsigned frames.
        run: Key of the current run, or None before the first run.

    Raises:
        InputError: The pre-shared key is shorter than 16 bytes.
    """

    pre_shared: bytes | None = None
    run: bytes | None = None

    def __post_init__(self) -> None:
        if self.pre_shared is not None and len(self.pre_shared) < MIN_KEY:
            problem = f"a key must have at least {MIN_KEY} bytes, not {len(self.pre_shared)}"
            raise InputError(f"{problem}; create one with `head -c 32 /dev/urandom > key.bin`")

    def for_run(self, run_id: int, nonce: int) -> Keys:
        """Return the keys of a run. The run key differs from the keys of all other runs.

        Args:
            run_id: Random number chosen by the link, 32 bits.
            nonce: Random number chosen by the device, 64 bits.
        """
        if self.pre_shared is None:
            return self
        key = hmac.digest(self.pre_shared, _RUN_ID_AND_NONCE.pack(run_id, nonce), "sha256")
        return Keys(self.pre_shared, key)

    def key_for(self, kind: int) -> bytes | None:
        """Return the key for frames of a kind, or None for unsigned frames.

        Raises:
            FrameError: The frame requires a run key, but no run has begun.
        """
        if self.pre_shared is None or kind in _WITH_PRE_SHARED_KEY:
            return self.pre_shared
        if self.run is None:
            raise FrameError("signature")
        return self.run

    def unpack(self, data: bytes) -> Frame:
        """Return the frame in the given bytes, verified with the key for its kind."""
        if self.pre_shared is None:
            return unpack(data)
        has_kind = len(data) > _KIND_AT
        return unpack(data, self.key_for(data[_KIND_AT]) if has_kind else self.pre_shared)


def run_id_of(data: bytes) -> int:
    """Return the run id in bytes that may be a frame, without checks."""
    return int.from_bytes(data[_RUN_ID], "little")


def all_finite(values: FloatArray) -> bool:
    """Return whether all values are finite. It checks the sum first, which is faster."""
    return math.isfinite(sum(values.tolist())) or bool(np.isfinite(values).all())


def is_newer(seq: int, than: int) -> bool:
    """Return whether one sequence number follows another, modulo 2^32."""
    return 0 < (seq - than) & 0xFFFFFFFF < 0x80000000
