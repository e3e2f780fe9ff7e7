"""Base class of mechanisms: the state of a robot, and the steps that advance it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.model.muscle_laws import law_of
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import compile_blob, fixed_energy
from sim_dart.core.library import Core
from sim_dart.core.tasks import point_rows
from sim_dart.core.wrench_points import wrench_points
from sim_dart.dart.empty_world import EmptyWorld
from sim_dart.dart.world import World
from sim_dart.muscles.friction import has_cable_friction
from sim_dart.muscles.laws import MuscleLaws


class DivergedError(Exception):
    """State that is not finite or out of bounds. The plant adds the time and raises again."""


class ExternalForces(NamedTuple):
    """Forces and torques on a robot other than its muscle forces, constant over a step.

    Attributes:
        torques: Motor torques A tau, shape (n,), in [N·m] or [N].
        loads: Forces w on the position task frames, shape (3 p,), in [N], or None.
        wrenches: Wrenches on links, shape (6 k,), in [N] and [N·m], or None.
    """

    torques: FloatArray
    loads: FloatArray | None
    wrenches: FloatArray | None = None


class Momentum(NamedTuple):
    """Momentum of a robot in the world frame.

    Attributes:
        linear: Linear momentum, shape (3,), in [N·s].
        angular: Angular momentum about the world origin, shape (3,), in [N·m·s].
    """

    linear: FloatArray
    angular: FloatArray


class Mechanism(ABC):
    """State of a robot, with its muscles in the C core and its bodies in an engine.

    Args:
        robot: A valid robot.
        step: Length of a step, in [s].
        substeps: Number of integrator steps per step, with constant commands and loads. Muscles are
            evaluated in each of them.
        wrenched: Names of the links on which external wrenches act.
        energy: Whether to sum up the work done on the robot.

    Raises:
        UnknownNameError: A link does not exist.

    Attributes:
        core: The muscle paths.
        laws: The muscle laws, or None if all muscles are ideal cables without friction. The
            commands of such cables are their tensions.
        q, qd: Joint positions and velocities, shape (n,).
        world: The world with objects and contacts.
        work: Work of muscles, external forces, damping and cable friction, shape (4,), in [J], or
            None.
        lengths, jacobian: l and L at q, as views.
        load_size: Number of values of the loads, three per position task frame.
        wrench_size: Number of values of the wrenches, six per link.
    """

    q: FloatArray
    qd: FloatArray
    world: World | EmptyWorld

    def __init__(
        self, robot: Robot, step: float, substeps: int, wrenched: Sequence[str], *, energy: bool
    ) -> None:
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
        self._wrench_points = wrench_points(robot, wrenched)
        self.work = np.zeros(4) if energy else None
        self._substep, self._substeps = step / substeps, substeps
        self._work_of_step = self.core.array("work", 4)
        self._handle = self.core.handle
        self._move = self.core.move_checked
        self._fixed_energy = fixed_energy(robot)
        self._energies = self.core.array("energies", 3)
        self._momenta = self.core.array("momenta", 2, 3)

    @abstractmethod
    def set_state(self, q: FloatArray, qd: FloatArray) -> None:
        """Set the state. The mechanism keeps references to the arrays.

        Raises:
            DivergedError: The state is not finite or out of bounds. The mechanism is unchanged.
        """

    @abstractmethod
    def step(self, commands: FloatArray, external: ExternalForces | None) -> None:
        """Advance the robot by one step with constant commands and external forces.

        Args:
            commands: Muscle commands, shape (m,).

        Raises:
            InputError: A command is not finite.
            DivergedError: The state is no longer finite.
        """

    def energies(self) -> tuple[float, float]:
        """Return the kinetic energy 1/2 qd'M qd and the potential energy, in [J].

        The potential energy includes the weight, zero at the world origin, and joint springs.
        """
        self.core.update_energies(self._handle, self.qd.tobytes())
        kinetic, weight, springs = self._energies.tolist()
        return kinetic, weight + self._fixed_energy + springs

    def momentum(self) -> Momentum:
        """Return the linear and angular momentum in the world frame."""
        self.core.update_energies(self._handle, self.qd.tobytes())
        return Momentum(*self._momenta.copy())

    @property
    def muscle_states(self) -> FloatArray:
        """States of the muscles, shape (s,), as a view."""
        return np.empty(0) if self.laws is None else self.laws.states

    def update(self, q: FloatArray, qd: FloatArray) -> None:
        """Evaluate muscles and tasks at a state. The mechanism keeps references to the arrays.

        Raises:
            DivergedError: The state is not finite or out of bounds. The mechanism is unchanged.
        """
        bad = self._move(self._handle, q.tobytes(), qd.tobytes())
        if bad:
            self.raise_state_error(bad - 1, q, qd)
        self.q, self.qd = q, qd

    def raise_state_error(self, k: int, q: FloatArray, qd: FloatArray) -> None:
        """Raise DivergedError for coordinate k of a state."""
        name = self.robot.coordinates[k].name
        raise DivergedError(f"{name} is {q[k]} with velocity {qd[k]}")

    def raise_command_error(self, k: int, commands: FloatArray) -> None:
        """Raise InputError for the command of muscle k."""
        label = "force" if self.laws is None else "command"
        name = self.robot.muscles[k].name
        raise InputError(f"{label} {commands[k]} of muscle {name!r} is not finite")

    def check_muscles(self) -> None:
        """Check that the states of all muscles are finite.

        Raises:
            DivergedError: A state is not finite.
        """
        laws = self.laws
        if laws is None or np.isfinite(laws.states).all():
            return
        worst = int(np.flatnonzero(~np.isfinite(laws.states))[0])
        raise DivergedError(f"{laws.state_names[worst]} is {laws.states[worst]}")
