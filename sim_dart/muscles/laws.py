"""Tensions of a robot's muscles from their commands: the muscle laws, in the C core."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Muscle, Robot
from addin_sdfusion.robot.model.muscle_laws import command_range, law_of, states_of
from sim_dart.core.arrays import BoolArray, FloatArray, vector
from sim_dart.core.library import Core

from .friction import bends, stretches
from .own_laws import OwnLaws

Curve = Literal[
    "active_force_length", "force_velocity", "passive_force_length", "tendon_force_length"
]

_HALVINGS = 60


class Reach(NamedTuple):
    """Tensions that muscles can reach.

    Attributes:
        low: The smallest, shape (m,), in [N].
        high: The largest, shape (m,), in [N]; infinite for ideal cables.
    """

    low: FloatArray
    high: FloatArray


class MuscleLaws:
    """The muscle laws of a robot's active muscles, at the pose to which the core was moved last.

    A command beyond the range of its law acts as the nearest one in it; that of a passive muscle is
    ignored. Commands have shape (m,), each in its law's unit, qd has shape (n,), in [rad/s] or
    [m/s], and states have shape (S,): another shape or a value that is not finite is an InputError.

    A step of a simulation is

        core.move(q);  laws.drive(qd, u);  ... qd' from laws.torques ...
        laws.update_rates(qd');  laws.advance(u, h)

    Args:
        robot: A valid robot.
        core: That robot's core, shared with its other users.

    Attributes:
        passive: Which muscles take no command, shape (m,).
        modelled: Which muscles have another law than `ideal`, shape (m,).
        state_names: Names of the states, such as `activation.biceps`, S of them. Behind those
            of laws are those of cables with friction, of the first bend `stretch_1.biceps`: by how
            much what lies behind it is stretched, of cables that stretch all along; then
            `slip_1.biceps`: its slip direction.
        state_units: Their units.
        command_names: What each command is, such as `excitation`; empty for a passive muscle.
        command_units: Their units; empty for a passive muscle.
        command_low: Smallest commands, shape (m,).
        command_high: Largest commands, shape (m,); infinite for ideal cables.
        own: Custom those, in Python.
        states: States of the laws, shape (S,): a view, which may be written.
        state_rates: Their time derivatives, from `update_state_rates`; a view.
        rates: l' = L qd, shape (m,), in [m/s]; a view.
        tensions: f of the last `drive`, shape (m,), in [N]; a view. Never negative, but for
            springs that push.
        far_tensions: What friction makes of them at the last via points, shape (m,), in [N]; a
            view.
        torques: -L^T f of the last `drive`, with friction -P^T f, shape (n,), in [N.m] or [N]; a
            view.
    """

    def __init__(self, robot: Robot, core: Core) -> None:
        muscles = robot.muscles
        m, n = len(muscles), len(robot.coordinates)
        laws = [law_of(muscle.model) for muscle in muscles]
        states = [(state, muscle) for muscle in muscles for state in states_of(muscle.model)]
        stretched = _of_bends("stretch", robot, stretches)
        slips = _of_bends("slip", robot, bends)
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
        self.state_rates = core.array("law_rates", len(self.state_names))
        self.rates = core.array("rates", m)
        self.tensions = core.array("tensions", m)
        self.far_tensions = core.array("far_tensions", m) if slips else self.tensions
        self.torques = core.array("torques", n)
        self._low, self._high = core.array("force_low", m), core.array("force_high", m)
        self._commands = core.array("commands", m)
        self._names = tuple(muscle.name for muscle in muscles)
        self.own = OwnLaws(robot)
        self._lengths = core.array("lengths", m)
        self._core, self._handle, self._m, self._n = core, core.handle, m, n

    def start(self, commands: ArrayLike) -> None:
        """Set the states to those of muscles at rest, with these commands for long."""
        u = self._vector("commands", commands)
        self._check(self._core.start(self._handle, u.tobytes()), "command", u)

    def set_states(self, states: ArrayLike) -> None:
        """Set the states, for example to measured ones."""
        values = vector("states", states, self.states.size)
        if not np.isfinite(values).all():
            name = self.state_names[int(np.argmin(np.isfinite(values)))]
            raise InputError(f"state {name!r} is not finite")
        self.states[:] = values

    def update_rates(self, qd: ArrayLike) -> FloatArray:
        """Path velocities l' = L qd."""
        self._core.update_rates(self._handle, vector("qd", qd, self._n).tobytes())
        return self.rates

    def drive(self, qd: ArrayLike, commands: ArrayLike) -> FloatArray:
        """Rates, tensions and torques; the tensions are returned."""
        u = self._vector("commands", commands)
        rates = vector("qd", qd, self._n).tobytes()
        inner = self.inner_commands(u, rates)
        self._check(self._core.drive(self._handle, rates, inner.tobytes()), "command", u)
        return self.tensions

    def inner_commands(self, commands: FloatArray, rates: bytes) -> FloatArray:
        """Return the commands as the core takes them: tensions for custom laws.

        Args:
            commands: Shape (m,), each in the unit of its law.
            rates: The joint velocities, shape (n,), as bytes.
        """
        if not self.own:
            return commands
        self._core.update_rates(self._handle, rates)
        return self.own.forces(commands, self._lengths, self.rates)

    def update_state_rates(self, commands: ArrayLike) -> FloatArray:
        """Time derivatives of the states, at the last rates.

        They can be much faster than a step: `advance` is made for that, explicit rules are not.
        """
        u = self._vector("commands", commands)
        self._check(self._core.update_law_rates(self._handle, u.tobytes()), "command", u)
        return self.state_rates

    def advance(self, commands: ArrayLike, h: float) -> None:
        """Go on with the states, while every path lengthens with its last rate.

        Args:
            commands: Constant meanwhile.
            h: How long, in [s].
        """
        u = self._vector("commands", commands)
        self._check(self._core.advance(self._handle, u.tobytes(), h), "command", u)

    def reach(self, h: float) -> Reach:
        """Smallest and largest tensions that can be had after a time, at the last rates.

        They are those of the smallest and the largest command. A law without states acts at once:
        its tensions are those of now. A passive muscle has one tension. An ideal cable has 0 and
        infinity. The states stay.

        Args:
            h: After how long, in [s].

        """
        self._core.reach(self._handle, h)
        self.own.reach(self._low, self._high, self._lengths, self.rates)
        return Reach(self._low.copy(), self._high.copy())

    def invert(self, forces: ArrayLike, h: float, period: float = 0.0) -> FloatArray:
        """Return the commands that lead to these tensions, or to the nearest ones within `reach`.

        A command is held meanwhile, but for that of a drive that holds a position: this is expected
        to move along with its path, every period.

        Args:
            forces: Desired tensions, shape (m,), in [N].
            h: After how long, in [s].
            period: Until the next command, in [s]; h if 0.

        Returns:
            Commands, shape (m,), in each law's unit; 0 for passive muscles. A view.
        """
        f = self._vector("forces", forces)
        self._check(self._core.invert(self._handle, f.tobytes(), h, period or h), "force", f)
        self.own.invert(self._commands, f, self._lengths, self.rates)
        return self._commands

    def resting_commands(self, tensions: FloatArray) -> FloatArray:
        """Return the commands with which muscles at rest hold these tensions, or the nearest ones.

        The path velocities are taken as zero; the muscles' states change.

        Args:
            tensions: Shape (m,), in [N].

        Returns:
            Shape (m,), each in the unit of its law; 0 for passive muscles.
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
        """Smallest and largest tensions that muscles can hold at rest.

        The path velocities are taken as zero; the muscles' states change.
        """
        bounded = np.isfinite(self.command_high)
        least = self._resting(self.command_low)
        most = self._resting(np.where(bounded, self.command_high, 0.0))
        most = np.where(bounded, most, np.inf)
        return Reach(np.minimum(least, most), np.maximum(least, most))

    def _resting(self, commands: FloatArray) -> FloatArray:
        """Tensions in equilibrium with constant commands at rest."""
        self.start(commands)
        return self.drive(np.zeros(self._n), commands).copy()

    def curve(self, muscle: str, name: Curve, x: ArrayLike, slope: bool = False) -> FloatArray:
        """Return a curve of a muscle of Hill's type, or its slope.

        Args:
            muscle: The muscle's name.
            name: Which curve.
            x: Fibre length over the optimal one, tendon length over its slack length, or fibre
                velocity over the largest contraction velocity, positive while lengthening.
            slope: Whether to return dy/dx.

        Raises:
            InputError: The muscle's law has no such curve.
        """
        index = self._names.index(muscle)
        points = np.asarray(x, dtype=np.float64)
        word = name.encode()
        values = [self._core.curve(self._handle, index, word, p, slope) for p in points.reshape(-1)]
        if np.isnan(values).any():
            raise InputError(f"muscle {muscle!r} has no curve {name!r}")
        return np.array(values).reshape(points.shape)

    def _vector(self, what: str, values: ArrayLike) -> FloatArray:
        return vector(what, values, self._m)

    def _check(self, bad: int, what: str, values: FloatArray) -> None:
        if bad:
            name = self._names[bad - 1]
            raise InputError(f"{what} {values[bad - 1]} of muscle {name!r} is not finite")


def _of_bends(what: str, robot: Robot, count: Callable[[Muscle], int]) -> list[str]:
    return [f"{what}_{k}.{m.name}" for m in robot.muscles for k in range(1, count(m) + 1)]
