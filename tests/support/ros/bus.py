"""Nodes of one process without a middleware: what one publishes the others have at once."""

from __future__ import annotations

import itertools
import threading
import time
from collections import defaultdict, deque
from typing import Self

from cardsflow_fmu.middleware.address import NodeAddress
from cardsflow_fmu.middleware.node import End, Message, Topic


class BusInbox:
    """The messages of a topic."""

    def __init__(self) -> None:
        self.messages: deque[Message] = deque(maxlen=10)
        self.there = threading.Condition()

    def put(self, message: Message) -> None:
        with self.there:
            self.messages.append(message)
            self.there.notify()

    def receive(self, until: float) -> Message | None:
        with self.there:
            while not self.messages:
                left = until - time.monotonic()
                if left <= 0 or not self.there.wait(min(left, 1e6)):
                    return None
            return self.messages.popleft()


class Bus:
    """What the nodes are connected by."""

    def __init__(self) -> None:
        self.inboxes: dict[str, list[BusInbox]] = defaultdict(list)
        self.ends: list[tuple[BusNode, str, Topic]] = []
        self.numbers = itertools.count(1)

    def node(self, address: NodeAddress | None = None) -> BusNode:
        """Another node."""
        return BusNode(self)


class BusNode:
    """A node; each has one identity as a publisher."""

    def __init__(self, bus: Bus) -> None:
        self._bus, self.identity = bus, next(bus.numbers)

    def advertise(self, topic: Topic) -> None:
        self._bus.ends.append((self, "publisher", topic))

    def publish(self, topic: Topic, content: bytes) -> None:
        for inbox in self._bus.inboxes[topic.name]:
            inbox.put(Message(content, self.identity))

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
