"""The topics of ROS 2 that stand for a device: its commands, and its states.

States are `sensor_msgs/JointState`: of joints position, velocity and the measured torque of motors,
of muscles length, its rate and tension. Commands are of the same type, with the forces of muscles
and the torques of motors at joints as effort, by name; or those of ros2_control: the same numbers
in this order as `std_msgs/Float64MultiArray`, for a forward_command_controller.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.ros_interface import message_types as types
from cardsflow_fmu.ros_interface.address import NodeAddress
from cardsflow_fmu.ros_interface.joint_state import JointState
from cardsflow_fmu.ros_interface.node import Received, Topic, Values
from cardsflow_fmu.utils.arrays import FloatArray

Status = Literal["ready", "running", "safe"]
READY: Status = "ready"
RUNNING: Status = "running"
SAFE: Status = "safe"
"""What a device does, as the frame of its states."""


class _Part(NamedTuple):
    """Where a part of a state vector is in a message: a field, and the names' places there."""

    field: str
    names: tuple[str, ...]
    places: list[int]


class DeviceTopics:
    """The messages of one robot.

    Args:
        robot: The robot.
        settings: Of its hardware.
        address: Of the node; its `controller` makes them those of ros2_control.

    Raises:
        InputError: Its motors take something else than forces, or a muscle has a joint's name.

    Attributes:
        commands_topic, states_topic: The topics.
        commands: Names in the order of a command: muscles, then motors at joints.
        states: Names in the order of a state's message: joints, then muscles.
    """

    def __init__(
        self, robot: Robot, settings: HardwareSettings, address: NodeAddress | None = None
    ) -> None:
        if settings.motors.command != "force" or settings.scale != 1.0:
            what = "commands by ROS are forces in N: leave out [hardware.motors] and the scale"
            raise InputError(what, key="hardware.motors")
        if not settings.has_positions:
            what = "robots by ROS tell their joints' positions: leave it out"
            raise InputError(what, key="hardware.has_positions")
        joints = tuple(c.name for c in robot.coordinates)
        muscles = tuple(muscle.name for muscle in robot.muscles)
        motors = tuple(motor.name for motor in robot.motors)
        for name in set(joints) & set(muscles):
            what = f"a joint and a muscle are both named {name!r}, and messages of ROS have one"
            raise InputError(what, key=f"muscles.{name}")
        self.commands = (*muscles, *motors)
        self.states = (*joints, *muscles)
        parts = [("position", joints), ("velocity", joints)]
        parts += [("position", muscles)] if settings.has_lengths else []
        parts += [("effort", muscles), ("effort", motors)] if settings.has_tensions else []
        self._parts = [
            _Part(field, names, [self.states.index(name) for name in names])
            for field, names in parts
        ]
        controller = "" if address is None else address.controller
        self.states_topic = Topic("/device_states", types.JOINT_STATE)
        self.commands_topic = Topic("/device_commands", types.JOINT_STATE)
        if controller:
            self.states_topic = Topic("/joint_states", types.JOINT_STATE)
            self.commands_topic = Topic(f"/{controller}/commands", types.COMMANDS)
        self._row = {field: np.full(len(self.states), np.nan) for field in JointState._fields[3:]}

    @property
    def needed(self) -> dict[str, tuple[str, ...]]:
        """Names whose numbers a state must have, by fields."""
        return {
            field: tuple(n for part in self._parts if part.field == field for n in part.names)
            for field in self._row
        }

    def command_values(self, time_ns: int, command: FloatArray) -> Values:
        """Return the message of a command, shape (commands,), in [N] and [N·m]."""
        if self.commands_topic.type == types.COMMANDS:
            return {"data": command}
        return JointState(time_ns, "", self.commands, effort=command).values

    def command_state(self, received: Received) -> JointState:
        """A command that was received, as the efforts of joints; without names by their order."""
        if self.commands_topic.type != types.COMMANDS:
            return JointState.of(received.message)
        effort = np.asarray(received.message.data, dtype=np.float64)
        return JointState(received.sent_ns, "", self.commands, effort=effort)

    def state_values(
        self, time_ns: int, state: FloatArray, rates: FloatArray, status: str
    ) -> Values:
        """Return the message of a state.

        Args:
            time_ns: When it was measured, in [ns] since 1970.
            state: q, qd and what is measured of l, tension and torque, shape (states,).
            rates: l', shape (m,), in [m/s].
            status: What the device does.
        """
        first = 0
        for field, names, places in self._parts:
            self._row[field][places] = state[first : first + len(names)]
            first += len(names)
        if rates.size:
            self._row["velocity"][-len(rates) :] = rates
        return JointState(time_ns, status, self.states, **self._row).values

    def state(self, values: dict[str, FloatArray]) -> FloatArray:
        """Return the state vector of what `TopicReader` has read by `needed`, shape (states,)."""
        ends = dict.fromkeys(values, 0)
        parts = []
        for field, names, _ in self._parts:
            first = ends[field]
            ends[field] = first + len(names)
            parts.append(values[field][first : ends[field]])
        return np.concatenate(parts)
