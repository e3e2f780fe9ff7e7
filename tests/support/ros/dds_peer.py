"""A peer over DDS without our code: types of its own, CycloneDDS's bytes; prints what it sees.

    python dds_peer.py DOMAIN TOPIC SECONDS

It ends as soon as it has seen the node's graph and messages of JointState on the topic, and prints
them as JSON.
"""

import json
import os
import sys
import time
from dataclasses import dataclass

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, bounded_str, float64, int32, sequence, uint8, uint32
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

LOOPBACK = (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/>'
    "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>"
    'auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain>'
    "</CycloneDDS>"
)


@final
@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@final
@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@final
@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@final
@dataclass
class Gid(IdlStruct, typename="rmw_dds_common::msg::dds_::Gid_"):
    data: array[uint8, 16]


@final
@dataclass
class NodeEntities(IdlStruct, typename="rmw_dds_common::msg::dds_::NodeEntitiesInfo_"):
    node_namespace: bounded_str[256]
    node_name: bounded_str[256]
    reader_gid_seq: sequence[Gid]
    writer_gid_seq: sequence[Gid]


@final
@dataclass
class Participant(IdlStruct, typename="rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_"):
    gid: Gid
    node_entities_info_seq: sequence[NodeEntities]


def watch(domain: int, name: str, seconds: float) -> dict[str, object]:
    os.environ["CYCLONEDDS_URI"] = LOOPBACK
    participant = DomainParticipant(domain)
    reliable = Policy.Reliability.Reliable(10**9)
    latched = Qos(reliable, Policy.Durability.TransientLocal, Policy.History.KeepLast(9))
    graph = DataReader(
        participant, Topic(participant, "ros_discovery_info", Participant), qos=latched
    )
    states = DataReader(participant, Topic(participant, f"rt{name}", JointState), qos=Qos(reliable))
    publications = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)
    endpoints: dict[str, tuple[str, str, str]] = {}
    nodes: list[tuple[str, str, list[str]]] = []
    messages: list[object] = []
    end = time.monotonic() + seconds
    while time.monotonic() < end and not (messages and nodes and f"rt{name}" in endpoints):
        for one in publications.take(100):
            data = one.qos[Policy.Userdata]
            user_data = data.data.decode() if data else ""
            endpoints[one.topic_name] = (one.type_name, user_data, one.key.hex)
        for one in graph.take(9):
            for node in one.node_entities_info_seq:
                writers = [bytes(gid.data).hex() for gid in node.writer_gid_seq]
                nodes.append((node.node_namespace, node.node_name, writers))
        for one in states.take(9):
            stamp = (one.header.stamp.sec, one.header.stamp.nanosec)
            messages[:] = [[stamp, one.name, one.position, one.velocity, one.effort]]
        time.sleep(0.02)
    return {"endpoints": endpoints, "nodes": nodes, "messages": messages}


if __name__ == "__main__":
    print(json.dumps(watch(int(sys.argv[1]), sys.argv[2], float(sys.argv[3]))), flush=True)
    os._exit(0)  # CycloneDDS may wait for ever where its entities end in another order
