"""Joint states in recordings of ROS 2: MCAP files, and rosbag2's databases and folders."""

from __future__ import annotations

import contextlib
import io
import sqlite3
import struct
import zlib
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import opened_file
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.extras import require

RECORDINGS = (".mcap", ".db3")
TOPIC = "/joint_states"

_TYPE = "sensor_msgs/msg/JointState"
_FOLDER_FILE = "metadata.yaml"
_TABLES = (
    "SELECT topics.name, messages.timestamp, messages.data FROM messages "
    "JOIN topics ON messages.topic_id = topics.id "
    "WHERE topics.type = ? AND topics.serialization_format = 'cdr' AND length(messages.data) < ?"
)
_MOST_BYTES = limits.MIB
"""Of a message: thousands of joints."""


class _Message(NamedTuple):
    """A message: topic, when it was recorded in [ns], its bytes."""

    topic: str
    time_ns: int
    content: bytes


class JointStates(NamedTuple):
    """Joint states over time.

    Attributes:
        names: Names of the joints.
        time: Shape (m,), in [s], from the first on, as in the messages' headers.
        q: Positions, shape (m, n), in [rad] or [m].
        qd: Velocities, shape (m, n); None where they are not there.
    """

    names: tuple[str, ...]
    time: FloatArray
    q: FloatArray
    qd: FloatArray | None

    def columns(self) -> dict[str, FloatArray]:
        """The columns of a recorded motion by their names."""
        columns = {"time": self.time}
        columns |= {f"q.{name}": self.q[:, k] for k, name in enumerate(self.names)}
        if self.qd is not None:
            columns |= {f"qd.{name}": self.qd[:, k] for k, name in enumerate(self.names)}
        return columns


def is_recording(path: Path) -> bool:
    """Whether a path is named as a recording of ROS 2 is, or is a folder of rosbag2."""
    with contextlib.suppress(OSError, ValueError):
        if (path / _FOLDER_FILE).is_file():
            return True
    return path.suffix.lower() in RECORDINGS


def read_joint_states(path: Path, joints: Sequence[str] = ()) -> JointStates:
    """The joint states of a recording.

    They are those of `/joint_states`, or of the only topic with such messages. Of publishers that
    name other joints, the first publisher that names all of `joints` counts.

    Args:
        path: A .mcap, a .db3, or a folder of rosbag2.
        joints: Names of joints; the first publisher counts when empty.

    Raises:
        InputError: There are none, the file is damaged, or the extra `ros2` is missing.
    """
    require("recordings of ROS 2", "ros2", "mcap.stream_reader", "rosbags.typesys")
    files = [path] if path.is_file() else _files_of(path)
    found: dict[str, list[_Message]] = defaultdict(list)
    for file in files:
        read = _mcap_messages if file.suffix.lower() == ".mcap" else _database_messages
        try:
            for message in read(file):
                found[message.topic].append(message)
        except InputError:
            raise
        except Exception as error:  # damage shows in errors of any kind
            what = " ".join(str(error).split()) or type(error).__name__
            raise InputError(f"is damaged: {what}"[:300], file=file) from None
    topic = TOPIC if TOPIC in found else next(iter(found), None)
    if topic is None:
        raise InputError(f"holds no messages {_TYPE}", file=path)
    if topic != TOPIC and len(found) > 1:
        what = f"holds joint states as {', '.join(sorted(found))}, and none as {TOPIC}"
        raise InputError(what, file=path)
    return _states(found[topic], joints, path)


def _files_of(folder: Path) -> list[Path]:
    """The files of a folder of rosbag2."""
    if not folder.is_dir():
        raise InputError("is neither a file nor a folder", file=folder)
    there = [file for file in folder.iterdir() if file.suffix.lower() in RECORDINGS]
    if not there:
        packed = [file.name for file in folder.iterdir() if file.suffix.lower() == ".zstd"]
        what = f"its files are compressed as a whole, such as {packed[0]}" if packed else "no files"
        hint = "convert it by ros2 bag convert" if packed else f"it needs {' or '.join(RECORDINGS)}"
        raise InputError(f"is a folder of rosbag2: {what}; {hint}", file=folder)
    return sorted(there, key=lambda file: (len(file.name), file.name))


def _database_messages(file: Path) -> Iterator[_Message]:
    with opened_file(file, limits.RECORDING):
        pass
    place = f"{file.resolve().as_uri()}?mode=ro&immutable=1"
    with contextlib.closing(sqlite3.connect(place, uri=True)) as database:
        yield from map(_Message._make, database.execute(_TABLES, (_TYPE, _MOST_BYTES)))


def _mcap_messages(file: Path) -> Iterator[_Message]:
    """The messages, also of a file whose end is missing."""
    from mcap import records
    from mcap.exceptions import EndOfFile
    from mcap.stream_reader import StreamReader

    types: dict[int, str] = {}
    topics: dict[int, str] = {}
    with opened_file(file, limits.RECORDING) as stream:
        reader = StreamReader(stream, emit_chunks=True, record_size_limit=limits.RECORDING)
        try:
            for record in _unpacked(reader.records, file):
                if isinstance(record, records.Schema):
                    types[record.id] = record.name
                elif isinstance(record, records.Channel):
                    if types.get(record.schema_id) == _TYPE and record.message_encoding == "cdr":
                        topics[record.id] = record.topic
                elif isinstance(record, records.Message) and record.channel_id in topics:
                    topic, data = topics[record.channel_id], record.data
                    yield _Message(topic, record.log_time, data)
        except (EndOfFile, struct.error):
            if not topics:
                raise InputError("is no MCAP file, or ends too early", file=file) from None


def _unpacked(found: Any, file: Path) -> Iterator[Any]:
    """Records, those of chunks in their place."""
    from mcap.records import Chunk
    from mcap.stream_reader import breakup_chunk

    left = limits.RECORDING
    for record in found:
        if not isinstance(record, Chunk):
            yield record
            continue
        left -= record.uncompressed_size
        if left < 0:
            raise InputError(f"unpacked it {limits.too_large(limits.RECORDING)}", file=file)
        data = _decompressed(record.compression, record.data, record.uncompressed_size)
        if record.uncompressed_crc not in (0, zlib.crc32(data)):
            raise InputError("is damaged: a checksum is wrong", file=file)
        record.compression, record.data = "", data
        yield from breakup_chunk(record)


def _decompressed(compression: str, data: bytes, size: int) -> bytes:
    """The content of a chunk, whatever it says of itself no more than it announces."""
    if not compression:
        return data
    if compression == "zstd":
        import zstandard

        with zstandard.ZstdDecompressor().stream_reader(io.BytesIO(data)) as stream:
            content = stream.read(size + 1)
    elif compression == "lz4":
        import lz4.frame

        content = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
    else:
        raise ValueError(f"its compression {compression!r} is not known")
    if len(content) != size:
        raise ValueError("a chunk is not as long as it says")
    return bytes(content)


def _states(messages: list[_Message], joints: Sequence[str], path: Path) -> JointStates:
    from rosbags.typesys import Stores, get_typestore

    decode = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr
    groups: dict[tuple[str, ...], list[Any]] = defaultdict(list)
    for message in messages:
        try:
            state: Any = decode(message.content, _TYPE)
        except Exception as error:  # damage shows in errors of any kind
            what = f"is damaged: a message of {message.topic} cannot be read"
            raise InputError(what, file=path) from error
        stamp = state.header.stamp
        stamped = stamp.sec * 1_000_000_000 + stamp.nanosec
        groups[tuple(state.name)].append((stamped, message.time_ns, state))
    named = (names for names in groups if names and set(joints) <= set(names))
    names = next(named, next(iter(groups)))
    own = int(not any(stamped for stamped, _, _ in groups[names]))  # no stamps: when recorded
    rows = sorted(((row[own], row[2]) for row in groups[names]), key=lambda row: row[0])
    time = np.array([time for time, _ in rows], dtype=np.int64)
    q = _table([state.position for _, state in rows], names, "positions", path)
    has_rates = all(len(state.velocity) for _, state in rows)
    qd = _table([s.velocity for _, s in rows], names, "velocities", path) if has_rates else None
    return JointStates(names, (time - time[0]) / 1e9, q, qd)


def _table(rows: list[Any], names: Sequence[str], what: str, path: Path) -> FloatArray:
    if any(len(row) != len(names) for row in rows):
        raise InputError(f"its joint states have not as many {what} as names", file=path)
    return np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
