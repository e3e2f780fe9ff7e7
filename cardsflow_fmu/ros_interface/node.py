"""Interfaces of topics, messages and nodes."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any, Literal, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

Values = Mapping[str, Any]
"""Fields of a message by name. Nested messages are mappings, and missing fields are zero."""

End = Literal["publisher", "subscriber"]


class Topic(NamedTuple):
    """ROS topic.

    Attributes:
        name: Name, such as `/joint_states`.
        type: Message type, such as `sensor_msgs/msg/JointState`.
        latched: Whether late subscribers receive the last message too.
    """

    name: str
    type: str
    latched: bool = False


class Received(NamedTuple):
    """Received message.

    Attributes:
        message: The message, with its fields as attributes.
        publisher: Identity of the publisher, or None if the topic has several publishers.
        sent_ns: Time of publication, in [ns] since 1970, or 0 if the middleware does not report it.
    """

    message: Any
    publisher: Hashable
    sent_ns: int


class Inbox(Protocol):
    """Interface of a queue of received messages. If the queue is full, the oldest are dropped."""

    def receive(self, until: float) -> Received | None:
        """Return the next message, or None if no message arrives before the deadline.

        A message that has already arrived is returned even after the deadline.

        Args:
            until: Deadline on the monotonic clock, in [s].
        """


class Node(Protocol):
    """Interface of a ROS node, as a context manager that closes the node."""

    def has_type(self, message_type: str) -> bool:
        """Return whether a message type is installed."""

    def advertise(self, topic: Topic) -> None:
        """Create a publisher for a topic."""

    def publish(self, topic: Topic, values: Values) -> None:
        """Publish a message on an advertised topic."""

    def subscribe(self, topic: Topic) -> Inbox:
        """Subscribe to a topic and return its queue of messages."""

    def types(self, topic: Topic, end: End) -> list[str]:
        """Return the message types of the publishers or subscribers of a topic in other nodes."""

    def close(self) -> None:
        """Close the node."""

    def __enter__(self) -> Self:
        """Return the node."""

    def __exit__(self, *exception: object) -> None:
        """Close the node."""


def header(time_ns: int | NDArray[np.int64], frame: str = "") -> Values:
    """Return the fields of a `std_msgs/msg/Header`.

    Args:
        time_ns: Time of a message, or times of many messages, in [ns].
    """
    return {"stamp": stamp(time_ns), "frame_id": frame}


def stamp(time_ns: int | NDArray[np.int64]) -> Values:
    """Return the fields of a `builtin_interfaces/msg/Time`."""
    seconds, nanoseconds = divmod(time_ns, 1_000_000_000)
    return {"sec": seconds, "nanosec": nanoseconds}
