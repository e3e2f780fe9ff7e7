"""Commands by ROS topics: checks, timeouts, and links that use the states."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from support.process_output import wait_until
from support.robots.robots import PLANAR_2R
from support.ros import bus as buses
from support.ros.bus import Bus, BusNode

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings, MotorSettings
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.emulator.emulated_device import device_of
from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
from cardsflow_fmu.hardware.emulator.loopback_link import LoopbackLink
from cardsflow_fmu.hardware.links import ros_link
from cardsflow_fmu.hardware.links.ros_link import RosLink
from cardsflow_fmu.hardware.protocol.device_topics import SAFE, DeviceTopics
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.topic_reader import TopicReader
from cardsflow_fmu.hardware.session import session as sessions
from cardsflow_fmu.hardware.session import topic_commands
from cardsflow_fmu.hardware.session.connect import handshake_of
from cardsflow_fmu.hardware.session.open_link import open_link
from cardsflow_fmu.hardware.session.session import HardwareSession
from cardsflow_fmu.hardware.session.topic_commands import TopicCommands
from cardsflow_fmu.ros_interface.address import NodeAddress
from cardsflow_fmu.ros_interface.joint_state import JointState
from cardsflow_fmu.ros_interface.node import Topic

ROBOT = Experiment.load(PLANAR_2R).robot
NAMES = tuple(muscle.name for muscle in ROBOT.muscles)
SETTINGS = HardwareSettings(watchdog=5.0, ramp_in=0.0, ramp_down=0.1, max_missed=1000)
TIMEOUT = 60.0
TOPICS = DeviceTopics(ROBOT, SETTINGS)
COMMANDS, STATES = TOPICS.commands_topic, TOPICS.states_topic
FORCES = np.array([30.0, 31.0, 32.0, 33.0])
MAX_WAIT = 20.0
"""Time to wait for a condition, in [s]."""


class Clock:
    """Clock that a test can advance, so that no pause reaches a timeout.

    Attributes:
        ahead: Time by which the clock is ahead of the time of the system, in [s].
    """

    ahead = 0.0

    def __getattr__(self, name: str) -> object:
        return getattr(time, name)

    def monotonic(self) -> float:
        return time.monotonic() + self.ahead


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Return the clock of the timeouts of topics."""
    clock = Clock()
    for module in (topic_commands, ros_link, buses):
        monkeypatch.setattr(module, "time", clock)
    monkeypatch.setattr(sessions, "_MAX_RAMP_DELAY", 60.0)  # a pause does not shorten a ramp
    return clock


class RecordingRobot(EmulatedRobot):
    """Emulated arm that records its commands."""

    def __init__(self) -> None:
        self.given: list[np.ndarray] = []
        self.safes = 0
        super().__init__(ROBOT, 1e-3)

    def apply(self, command: np.ndarray) -> None:
        self.given.append(command.copy())
        super().apply(command)

    def safe(self) -> None:
        self.safes += 1
        super().safe()


class ServedDevice:
    """Device with commands from topics on a bus."""

    def __init__(self, bus: Bus, topics: DeviceTopics = TOPICS) -> None:
        self.robot, self.lines = RecordingRobot(), list[str]()
        self.device: Device = device_of(self.robot, SETTINGS)
        self.topics = topics
        self.commands = TopicCommands(
            ROBOT,
            self.topics,
            bus.node(),
            TIMEOUT,
            self.session,
            self.robot.state,
            self.lines.append,
        )

    def session(self) -> HardwareSession:
        link = LoopbackLink(lambda: self.device, timeout=0.2)
        handshake = handshake_of(ROBOT, SETTINGS, 2e-3)
        return HardwareSession(ROBOT, SETTINGS, link, handshake)

    def has_reported(self, what: str) -> bool:
        return any(what in line for line in self.lines)


@pytest.fixture
def bus() -> Bus:
    return Bus()


@contextmanager
def serving(bus: Bus, topics: DeviceTopics = TOPICS) -> Iterator[ServedDevice]:
    served, stop = ServedDevice(bus, topics), threading.Event()
    thread = threading.Thread(target=lambda: served.commands.run(stop.is_set))
    thread.start()
    try:
        yield served
    finally:
        stop.set()
        thread.join()


def send(node: BusNode, forces: np.ndarray = FORCES, names: tuple[str, ...] = NAMES) -> None:
    node.publish(COMMANDS, JointState(time.time_ns(), "", names, effort=forces).values)


def commanding(node: BusNode, condition: Callable[[], object]) -> None:
    """Send valid commands until a condition holds."""

    def sent() -> object:
        send(node)
        return condition()

    assert wait_until(sent)


@pytest.mark.slow
def test_commands_are_applied_and_ramped_down_after_the_timeout(bus: Bus, clock: Clock) -> None:
    inbox, node = bus.node().subscribe(STATES), bus.node()
    with serving(bus) as served:
        reader = TopicReader(served.topics.needed, 10.0)
        commanding(node, lambda: served.robot.given and (served.robot.given[-1] == FORCES).all())
        clock.ahead += 2.0 * TIMEOUT
        assert wait_until(lambda: served.has_reported(f"none arrived for {TIMEOUT:g} s"))
        assert wait_until(lambda: served.device.state == "safe" and served.commands.status == SAFE)
        falls = np.array(served.robot.given)
        given = len(falls)
        least = np.array([muscle.f_min for muscle in ROBOT.muscles])
        last = int(np.flatnonzero((falls == FORCES).all(axis=1))[-1])
        steps = np.diff(falls[last:], axis=0)
        assert (steps <= 0.0).all()
        assert len(steps) > 10
        np.testing.assert_allclose(falls[-1], least)
        # the same publisher is rejected now; another one may begin
        commanding(node, lambda: served.commands.counters.get("ended", 0) > 3)
        assert len(served.robot.given) == given
        commanding(bus.node(), lambda: len(served.robot.given) > given)

    def is_measured() -> bool:
        message = inbox.receive(time.monotonic())
        values = message and reader.read(message, time.monotonic())
        return bool(values) and served.topics.state(values).shape == (SETTINGS.states(2, 4),)

    assert wait_until(is_measured)


def test_invalid_messages_do_not_move_the_robot(bus: Bus) -> None:
    node = bus.node()
    with serving(bus) as served:
        for _ in range(3):
            send(node, np.array([1.0, 2.0, np.nan, 4.0]))
            send(node, FORCES[:3], NAMES[:3])
            send(node, FORCES, ("no", "such", "muscles", "here"))
            time.sleep(0.01)
        assert wait_until(lambda: served.commands.counters.get("names", 0) >= 6)
        assert served.robot.given == []
        assert served.device.state == "idle"
    for what in ("not finite", "wrong names"):
        assert served.has_reported(what)


def test_messages_of_several_publishers_are_rejected(bus: Bus, clock: Clock) -> None:
    first, second = bus.node(), bus.node()
    first.advertise(COMMANDS)
    with serving(bus) as served:
        commanding(first, lambda: served.robot.given)
        second.advertise(COMMANDS)

        def both() -> object:
            send(first)
            send(second, 2 * FORCES)
            return served.commands.counters.get("several", 0) > 6

        assert wait_until(both)
        assert served.has_reported("several nodes publish")
        clock.ahead += 2.0 * TIMEOUT
        assert wait_until(lambda: served.device.state == "safe")
    assert max(row[0] for row in served.robot.given) <= FORCES[0]


def test_commands_of_a_forward_command_controller_have_no_names(bus: Bus) -> None:
    topics = DeviceTopics(ROBOT, SETTINGS, NodeAddress(controller="tendons"))
    assert topics.commands_topic == Topic("/tendons/commands", "std_msgs/msg/Float64MultiArray")
    states, node = bus.node().subscribe(Topic("/joint_states", STATES.type)), bus.node()
    with serving(bus, topics) as served:

        def sent() -> object:
            node.publish(topics.commands_topic, {"data": FORCES[:3]})
            node.publish(topics.commands_topic, {"data": FORCES})
            return served.robot.given and (served.robot.given[-1] == FORCES).all()

        assert wait_until(sent)
        assert served.has_reported("do not contain numbers for all names")
        message = states.receive(time.monotonic() + MAX_WAIT)
    assert message is not None
    assert message.message.name == (*(c.name for c in ROBOT.coordinates), *NAMES)


def test_a_device_in_use_rejects_commands(bus: Bus) -> None:
    node = bus.node()
    with serving(bus) as served:
        other = served.session()
        other.open()
        other.exchange(0.0, FORCES)
        given = len(served.robot.given)
        commanding(
            node,
            lambda: served.has_reported("are rejected: the device at loopback: rejected the run"),
        )
        assert len(served.robot.given) == given
        other.end(ramp=False)


@pytest.fixture
def make_link(bus: Bus, monkeypatch: pytest.MonkeyPatch) -> Callable[..., RosLink]:
    monkeypatch.setattr(ros_link, "open_node", bus.node)
    return lambda timeout=MAX_WAIT, silence=TIMEOUT: RosLink(
        f"ros2://?timeout={silence}", NodeAddress(timeout=silence), TOPICS, timeout=timeout
    )


def test_a_link_drives_a_device_and_reports_its_safe_state(
    bus: Bus, make_link: Callable[..., RosLink]
) -> None:
    link = make_link()
    with serving(bus) as served:
        link.open(handshake_of(ROBOT, SETTINGS, 2e-3))
        n = len(ROBOT.coordinates)
        np.testing.assert_array_equal(link.start_state[:n], served.robot.plant.q)
        for k in range(20):
            came = link.exchange(2e-3 * k, FORCES, time.monotonic() + MAX_WAIT)
            assert came.state is not None
        assert wait_until(lambda: (served.robot.given[-1] == FORCES).all())
        served.device.go_safe()

        def is_reported() -> bool:
            came = link.exchange(1.0, FORCES, time.monotonic() + MAX_WAIT)
            return came.device_flags != 0

        assert wait_until(is_reported)
        link.close()


def test_a_robot_that_stops_publishing_ends_a_run_after_the_timeout(
    bus: Bus, make_link: Callable[..., RosLink], clock: Clock
) -> None:
    link = make_link()
    with serving(bus):
        link.open(handshake_of(ROBOT, SETTINGS, 2e-3))
        link.exchange(0.0, FORCES, clock.monotonic() + MAX_WAIT)
    clock.ahead += 2.0 * TIMEOUT
    silent = f"does not respond: no state has arrived for {TIMEOUT:g} s"
    with pytest.raises(HardwareError, match=re.escape(silent)):
        for _ in range(1000):
            link.exchange(0.0, FORCES, clock.monotonic())


def test_a_link_that_cannot_be_opened_names_the_missing_part(
    bus: Bus, make_link: Callable[..., RosLink]
) -> None:
    handshake = handshake_of(ROBOT, SETTINGS, 2e-3)

    def refused(what: str, link: RosLink) -> None:
        with pytest.raises(HardwareError, match=re.escape(what)):
            link.open(handshake)

    refused("/device_states has no publisher", make_link(0.05))
    other = bus.node()
    other.advertise(Topic(STATES.name, "std_msgs/msg/String"))
    refused("has the type std_msgs/msg/String", make_link(0.05))
    refused("shorter than two steps", make_link(silence=1e-3))
    other.close()
    with serving(bus):
        commander = bus.node()
        commander.advertise(COMMANDS)
        refused("another node publishes commands", make_link())


def test_invalid_settings_are_rejected_before_a_node_is_opened() -> None:
    with pytest.raises(InputError, match="topics have no watchdog: specify the maximum time"):
        open_link("ros2://", make_topics=lambda _: TOPICS)
    with pytest.raises(InputError, match="not signed"):
        open_link("ros2://?timeout=1", key=bytes(32), make_topics=lambda _: TOPICS)
    with pytest.raises(InputError, match="forces in N"):
        motors = MotorSettings(command="length", stiffness=(1e3,) * 4)
        DeviceTopics(ROBOT, HardwareSettings(motors=motors))
