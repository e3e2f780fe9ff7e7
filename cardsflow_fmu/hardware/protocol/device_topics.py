"""ROS 2 topics of a device: commands and states.

States are `sensor_msgs/JointState` messages. For joints they contain position, velocity and
measured motor torque; for muscles they contain length, rate of the length and tension.

Commands are by default `sensor_msgs/JointState` messages too, with the muscle forces and the
torques of joint motors as efforts. For a forward_command_controller of ros2_control, they are
`std_msgs/Float64MultiArray` messages with the same numbers: first the muscles, then the motors.
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
"""Status of a device, which its state messages contain as frame id."""


class _Part(NamedTuple):
    """Part of a state vector: field of the message, names, and their indices in the field."""

    field: str
    names: tuple[str, ...]
    indices: list[int]


class DeviceTopics:
    """Topics and messages of the hardware of a robot.

    Args:
        address: Address of the node. If it specifies a controller, the topics are those of
            ros2_control.

    Raises:
        InputError: The commands are not forces, positions are not measured, or a joint and a muscle
            have the same name.

    Attributes:
        commands: Names in the order of a command: muscles, then joint motors.
        states: Names in the order of a state message: joints, then muscles.
    """

    def __init__(
        self, robot: Robot, settings: HardwareSettings, address: NodeAddress | None = None
    ) -> None:
        if settings.motors.command != "force" or settings.scale != 1.0:
            problem = "ROS commands are forces in N; remove [hardware.motors] and hardware.scale"
            raise InputError(problem, key="hardware.motors")
        if not settings.has_positions:
            problem = "a ROS link requires measured joint positions; remove this setting"
            raise InputError(problem, key="hardware.has_positions")
        joints = tuple(c.name for c in robot.coordinates)
        muscles = tuple(muscle.name for muscle in robot.muscles)
        motors = tuple(motor.name for motor in robot.motors)
        for name in set(joints) & set(muscles):
            problem = f"a joint and a muscle are both named {name!r}; names in ROS must be unique"
            raise InputError(problem, key=f"muscles.{name}")
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
        """Names of the required values of a state message, for each field."""
        return {
            field: tuple(n for part in self._parts if part.field == field for n in part.names)
            for field in self._row
        }

    def command_values(self, time_ns: int, command: FloatArray) -> Values:
        """Return the fields of the message of a command, shape (commands,), in [N] and [N·m]."""
        if self.commands_topic.type == types.COMMANDS:
            return {"data": command}
        return JointState(time_ns, "", self.commands, effort=command).values

    def command_state(self, received: Received) -> JointState:
        """Return a received command as a joint state with efforts.

        A message without names contains the values in the order of `commands`.
        """
        if self.commands_topic.type != types.COMMANDS:
            return JointState.from_message(received.message)
        effort = np.asarray(received.message.data, dtype=np.float64)
        return JointState(received.sent_ns, "", self.commands, effort=effort)

    def state_values(
        self, time_ns: int, state: FloatArray, rates: FloatArray, status: str
    ) -> Values:
        """Return the fields of the message of a state.

        Args:
            time_ns: Time of the measurement, in [ns] since 1970.
            state: q, qd and the measured values of l, tension and torque, shape (states,).
            rates: l', shape (m,), in [m/s].
        """
        first = 0
        for field, names, indices in self._parts:
            self._row[field][indices] = state[first : first + len(names)]
            first += len(names)
        if rates.size:
            self._row["velocity"][-len(rates) :] = rates
        return JointState(time_ns, status, self.states, **self._row).values

    def state(self, values: dict[str, FloatArray]) -> FloatArray:
        """Return the state vector, shape (states,).

        Args:
            values: Values that `TopicReader` returns for the names `needed`.
        """
        ends = dict.fromkeys(values, 0)
        parts = []
        for field, names, _ in self._parts:
            first = ends[field]
            ends[field] = first + len(names)
            parts.append(values[field][first : ends[field]])
        return np.concatenate(parts)
