"""ROS node of a device, which publishes its states and optionally accepts commands."""

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

from .publisher import RunPublisher, short_switch_interval
from .scene_topics import RATE, ShownRobot


class DeviceNode:
    """ROS node for a device, as a context manager.

    The device still uses the hardware protocol. One thread publishes the measurements. If commands
    are accepted, another thread sends the commands of the topic to the device by the hardware
    protocol.

    Args:
        uri: Address of the device's server.
        key: Pre-shared key of the device, or None.
        report: Function that is called with a line of text about the node.
        accepts_commands: Whether commands are accepted from a topic. If so, the address must
            specify a timeout.

    Raises:
        InputError: This Python has no rclpy, the middleware cannot be started, or the robot has no
            limits for the commands.
    """

    def __init__(
        self,
        device: Device,
        shown: ShownRobot,
        settings: HardwareSettings,
        uri: str,
        address: NodeAddress,
        key: bytes | None,
        report: Callable[[str], object],
        accepts_commands: bool,
    ) -> None:
        self._device, self._robot = device, shown.robot
        self._settings = settings.copy_with(mode="realtime", link=uri)
        self._address, self._key, self._report = address, key, report
        self._names = ("time", *(n for n, _ in hardware_signals(shown.robot, settings).states))
        self._stop = threading.Event()
        self._switches = contextlib.ExitStack()
        self._next = 0.0
        self._state: FloatArray = device.robot.state()
        topics = DeviceTopics(shown.robot, settings, address) if accepts_commands else None
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
            self._make_session()  # reports missing limits of the robot immediately
            self._tasks.append(threading.Thread(target=self._run_commands, name="commands"))

    @property
    def description(self) -> str:
        """Description of the node in one line."""
        address, line = self._address, f"published as node {self._address}{self._publisher.remark}"
        if self._commands is None:
            return line
        topic = address.absolute(self._commands.topic.name)
        return f"{line}; commands from {topic} with a timeout of {address.timeout:g} s"

    @property
    def totals(self) -> dict[str, object]:
        """Number of messages on the topic of commands; empty if commands are not accepted."""
        return {} if self._commands is None else {"ROS commands": self._commands.counters}

    def sample_state(self) -> None:
        """Sample the measurements of the device, at a fixed rate. Call it between device steps."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + 1.0 / RATE
        self._state = state = self._device.robot.state()
        self._publisher.watch(self._names, np.concatenate([[time.time()], state])[np.newaxis])

    def _publish(self) -> None:
        # Without priority, this thread could hold Python's lock while it waits for a core.
        with real_time_priority():
            self._publisher.run()
        if self._publisher.failure is not None:
            self._report(f"no longer published: {self._publisher.failure}")

    def _run_commands(self) -> None:
        assert self._commands is not None
        try:
            self._commands.run(self._stop.is_set)
        except Exception as error:  # the device's watchdog brings the device to its safe state
            problem = " ".join(str(error).split()) or type(error).__name__
            self._report(f"ROS commands are no longer accepted: {problem}")

    def _make_session(self) -> HardwareSession:
        settings, step = self._settings, self._device.step
        handshake = handshake_of(self._robot, settings, step)
        link = open_link(settings.link, key=self._key)
        return HardwareSession(self._robot, settings, link, handshake)

    def __enter__(self) -> Self:
        self._switches.enter_context(short_switch_interval())
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
