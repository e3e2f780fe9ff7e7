"""Node that answers every command with a state, for measuring round trip times.

    python echo_node.py ros2://...

It prints `up` once it has a subscription.
"""

from __future__ import annotations

import sys
import time
from typing import NoReturn

import numpy as np
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.hardware.protocol.device_topics import RUNNING, DeviceTopics
from cardsflow_fmu.hardware.protocol.topic_reader import TopicReader
from cardsflow_fmu.ros_interface.address import node_address
from cardsflow_fmu.ros_interface.rclpy_node import open_node


def echo(uri: str) -> NoReturn:
    experiment = Experiment.load(PLANAR_2R)
    topics = DeviceTopics(experiment.robot, experiment.hardware)
    reader = TopicReader({"effort": topics.commands}, 10.0)
    state, rates = np.zeros(experiment.hardware.states(2, 4)), np.zeros(4)
    with open_node(node_address(uri)) as node:
        inbox = node.subscribe(topics.commands_topic)
        node.advertise(topics.states_topic)
        print("up", flush=True)
        while True:
            message = inbox.receive(time.monotonic() + 0.05)
            if message is not None:
                values = reader.read(message, time.monotonic())
                if values is None:
                    reader.start()  # belongs to the next block, which has another publisher
                else:
                    state[:4] = values["effort"]
            values = topics.state_values(time.time_ns(), state, rates, RUNNING)
            node.publish(topics.states_topic, values)


if __name__ == "__main__":
    echo(sys.argv[1])
