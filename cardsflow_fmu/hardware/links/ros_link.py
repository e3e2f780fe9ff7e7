"""The link by topics of ROS 2: commands as messages, and states as they come.

Topics have no handshake, no watchdog and no stop. So the names in messages take the place of the
signature, and silence that of a stop: the other side has to bring the forces down where commands
stay away for the time that both sides state.
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

_LOOK_EVERY = 0.05
_MAX_MESSAGES = 100
"""Most messages that are read at once, so that a flood stalls nothing."""
_NO_TIMEOUT = (
    "a topic has no watchdog: state how long the robot may go on without commands, as "
    "ros2://...?timeout=0.1, and the same at the robot's side; safest is our protocol, udp://..., "
    "and --publish beside it"
)


class RosLink:
    """A link by topics; see `HardwareLink`.

    Args:
        uri: ros2://...?timeout=S
        address: The same, read.
        topics: The messages of the robot.
        timeout: How long `open` waits, in [s].

    Raises:
        InputError: The address states no timeout.

    Attributes:
        silence: The stated timeout, in [s].
    """

    def __init__(
        self, uri: str, address: NodeAddress, topics: DeviceTopics, *, timeout: float = 5.0
    ) -> None:
        self.uri, self._address, self._topics, self._waits = uri, address, topics, timeout
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
        self._followed = False

    @property
    def counters(self) -> Counter[str]:
        """Messages sent and received, and dropped by reason."""
        return self._counters + self._reader.counters

    def open(self, handshake: Handshake) -> None:
        """Wait for the robot's states and for its subscriber; see `HardwareLink.open`."""
        self.close()
        if handshake.lockstep:
            what = "topics have no lock step: set hardware.mode = 'realtime', or use our protocol"
            raise HardwareError(f"no link to {self.uri}: {what}")
        if self.silence < 2.0 * handshake.step:
            what = f"its timeout of {self.silence:g} s is shorter than two steps"
            raise HardwareError(f"no link to {self.uri}: {what}")
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
        self._begun_at, self._followed = None, False

    def _wait_for_robot(self, node: Node, inbox: Inbox) -> None:
        """Wait for a state, and for one node that takes commands; reject other commanders."""
        end = time.monotonic() + self._waits
        state, commands = None, self._topics.commands_topic
        while time.monotonic() < end:
            state = self._next(inbox, min(time.monotonic() + _LOOK_EVERY, end)) or state
            takers = node.types(commands, "subscriber").count(commands.type)
            if state is not None and takers:
                if node.types(commands, "publisher"):
                    what = "another node publishes commands; end that one first"
                    raise HardwareError(f"no link to {self.uri}: {what}")
                self.start_state = state[1]
                return
        raise HardwareError(f"no link to {self.uri} within {self._waits:g} s: {self._what(node)}")

    def _what(self, node: Node) -> str:
        """What is missing."""
        states = self._topics.states_topic
        ends: list[tuple[Topic, End]] = [(states, "publisher")]
        ends += [(self._topics.commands_topic, "subscriber")]
        for topic, end in ends:
            name = self._address.absolute(topic.name)
            types = node.types(topic, end)
            if not types:
                return f"{name} has no {end}; is the robot running, in this domain and namespace?"
            if topic.type not in types:
                return f"{name} has the type {types[0]}, and is to have {topic.type}"
        dropped = [reason for reason in REASONS if self._reader.counters[reason]]
        if not dropped:
            return f"no messages come on {self._address.absolute(states.name)}"
        names = ", ".join(self._topics.states)
        return f"{self._address.absolute(states.name)}: {REASONS[dropped[0]]}; needed are {names}"

    def _next(self, inbox: Inbox, until: float) -> tuple[float, FloatArray] | None:
        """Return the next state that counts, and when it came, or None until then."""
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
            HardwareError: No state has come for the stated timeout, or nothing follows commands.
        """
        if self._node is None or self._inbox is None:
            raise HardwareError(f"the link to {self.uri} is not open")
        newest = None
        for _ in range(_MAX_MESSAGES):
            came = self._next(self._inbox, -math.inf)
            if came is None:
                break
            newest = came
        values = self._topics.command_values(time.time_ns(), command)
        sent = time.monotonic()
        self._node.publish(self._topics.commands_topic, values)
        self._counters["sent"] += 1
        self._seq += 1
        if self._begun_at is None:
            self._begun_at = self._newest_at = sent
        newest = self._next(self._inbox, deadline) or newest
        if newest is None:
            age = time.monotonic() - self._newest_at
            self._counters["missed"] += 1
            if age > self.silence:
                what = f"no state came for {self.silence:g} s"
                raise HardwareError(f"the robot at {self.uri} is lost: {what}")
            return Exchange(None, self._seq - 1, age, math.nan, 0)
        self._newest_at, state = newest
        flags = self._flags(sent - self._begun_at)
        round_trip = self._newest_at - sent if self._newest_at > sent else math.nan
        age = time.monotonic() - self._newest_at
        return Exchange(state, self._seq, age, round_trip, flags)

    def _flags(self, since: float) -> int:
        """What the frame of a state says of a device, as flags; that of other robots says nothing.

        Args:
            since: Time since the first command, in [s].
        """
        status = self._reader.frame
        self._followed = self._followed or status == RUNNING
        if self._followed:
            return int(Flag.SAFE) if status == SAFE else 0
        if status in (READY, SAFE) and since > self.silence:
            what = f"it has not followed commands for {self.silence:g} s; see its messages"
            raise HardwareError(f"the device at {self.uri} rejected the run: {what}")
        return 0

    def stop(self) -> bool:
        """Nothing: the robot's side brings its forces down when commands stay away."""
        return False

    def close(self) -> None:
        """Leave the graph."""
        self.agreed = None
        node, self._node, self._inbox = self._node, None, None
        if node is not None:
            node.close()
