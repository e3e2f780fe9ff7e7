"""Topics, messages and nodes, as the other rooms use them."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any, Literal, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

Values = Mapping[str, Any]
"""A message as plain data: its fields by name, nested ones as mappings; missing ones are zero."""

End = Literal["publisher", "subscriber"]


class Topic(NamedTuple):
    """A topic.

    Attributes:
        name: Such as `/joint_states`.
        type: Such as `sensor_msgs/msg/JointState`.
        latched: Whether late subscribers get its last message, too.
    """

    name: str
    type: str
    latched: bool = False


class Received(NamedTuple):
    """A message that was received.

    Attributes:
        message: The message, with its fields as attributes.
        publisher: Identity of the topic's only publisher; None if there are several.
        sent_ns: When it was published, in [ns] since 1970; 0 if the middleware does not say.
    """

    message: Any
    publisher: Hashable
    sent_ns: int


class Inbox(Protocol):
    """The messages of a topic, the oldest first; of too many the oldest are dropped."""

    def receive(self, until: float) -> Received | None:
        """Return the next message; one that is there already is returned even after the deadline.

        Args:
            until: How long to wait, on the monotonic clock, in [s].

        Returns:
            None if there is none until then.
        """


class Node(Protocol):
    """A node, as a context that leaves the graph at its end."""

    def knows(self, message_type: str) -> bool:
        """Return whether this installation of ROS has a message type."""

    def advertise(self, topic: Topic) -> None:
        """Announce a topic that will be published."""

    def publish(self, topic: Topic, values: Values) -> None:
        """Send a message of an advertised topic."""

    def subscribe(self, topic: Topic) -> Inbox:
        """Receive the messages of a topic from now on."""

    def types(self, topic: Topic, end: End) -> list[str]:
        """Return the types with which other nodes publish a topic or subscribe to it, one each."""

    def close(self) -> None:
        """Leave the graph."""

    def __enter__(self) -> Self:
        """The node itself."""

    def __exit__(self, *exception: object) -> None:
        """Leave the graph."""


def header(time_ns: int | NDArray[np.int64], frame: str = "") -> Values:
    """Return a time in [ns], or those of many messages, and a frame as `std_msgs/msg/Header`."""
    return {"stamp": stamp(time_ns), "frame_id": frame}


def stamp(time_ns: int | NDArray[np.int64]) -> Values:
    """Return a time in [ns], or those of many messages, as `builtin_interfaces/msg/Time`."""
    seconds, rest = divmod(time_ns, 1_000_000_000)
    return {"sec": seconds, "nanosec": rest}
