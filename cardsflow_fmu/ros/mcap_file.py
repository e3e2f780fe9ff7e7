"""MCAP files of messages, by the package mcap; rosbag2, Foxglove and PlotJuggler open them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import TracebackType
from typing import BinaryIO, Self

import numpy as np

from cardsflow_fmu.middleware.node import Topic
from cardsflow_fmu.middleware.types import definition, require_ros, type_hash
from cardsflow_fmu.version import __version__

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
    """A writer of messages into a stream, as a context that completes the file.

    Args:
        stream: Where to.
        topics: The topics.

    Raises:
        InputError: A package of the extra `ros2` is missing.
    """

    def __init__(self, stream: BinaryIO, topics: Sequence[Topic]) -> None:
        require_ros()
        from mcap.writer import Writer

        self._writer = Writer(stream)
        self._writer.start(profile="ros2", library=f"cardsflow {__version__}")
        schemas = {
            name: self._writer.register_schema(name, "ros2msg", definition(name).encode())
            for name in dict.fromkeys(topic.type for topic in topics)
        }
        self._channels = {
            topic: self._writer.register_channel(
                topic.name, "cdr", schemas[topic.type], _channel_metadata(topic)
            )
            for topic in topics
        }
        self._counts = dict.fromkeys(topics, 0)

    def attach(self, files: Mapping[str, bytes]) -> None:
        """Add files by their names."""
        for name, content in files.items():
            self._writer.add_attachment(0, 0, name, "application/octet-stream", content)

    def write(self, batches: Iterable[Batch]) -> None:
        """Write messages in the order of their times."""
        found = [batch for batch in batches if len(batch.time_ns)]
        if not found:
            return
        times = np.concatenate([batch.time_ns for batch in found])
        owners = np.repeat(np.arange(len(found)), [len(batch.time_ns) for batch in found])
        places = np.concatenate([np.arange(len(batch.time_ns)) for batch in found])
        order = np.argsort(times, kind="stable")
        contents = [batch.rows.tobytes() for batch in found]
        sizes = [batch.rows.shape[1] for batch in found]
        channels = [self._channels[batch.topic] for batch in found]
        numbers = [self._counts[batch.topic] for batch in found]
        add = self._writer.add_message
        for time, owner, place in zip(
            times[order].tolist(), owners[order].tolist(), places[order].tolist(), strict=True
        ):
            content = contents[owner][place * sizes[owner] : (place + 1) * sizes[owner]]
            add(channels[owner], time, content, time, numbers[owner] + place)
        for batch in found:
            self._counts[batch.topic] += len(batch.time_ns)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self._writer.finish()


def _channel_metadata(topic: Topic) -> dict[str, str]:
    """What rosbag2 keeps beside a topic: how it was offered, and the hash of its type."""
    qos = {"history": "keep_last", "depth": 1, "durability": "transient_local"}
    if not topic.latched:
        qos = {"history": "keep_last", "depth": 10, "durability": "volatile"}
    return {"offered_qos_profiles": _QOS.format(**qos), "topic_type_hash": type_hash(topic.type)}
