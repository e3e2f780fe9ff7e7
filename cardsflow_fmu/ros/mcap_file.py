"""MCAP files of ROS messages, which rosbag2, Foxglove and PlotJuggler can open."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count
from typing import BinaryIO, Self

import numpy as np

from cardsflow_fmu.ros_interface.message_types import require_ros, type_store
from cardsflow_fmu.ros_interface.node import Topic
from cardsflow_fmu.version import __version__

from .message_rows import Bytes, message_rows
from .topics import Batch

_QOS = """- history: {history}
  depth: {depth}
  reliability: reliable
  durability: {durability}
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: automatic
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false"""


class McapWriter:
    """Writer of messages, as a context manager that completes the file."""

    def __init__(self, stream: BinaryIO, topics: Sequence[Topic]) -> None:
        require_ros()
        from mcap.writer import Writer

        self._store = store = type_store()
        self._writer = Writer(stream)
        self._writer.start(profile="ros2", library=f"cardsflow {__version__}")
        schemas = {
            name: self._writer.register_schema(
                name, "ros2msg", store.generate_msgdef(name, ros_version=2)[0].encode()
            )
            for name in dict.fromkeys(topic.type for topic in topics)
        }
        self._channels = {
            topic: self._writer.register_channel(
                topic.name,
                "cdr",
                schemas[topic.type],
                {
                    "offered_qos_profiles": _qos(topic),
                    "topic_type_hash": store.hash_rihs01(topic.type),
                },
            )
            for topic in topics
        }
        self._numbers = {topic: count() for topic in topics}

    def attach(self, files: Mapping[str, bytes]) -> None:
        """Add files to the recording."""
        for name, content in files.items():
            self._writer.add_attachment(0, 0, name, "application/octet-stream", content)

    def write(self, batches: Iterable[Batch]) -> None:
        """Write messages, ordered by time."""
        filled = list(batches)
        if not filled:
            return
        times = np.concatenate([batch.time_ns for batch in filled])
        owners = np.repeat(np.arange(len(filled)), [len(batch.time_ns) for batch in filled])
        order = np.argsort(times, kind="stable")
        channels = [self._channels[batch.topic] for batch in filled]
        numbers = [self._numbers[batch.topic] for batch in filled]
        contents = [_contents(message_rows(self._store, batch)) for batch in filled]
        add = self._writer.add_message
        for k, time_ns in zip(owners[order].tolist(), times[order].tolist(), strict=True):
            at = max(0, time_ns)  # times in an MCAP file are unsigned
            add(channels[k], at, next(contents[k]), at, next(numbers[k]))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *exception: object) -> None:
        if kind is None:
            self._writer.finish()


def _qos(topic: Topic) -> str:
    """Return the quality of service of a topic in the YAML format of rosbag2."""
    qos = {"history": "keep_last", "depth": 1, "durability": "transient_local"}
    if not topic.latched:
        qos = {"history": "keep_last", "depth": 10, "durability": "volatile"}
    return _QOS.format(**qos)


def _contents(rows: Bytes) -> Iterator[bytes]:
    """Return the rows of an array of bytes, shape (K, size), as bytes objects."""
    return iter(rows.view(np.dtype((np.void, rows.shape[1])))[:, 0].tolist())
