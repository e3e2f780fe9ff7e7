"""Muscles with tension laws under a force-based control law: reachable tensions and commands.

At every tick the muscles' states and the joints' velocities say which tensions can be reached
within a horizon; the control law chooses among them, and the commands that lead there, if they are
held as long, are found by inverting the muscles' laws. A horizon of one period aims at
the next tick. Muscles that answer late, as a motor behind a spring does, need a longer one: a
command that makes up for the whole delay within a single period overshoots in what is not aimed at,
and the next one more. A drive that holds a position is commanded one that moves along with the path
from tick to tick: a single one for the whole horizon would lead the path, and feed the motion.
"""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.tension_laws import states_of
from cardsflow_fmu.signals.muscles import driven_muscles, state_order
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import MuscleDrive
from sim_dart.muscles.cable_slip import CableSlip

LATE_PERIODS = 4
"""Horizon where a muscle has several states, in periods, unless an experiment has another."""


def late_periods(robot: Robot) -> int:
    """The horizon of a robot's muscles in periods, unless an experiment has another."""
    return LATE_PERIODS if any(len(states_of(m.model)) > 1 for m in robot.muscles) else 1


class MuscleControl:
    """The muscles of a robot under a control law.

    Args:
        robot: The robot; some of its muscles have laws.
        horizon: Horizon of the commands, in [s]; 0 for one period, or `LATE_PERIODS`.

    Attributes:
        size: Length of its memory, see `get_state`.
    """

    def __init__(self, robot: Robot, horizon: float = 0.0) -> None:
        self._horizon, self._periods = horizon, late_periods(robot)
        self._drive = MuscleDrive(robot)
        self._driven = driven_muscles(robot)
        self._order = np.array(state_order(robot), dtype=np.intp)
        self._states = np.zeros(self._drive.states)
        self._m = len(robot.muscles)
        self.size = 2 * self._m + 1
        self.reset(())

    def reset(self, commands: tuple[float, ...]) -> None:
        """Clear the memory.

        Args:
            commands: Commands until the first tick, shape (m,); 0 when empty.
        """
        self._held = np.array(commands) if len(commands) else np.zeros(self._m)
        self._began = np.zeros(self._m)
        self._has_ticked = False

    @property
    def commands(self) -> FloatArray:
        """The commands of the muscles that take one, in the order of their ports."""
        return self._held[self._driven]

    def observe(
        self, q: FloatArray, qd: FloatArray, states: FloatArray, slip: CableSlip | None
    ) -> FloatArray | None:
        """Set the measured state of a tick.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            states: Of the muscles, in the order of their ports, shape (s,).
            slip: Which way cables with friction rub.

        Returns:
            The mean tensions since the last tick, shape (m,), in [N]; None at the first.
        """
        self._states[self._order] = states
        self._drive.set_state(q, qd, self._states, () if slip is None else slip.states)
        if not self._has_ticked:
            return None
        mean: FloatArray = 0.5 * (self._began + self._drive.tensions(self._held))
        return mean

    def horizon(self, period: float) -> float:
        """Horizon of the commands of a tick, in [s].

        Args:
            period: Until the next tick, in [s].
        """
        return max(self._horizon, period) if self._horizon else self._periods * period

    def bounds(
        self, f_min: FloatArray, f_max: FloatArray, period: float
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Reachable tensions, within the bounds where these can be kept.

        Args:
            f_min: Smallest desired forces, shape (m,), in [N].
            f_max: Largest desired forces, shape (m,), in [N].
            period: Until the next tick, in [s].

        Returns:
            The least and the greatest tensions, shape (m,), never negative; and what passive
            springs push with, shape (m,), never positive: no cable can.
        """
        low, high = self._drive.reach(self.horizon(period))
        least, most = np.clip(f_min, low, high), np.clip(f_max, low, high)
        return np.maximum(least, 0.0), np.maximum(most, 0.0), np.minimum(most, 0.0)

    def update(self, forces: FloatArray, period: float) -> None:
        """Find the commands with which the muscles come to these tensions.

        Args:
            forces: Shape (m,), in [N].
            period: Until the next tick, in [s].
        """
        self._held = self._drive.commands(forces, self.horizon(period), period)
        self._began = self._drive.tensions(self._held)
        self._has_ticked = True

    def get_state(self) -> FloatArray:
        """The memory, shape (size,)."""
        return np.concatenate([self._held, self._began, [self._has_ticked]])

    def set_state(self, state: FloatArray) -> None:
        """Go back to a state from `get_state`."""
        m = self._m
        self._held, self._began = state[:m].copy(), state[m : 2 * m].copy()
        self._has_ticked = bool(state[2 * m])
