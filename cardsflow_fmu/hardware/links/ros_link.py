"""Link by ROS 2 topics: commands and states are messages.

Topics have no handshake, no watchdog and no stop command. Therefore the names in messages replace
the signature, and a timeout replaces the stop command: the robot must reduce its forces if it
receives no command for the timeout, which both sides specify.
"""

from __future__ import annotations

import math
import secrets
import time
from collections import Counter

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.protocol.clock import Clock
from cardsflow_fmu.hardware.protocol.device_topics import (
    READY,
    RUNNING,
    SAFE,
    DeviceTopics,
)
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.frame import Flag
from cardsflow_fmu.hardware.protocol.handshake import Handshake
from cardsflow_fmu.hardware.protocol.topic_reader import REASONS, TopicReader
from cardsflow_fmu.ros_interface.address import NodeAddress
from cardsflow_fmu.ros_interface.node import End, Inbox, Node, Topic
from cardsflow_fmu.ros_interface.rclpy_node import open_node
from cardsflow_fmu.utils.arrays import FloatArray

_POLL_PERIOD = 0.05
_MAX_MESSAGES = 100
"""Maximum number of messages read at once, so that a flood cannot block the link."""
_NO_TIMEOUT = (
    "topics have no watchdog: specify the maximum time between commands, such as "
    "ros2://...?timeout=0.1, and use the same time on the robot; the safest choice is the "
    "CARDSFlow hardware protocol, udp://..., together with --publish"
)


class RosLink:
    """Link by ROS 2 topics; see `HardwareLink`.

    Args:
        uri: Address of the form ros2://...?timeout=S.
        topics: Topics and messages of the robot.
        timeout: Maximum time for which `open` waits, in [s].

    Raises:
        InputError: The address specifies no timeout.

    Attributes:
        silence: Timeout of the address: maximum time between messages, in [s].
    """

    def __init__(
        self, uri: str, address: NodeAddress, topics: DeviceTopics, *, timeout: float = 5.0
    ) -> None:
        self.uri, self._address, self._topics, self._open_timeout = uri, address, topics, timeout
        silence = address.timeout
        if silence is None:
            raise InputError(_NO_TIMEOUT, key="hardware.link")
        self.silence = silence
        self.clock: Clock = time
        self.run_id = 0
        self.agreed: Handshake | None = None
        self.start_state: FloatArray = np.zeros(0)
        self._counters: Counter[str] = Counter()
        self._node: Node | None = None
        self._inbox: Inbox | None = None
        self._reader = TopicReader(topics.needed, silence, only=False)
        self._seq = 0
        self._newest_at = -math.inf
        self._begun_at: float | None = None
        self._was_running = False

    @property
    def counters(self) -> Counter[str]:
        """Number of messages sent, received, and dropped (by reason)."""
        return self._counters + self._reader.counters

    def open(self, handshake: Handshake) -> None:
        """Wait for the robot to publish states and to subscribe to commands.

        See `HardwareLink.open`.
        """
        self.close()
        if handshake.lockstep:
            problem = "topics do not support lockstep: set hardware.mode = 'realtime', or use"
            raise HardwareError(f"cannot connect to {self.uri}: {problem} udp://")
        if self.silence < 2.0 * handshake.step:
            problem = f"the timeout of {self.silence:g} s is shorter than two steps"
            raise HardwareError(f"cannot connect to {self.uri}: {problem}")
        self._node = node = open_node(self._address)
        try:
            self._inbox = node.subscribe(self._topics.states_topic)
            node.advertise(self._topics.commands_topic)
            self._reader.start()
            self._wait_for_robot(node, self._inbox)
        except BaseException:
            self.close()
            raise
        self.agreed, self.run_id = handshake, secrets.randbelow(0xFFFFFFFF) + 1
        self._seq, self._newest_at = 0, time.monotonic()
        self._begun_at, self._was_running = None, False

    def _wait_for_robot(self, node: Node, inbox: Inbox) -> None:
        """Wait for a state and for a node that subscribes to commands.

        Raises:
            HardwareError: No robot is found in time, or another node publishes commands.
        """
        end = time.monotonic() + self._open_timeout
        state, commands = None, self._topics.commands_topic
        while time.monotonic() < end:
            state = self._next_state(inbox, min(time.monotonic() + _POLL_PERIOD, end)) or state
            subscribers = node.types(commands, "subscriber").count(commands.type)
            if state is not None and subscribers:
                if node.types(commands, "publisher"):
                    problem = "another node publishes commands; stop that node first"
                    raise HardwareError(f"cannot connect to {self.uri}: {problem}")
                self.start_state = state[1]
                return
        missing = self._missing_part(node)
        raise HardwareError(
            f"cannot connect to {self.uri} within {self._open_timeout:g} s: {missing}"
        )

    def _missing_part(self, node: Node) -> str:
        """Return a description of the missing or unsuitable topic."""
        states = self._topics.states_topic
        ends: list[tuple[Topic, End]] = [(states, "publisher")]
        ends += [(self._topics.commands_topic, "subscriber")]
        for topic, end in ends:
            name = self._address.absolute(topic.name)
            types = node.types(topic, end)
            if not types:
                return f"{name} has no {end}; does the robot run in this domain and namespace?"
            if topic.type not in types:
                return f"{name} has the type {types[0]}, but must have the type {topic.type}"
        dropped = [reason for reason in REASONS if self._reader.counters[reason]]
        if not dropped:
            return f"no messages arrive on {self._address.absolute(states.name)}"
        names = ", ".join(self._topics.states)
        return f"{self._address.absolute(states.name)}: {REASONS[dropped[0]]}; required: {names}"

    def _next_state(self, inbox: Inbox, until: float) -> tuple[float, FloatArray] | None:
        """Return the arrival time and values of the next valid state, or None if none arrives."""
        for _ in range(_MAX_MESSAGES):
            message = inbox.receive(until)
            if message is None:
                break
            now = time.monotonic()
            values = self._reader.read(message, now)
            if values is not None:
                return now, self._topics.state(values)
        return None

    def exchange(self, t: float, command: FloatArray, deadline: float) -> Exchange:
        """Send a command and wait for the next state; see `HardwareLink.exchange`.

        Raises:
            HardwareError: No state has arrived within the timeout, or the device ignores commands.
        """
        if self._node is None or self._inbox is None:
            raise HardwareError(f"the link to {self.uri} is not open")
        newest = None
        for _ in range(_MAX_MESSAGES):
            received = self._next_state(self._inbox, -math.inf)
            if received is None:
                break
            newest = received
        values = self._topics.command_values(time.time_ns(), command)
        sent = time.monotonic()
        self._node.publish(self._topics.commands_topic, values)
        self._counters["sent"] += 1
        self._seq += 1
        if self._begun_at is None:
            self._begun_at = self._newest_at = sent
        newest = self._next_state(self._inbox, deadline) or newest
        if newest is None:
            age = time.monotonic() - self._newest_at
            self._counters["missed"] += 1
            if age > self.silence:
                problem = f"no state has arrived for {self.silence:g} s"
                raise HardwareError(f"the robot at {self.uri} does not respond: {problem}")
            return Exchange(None, self._seq - 1, age, math.nan, 0)
        self._newest_at, state = newest
        flags = self._flags(sent - self._begun_at)
        round_trip = self._newest_at - sent if self._newest_at > sent else math.nan
        age = time.monotonic() - self._newest_at
        return Exchange(state, self._seq, age, round_trip, flags)

    def _flags(self, since: float) -> int:
        """Return the device flags that the frame id of the newest state specifies.

        Only a CARDSFlow device uses the frame id for its status. For other robots there are no
        flags.

        Args:
            since: Time since the first command, in [s].
        """
        status = self._reader.frame
        self._was_running = self._was_running or status == RUNNING
        if self._was_running:
            return int(Flag.SAFE) if status == SAFE else 0
        if status in (READY, SAFE) and since > self.silence:
            problem = f"it has ignored commands for {self.silence:g} s; see the messages of"
            raise HardwareError(f"the device at {self.uri} rejected the run: {problem} the device")
        return 0

    def stop(self) -> bool:
        """Do nothing, since the robot reduces its forces after the timeout."""
        return False

    def close(self) -> None:
        """Close the node."""
        self.agreed = None
        node, self._node, self._inbox = self._node, None, None
        if node is not None:
            node.close()
