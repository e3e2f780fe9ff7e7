"""A node over DDS, as rmw_cyclonedds and rmw_fastrtps have them, by CycloneDDS.

Topics are `rt/<name>`; endpoints carry the hash of their type in USER_DATA; every participant
publishes its nodes and their endpoints on `ros_discovery_info`.
"""

from __future__ import annotations

import functools
import time
from typing import Any, Self
from xml.sax.saxutils import quoteattr

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.extras import require

from .address import SCHEME, NodeAddress
from .cdr import message_rows
from .node import End, Message, Topic, ros_type
from .types import type_hash

_GRAPH = Topic("ros_discovery_info", "rmw_dds_common/msg/ParticipantEntitiesInfo", latched=True)
_LOOPBACK = ("localhost", "127.0.0.1", "::1")
_LONGEST_BLOCK = 1_000_000
"""Longest time that publishing waits for slow subscribers, in [ns]."""
_LONGEST_WAIT = 1e6  # [s]
_MOST_ENDPOINTS = 10_000


class DdsNode:
    """A node, as a context that leaves the graph at its end; see `Node`.

    Args:
        address: Where and who it is.

    Raises:
        InputError: A package of the extra `ros2-dds` is missing, or DDS cannot be started.
    """

    def __init__(self, address: NodeAddress) -> None:
        require("topics of ROS 2 over DDS", "ros2-dds", "cyclonedds.domain", "rosbags.typesys")
        from cyclonedds.core import DDSException, Policy, Qos
        from cyclonedds.domain import DomainParticipant

        self._address = address
        try:
            self._domain = _domain(address.domain, address.host)
            qos = Qos(Policy.Userdata(b"enclave=/;"))
            self._participant: Any = DomainParticipant(address.domain, qos=qos)
        except DDSException as error:
            what = f"DDS cannot be started in domain {address.domain}: {error.msg}"
            raise InputError(what, key=SCHEME) from None
        self._writers: dict[Topic, Any] = {}
        self._inboxes: list[DdsInbox] = []
        self._endpoints: dict[End, Any] = {}
        self._graph = self._writer(_GRAPH, _GRAPH.name)
        self._tell_graph()

    def advertise(self, topic: Topic) -> None:
        """Tell the graph of a topic that will be published."""
        self._writers[topic] = self._writer(topic, self._dds_name(topic))
        self._tell_graph()

    def publish(self, topic: Topic, content: bytes) -> None:
        """Send a message of an advertised topic; where nobody takes it, it is gone."""
        _write(self._writers[topic], content)

    def subscribe(self, topic: Topic) -> DdsInbox:
        """Take the messages of a topic from now on."""
        from cyclonedds.sub import DataReader

        # best effort: a reliable subscriber would not get what is published with best effort
        qos = _qos(topic, self._address, reliable=topic.latched)
        there = self._topic(topic, self._dds_name(topic))
        inbox = DdsInbox(self._participant, DataReader(self._participant, there, qos=qos))
        self._inboxes.append(inbox)
        self._tell_graph()
        return inbox

    def types(self, topic: Topic, end: End) -> list[str]:
        """The types with which other nodes publish a topic or subscribe to it, one each."""
        from cyclonedds.core import InstanceState

        name, own = self._dds_name(topic), self._participant.guid
        there = self._known(end).read(_MOST_ENDPOINTS)
        return [
            ros_type(endpoint.type_name)
            for endpoint in there
            if endpoint.sample_info.instance_state == InstanceState.Alive
            and endpoint.topic_name == name
            and endpoint.participant_key != own
        ]

    def close(self) -> None:
        """Leave the graph."""
        # entities go when nothing refers to them: dependent ones first
        for inbox in self._inboxes:
            inbox.close()
        self._inboxes.clear()
        self._writers.clear()
        self._endpoints.clear()
        self._graph = self._participant = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _known(self, end: End) -> Any:
        """A reader of the endpoints that are known."""
        from cyclonedds import builtin

        if end not in self._endpoints:
            is_publisher = end == "publisher"
            topic = (
                builtin.BuiltinTopicDcpsPublication
                if is_publisher
                else builtin.BuiltinTopicDcpsSubscription
            )
            self._endpoints[end] = builtin.BuiltinDataReader(self._participant, topic)
        return self._endpoints[end]

    def _dds_name(self, topic: Topic) -> str:
        return f"rt{self._address.absolute(topic.name)}"

    def _topic(self, topic: Topic, name: str) -> Any:
        from cyclonedds.topic import Topic as DdsTopic

        from .dds_types import sample_type

        return DdsTopic(self._participant, name, sample_type(topic.type))

    def _writer(self, topic: Topic, name: str) -> Any:
        from cyclonedds.pub import DataWriter

        qos = _qos(topic, self._address, reliable=topic.latched or self._address.reliable)
        return DataWriter(self._participant, self._topic(topic, name), qos=qos)

    def _tell_graph(self) -> None:
        """Publish the node and its endpoints."""
        node = {
            "node_namespace": self._address.namespace or "/",
            "node_name": self._address.node,
            "reader_gid_seq": [_gid(inbox.reader) for inbox in self._inboxes],
            "writer_gid_seq": [_gid(writer) for writer in self._writers.values()],
        }
        values = {"gid": _gid(self._participant), "node_entities_info_seq": [node]}
        _write(self._graph, message_rows(_GRAPH.type, values, 1)[0].tobytes())


class DdsInbox:
    """The messages of a topic; see `Inbox`."""

    def __init__(self, participant: Any, reader: Any) -> None:
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet

        self.reader = reader
        any_ = ViewState.Any | SampleState.NotRead | InstanceState.Any
        self._waits = WaitSet(participant)
        self._waits.attach(ReadCondition(reader, any_))

    def receive(self, until: float) -> Message | None:
        """The next message; see `Inbox.receive`."""
        while True:
            for sample in self.reader.take(1):
                if sample.sample_info.valid_data:
                    publisher = sample.sample_info.publication_handle
                    return Message(sample.content, publisher)
            left = until - time.monotonic()
            if left <= 0.0 or not self._waits.wait(int(1e9 * min(left, _LONGEST_WAIT))):
                return None

    def close(self) -> None:
        """Leave the topic."""
        self._waits = self.reader = None


def _write(writer: Any, content: bytes) -> None:
    from cyclonedds.core import DDSException

    sample = writer.data_type.__new__(writer.data_type)
    sample.content = content
    try:
        writer.write(sample)
    except DDSException as error:
        if error.code != DDSException.DDS_RETCODE_TIMEOUT:
            raise


def _gid(entity: Any) -> dict[str, Any]:
    return {"data": np.frombuffer(entity.guid.bytes, np.uint8)}


def _qos(topic: Topic, address: NodeAddress, *, reliable: bool) -> Any:
    from cyclonedds.core import Policy, Qos

    depth = 1 if topic.latched else address.depth
    return Qos(
        Policy.Reliability.Reliable(_LONGEST_BLOCK) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if topic.latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        Policy.IgnoreLocal.Participant,
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.Userdata(f"typehash={type_hash(topic.type)};".encode()),
    )


@functools.cache
def _domain(number: int, host: str) -> Any:
    """A domain with one peer, once for a process; that of CycloneDDS's own settings without."""
    from cyclonedds.domain import Domain

    if not host:
        return None
    interface = ""
    if host in _LOOPBACK:
        interface = '<Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>'
    return Domain(
        number,
        f"<CycloneDDS><Domain><General>{interface}<AllowMulticast>false</AllowMulticast></General>"
        f"<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="
        f"{quoteattr(host)}/></Peers></Discovery></Domain></CycloneDDS>",
    )
