"""A device as a node: its states to be watched, and commands from a topic where asked for."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from typing import Self

import numpy as np

from cardsflow_fmu.cosim.pacing import real_time_priority
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.protocol.device_topics import DeviceTopics
from cardsflow_fmu.hardware.protocol.signals import hardware_signals
from cardsflow_fmu.hardware.session.connect import handshake_of
from cardsflow_fmu.hardware.session.open_link import open_link
from cardsflow_fmu.hardware.session.session import HardwareSession
from cardsflow_fmu.hardware.session.topic_commands import TopicCommands
from cardsflow_fmu.ros_interface.address import NodeAddress
from cardsflow_fmu.ros_interface.node import Node
from cardsflow_fmu.ros_interface.rclpy_node import open_node
from cardsflow_fmu.utils.arrays import FloatArray

from .publisher import RunPublisher, quick_switches
from .scene_topics import RATE, Shown


class DeviceNode:
    """A node next to a device, as a context.

    The device keeps our protocol in front. A thread publishes what it measures; commands from the
    topic, if they are taken, come to it by our protocol, from another thread.

    Args:
        device: The device.
        shown: Its robot.
        settings: Of its hardware.
        uri: Address at which the device is served.
        address: Of the node.
        key: The device's key; None without.
        report: Takes a line for people.
        takes_commands: Whether commands are taken from the topic; the address has a timeout then.

    Raises:
        InputError: This Python has no rclpy, its middleware cannot be started, or the robot has no
            bounds to keep commands in.
    """

    def __init__(
        self,
        device: Device,
        shown: Shown,
        settings: HardwareSettings,
        uri: str,
        address: NodeAddress,
        key: bytes | None,
        report: Callable[[str], object],
        takes_commands: bool,
    ) -> None:
        self._device, self._robot = device, shown.robot
        self._settings = settings.replaced(mode="realtime", link=uri)
        self._address, self._key, self._report = address, key, report
        self._names = ("time", *(n for n, _ in hardware_signals(shown.robot, settings).states))
        self._stop = threading.Event()
        self._switches = contextlib.ExitStack()
        self._next = 0.0
        self._state: FloatArray = device.robot.state()
        topics = DeviceTopics(shown.robot, settings, address) if takes_commands else None
        self._node: Node = open_node(address)
        without = () if topics is None else (topics.states_topic.name,)
        self._publisher = RunPublisher(shown, self._node, has_clock=False, without=without)
        self._tasks = [threading.Thread(target=self._publish, name="ros2", daemon=True)]
        self._commands: TopicCommands | None = None
        if topics is not None and address.timeout is not None:
            self._commands = TopicCommands(
                shown.robot,
                topics,
                self._node,
                address.timeout,
                self._make_session,
                lambda: self._state,
                report,
            )
            self._make_session()  # what is wrong with the robot's bounds is said at once
            self._tasks.append(threading.Thread(target=self._take_commands, name="commands"))

    @property
    def description(self) -> str:
        """One line about the node."""
        address, line = self._address, f"published as node {self._address}{self._publisher.remark}"
        if self._commands is None:
            return line
        topic = address.absolute(self._commands.topic.name)
        return f"{line}; commands from {topic}, ramped down after {address.timeout:g} s without"

    @property
    def totals(self) -> dict[str, object]:
        """What came on the topic of commands."""
        return {} if self._commands is None else {"commands by ROS": self._commands.counters}

    def take_state(self) -> None:
        """Take what the device measures, at an even rate; to be called between its steps."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + 1.0 / RATE
        self._state = state = self._device.robot.state()
        self._publisher.watch(self._names, np.concatenate([[time.time()], state])[np.newaxis])

    def _publish(self) -> None:
        # a thread that holds Python's lock while others have its core would hold up the device
        with real_time_priority():
            self._publisher.run()
        if self._publisher.failure is not None:
            self._report(f"no longer published: {self._publisher.failure}")

    def _take_commands(self) -> None:
        assert self._commands is not None
        try:
            self._commands.run(self._stop.is_set)
        except Exception as error:  # of a thread: the device's watchdog has made it safe
            what = " ".join(str(error).split()) or type(error).__name__
            self._report(f"commands by ROS are no longer taken: {what}")

    def _make_session(self) -> HardwareSession:
        settings, step = self._settings, self._device.step
        handshake = handshake_of(self._robot, settings, step)
        link = open_link(settings.link, key=self._key)
        return HardwareSession(self._robot, settings, link, handshake)

    def __enter__(self) -> Self:
        self._switches.enter_context(quick_switches())
        for task in self._tasks:
            task.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._stop.set()
        self._publisher.stop()
        for task in self._tasks:
            task.join()
        self._node.close()
        self._switches.close()
