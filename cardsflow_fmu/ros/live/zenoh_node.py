"""A node over zenoh, as rmw_zenoh of Jazzy, Kilted and Rolling has them.

Messages go to keys `<domain>/<topic>/<type>/<hash>`; liveliness tokens tell the graph of nodes and
their topics; beside each message are its number, its time and the identity of its publisher.
"""

from __future__ import annotations

import struct
import time
from types import TracebackType
from typing import Any, Self

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.utils.extras import require

from ..topics import Topic
from ..types import type_hash
from .address import SCHEME, NodeAddress

_ROUTER_ANSWERS_WITHIN = 3000  # [ms]
_ATTACHMENT = struct.Struct("<qqB16s")
_VOLATILE = "::,10:,:,:,,"
_LATCHED = ":1:,1:,:,:,,"


class ZenohNode:
    """A node, as a context that leaves the graph at its end.

    Args:
        address: Where and who it is.

    Raises:
        InputError: A package of the extra `ros2-zenoh` is missing, or no router answers.
    """

    def __init__(self, address: NodeAddress) -> None:
        require("live topics of ROS 2", "ros2-zenoh", "zenoh", "xxhash", "rosbags.typesys")
        import zenoh

        self._address = address
        try:
            self._session: Any = zenoh.open(_config(address))
        except zenoh.ZError:
            what = f"no router answers at {address.router}; start rmw_zenohd there"
            raise InputError(what, key=SCHEME) from None
        self._tokens = [self._declare_token(0, "NN")]
        self._publishers: dict[Topic, _Publisher] = {}

    def advertise(self, topic: Topic) -> None:
        """Tell the graph of a topic that will be published."""
        import xxhash
        import zenoh

        name, kind = self._address.absolute(topic.name), dds_type(topic.type)
        hashed, qos = type_hash(topic.type), _LATCHED if topic.latched else _VOLATILE
        token = self._declare_token(
            len(self._publishers) + 1, "MP", _mangled(name), kind, hashed, qos
        )
        self._tokens.append(token)
        key = f"{self._address.domain}/{name.strip('/')}/{kind}/{hashed}"
        options: dict[str, Any] = {
            "congestion_control": zenoh.CongestionControl.DROP,
            "express": topic.latched,
        }
        if topic.latched:
            cache = zenoh.ext.CacheConfig(1)
            publisher = zenoh.ext.declare_advanced_publisher(
                self._session, key, cache=cache, publisher_detection=True, **options
            )
        else:
            publisher = self._session.declare_publisher(key, **options)
        digest = xxhash.xxh3_128_intdigest(token.text.encode())
        self._publishers[topic] = _Publisher(publisher, digest.to_bytes(16, "little"))

    def publish(self, topic: Topic, content: bytes) -> None:
        """Send a message of an advertised topic; where nobody takes it, it is gone."""
        self._publishers[topic].put(content)

    def close(self) -> None:
        """Leave the graph."""
        for token in self._tokens:
            token.declared.undeclare()
        self._tokens.clear()
        self._session.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _declare_token(self, entity: int, kind: str, *about: str) -> _Token:
        """A liveliness token of the node, which is entity 0, or of one of its topics."""
        address = self._address
        place = f"@ros2_lv/{address.domain}/{self._session.zid()}/0/{entity}/{kind}"
        text = "/".join([place, "%", _mangled(address.namespace), address.node, *about])
        return _Token(text, self._session.liveliness().declare_token(text))


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


def dds_type(name: str) -> str:
    """A type as DDS has it: `std_msgs/msg/String` -> `std_msgs::msg::dds_::String_`."""
    package, kind, own = name.split("/")
    return f"{package}::{kind}::dds_::{own}_"


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
