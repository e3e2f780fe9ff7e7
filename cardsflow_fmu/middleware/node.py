"""Nodes and topics of ROS 2, whatever carries them."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Literal, NamedTuple, Protocol, Self

End = Literal["publisher", "subscriber"]


class Topic(NamedTuple):
    """A topic.

    Attributes:
        name: Such as `/joint_states`.
        type: Such as `sensor_msgs/msg/JointState`.
        latched: Whether its last message is for those who come later, too.
    """

    name: str
    type: str
    latched: bool = False


class Message(NamedTuple):
    """A message that was received.

    Attributes:
        content: Its bytes, CDR with its header.
        publisher: Identity of its publisher, the same in all of its messages.
    """

    content: bytes
    publisher: Hashable


class Inbox(Protocol):
    """The messages of a topic, the oldest first; of too many the oldest are dropped."""

    def receive(self, until: float) -> Message | None:
        """The next message; one that is there already is returned even after the deadline.

        Args:
            until: How long to wait, on the monotonic clock, in [s].

        Returns:
            None if there is none until then.
        """


class Node(Protocol):
    """A node, as a context that leaves the graph at its end."""

    def advertise(self, topic: Topic) -> None:
        """Tell the graph of a topic that will be published."""

    def publish(self, topic: Topic, content: bytes) -> None:
        """Send a message of an advertised topic; where nobody takes it, it is gone."""

    def subscribe(self, topic: Topic) -> Inbox:
        """Take the messages of a topic from now on."""

    def types(self, topic: Topic, end: End) -> list[str]:
        """The types with which other nodes publish a topic or subscribe to it, one each."""

    def close(self) -> None:
        """Leave the graph."""

    def __enter__(self) -> Self:
        """The node itself."""

    def __exit__(self, *exception: object) -> None:
        """Leave the graph."""


def dds_type(name: str) -> str:
    """A type as DDS has it: `std_msgs/msg/String` -> `std_msgs::msg::dds_::String_`."""
    package, kind, own = name.split("/")
    return f"{package}::{kind}::dds_::{own}_"


def ros_type(name: str) -> str:
    """A type of DDS as ROS has it, if it is one of ROS."""
    return name.replace("::dds_::", "/").replace("::", "/").removesuffix("_")
