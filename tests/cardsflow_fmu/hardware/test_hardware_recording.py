"""Recordings: the records read equal the records written, even if the file is truncated."""

from __future__ import annotations

import json
import math
import os
import signal
import struct
import subprocess
import sys
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.emulator.replay import ReplayedRobot
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.recording import (
    MISSED,
    HardwareRecording,
    Recorder,
    RecordingHeader,
    read_recording,
)

STEP = 1e-3
HEADER = RecordingHeader(
    ("f.a", "f.b"),
    ("N", "N"),
    ("q.é", "qd.é", "l.a"),
    ("rad", "rad/s", "m"),
    signature=0xFEDCBA9876543210,
    step=STEP,
    lockstep=True,
    run_id=77,
    link="udp://127.0.0.1:5005",
)
RECORD = 40 + 8 * 5


@dataclass
class FakeExchange:
    """Result of an exchange."""

    state: np.ndarray | None
    seq: int = 0
    age: float = 0.0
    round_trip: float = math.nan
    device_flags: int = 0


def write(file: Path, rows: int, start_state: tuple[float, ...] = ()) -> list[tuple]:
    """Write a recording of random exchanges; every fifth has no new state."""
    rng = np.random.default_rng(3)
    written = []
    with Recorder(file, replace(HEADER, start_state=start_state)) as recorder:
        for k in range(rows):
            command = rng.normal(size=2)
            state = None if k % 5 == 4 else rng.normal(size=3)
            came = FakeExchange(
                state, 2**32 - 3 + k, k * 1e-4, math.nan if state is None else 5e-5, k % 4
            )
            recorder.write(k * STEP, command, came)
            written.append((k * STEP, command, came))
        assert recorder.records == rows
        assert recorder.failure is None
    return written


def require_equal(recording: HardwareRecording, written: list[tuple]) -> None:
    assert len(recording) == len(written)
    for k, (t, command, came) in enumerate(written):
        assert recording.t[k] == t
        np.testing.assert_array_equal(recording.commands[k], command)
        state = np.full(3, math.nan) if came.state is None else came.state
        np.testing.assert_array_equal(recording.states[k], state)
        assert recording.seq[k] == came.seq % 2**32
        assert recording.age[k] == came.age
        np.testing.assert_equal(recording.round_trip[k], came.round_trip)
        assert recording.flags[k] == came.device_flags | (MISSED if came.state is None else 0)


def test_a_recording_round_trips(tmp_path: Path) -> None:
    file = tmp_path / "hardware.rec"
    written = write(file, 23)
    recording = read_recording(file)
    assert recording.header == HEADER
    assert recording.header.versions["cardsflow"]
    assert recording.lost_bytes == 0
    require_equal(recording, written)


def test_a_recording_without_records_is_valid(tmp_path: Path) -> None:
    write(tmp_path / "empty.rec", 0)
    recording = read_recording(tmp_path / "empty.rec")
    assert len(recording) == 0
    with pytest.raises(InputError, match="contains no states to replay"):
        ReplayedRobot(recording)


@pytest.mark.parametrize("cut", [1, 8, RECORD - 1, RECORD, RECORD + 1, 3 * RECORD - 5])
def test_complete_records_of_a_truncated_file_are_read(tmp_path: Path, cut: int) -> None:
    file = tmp_path / "cut.rec"
    written = write(file, 12)
    file.write_bytes(file.read_bytes()[:-cut])
    recording = read_recording(file)
    require_equal(recording, written[: 12 - math.ceil(cut / RECORD)])
    assert recording.lost_bytes == -cut % RECORD


def test_a_damaged_record_ends_the_recording(tmp_path: Path) -> None:
    file = tmp_path / "damaged.rec"
    written = write(file, 12)
    data = bytearray(file.read_bytes())
    data[-5 * RECORD + 40] ^= 1
    file.write_bytes(data)
    recording = read_recording(file)
    require_equal(recording, written[:7])
    assert recording.lost_bytes == 5 * RECORD


def test_records_that_are_not_in_order_end_the_recording(tmp_path: Path) -> None:
    file = tmp_path / "swapped.rec"
    written = write(file, 12)
    data = file.read_bytes()
    file.write_bytes(data[: -2 * RECORD] + data[-RECORD:] + data[-2 * RECORD : -RECORD])
    require_equal(read_recording(file), written[:10])


@given(data=st.data())
def test_a_damaged_file_is_read_in_part_or_rejected(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("damaged", numbered=True)
    file = folder / "hardware.rec"
    written = write(file, 6)
    content = bytearray(file.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        content[place] ^= data.draw(st.integers(1, 255))
    file.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        recording = read_recording(file)
    except InputError:
        return
    assert recording.header == HEADER
    require_equal(recording, written[: len(recording)])


def altered(content: dict | str | bytes, version: int = 1, magic: bytes = b"CFHWREC\0") -> bytes:
    """Return a file with another header and a valid checksum."""
    raw = content if isinstance(content, bytes) else json.dumps(content).encode()
    return struct.pack("<8sIII", magic, version, len(raw), zlib.crc32(raw)) + raw


def good() -> dict:
    return {
        "command_names": ["f.a"],
        "command_units": ["N"],
        "state_names": ["q.a"],
        "state_units": ["rad"],
        "signature": "00ff",
        "step": STEP,
        "scale": 1.0,
        "lockstep": False,
        "run_id": 1,
        "link": "",
        "start_state": [],
        "created": "",
        "versions": {},
    }


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is not a hardware recording"),
        (b"CFHWREC\0", "is not a hardware recording"),
        (b"time,q.a\n0.0,1.0\n0.1,2.0\n", "is not a hardware recording"),
        (altered(good(), magic=b"CFHWREX\0"), "is not a hardware recording"),
        (altered(good(), version=2), "has the unsupported version 2; supported: 1"),
        (altered(good())[:-1], "its header is damaged"),
        (altered(good())[:20] + b"x" + altered(good())[21:], "its header is damaged"),
        (altered(b"\xff\xfe"), "its header is invalid"),
        (altered("[" * 10), "its header is invalid"),
        (altered(b"[" * 100_000), "its header is invalid"),
        (altered({"step": 1.0}), "its header is invalid: 'command_names'"),
        (
            altered(good() | {"step": 0.0}),
            "step must be at least 1e-06 s, and scale must be positive",
        ),
        (altered(good() | {"step": "1"}), "its header is invalid"),
        (altered(good() | {"signature": 3}), "its header is invalid"),
        (altered(good() | {"state_names": [1]}), "state_names must be strings"),
        (altered(good() | {"state_units": []}), "the numbers of names and units must be equal"),
        (altered(good() | {"state_names": [], "state_units": []}), "1 to 65535"),
        (altered(good() | {"start_state": [1.0, 2.0]}), "start_state must have 1 numbers"),
    ],
)
def test_a_damaged_header_is_rejected(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "hardware.rec"
    file.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        read_recording(file)
    assert str(caught.value).startswith(str(file))


def test_a_missing_recording_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_recording(tmp_path / "none.rec")


def test_files_that_are_not_recordings_are_not_overwritten(tmp_path: Path) -> None:
    file = tmp_path / "thesis.txt"
    file.write_text("mine")
    with pytest.raises(InputError, match="already exists and is not a hardware recording"):
        Recorder(file, HEADER)
    assert file.read_text() == "mine"
    write(tmp_path / "hardware.rec", 9)
    write(tmp_path / "hardware.rec", 2)
    assert len(read_recording(tmp_path / "hardware.rec")) == 2


@pytest.mark.parametrize("place", ["", "none/hardware.rec", "file/hardware.rec"])
def test_a_recording_that_cannot_be_written_is_rejected(tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot be written|is not a regular file"):
        Recorder(tmp_path / place, HEADER)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_full_disk_ends_the_recording_and_not_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Recorder(tmp_path / "hardware.rec", HEADER) as recorder:
        recorder.write(0.0, np.zeros(2), FakeExchange(np.zeros(3)))
        with Path("/dev/full").open("wb", buffering=0) as full, monkeypatch.context() as patch:
            patch.setattr(recorder, "_stream", full)
            for _ in range(3):
                recorder.write(0.0, np.zeros(2), FakeExchange(np.zeros(3)))
    assert recorder.records == 1
    assert recorder.failure == "No space left on device"


KILLED = """
import sys, time
sys.path[:0] = [{tests!r}]
import numpy as np
from test_hardware_recording import HEADER, FakeExchange
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.recording import Recorder
recorder = Recorder({file!r}, HEADER)
for k in range(500):
    recorder.write(k * 1e-3, np.full(2, k), FakeExchange(np.full(3, -k), k))
print("written", flush=True)
time.sleep(60)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_the_recording_of_a_killed_run_is_readable(tmp_path: Path) -> None:
    file = tmp_path / "hardware.rec"
    script = KILLED.format(tests=str(Path(__file__).parent), file=str(file))
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"written\n"
        os.kill(process.pid, signal.SIGKILL)
    recording = read_recording(file)
    assert len(recording) == 500
    np.testing.assert_array_equal(recording.commands[:, 0], np.arange(500))


@pytest.mark.slow
def test_a_replay_in_lockstep_has_the_states_in_order(tmp_path: Path) -> None:
    """If no state was recorded, the previous one is repeated."""
    written = write(tmp_path / "a.rec", 5000, (7.0, 8.0, 9.0))
    robot = ReplayedRobot(read_recording(tmp_path / "a.rec"))
    assert (robot.commands, robot.states) == (2, 3)
    for _ in range(2):
        robot.reset()
        expected = np.array([7.0, 8.0, 9.0])
        np.testing.assert_array_equal(robot.state(), expected)
        for _, command, came in written:
            robot.apply(command)
            robot.advance(STEP)
            expected = expected if came.state is None else came.state
            np.testing.assert_array_equal(robot.state(), expected)
        assert robot.deviation == 0.0
        with pytest.raises(HardwareError, match="the recording ends after 5 s"):
            robot.advance(STEP)


def test_a_replay_in_real_time_follows_the_clock(tmp_path: Path) -> None:
    """The replay has a four times smaller step than the recording."""
    header = RecordingHeader(("f",), ("N",), ("q",), ("rad",), signature=1, step=0.01)
    with Recorder(tmp_path / "a.rec", header) as recorder:
        for k in range(50):
            recorder.write(
                2.0 + k * 0.01, np.array([float(k)]), FakeExchange(np.array([-float(k)]))
            )
    robot = ReplayedRobot(read_recording(tmp_path / "a.rec"))
    assert robot.duration == pytest.approx(0.49)
    for k in range(4 * 49):
        assert robot.state() == [-(k // 4)]
        robot.advance(0.0025)
    robot.reset()
    robot.advance(0.1)
    robot.apply(np.array([12.5]))
    assert robot.deviation == 2.5
