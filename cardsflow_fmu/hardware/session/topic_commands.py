"""Commands from a topic of ROS 2 to a device, which has our protocol in front.

A topic has no watchdog. So commands pass the checks of `TopicReader` and the limits of a session,
and reach the device by our protocol. Where they stay away for the stated timeout, the session ends:
forces are ramped down, and the device goes to its safe state. Whose commands have ended has to
begin again: with another publisher, as after a new start.
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

_IDLE_EVERY = 0.02
"""Time between two states while nobody commands, in [s]."""
_MAX_MESSAGES = 100
"""Most messages that are read at once, so that a flood stalls nothing."""
_LATE, _EARLY = 1.5, 0.5
"""Parts of a step after which the last command is sent again, and before which none is."""


class TopicCommands:
    """A device that takes commands from a topic.

    Args:
        robot: The robot.
        topics: Its messages.
        node: The node.
        timeout: Longest time without a command, in [s].
        make_session: Makes a session with the device, which is not open yet.
        idle_state: The device's state while nobody commands, shape (states,).
        report: Takes a line for people: beginnings, ends, what is dropped.

    Attributes:
        status: What the device does for this topic.
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
        """The topic of commands."""
        return self._topics.commands_topic

    @property
    def counters(self) -> dict[str, int]:
        """Messages received, and dropped by reason."""
        return dict(self._reader.counters)

    def run(self, stop: Callable[[], object]) -> None:
        """Pass commands on until `stop`, then bring the device to its safe state."""
        try:
            while not stop():
                if self._session is None:
                    self._wait()
                else:
                    self._follow(self._session)
        finally:
            if self._session is not None:
                self._session.end()

    def _newest(self, until: float) -> FloatArray | None:
        """The newest command that counts, shape (commands,); None if there is none until then."""
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
            self._report(f"commands by ROS: {REASONS[reason]}")
        return newest

    def _wait(self) -> None:
        """Wait for a first command, and connect it with the device."""
        command = self._newest(time.monotonic() + _IDLE_EVERY)
        if command is None:
            self._publish(self._idle_state())
            return
        session = self._make_session()
        try:
            session.open()
        except HardwareError as error:
            self._report(f"commands by ROS are rejected: {error}")
            self._reader.start(ended=True)
            return
        self._session, self._begun = session, time.monotonic()
        self._command, self._commanded = command, self._begun
        self._reported.clear()
        self._report("commands by ROS begin")
        self._exchange(session)

    def _follow(self, session: HardwareSession) -> None:
        """Pass on the next command, or the last one again; end where none came for too long."""
        early = self._exchanged + _EARLY * session.step - time.monotonic()
        if early > 0.0:
            time.sleep(early)
        command = self._newest(self._exchanged + _LATE * session.step)
        now = time.monotonic()
        if command is not None:
            self._command, self._commanded = command, now
        elif now - self._commanded > self._timeout:
            self._end(session, f"none came for {self._timeout:g} s: forces are ramped down")
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
        self._report(f"commands by ROS end: {why}")
        self._session, self.status = None, SAFE
        self._reader.start(ended=True)
        session.end()

    def _publish(self, state: FloatArray) -> None:
        q, qd = state[: self._n], state[self._n : 2 * self._n]
        rates = self._paths.evaluate(q).jacobian @ qd
        values = self._topics.state_values(time.time_ns(), state, rates, self.status)
        self._node.publish(self._topics.states_topic, values)
