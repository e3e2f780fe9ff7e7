"""A node over zenoh, as rmw_zenoh of Jazzy, Kilted and Rolling has them.

Messages go to keys `<domain>/<topic>/<type>/<hash>`; liveliness tokens tell the graph of nodes and
their topics; beside each message are its number, its time and the identity of its publisher.
"""

from __future__ import annotations

import struct
import threading
import time
from collections import deque
from typing import Any, Self

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.utils.extras import require

from .address import SCHEME, NodeAddress
from .node import End, Message, Topic, dds_type, ros_type
from .types import type_hash

_ROUTER_ANSWERS_WITHIN = 3000  # [ms]
_ATTACHMENT = struct.Struct("<qqB16s")
_ANY_HASH = "TypeHashNotSupported"  # of ROS 2 Humble
_ENDS: dict[End, str] = {"publisher": "MP", "subscriber": "MS"}
_TYPE = 10
"""Part of a token that is its type: @ros2_lv, domain, session, node, entity, kind, enclave,
namespace, name of the node, topic, type, hash, QoS."""


class ZenohNode:
    """A node, as a context that leaves the graph at its end; see `Node`.

    Args:
        address: Where and who it is.

    Raises:
        InputError: A package of the extra `ros2-zenoh` is missing, or no router answers.
    """

    def __init__(self, address: NodeAddress) -> None:
        require("topics of ROS 2 over zenoh", "ros2-zenoh", "zenoh", "xxhash", "rosbags.typesys")
        import zenoh

        self._address = address
        try:
            self._session: Any = zenoh.open(_config(address))
        except zenoh.ZError:
            what = f"no router answers at {address.router}; start rmw_zenohd there"
            raise InputError(what, key=SCHEME) from None
        self._tokens = [self._declare_token(0, "NN")]
        self._publishers: dict[Topic, _Publisher] = {}
        self._subscribers: list[Any] = []

    def advertise(self, topic: Topic) -> None:
        """Tell the graph of a topic that will be published."""
        import xxhash
        import zenoh

        token = self._declare_end(topic, "publisher")
        options: dict[str, Any] = {
            "congestion_control": zenoh.CongestionControl.DROP,
            "express": True,
        }
        if topic.latched:
            cache = zenoh.ext.CacheConfig(1)
            publisher = zenoh.ext.declare_advanced_publisher(
                self._session, self._key(topic), cache=cache, publisher_detection=True, **options
            )
        else:
            publisher = self._session.declare_publisher(self._key(topic), **options)
        digest = xxhash.xxh3_128_intdigest(token.text.encode())
        self._publishers[topic] = _Publisher(publisher, digest.to_bytes(16, "little"))

    def publish(self, topic: Topic, content: bytes) -> None:
        """Send a message of an advertised topic; where nobody takes it, it is gone."""
        self._publishers[topic].put(content)

    def subscribe(self, topic: Topic) -> ZenohInbox:
        """Take the messages of a topic from now on."""
        self._declare_end(topic, "subscriber")
        inbox = ZenohInbox(self._address.depth)
        place, _, hashed = self._key(topic).rpartition("/")
        for known in (hashed, _ANY_HASH):
            declared = self._session.declare_subscriber(f"{place}/{known}", inbox.put)
            self._subscribers.append(declared)
        return inbox

    def types(self, topic: Topic, end: End) -> list[str]:
        """The types with which other nodes publish a topic or subscribe to it, one each."""
        name, domain = _mangled(self._address.absolute(topic.name)), self._address.domain
        there = f"@ros2_lv/{domain}/*/*/*/{_ENDS[end]}/*/*/*/{name}/**"
        tokens = [str(a.ok.key_expr) for a in self._session.liveliness().get(there) if a.ok]
        own = {token.text for token in self._tokens}
        return [ros_type(token.split("/")[_TYPE]) for token in tokens if token not in own]

    def close(self) -> None:
        """Leave the graph."""
        for token in self._tokens:
            token.declared.undeclare()
        self._tokens.clear()
        self._session.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _key(self, topic: Topic) -> str:
        name = self._address.absolute(topic.name).strip("/")
        return f"{self._address.domain}/{name}/{dds_type(topic.type)}/{type_hash(topic.type)}"

    def _declare_end(self, topic: Topic, end: End) -> _Token:
        token = self._declare_token(
            len(self._tokens),
            _ENDS[end],
            _mangled(self._address.absolute(topic.name)),
            dds_type(topic.type),
            type_hash(topic.type),
            self._qos(topic),
        )
        self._tokens.append(token)
        return token

    def _qos(self, topic: Topic) -> str:
        """Reliability, durability, history and its depth; empty where they are ROS's default."""
        if topic.latched:
            return ":1:,1:,:,:,,"
        return f"{'' if self._address.reliable else 2}::,{self._address.depth}:,:,:,,"

    def _declare_token(self, entity: int, kind: str, *about: str) -> _Token:
        """A liveliness token of the node, which is entity 0, or of one of its topics."""
        address = self._address
        place = f"@ros2_lv/{address.domain}/{self._session.zid()}/0/{entity}/{kind}"
        text = "/".join([place, "%", _mangled(address.namespace), address.node, *about])
        return _Token(text, self._session.liveliness().declare_token(text))


class ZenohInbox:
    """The messages of a topic; see `Inbox`."""

    def __init__(self, depth: int) -> None:
        self._messages: deque[Message] = deque(maxlen=depth)
        self._there = threading.Event()

    def put(self, sample: Any) -> None:
        """Take a message, in a thread of zenoh's; one that does not say who sent it is dropped."""
        attachment = bytes(sample.attachment) if sample.attachment is not None else b""
        if len(attachment) != _ATTACHMENT.size:
            return
        self._messages.append(Message(bytes(sample.payload), attachment[-16:]))
        self._there.set()

    def receive(self, until: float) -> Message | None:
        """The next message; see `Inbox.receive`."""
        while True:
            if self._messages:
                return self._messages.popleft()
            self._there.clear()
            if self._messages:
                continue
            if not self._there.wait(max(until - time.monotonic(), 0.0)):
                return None


class _Token:
    """A liveliness token and its text."""

    def __init__(self, text: str, declared: Any) -> None:
        self.text, self.declared = text, declared


class _Publisher:
    """A publisher of one topic, with the identity that it sends beside messages."""

    def __init__(self, publisher: Any, identity: bytes) -> None:
        self._publisher, self._identity = publisher, identity
        self._count = 0

    def put(self, content: bytes) -> None:
        self._count += 1
        attachment = _ATTACHMENT.pack(self._count, time.time_ns(), 16, self._identity)
        self._publisher.put(content, attachment=attachment)


def _mangled(name: str) -> str:
    return name.replace("/", "%") or "%"


def _config(address: NodeAddress) -> Any:
    import zenoh

    config = zenoh.Config()
    for key, value in {
        "mode": "peer",
        "connect/endpoints": [address.router],
        "connect/timeout_ms": _ROUTER_ANSWERS_WITHIN,
        "connect/exit_on_failure": True,
        "listen/endpoints": ["tcp/localhost:0"],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": True,
        "timestamping/enabled": True,
    }.items():
        config.insert_json5(key, json_text(value))
    return config
