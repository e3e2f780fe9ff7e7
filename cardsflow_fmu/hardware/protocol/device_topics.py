"""The topics of ROS 2 that stand for a device: its commands, and its states.

Both are `sensor_msgs/JointState`, so that nobody needs to build other messages. Commands have the
forces of muscles and the torques of motors at joints as effort. States have, of joints, position,
velocity and the measured torque of a motor, and of muscles length, its rate and tension.
"""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.middleware.joint_state import JointState, JointStateWriter
from cardsflow_fmu.middleware.node import Topic
from cardsflow_fmu.middleware.types import JOINT_STATE
from cardsflow_fmu.utils.arrays import FloatArray

COMMANDS = Topic("/device_commands", JOINT_STATE)
STATES = Topic("/device_states", JOINT_STATE)

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

    Raises:
        InputError: Its motors take something else than forces, or a muscle has a joint's name.

    Attributes:
        commands: Names in the order of a command: muscles, then motors at joints.
        states: Names in the order of a state's message: joints, then muscles.
    """

    def __init__(self, robot: Robot, settings: HardwareSettings) -> None:
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
        self._command_writer = JointStateWriter(self.commands, effort=True)
        self._state_writers = {
            status: JointStateWriter(self.states, status, position=True, velocity=True, effort=True)
            for status in get_args(Status)
        }
        self._row = {field: np.full(len(self.states), np.nan) for field in JointState._fields[3:]}

    @property
    def needed(self) -> dict[str, tuple[str, ...]]:
        """Names whose numbers a state must have, by fields."""
        return {
            field: tuple(n for part in self._parts if part.field == field for n in part.names)
            for field in self._row
        }

    def command_message(self, time_ns: int, command: FloatArray) -> bytes:
        """The bytes of a command, shape (commands,), in [N] and [N·m]."""
        return self._command_writer.write(time_ns, command)

    def state_message(
        self, time_ns: int, state: FloatArray, rates: FloatArray, status: str
    ) -> bytes:
        """The bytes of a state.

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
        return self._state_writers[status].write(time_ns, *self._row.values())

    def state(self, values: dict[str, FloatArray]) -> FloatArray:
        """The state vector of what `TopicReader` has read by `needed`, shape (states,)."""
        ends = dict.fromkeys(values, 0)
        parts = []
        for field, names, _ in self._parts:
            first = ends[field]
            ends[field] = first + len(names)
            parts.append(values[field][first : ends[field]])
        return np.concatenate(parts)
