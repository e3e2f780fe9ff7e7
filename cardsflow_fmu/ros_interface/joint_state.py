"""Joint states as plain data, to and from messages `sensor_msgs/JointState`."""

from __future__ import annotations

from typing import Any, NamedTuple, Self

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

from .node import Values, header

_NOTHING = np.zeros(0)


class JointState(NamedTuple):
    """The states of joints, or of tendons: length, its rate and tension.

    Attributes:
        time_ns: Stamp of the message, in [ns].
        frame: Its frame.
        names: Names of the joints.
        position, velocity, effort: Shape (n,) each; (0,) if they are left out.
    """

    time_ns: int
    frame: str
    names: tuple[str, ...]
    position: FloatArray = _NOTHING
    velocity: FloatArray = _NOTHING
    effort: FloatArray = _NOTHING

    @classmethod
    def of(cls, message: Any) -> Self:
        """Return the state in a message of rclpy or of rosbags."""
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
        """The fields of the message."""
        return {
            "header": header(self.time_ns, self.frame),
            "name": self.names,
            "position": self.position,
            "velocity": self.velocity,
            "effort": self.effort,
        }
