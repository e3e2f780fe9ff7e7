"""Muscle laws in the C core: tensions of a robot's muscles from their commands."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Muscle, Robot
from addin_sdfusion.robot.model.muscle_laws import command_range, law_of, states_of
from sim_dart.core.arrays import BoolArray, FloatArray, vector
from sim_dart.core.library import Core

from .custom_laws import CustomLaws
from .friction import bend_count, stretch_count

_HALVINGS = 60


class Reach(NamedTuple):
    """Range of tensions that muscles can reach.

    Attributes:
        low: Smallest tensions, shape (m,), in [N].
        high: Largest tensions, shape (m,), in [N]; infinite for ideal cables.
    """

    low: FloatArray
    high: FloatArray


class MuscleLaws:
    """Muscle laws of a robot's active muscles, evaluated at the last pose of the core.

    A command outside the range of its muscle law is clipped to this range. The command of a passive
    muscle is ignored. Commands have shape (m,), each in the unit of its law. qd has shape (n,), in
    [rad/s] or [m/s]. States have shape (S,). All methods raise InputError for another shape or for
    values that are not finite.

    A simulation step calls

        core.move(q);  laws.drive(qd, u);  ... qd' from laws.torques ...
        laws.update_rates(qd');  laws.advance(u, h)

    Args:
        robot: A valid robot.
        core: The core of this robot, which can be shared.

    Attributes:
        passive: Flags of muscles without command, shape (m,).
        modelled: Flags of muscles with another law than `ideal`, shape (m,).
        state_names: Names of the S states, such as `activation.biceps`. After the states of the
            laws follow the states of cables with friction: `stretch_1.biceps`, the stretch of the
            cable after the first bend (only with distributed elasticity), and `slip_1.biceps`, the
            slip direction at the first bend.
        command_names: Quantity of each command, such as `excitation`; empty for a passive muscle.
        command_units: Units of the commands; empty for a passive muscle.
        command_low: Smallest commands, shape (m,).
        command_high: Largest commands, shape (m,); infinite for ideal cables.
        custom: The custom muscle laws in Python.
        states: States, shape (S,), as a view that can be written.
        rates: Path velocities l' = L qd, shape (m,), in [m/s], as a view.
        tensions: Tensions f of the last `drive`, shape (m,), in [N], as a view. Only springs that
            can push have negative values.
        far_tensions: Tensions at the last via points, after friction, shape (m,), in [N], as a
            view.
        torques: Generalised forces -L'f of the last `drive`, with friction -P'f, shape (n,), in
            [N·m] or [N], as a view.
    """

    def __init__(self, robot: Robot, core: Core) -> None:
        muscles = robot.muscles
        m, n = len(muscles), len(robot.coordinates)
        laws = [law_of(muscle.model) for muscle in muscles]
        states = [(state, muscle) for muscle in muscles for state in states_of(muscle.model)]
        stretched = _bend_state_names("stretch", robot, stretch_count)
        slips = _bend_state_names("slip", robot, bend_count)
        ranges = np.array([command_range(muscle.model) for muscle in muscles]).reshape(m, 2)
        commands = [law.command for law in laws]
        self.passive: BoolArray = np.array([c is None for c in commands], dtype=np.bool_)
        self.modelled: BoolArray = np.array([law.kind != "ideal" for law in laws], dtype=np.bool_)
        names = [f"{state.name}.{muscle.name}" for state, muscle in states]
        units = [state.unit for state, _ in states]
        self.state_names = (*names, *stretched, *slips)
        self.state_units = (*units, *["m"] * len(stretched), *["1"] * len(slips))
        self.command_names = tuple("" if c is None else c.name for c in commands)
        self.command_units = tuple("" if c is None else c.unit for c in commands)
        self.command_low: FloatArray = ranges[:, 0].copy()
        self.command_high: FloatArray = ranges[:, 1].copy()
        self.states = core.array("law_states", len(self.state_names))
        self.rates = core.array("rates", m)
        self.tensions = core.array("tensions", m)
        self.far_tensions = core.array("far_tensions", m) if slips else self.tensions
        self.torques = core.array("torques", n)
        self._low, self._high = core.array("force_low", m), core.array("force_high", m)
        self._commands = core.array("commands", m)
        self._names = tuple(muscle.name for muscle in muscles)
        self.custom = CustomLaws(robot)
        self._lengths = core.array("lengths", m)
        self._core, self._handle, self._m, self._n = core, core.handle, m, n

    def start(self, commands: ArrayLike) -> None:
        """Set the states to the equilibrium at rest with the given commands."""
        u = self._vector("commands", commands)
        self._check(self._core.start(self._handle, u.tobytes()), "command", u)

    def set_states(self, states: ArrayLike) -> None:
        """Set the states, for example to measured values."""
        values = vector("states", states, self.states.size)
        if not np.isfinite(values).all():
            name = self.state_names[int(np.argmin(np.isfinite(values)))]
            raise InputError(f"state {name!r} is not finite")
        self.states[:] = values

    def update_rates(self, qd: ArrayLike) -> FloatArray:
        """Compute and return the path velocities l' = L qd, shape (m,), in [m/s]."""
        self._core.update_rates(self._handle, vector("qd", qd, self._n).tobytes())
        return self.rates

    def drive(self, qd: ArrayLike, commands: ArrayLike) -> FloatArray:
        """Compute path velocities, tensions and torques, and return the tensions."""
        u = self._vector("commands", commands)
        rates = vector("qd", qd, self._n).tobytes()
        inner = self.inner_commands(u, rates)
        self._check(self._core.drive(self._handle, rates, inner.tobytes()), "command", u)
        return self.tensions

    def inner_commands(self, commands: FloatArray, rates: bytes) -> FloatArray:
        """Return the commands for the core. For custom laws these are tensions.

        Args:
            commands: Muscle commands, shape (m,), each in the unit of its law.
            rates: The joint velocities, shape (n,), as bytes.
        """
        if not self.custom:
            return commands
        self._core.update_rates(self._handle, rates)
        return self.custom.forces(commands, self._lengths, self.rates)

    def advance(self, commands: ArrayLike, h: float) -> None:
        """Integrate the states over a time step with constant commands and path velocities.

        Args:
            commands: Muscle commands, shape (m,).
            h: Time step, in [s].
        """
        u = self._vector("commands", commands)
        self._check(self._core.advance(self._handle, u.tobytes(), h), "command", u)

    def reach(self, h: float) -> Reach:
        """Return the range of tensions that can be reached within a time step.

        The path velocities are those of the last call of `drive` or `update_rates`. The range
        corresponds to the smallest and the largest command. A law without states acts
        immediately. The range of a passive muscle is a single value, the range of an ideal cable is
        0 to infinity. The states do not change.

        Args:
            h: Time, in [s].
        """
        self._core.reach(self._handle, h)
        self.custom.reach(self._low, self._high, self._lengths, self.rates)
        return Reach(self._low.copy(), self._high.copy())

    def invert(self, forces: ArrayLike, h: float, period: float = 0.0) -> FloatArray:
        """Return the commands that lead to the given tensions, or to the nearest within `reach`.

        Commands are assumed to be constant during h. The command of a position-controlled drive is
        assumed to follow the velocity of its path in every period.

        Args:
            forces: Desired tensions, shape (m,), in [N].
            h: Time to reach them, in [s].
            period: Time until the next command, in [s]; 0 for h.

        Returns:
            Commands, shape (m,), each in the unit of its law; 0 for passive muscles. This is a
            view.
        """
        f = self._vector("forces", forces)
        self._check(self._core.invert(self._handle, f.tobytes(), h, period or h), "force", f)
        self.custom.invert(self._commands, f, self._lengths, self.rates)
        return self._commands

    def resting_commands(self, tensions: FloatArray) -> FloatArray:
        """Return the commands that hold the given tensions at rest, or the nearest reachable ones.

        The path velocities are set to zero. The states of the muscles change.

        Args:
            tensions: Desired tensions, shape (m,), in [N].

        Returns:
            Commands, shape (m,), each in the unit of its law; 0 for passive muscles.
        """
        least = self.command_low
        bounded = np.isfinite(self.command_high)
        most = np.where(bounded, self.command_high, np.maximum(tensions, least))
        grows = self._resting(least) <= self._resting(most)
        weak, strong = np.where(grows, least, most), np.where(grows, most, least)
        strong = np.where(self._resting(weak) >= tensions, weak, strong)
        for _ in range(_HALVINGS):
            middle = 0.5 * (weak + strong)
            enough = self._resting(middle) >= tensions
            weak, strong = np.where(enough, weak, middle), np.where(enough, middle, strong)
        return strong

    def resting_reach(self) -> Reach:
        """Return the range of tensions that muscles can hold at rest.

        The path velocities are set to zero. The states of the muscles change.
        """
        bounded = np.isfinite(self.command_high)
        least = self._resting(self.command_low)
        most = self._resting(np.where(bounded, self.command_high, 0.0))
        most = np.where(bounded, most, np.inf)
        return Reach(np.minimum(least, most), np.maximum(least, most))

    def _resting(self, commands: FloatArray) -> FloatArray:
        """Return the tensions in equilibrium at rest with constant commands."""
        self.start(commands)
        return self.drive(np.zeros(self._n), commands).copy()

    def _vector(self, label: str, values: ArrayLike) -> FloatArray:
        return vector(label, values, self._m)

    def _check(self, bad: int, label: str, values: FloatArray) -> None:
        if bad:
            name = self._names[bad - 1]
            raise InputError(f"{label} {values[bad - 1]} of muscle {name!r} is not finite")


def _bend_state_names(prefix: str, robot: Robot, count: Callable[[Muscle], int]) -> list[str]:
    return [f"{prefix}_{k}.{m.name}" for m in robot.muscles for k in range(1, count(m) + 1)]
