"""What a robot's muscles can pull with next, and the commands that make them, for controllers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray, finite
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core

from .laws import MuscleLaws
from .rest import resting_commands, resting_reach


class Reach(NamedTuple):
    """Tensions that muscles can come to within a time.

    Attributes:
        low: The smallest, shape (m,), in [N].
        high: The largest, shape (m,), in [N]; infinite for ideal cables.
    """

    low: FloatArray
    high: FloatArray


class MuscleDrive:
    """The muscles of a robot as its controller knows them, apart from any plant.

    Args:
        robot: A valid robot; its active cable set counts.

    Attributes:
        states: Number of states that the muscles have.
    """

    def __init__(self, robot: Robot) -> None:
        self._n, self._m = len(robot.coordinates), len(robot.muscles)
        self._core = Core(compile_blob(robot))
        self._laws = MuscleLaws(robot, self._core)
        self._qd = np.zeros(self._n)
        self.states = len(self._laws.state_names)

    def see(self, q: ArrayLike, qd: ArrayLike, states: ArrayLike) -> None:
        """Take over the state that the other calls start from.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            states: Of the muscles, shape (s,), muscle after muscle.

        Raises:
            InputError: A value is not finite, or the shape is wrong.
        """
        self._go(q)
        self._qd = finite("qd", qd, self._n)
        self._laws.update_rates(self._qd)
        self._laws.set_states(states)

    def tensions(self, commands: FloatArray) -> FloatArray:
        """What the muscles pull with now, shape (m,), in [N].

        Args:
            commands: Shape (m,), each in the unit of its law.
        """
        return self._laws.drive(self._qd, commands).copy()

    def reach(self, period: float) -> Reach:
        """The tensions that the muscles can come to.

        A passive muscle has one alone; that of an ideal cable has no bound.

        Args:
            period: Within which time, in [s].
        """
        low, high = self._laws.reach(period)
        return Reach(low.copy(), high.copy())

    def commands(self, forces: FloatArray, period: float) -> FloatArray:
        """The commands with which the muscles come to these tensions, or as near as they can.

        Args:
            forces: Shape (m,), in [N].
            period: Within which time, in [s].

        Returns:
            Shape (m,), each in the unit of its law; 0 for passive muscles.
        """
        return self._laws.invert(forces, period).copy()

    def resting_reach(self, q: ArrayLike) -> Reach:
        """The tensions that muscles can hold while they stand still.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        self._go(q)
        return Reach(*resting_reach(self._laws))

    def resting_commands(self, q: ArrayLike, tensions: FloatArray) -> FloatArray:
        """The commands with which muscles that stand still hold these tensions, or the nearest.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            tensions: Shape (m,), in [N].

        Returns:
            Shape (m,), each in the unit of its law; 0 for passive muscles.
        """
        self._go(q)
        return resting_commands(self._laws, tensions)

    def _go(self, q: ArrayLike) -> None:
        at = finite("q", q, self._n)
        self._core.move(self._core.handle, at.tobytes())
