"""ROS node of a device, with a bus in this process; `test_real_ros` uses real nodes."""

from __future__ import annotations

import time

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R
from support.ros.bus import Bus

from cardsflow_fmu import Experiment
from cardsflow_fmu.hardware.emulator.emulated_device import emulated_device
from cardsflow_fmu.ros import device_node
from cardsflow_fmu.ros.scene_topics import ShownRobot
from cardsflow_fmu.ros.topics import JOINT_STATES
from cardsflow_fmu.ros_interface.address import node_address

MAX_WAIT = 120.0
"""Time to wait for the device, in [s]."""


def test_measurements_of_a_device_are_published(monkeypatch: pytest.MonkeyPatch) -> None:
    bus, experiment = Bus(), Experiment.load(PLANAR_2R)
    monkeypatch.setattr(device_node, "open_node", bus.node)
    inbox = bus.node().subscribe(JOINT_STATES)
    emulated = emulated_device(experiment, experiment.hardware)
    begin = time.time()
    with device_node.DeviceNode(
        emulated,
        ShownRobot.from_experiment(experiment),
        experiment.hardware,
        "udp://127.0.0.1:1",
        node_address("ros2://"),
        None,
        print,
        accepts_commands=False,
    ) as node:
        node.sample_state()
        message = inbox.receive(time.monotonic() + MAX_WAIT)
    assert message is not None
    state = message.message
    assert state.name == tuple(c.name for c in experiment.robot.coordinates)
    np.testing.assert_array_equal(state.position, emulated.robot.state()[:2])
    stamp = state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec
    assert begin - 1e-3 <= stamp <= time.time()
    assert not any(topic.name == "/clock" for _, _, topic in bus.ends)


def test_the_description_of_a_node_contains_the_timeout(cardsflow: CommandLine) -> None:
    line = cardsflow.error_line(
        "device", PLANAR_2R, "--listen", "udp://127.0.0.1:0", "--ros2", "ros2://"
    )
    assert "commands from a topic need a timeout, such as ros2://?timeout=0.1" in line
