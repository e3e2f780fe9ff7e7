"""Inverse model of a robot's muscles for controllers: reachable tensions and their commands."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray, finite, vector
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core

from .friction import bend_count, stretch_count
from .laws import MuscleLaws, Reach


class MuscleDrive:
    """Inverse model of the muscles of a robot, independent of a plant.

    Args:
        robot: A valid robot. Its active cable set is used.

    Attributes:
        states: Number of states of the muscle laws.
    """

    def __init__(self, robot: Robot) -> None:
        self._n, self._m = len(robot.coordinates), len(robot.muscles)
        self._core = Core(compile_blob(robot))
        self._laws = MuscleLaws(robot, self._core)
        self._qd = np.zeros(self._n)
        self._of_bends = sum(bend_count(muscle) + stretch_count(muscle) for muscle in robot.muscles)
        self.states = len(self._laws.state_names) - self._of_bends

    def set_state(
        self, q: ArrayLike, qd: ArrayLike, states: ArrayLike, slips: ArrayLike = ()
    ) -> None:
        """Set the state that the other methods use.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            states: States of the muscle laws, shape (s,), in the order of the muscles.
            slips: Slip directions of cables with friction, shape (bends,), see `CableSlip`; 0 if
                empty.

        Raises:
            InputError: A value is not finite or the shape is wrong.
        """
        self._move(q)
        self._qd = finite("qd", qd, self._n)
        self._laws.update_rates(self._qd)
        law_states = vector("states", states, self.states)
        all_states = np.concatenate([law_states, np.zeros(self._of_bends)])
        if np.size(slips):
            all_states[-np.size(slips) :] = slips
        self._laws.set_states(all_states)

    def tensions(self, commands: FloatArray) -> FloatArray:
        """Return the tensions at the current state, shape (m,), in [N].

        Args:
            commands: Muscle commands, shape (m,), each in the unit of its muscle law.
        """
        return self._laws.drive(self._qd, commands).copy()

    def reach(self, period: float) -> Reach:
        """Return the tensions that can be reached within a period; see `MuscleLaws.reach`."""
        return self._laws.reach(period)

    def commands(self, forces: FloatArray, horizon: float, period: float = 0.0) -> FloatArray:
        """Return the commands that lead to the given tensions; see `MuscleLaws.invert`."""
        return self._laws.invert(forces, horizon, period).copy()

    def resting_reach(self, q: ArrayLike) -> Reach:
        """Return the range of tensions at rest at q, shape (n,), in [rad] or [m]."""
        self._move(q)
        return self._laws.resting_reach()

    def resting_commands(self, q: ArrayLike, tensions: FloatArray) -> FloatArray:
        """Return the commands that hold tensions at q; see `MuscleLaws.resting_commands`."""
        self._move(q)
        return self._laws.resting_commands(tensions)

    def _move(self, q: ArrayLike) -> None:
        at = finite("q", q, self._n)
        self._core.move(self._core.handle, at.tobytes())
