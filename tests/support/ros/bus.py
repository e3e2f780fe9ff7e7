"""Nodes in one process without a middleware: messages are delivered immediately."""

from __future__ import annotations

import itertools
import threading
import time
from collections import defaultdict, deque
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Self

from cardsflow_fmu.ros_interface.address import NodeAddress
from cardsflow_fmu.ros_interface.node import End, Received, Topic, Values


def as_message(values: object) -> object:
    """Return a message with its fields as attributes, like in rclpy."""
    if not isinstance(values, Mapping):
        return values
    return SimpleNamespace(**{field: as_message(value) for field, value in values.items()})


class BusInbox:
    """Queue of the messages of a topic."""

    def __init__(self) -> None:
        self.messages: deque[Received] = deque(maxlen=10)
        self.there = threading.Condition()

    def put(self, message: Received) -> None:
        with self.there:
            self.messages.append(message)
            self.there.notify()

    def receive(self, until: float) -> Received | None:
        with self.there:
            while not self.messages:
                left = until - time.monotonic()
                if left <= 0 or not self.there.wait(min(left, 1e6)):
                    return None
            return self.messages.popleft()


class Bus:
    """Connection between nodes."""

    def __init__(self, *, unknown: tuple[str, ...] = ()) -> None:
        self.unknown = unknown
        self.inboxes: dict[str, list[BusInbox]] = defaultdict(list)
        self.ends: list[tuple[BusNode, str, Topic]] = []
        self.numbers = itertools.count(1)

    def node(self, address: NodeAddress | None = None) -> BusNode:
        """Return a new node."""
        return BusNode(self)


class BusNode:
    """Node with one identity as a publisher."""

    def __init__(self, bus: Bus) -> None:
        self._bus, self.identity = bus, next(bus.numbers)

    def has_type(self, message_type: str) -> bool:
        return message_type not in self._bus.unknown

    def advertise(self, topic: Topic) -> None:
        self._bus.ends.append((self, "publisher", topic))

    def publish(self, topic: Topic, values: Values) -> None:
        publishers = {
            node for node, end, there in self._bus.ends if (end, there) == ("publisher", topic)
        }
        sole = self.identity if publishers <= {self} else None
        received = Received(as_message(values), sole, time.time_ns())
        for inbox in self._bus.inboxes[topic.name]:
            inbox.put(received)

    def subscribe(self, topic: Topic) -> BusInbox:
        self._bus.ends.append((self, "subscriber", topic))
        inbox = BusInbox()
        self._bus.inboxes[topic.name].append(inbox)
        return inbox

    def types(self, topic: Topic, end: End) -> list[str]:
        return [
            there.type
            for node, kind, there in self._bus.ends
            if node is not self and kind == end and there.name == topic.name
        ]

    def close(self) -> None:
        self._bus.ends = [there for there in self._bus.ends if there[0] is not self]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
