"""Messages with joint states in ROS 2 files: MCAP files and rosbag2 databases."""

from __future__ import annotations

import contextlib
import io
import re
import sqlite3
import struct
import zlib
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import BinaryIO, NamedTuple

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import open_file
from cardsflow_fmu.utils.extras import require

TYPE = "sensor_msgs/msg/JointState"

_MAX_BYTES = limits.MIB
"""Maximum size of a message, enough for thousands of joints."""

_QUERY = (
    "SELECT topics.name, messages.timestamp, messages.data FROM messages "
    "JOIN topics ON messages.topic_id = topics.id "
    "WHERE topics.type = ? AND topics.serialization_format = 'cdr' AND length(messages.data) < ?"
)
_DATABASE_SCHEMA = "SELECT type, name, sql FROM main.sqlite_master"
_PLAIN = re.compile(r"CREATE\s+(TABLE|INDEX|UNIQUE\s+INDEX)\s", re.IGNORECASE)
_COLUMNS = "PRAGMA main.table_xinfo({})"
_HIDDEN = 6
"""Column of `_COLUMNS` that is not 0 for hidden and computed columns."""
_MAX_ROW = 2 * limits.MIB
"""Maximum size of a text, a blob and a row in SQLite."""
_OPERATIONS, _ROUNDS = 1_000_000, 300
"""Number of SQLite instructions per progress call, and maximum number of calls."""

_MAGIC = b"\x89MCAP0\r\n"
_FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 2, 3, 4, 5, 6
_RECORD, _CHUNK_HEAD = struct.Struct("<BQ"), struct.Struct("<QQQI")
_MESSAGE_HEAD = struct.Struct("<HIQQ")


class Message(NamedTuple):
    """Message of a recording.

    Attributes:
        time_ns: Time of recording, in [ns].
        content: Serialized message.
    """

    topic: str
    time_ns: int
    content: bytes


class Budget:
    """Limits on the size of a recording; counts what is already read."""

    def __init__(self) -> None:
        self._chunk_bytes, self._bytes = limits.RECORDING, limits.ARRAYS
        self._records, self._messages = count(1), count(1)

    def count_bytes(self, size: int) -> None:
        """Count the bytes of a chunk."""
        self._chunk_bytes -= size
        if self._chunk_bytes < 0:
            raise InputError(f"unpacked it {limits.too_large(limits.RECORDING)}")

    def count_record(self) -> None:
        """Count a record of any message type."""
        if next(self._records) > limits.RECORDS:
            raise InputError(f"has more than {limits.RECORDS} messages")

    def count_message(self, message: Message) -> None:
        """Count a message with joint states."""
        self._bytes -= len(message.content)
        if next(self._messages) > limits.JOINT_STATES or self._bytes < 0:
            most = (
                f"{limits.JOINT_STATES} joint states or {limits.ARRAYS // limits.MIB} MiB of them"
            )
            raise InputError(
                f"has more than {most}; record fewer messages per second, or a shorter time"
            )


def messages(file: Path, budget: Budget) -> Iterator[Message]:
    """Yield the messages with joint states.

    Damaged files raise errors of any type.
    """
    read = _mcap_messages if file.suffix.lower() == ".mcap" else _database_messages
    for message in read(file, budget):
        budget.count_message(message)
        yield message


def _database_messages(file: Path, _: Budget) -> Iterator[Message]:
    """Yield the messages in a rosbag2 database.

    SQL of an untrusted database is not executed: views, computed columns and endless queries are
    rejected.
    """
    with open_file(file, limits.RECORDING):
        pass
    place = f"{file.resolve().as_uri()}?mode=ro&immutable=1"
    with contextlib.closing(sqlite3.connect(place, uri=True)) as database:
        rounds = count(1)
        database.set_progress_handler(lambda: next(rounds) > _ROUNDS, _OPERATIONS)
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _MAX_ROW)
        _require_plain(database)
        database.set_authorizer(_authorize)
        yield from map(Message._make, database.execute(_QUERY, (TYPE, _MAX_BYTES)))


def _require_plain(database: sqlite3.Connection) -> None:
    """Check that a database only has plain tables and indices, without computed columns.

    Virtual tables could replace what later queries read. Each statement names the schema, since
    tables of the file may have the names of SQLite's own tables and functions.
    """
    for kind, name, sql in database.execute(_DATABASE_SCHEMA):
        if sql is not None and _PLAIN.match(sql) is None:
            raise InputError(f"its {kind} {name!r} is not allowed: only plain tables are read")
    for table in ("topics", "messages"):
        if any(row[_HIDDEN] for row in database.execute(_COLUMNS.format(table))):
            raise InputError(f"its table {table} has computed columns")


def _authorize(
    action: int, _: str | None, name: str | None, __: str | None, view: str | None
) -> int:
    """Allow only reading plain tables; authorizer of SQLite."""
    is_read = view is None and action in (sqlite3.SQLITE_SELECT, sqlite3.SQLITE_READ)
    is_length = action == sqlite3.SQLITE_FUNCTION and name == "length"
    return sqlite3.SQLITE_OK if is_read or is_length else sqlite3.SQLITE_DENY


def _mcap_messages(file: Path, budget: Budget) -> Iterator[Message]:
    """Yield the messages of an MCAP file (mcap.dev/spec); the file may be truncated."""
    types: dict[int, str] = {}
    topics: dict[int, str] = {}
    with open_file(file, limits.RECORDING) as stream:
        if stream.read(len(_MAGIC)) != _MAGIC:
            raise ValueError("it is not an MCAP file")
        for kind, content in _unpack_chunks(stream, budget):
            if kind == _SCHEMA:
                (number,) = struct.unpack_from("<H", content)
                types[number], _ = _text(content, 2)
            elif kind == _CHANNEL:
                number, schema = struct.unpack_from("<HH", content)
                topic, end = _text(content, 4)
                if types.get(schema) == TYPE and _text(content, end)[0] == "cdr":
                    topics[number] = topic
            elif kind == _MESSAGE:
                channel, _, time_ns, _ = _MESSAGE_HEAD.unpack_from(content)
                if channel in topics:
                    yield Message(topics[channel], time_ns, content[_MESSAGE_HEAD.size :])


def _unpack_chunks(stream: BinaryIO, budget: Budget) -> Iterator[tuple[int, bytes]]:
    """Yield kind and content of all records, including the records in chunks."""
    for kind, content in _records(stream, budget):
        if kind == _FOOTER:
            return
        if kind != _CHUNK:
            yield kind, content
            continue
        _, _, size, checksum = _CHUNK_HEAD.unpack_from(content)
        compression, end = _text(content, _CHUNK_HEAD.size)
        budget.count_bytes(size)
        data = _decompress(compression, memoryview(content)[end + 8 :], size)
        if checksum not in (0, zlib.crc32(data)):
            raise ValueError("a checksum is wrong")
        yield from _records(io.BytesIO(data), budget)


def _records(stream: BinaryIO, budget: Budget) -> Iterator[tuple[int, bytes]]:
    """Yield kind and content of the records; an incomplete last record is ignored."""
    while len(head := stream.read(_RECORD.size)) == _RECORD.size:
        budget.count_record()
        kind, length = _RECORD.unpack(head)
        if length > limits.RECORDING:
            raise ValueError("a record exceeds the maximum file size")
        if len(content := stream.read(length)) < length:
            return
        yield kind, content


def _text(content: bytes, place: int) -> tuple[str, int]:
    """Return a length-prefixed text and the position of its end."""
    (length,) = struct.unpack_from("<I", content, place)
    end = place + 4 + length
    return content[place + 4 : end].decode(), end


def _decompress(compression: str, data: memoryview, size: int) -> bytes:
    """Return the content of a chunk, limited to its declared size."""
    if not compression:
        return bytes(data)
    if compression == "zstd":
        require("recordings of ROS 2 with compressed messages", "ros2", "zstandard")
        import zstandard

        with zstandard.ZstdDecompressor().stream_reader(io.BytesIO(data)) as stream:
            content = stream.read(size + 1)
    elif compression == "lz4":
        require("recordings of ROS 2 with compressed messages", "ros2", "lz4.frame")
        import lz4.frame

        content = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
    else:
        raise ValueError(f"its compression {compression!r} is unknown")
    if len(content) != size:
        raise ValueError("the size of a chunk differs from its declared size")
    return bytes(content)
