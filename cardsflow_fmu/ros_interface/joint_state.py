"""Joint states, and their conversion from and to `sensor_msgs/JointState` messages."""

from __future__ import annotations

from typing import Any, NamedTuple, Self

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

from .node import Values, header

_EMPTY = np.zeros(0)


class JointState(NamedTuple):
    """States of joints, or of tendons: length, rate of the length, and tension.

    Attributes:
        time_ns: Time stamp of the message, in [ns].
        frame: Frame id of the message.
        position, velocity, effort: Values, shape (n,) each, or shape (0,) if not specified.
    """

    time_ns: int
    frame: str
    names: tuple[str, ...]
    position: FloatArray = _EMPTY
    velocity: FloatArray = _EMPTY
    effort: FloatArray = _EMPTY

    @classmethod
    def from_message(cls, message: Any) -> Self:
        """Return the joint states in a message of rclpy or rosbags."""
        stamp = message.header.stamp
        fields = (message.position, message.velocity, message.effort)
        return cls(
            stamp.sec * 1_000_000_000 + stamp.nanosec,
            message.header.frame_id,
            tuple(message.name),
            *(np.asarray(numbers, dtype=np.float64) for numbers in fields),
        )

    @property
    def values(self) -> Values:
        """Fields of the message."""
        return {
            "header": header(self.time_ns, self.frame),
            "name": self.names,
            "position": self.position,
            "velocity": self.velocity,
            "effort": self.effort,
        }
