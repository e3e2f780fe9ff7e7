"""Commands from a ROS 2 topic to a device that uses the hardware protocol.

A topic has no watchdog. Therefore `TopicReader` checks the commands, a session limits them, and the
session sends them by the hardware protocol. If no command arrives within the timeout, the session
ends: forces are ramped down, and the device enters its safe state. Afterwards, messages of the same
publisher are rejected, so that its node must be restarted.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.hardware.protocol.device_topics import (
    READY,
    RUNNING,
    SAFE,
    DeviceTopics,
    Status,
)
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.topic_reader import REASONS, TopicReader
from cardsflow_fmu.ros_interface.node import Node, Topic
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import MusclePaths

from .session import HardwareSession

_IDLE_PERIOD = 0.02
"""Time between published states while no node sends commands, in [s]."""
_MAX_MESSAGES = 100
"""Maximum number of messages read at once, so that a flood cannot block the device."""
_RESEND_AFTER, _SEND_AFTER = 1.5, 0.5
"""Fractions of a step after which the last command is repeated, and a new command is sent."""


class TopicCommands:
    """Bridge that sends the commands of a topic to a device.

    Args:
        topics: Topics and messages of the robot.
        timeout: Maximum time between commands, in [s].
        make_session: Function that creates a session with the device, which is not open yet.
        idle_state: Function that returns the state of the device, shape (states,), while no node
            sends commands.
        report: Function that is called with a line of text when commands begin, end or are dropped.

    Attributes:
        status: Status of the device: "ready", "running" or "safe".
    """

    def __init__(
        self,
        robot: Robot,
        topics: DeviceTopics,
        node: Node,
        timeout: float,
        make_session: Callable[[], HardwareSession],
        idle_state: Callable[[], FloatArray],
        report: Callable[[str], object],
    ) -> None:
        self._topics, self._node, self._timeout = topics, node, timeout
        self._make_session, self._idle_state, self._report = make_session, idle_state, report
        self._paths = MusclePaths(robot)
        self._n = len(robot.coordinates)
        needed = {"effort": topics.commands}
        self._reader = TopicReader(needed, timeout, parse=topics.command_state)
        self._reported: set[str] = set()
        self.status: Status = READY
        node.advertise(topics.states_topic)
        self._inbox = node.subscribe(topics.commands_topic)
        self._session: HardwareSession | None = None
        self._begun = self._commanded = self._exchanged = 0.0
        self._command: FloatArray = np.zeros(0)

    @property
    def topic(self) -> Topic:
        """Topic of the commands."""
        return self._topics.commands_topic

    @property
    def counters(self) -> dict[str, int]:
        """Number of received messages, and number of dropped messages by reason."""
        return dict(self._reader.counters)

    def run(self, stop: Callable[[], object]) -> None:
        """Send commands to the device until `stop` returns a true value.

        Then bring the device to its safe state.
        """
        try:
            while not stop():
                if self._session is None:
                    self._wait()
                else:
                    self._send_next_command(self._session)
        finally:
            if self._session is not None:
                self._session.end()

    def _newest_command(self, until: float) -> FloatArray | None:
        """Return the newest valid command, shape (commands,), or None if none arrives in time."""
        newest = None
        for _ in range(_MAX_MESSAGES):
            message = self._inbox.receive(until)
            if message is None:
                break
            values = self._reader.read(message, time.monotonic())
            if values is not None:
                newest, until = values["effort"], -math.inf
        for reason in REASONS.keys() & self._reader.counters.keys() - self._reported:
            self._reported.add(reason)
            self._report(f"ROS commands: {REASONS[reason]}")
        return newest

    def _wait(self) -> None:
        """Wait for a first command, and open a session with the device."""
        command = self._newest_command(time.monotonic() + _IDLE_PERIOD)
        if command is None:
            self._publish(self._idle_state())
            return
        session = self._make_session()
        try:
            session.open()
        except HardwareError as error:
            self._report(f"ROS commands are rejected: {error}")
            self._reader.start(ended=True)
            return
        self._session, self._begun = session, time.monotonic()
        self._command, self._commanded = command, self._begun
        self._reported.clear()
        self._report("ROS commands begin")
        self._exchange(session)

    def _send_next_command(self, session: HardwareSession) -> None:
        """Send the next command, or repeat the last one. End the session after the timeout."""
        early = self._exchanged + _SEND_AFTER * session.step - time.monotonic()
        if early > 0.0:
            time.sleep(early)
        command = self._newest_command(self._exchanged + _RESEND_AFTER * session.step)
        now = time.monotonic()
        if command is not None:
            self._command, self._commanded = command, now
        elif now - self._commanded > self._timeout:
            self._end(session, f"none arrived for {self._timeout:g} s; forces are ramped down")
            return
        self._exchange(session)

    def _exchange(self, session: HardwareSession) -> None:
        self._exchanged = time.monotonic()
        try:
            session.exchange(self._exchanged - self._begun, self._command)
        except HardwareError as error:
            self._end(session, str(error))
            return
        self.status = RUNNING
        self._publish(session.state)

    def _end(self, session: HardwareSession, why: str) -> None:
        self._report(f"ROS commands end: {why}")
        self._session, self.status = None, SAFE
        self._reader.start(ended=True)
        session.end()

    def _publish(self, state: FloatArray) -> None:
        q, qd = state[: self._n], state[self._n : 2 * self._n]
        rates = self._paths.evaluate(q).jacobian @ qd
        values = self._topics.state_values(time.time_ns(), state, rates, self.status)
        self._node.publish(self._topics.states_topic, values)
