"""A robot at a state, its muscles in the C core, its bodies in an engine: what integrators move."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.model.muscle_laws import law_of
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core
from sim_dart.core.tasks import point_rows
from sim_dart.muscles.friction import has_cable_friction
from sim_dart.muscles.laws import MuscleLaws


class DivergedError(Exception):
    """A state that is not finite or out of bounds; the plant catches it and adds the time."""


class ExternalForces(NamedTuple):
    """Forces and torques on a robot that are not its muscles', constant over a step.

    Attributes:
        torques: A tau, shape (n,), in [N·m] or [N].
        loads: w, forces on the task frames that are points, shape (3 p,), in [N]; None for none.
        wrenches: On the links that take them, shape (6 k,), in [N] and [N·m]; None for none.
    """

    torques: FloatArray
    loads: FloatArray | None
    wrenches: FloatArray | None = None


class Momentum(NamedTuple):
    """Momentum of a robot in the world.

    Attributes:
        linear: Shape (3,), in [N·s].
        angular: About the world's origin, shape (3,), in [N·m·s].
    """

    linear: FloatArray
    angular: FloatArray


class Mechanism(ABC):
    """A robot at a state.

    Args:
        robot: A valid robot.
        wrenched: Names of the links that take wrenches.

    Attributes:
        robot: The robot.
        core: Its muscle paths.
        laws: How its muscles' tensions follow from their commands; None if all are ideal cables
            without friction, whose commands are their tensions.
        q, qd: Where it is, shape (n,).
        lengths, jacobian: l and L there; views.
        load_size: Number of values in the loads: three a task frame that is a point.
        wrench_size: Number of values in the wrenches: six a link that takes one.
    """

    q: FloatArray
    qd: FloatArray

    def __init__(self, robot: Robot, wrenched: Sequence[str]) -> None:
        n, m = len(robot.coordinates), len(robot.muscles)
        self.robot = robot
        self.core = Core(compile_blob(robot))
        self.lengths = self.core.array("lengths", m)
        self.jacobian = self.core.array("jacobian", m, n)
        ideal = all(law_of(muscle.model).kind == "ideal" for muscle in robot.muscles)
        self.laws = (
            None if ideal and not has_cable_friction(robot) else MuscleLaws(robot, self.core)
        )
        self.q, self.qd = np.zeros(n), np.zeros(n)
        self.load_size = len(point_rows(robot))
        self.wrench_size = 6 * len(wrenched)
        self._handle = self.core.handle
        self._move = self.core.move_checked

    @abstractmethod
    def set_state(self, q: FloatArray, qd: FloatArray) -> None:
        """Go to a state; the arrays become the mechanism's own.

        Raises:
            DivergedError: It is not finite, or beyond all bounds; nothing has moved then.
        """

    @abstractmethod
    def energies(self) -> tuple[float, float]:
        """Kinetic energy 1/2 qd'M qd and potential energy, in [J].

        The potential one is that of the weight, zero at the world's origin, and of joint springs.
        """

    @abstractmethod
    def momentum(self) -> Momentum:
        """Linear and angular momentum in the world."""

    @property
    def muscle_states(self) -> FloatArray:
        """The muscles' states, shape (s,); a view."""
        return np.empty(0) if self.laws is None else self.laws.states

    def update(self, q: FloatArray, qd: FloatArray) -> None:
        """Evaluate muscles and tasks at a state; the arrays become the mechanism's own.

        Raises:
            DivergedError: It is not finite, or beyond all bounds; nothing has moved then.
        """
        bad = self._move(self._handle, q.tobytes(), qd.tobytes())
        if bad:
            self.refuse_state(bad - 1, q, qd)
        self.q, self.qd = q, qd

    def refuse_state(self, k: int, q: FloatArray, qd: FloatArray) -> None:
        """Raise DivergedError for coordinate k of a state."""
        name = self.robot.coordinates[k].name
        raise DivergedError(f"{name} is {q[k]} with velocity {qd[k]}")

    def refuse_command(self, k: int, commands: FloatArray) -> None:
        """Raise InputError for the command of muscle k."""
        what = "force" if self.laws is None else "command"
        name = self.robot.muscles[k].name
        raise InputError(f"{what} {commands[k]} of muscle {name!r} is not finite")

    def check_muscles(self) -> None:
        """Reject states of muscles that are not finite.

        Raises:
            DivergedError: One is not.
        """
        laws = self.laws
        if laws is None or np.isfinite(laws.states).all():
            return
        worst = int(np.flatnonzero(~np.isfinite(laws.states))[0])
        raise DivergedError(f"{laws.state_names[worst]} is {laws.states[worst]}")
