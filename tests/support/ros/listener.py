"""Node that uses rclpy and records all topics of another node, like `ros2 bag record -a`.

    python listener.py NODE BAG [PARAMETER ...]

It prints `up`, listens until its input ends, writes a bag with rosbags, and prints as JSON the
recorded graph and the node's parameters. It also prints `many` after 20 states of joints and a
message of each latched topic.
"""

from __future__ import annotations

import importlib
import json
import sys
import threading
import time
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import QoSProfile
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

MANY = 20
MAX_WAIT = 20.0
"""Time to wait for an answer, in [s]."""


class Recorder:
    """Recorder of the messages of all topics, as bytes, in the order of arrival."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.topics: dict[str, str] = {}
        self.latched: list[str] = []
        self.messages: list[tuple[str, int, bytes]] = []
        self.states, self.has_many = 0, False
        self.awaited: set[str] = set()

    def discover(self) -> None:
        """Subscribe to new topics of the graph."""
        for name, (kind, *_) in self.node.get_topic_names_and_types():
            if name in self.topics or name in ("/rosout", "/parameter_events"):
                continue
            publishers = self.node.get_publishers_info_by_topic(name)
            if not publishers:
                continue
            durability = publishers[0].qos_profile.durability
            package, _, own = kind.split("/")
            message = getattr(importlib.import_module(f"{package}.msg"), own)
            qos = QoSProfile(depth=1000, durability=durability)
            self.node.create_subscription(message, name, self._taker(name), qos, raw=True)
            self.topics[name] = kind
            if durability.name == "TRANSIENT_LOCAL":
                self.latched.append(name)
                self.awaited.add(name)

    def _taker(self, name: str) -> Any:
        def take(content: bytes) -> None:
            self.messages.append((name, time.time_ns(), bytes(content)))
            self.states += name.endswith("/joint_states")
            self.awaited.discard(name)
            if self.states >= MANY and not self.awaited and not self.has_many:
                self.has_many = True
                print("many", flush=True)

        return take

    def write(self, folder: Path) -> None:
        """Write a rosbag2 bag."""
        store = get_typestore(Stores.ROS2_JAZZY)
        with Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
            connections = {
                name: writer.add_connection(name, kind, typestore=store)
                for name, kind in self.topics.items()
            }
            for name, time_ns, content in self.messages:
                writer.write(connections[name], time_ns, content)


def answer(node: Node, future: Any) -> Any:
    rclpy.spin_until_future_complete(node, future, timeout_sec=MAX_WAIT)
    return future.result()


def read_parameters(node: Node, name: str, wanted: list[str]) -> dict[str, Any]:
    """Return the values of parameters, and the node's answer to a change of the first one."""
    client = AsyncParameterClient(node, name)
    client.wait_for_services(MAX_WAIT)
    values = answer(node, client.get_parameters(wanted)).values
    found = {
        key: Parameter.from_parameter_msg(parameter(key, value)).value
        for key, value in zip(wanted, values, strict=True)
    }
    changed = answer(node, client.set_parameters([Parameter(wanted[0], value=found[wanted[0]])]))
    return {"values": found, "changed": changed.results[0].successful}


def parameter(name: str, value: Any) -> Any:
    from rcl_interfaces.msg import Parameter as Message

    return Message(name=name, value=value)


def listen(name: str, folder: Path, wanted: list[str]) -> dict[str, Any]:
    rclpy.init()
    own_clock = Parameter("use_sim_time", value=True)
    node = rclpy.create_node("listener", parameter_overrides=[own_clock])
    recorder, ended = Recorder(node), threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    print("up", flush=True)
    nodes: set[str] = set()
    parameters: dict[str, Any] = {}
    while not ended.is_set():
        recorder.discover()
        rclpy.spin_once(node, timeout_sec=0.01)
        nodes |= {
            f"{space.rstrip('/')}/{own}" for own, space in node.get_node_names_and_namespaces()
        }
        if wanted and not parameters and name in nodes:
            parameters = read_parameters(node, name, wanted)
    recorder.write(folder)
    now = node.get_clock().now().nanoseconds * 1e-9
    node.destroy_node()
    return {
        "nodes": sorted(nodes),
        "topics": recorder.topics,
        "latched": recorder.latched,
        "parameters": parameters,
        "clock": now,
    }


if __name__ == "__main__":
    print(json.dumps(listen(sys.argv[1], Path(sys.argv[2]), sys.argv[3:]), default=list))
