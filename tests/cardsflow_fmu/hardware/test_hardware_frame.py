"""Frames: documented layout, and rejection of damaged or unsigned frames."""

from __future__ import annotations

import binascii
import hashlib
import itertools
import math
import re
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.hardware.hardware_fuzz import FRAMES, bad_frames, with_checksum

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.protocol.cobs import Unstuffer, decode, encode
from cardsflow_fmu.hardware.protocol.frame import (
    HEADER,
    MAX_VALUES,
    Flag,
    Frame,
    FrameError,
    FrameWriter,
    Keys,
    Kind,
    is_newer,
    pack,
    unpack,
)
from cardsflow_fmu.hardware.protocol.handshake import ErrorCode, Handshake
from cardsflow_fmu.hardware.protocol.signature import port_signature

PROTOCOL = Path(__file__).parents[3] / "docs/reference/hardware_protocol.md"
KEY = b"0123456789abcdef"
U32, U64 = st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1)
FINITE = st.floats(allow_nan=False, allow_infinity=False)
FRAMED = st.builds(
    Frame,
    st.sampled_from(Kind),
    st.integers(0, 0xFFFF).map(lambda flags: flags & ~1),
    U32,
    U32,
    FINITE,
    U64,
    U64,
    st.lists(FINITE, max_size=40),
)
KEYS = st.one_of(st.none(), st.binary(min_size=16, max_size=100))


def sample(key: bytes | None = None, values: tuple[float, ...] = (1.5, -2.0)) -> bytes:
    return pack(Frame(Kind.SETPOINT, 0, 7, 9, 0.25, 11, 13, values), key)


def reason(data: bytes, key: bytes | None = None) -> str:
    with pytest.raises(FrameError) as error:
        unpack(data, key)
    return error.value.reason


def test_the_layout_of_a_frame_follows_the_protocol() -> None:
    data = pack(Frame(Kind.STATE, 6, 0x01020304, 5, 0.75, 8, 9, (1.5, -2.0)))
    assert len(data) == 48 + 2 * 8
    assert data[:4] == b"CFHW"
    assert (data[4], data[5]) == (1, 4)
    assert struct.unpack_from("<H", data, 6) == (6,)
    assert data[8:12] == bytes([4, 3, 2, 1])
    assert struct.unpack_from("<IdQQ", data, 12) == (5, 0.75, 8, 9)
    assert struct.unpack_from("<HH", data, 40) == (2, 0)
    whole = data[:44] + bytes(4) + data[48:]
    assert struct.unpack_from("<I", data, 44) == (binascii.crc32(whole),)
    assert struct.unpack_from("<2d", data, 48) == (1.5, -2.0)


def test_the_signature_is_the_hmac_of_all_bytes_before() -> None:
    """The expected value is computed by RFC 2104 from the hash function."""
    data = sample(KEY)
    block = KEY.ljust(64, b"\0")
    inner = hashlib.sha256(bytes(x ^ 0x36 for x in block) + data[:-32]).digest()
    outer = hashlib.sha256(bytes(x ^ 0x5C for x in block) + inner).digest()
    assert data[-32:] == outer
    assert data[6] & 1 == 1


@pytest.mark.slow
@given(FRAMED, KEYS)
def test_unpack_is_the_inverse_of_pack(frame: Frame, key: bytes | None) -> None:
    back = unpack(pack(frame, key), key)
    assert back[:1] + back[2:7] == frame[:1] + frame[2:7]
    assert back.flags == frame.flags | (key is not None)
    assert np.asarray(back.values).tobytes() == np.asarray(frame.values, float).tobytes()


@given(FRAMED, KEYS, st.data())
def test_each_changed_byte_is_detected(
    frame: Frame, key: bytes | None, data: st.DataObject
) -> None:
    """The checksum covers all bytes except the reserved field, and also the checksum field."""
    packed = bytearray(pack(frame, key))
    at = data.draw(st.integers(0, len(packed) - 1))
    packed[at] ^= data.draw(st.integers(1, 255))
    assert reason(bytes(packed), key)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda d: d[:47], "length"),
        (lambda d: d[:-1], "length"),
        (lambda d: d + b"\0", "length"),
        (lambda d: d + bytes(32), "length"),
        (lambda d: b"X" + d[1:], "magic"),
        (lambda d: d[:4] + b"\2" + d[5:], "version"),
        (lambda d: d[:5] + b"\0" + d[6:], "type"),
        (lambda d: d[:5] + b"\x0a" + d[6:], "type"),
        (lambda d: d[:50] + b"\x01" + d[51:], "checksum"),
        (lambda d: with_checksum(d[:48] + struct.pack("<2d", 1.0, math.nan)), "not finite"),
        (lambda d: with_checksum(d[:48] + struct.pack("<2d", math.inf, -math.inf)), "not finite"),
        (lambda d: with_checksum(d[:16] + struct.pack("<d", math.inf) + d[24:]), "not finite"),
    ],
)
def test_invalid_frames_are_rejected_with_a_reason(change, why) -> None:
    assert reason(change(sample())) == why


def test_large_finite_numbers_are_finite() -> None:
    """Their sum is infinite."""
    values = (1e308, 1e308, 1e308)
    assert tuple(unpack(sample(None, values)).values) == values


def test_signed_frames_require_the_key_and_a_key_requires_signed_frames() -> None:
    assert reason(sample(), KEY) == "unsigned"
    assert reason(sample(KEY), None) == "signature"
    assert reason(sample(KEY), KEY + b"x") == "signature"
    resigned = with_checksum(sample(KEY)[:48] + struct.pack("<2d", 9.0, 9.0), signed=False)
    assert reason(resigned + sample(KEY)[-32:], KEY) == "signature"


def test_only_finite_numbers_are_packed() -> None:
    writer = FrameWriter(2)
    writer.values[:] = (1.0, math.nan)
    with pytest.raises(FrameError, match="not finite"):
        writer.pack(3, 0, 1, 1, 0.0, 0, 0, None)
    with pytest.raises(FrameError, match="not finite"):
        pack(Frame(Kind.STATE, 0, 1, 1, math.inf, 0, 0, ()))
    with pytest.raises(FrameError, match="length"):
        pack(Frame(Kind.STATE, 0, 1, 1, 0.0, 0, 0, np.zeros(MAX_VALUES + 1)))


def test_a_writer_packs_the_same_bytes_as_pack() -> None:
    writer = FrameWriter(2)
    for values in ((1.0, 2.0), (-3.0, 0.0)):
        writer.values[:] = values
        for key in (None, KEY):
            frame = Frame(Kind.STATE, 4, 1, 2, 3.0, 4, 5, values)
            assert writer.pack(*frame[:7], key) == pack(frame, key)


@given(U32, st.integers(1, 2**31 - 1))
def test_sequence_numbers_wrap_around(seq: int, ahead: int) -> None:
    later = (seq + ahead) % 2**32
    assert is_newer(later, seq)
    assert not is_newer(seq, later)
    assert not is_newer(seq, seq)


def test_each_run_has_a_different_key() -> None:
    keys = Keys(KEY)
    runs = [keys.for_run(run, nonce).run for run in (1, 2) for nonce in (1, 2)]
    assert len({*runs, KEY}) == 5
    assert keys.key_for(Kind.HELLO) == KEY == keys.for_run(1, 1).key_for(Kind.ERROR)
    with pytest.raises(FrameError, match="signature"):
        keys.key_for(Kind.SETPOINT)
    assert Keys().for_run(1, 1).key_for(Kind.SETPOINT) is None


def test_a_short_key_is_rejected() -> None:
    with pytest.raises(InputError, match="at least 16 bytes, not 15"):
        Keys(KEY[:15])


@pytest.mark.parametrize("key", [None, KEY])
def test_mutated_frames_are_rejected_or_valid(key: bytes | None) -> None:
    """Accepted frames have a valid length and checksum, and finite numbers."""
    samples = [sample(key), pack(Frame(Kind.HELLO, 0, 1, 0, 0.0, 1, 0, range(7)), key)]
    taken = 0
    for data in bad_frames(samples, FRAMES, seed=1):
        try:
            frame = unpack(data, key)
        except FrameError:
            continue
        taken += 1
        assert key is None
        assert len(data) == 48 + 8 * len(frame.values)
        assert data == with_checksum(data)
        assert np.isfinite(frame.values).all()
    assert (taken > 0) == (key is None)


@given(st.binary(max_size=2000))
def test_only_the_last_byte_of_an_encoded_frame_is_zero(frame: bytes) -> None:
    line = encode(frame)
    assert line.index(0) == len(line) - 1
    assert len(line) <= len(frame) + len(frame) // 254 + 2
    assert decode(line[:-1]) == frame


@pytest.mark.parametrize(
    ("frame", "line"),
    [
        (b"", "01"),
        (b"\0", "0101"),
        (b"\x11\x22\0\x33", "0311220233"),
        (b"\x11\0\0\0", "0211010101"),
        (bytes(range(1, 255)), "ff" + bytes(range(1, 255)).hex()),
    ],
)
def test_cobs_agrees_with_published_examples(frame: bytes, line: str) -> None:
    """The common examples of the method (Cheshire and Baker 1999)."""
    found = encode(frame)[:-1].hex()
    assert found == line or found == line + "01"
    assert decode(bytes.fromhex(line)) == frame


@given(st.lists(st.binary(min_size=1, max_size=400), max_size=8), st.lists(st.integers(1, 300)))
def test_frames_are_decoded_from_chunks_of_any_size(frames: list[bytes], cuts: list[int]) -> None:
    line = b"".join(map(encode, frames))
    unstuffer, found = Unstuffer(400), []
    for size in cuts:
        found += unstuffer.take(line[:size])
        line = line[size:]
    assert found + unstuffer.take(line) == frames
    assert unstuffer.damaged == 0


def test_a_receiver_is_synchronised_after_one_frame() -> None:
    unstuffer = Unstuffer(100)
    assert unstuffer.take(b"\x77\x12" + encode(b"lost")) == []
    assert unstuffer.take(encode(b"found")) == [b"found"]
    assert unstuffer.take(b"\x01" * 5000) == []
    assert unstuffer.take(b"\0" + encode(b"again")) == [b"again"]
    assert unstuffer.damaged == 2


PORTS = [("f.biceps", "N"), ("f.triceps", "N")], [("q.elbow", "rad")]


def test_a_signature_depends_on_names_units_order_kind_and_scale() -> None:
    commands, states = PORTS
    signatures = {
        port_signature(commands, states),
        port_signature(commands[::-1], states),
        port_signature(commands, [("q.elbow", "m")]),
        port_signature(commands, [("q.knee", "rad")]),
        port_signature(commands[:1], [commands[1], *states]),
        port_signature(commands, states, command_kind="length"),
        port_signature(commands, states, scale=10.0),
    }
    assert len(signatures) == 7
    assert port_signature(commands, states) == port_signature(tuple(commands), tuple(states))
    assert all(0 <= signature < 2**64 for signature in signatures)


@given(st.integers(0, 2**64 - 1), st.booleans())
def test_a_hello_round_trips(signature: int, lockstep: bool) -> None:
    handshake = Handshake(signature, 1e-3, 2.0, 0.02, 4, 12, lockstep)
    assert Handshake.from_values(handshake.values(), lockstep) == handshake


@pytest.mark.parametrize(
    "change",
    [
        {0: -1.0},
        {0: 2.0**32},
        {1: 0.5},
        {5: 1.5},
        {6: 65536.0},
        {6: -1.0},
    ],
)
def test_invalid_handshake_values_are_rejected(change: dict[int, float]) -> None:
    values = Handshake(5, 1e-3, 1.0, 0.02, 4, 12, False).values()
    for k, value in change.items():
        values[k] = value
    assert Handshake.from_values(values, False) is None
    assert Handshake.from_values(values[:6], False) is None


def rows(after: str) -> list[list[str]]:
    """Return the rows of the first table after a text in the protocol document."""
    lines = PROTOCOL.read_text().split(after, 1)[1].splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("|"))
    table = list(itertools.takewhile(lambda line: line.startswith("|"), lines[first:]))
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[2:]]


def test_the_protocol_document_agrees_with_the_code() -> None:
    kinds = {int(row[0]): row[1] for row in rows("### Kinds")}
    assert kinds == {int(kind): kind.name for kind in Kind}
    flags = {int(row[1]): (int(row[0]), row[2]) for row in rows("### Flags")}
    assert flags == {flag.value: (flag.value.bit_length() - 1, flag.name) for flag in Flag}
    codes = {int(row[0]): row[1] for row in rows("Otherwise, it answers with")}
    assert codes == {int(code): code.name for code in ErrorCode}
    letters = {"u8": "B", "u16": "H", "u32": "I", "u64": "Q", "f64": "d"}
    fields = [row for row in rows("## The frame") if row[1] in letters]
    form = "<"
    for offset, kind, _ in fields:
        assert struct.calcsize(form) == int(offset)
        form += letters[kind]
    assert form == HEADER.format


def test_the_signature_of_the_protocol() -> None:
    """The document contains the rule and an example."""
    text = re.search(r"```json\n(.*)\n```", PROTOCOL.read_text())
    expected = int.from_bytes(hashlib.sha256(text[1].encode()).digest()[:8], "big")
    states = [("q.elbow", "rad"), ("qd.elbow", "rad/s")]
    assert port_signature([("f.biceps", "N")], states) == expected
