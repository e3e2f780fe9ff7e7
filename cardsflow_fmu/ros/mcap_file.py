"""MCAP files of messages, by the package mcap; rosbag2, Foxglove and PlotJuggler open them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import TracebackType
from typing import Any, BinaryIO, Self

import numpy as np

from cardsflow_fmu.ros_interface.message_types import require_ros, type_store
from cardsflow_fmu.ros_interface.node import Topic, Values
from cardsflow_fmu.version import __version__

from .topics import Sample

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


_BASE, _NAME = 1, 2
"""Kinds of fields as rosbags numbers them: numbers and texts, messages; others are sequences."""
_ZEROS = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}


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
        self._counts = dict.fromkeys(topics, 0)

    def attach(self, files: Mapping[str, bytes]) -> None:
        """Add files by their names."""
        for name, content in files.items():
            self._writer.add_attachment(0, 0, name, "application/octet-stream", content)

    def write(self, samples: Iterable[Sample]) -> None:
        """Write messages in the order of their times."""
        for topic, time_ns, values in sorted(samples, key=lambda sample: sample.time_ns):
            message = _message(self._store, topic.type, values)
            content = bytes(self._store.serialize_cdr(message, topic.type))
            number = self._counts[topic]
            self._counts[topic] = number + 1
            self._writer.add_message(self._channels[topic], time_ns, content, time_ns, number)

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


def _qos(topic: Topic) -> str:
    """How a topic was offered, as rosbag2 keeps it beside the topic."""
    qos = {"history": "keep_last", "depth": 1, "durability": "transient_local"}
    if not topic.latched:
        qos = {"history": "keep_last", "depth": 10, "durability": "volatile"}
    return _QOS.format(**qos)


def _message(store: Any, name: str, values: Values) -> Any:
    """A message of rosbags; fields that are left out are zero or empty."""
    fields = store.get_msgdef(name).fields
    return store.types[name](
        **{field: _value(store, kind, values.get(field)) for field, kind in fields}
    )


def _value(store: Any, kind: tuple[int, Any], value: Any) -> Any:
    """The value of a field.

    Args:
        store: The message types.
        kind: What the field is, and of what: a number's or text's type; a message's name; the kind
            of elements and their count.
        value: Its value; None for zero or empty. A point may be an array of its coordinates.
    """
    node, of = kind
    if node == _BASE:
        return _ZEROS.get(of[0], 0) if value is None else value
    if node == _NAME:
        if isinstance(value, np.ndarray):
            value = dict(zip("xyz", value.tolist(), strict=True))
        return _message(store, of, value or {})
    element, count = of
    if element[0] == _BASE and element[1][0] != "string":
        number = element[1][0].replace("octet", "uint8").replace("byte", "uint8")
        return np.zeros(count, number) if value is None else np.asarray(value, number)
    return [_value(store, element, item) for item in ([None] * count if value is None else value)]
