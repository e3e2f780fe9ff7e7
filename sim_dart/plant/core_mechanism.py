"""A robot whose bodies are in the C core, and its integrator there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import fixed_energy
from sim_dart.core.close_loops import closed_pose, closed_rates
from sim_dart.core.mass_check import require_inertia
from sim_dart.core.wrench_points import wrench_points

from .energy import EnergyBalance
from .mechanism import ExternalForces, Mechanism, Momentum


class CoreMechanism(Mechanism):
    """A robot at a state, in the C core.

    Args:
        robot: A valid robot, with nothing that the core lacks; see `engine`.
        wrenched: Names of the links that take wrenches.

    Raises:
        InputError: Its mass matrix is singular.
        UnknownNameError: There is no such link.
    """

    def __init__(self, robot: Robot, *, wrenched: Sequence[str] = ()) -> None:
        super().__init__(robot, wrenched)
        n = len(robot.coordinates)
        self._fixed_energy = fixed_energy(robot)
        self._energies = self.core.array("energies", 3)
        self._momenta = self.core.array("momenta", 2, 3)
        self._M = self.core.array("mass_matrix", n, n)
        self._own_q, self._own_qd = self.core.array("q", n), self.core.array("qd", n)
        points = self.load_size // 3
        self._external = self.core.external_wrenches(*wrench_points(robot, wrenched))
        self._is_loaded = False
        self._loads, self._wrenches = self._external[:points, :3], self._external[points:]
        initial = np.array([coordinate.initial for coordinate in robot.coordinates])
        self.core.move(self._handle, initial.tobytes())
        self.core.update_mass_matrix(self._handle)
        require_inertia(robot, self._M)

    def set_state(self, q: FloatArray, qd: FloatArray) -> None:
        """Go to a state; see `Mechanism.set_state`."""
        self.update(q, qd)
        self._own_q[:], self._own_qd[:] = q, qd

    def closed(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the state nearest to one in which the robot's loops are closed, and stay so.

        Raises:
            InputError: They cannot be closed.
        """
        return closed_pose(self.robot, self.core, q), closed_rates(self.core, qd)

    def set_external(self, external: ExternalForces | None) -> bytes | None:
        """Set loads and wrenches of the next steps; the torques as the core takes them."""
        if self._is_loaded:
            self._external[:] = 0.0
            self._is_loaded = False
        if external is None:
            return None
        for part, target in ((external.loads, self._loads), (external.wrenches, self._wrenches)):
            if part is not None:
                target[:] = part.reshape(target.shape)
                self._is_loaded = True
        return external.torques.tobytes()

    def read_state(self) -> None:
        """Copy q and qd from the core after a step."""
        self.q, self.qd = self._own_q.copy(), self._own_qd.copy()

    def refuse_step(self, answer: int, commands: FloatArray) -> None:
        """Raise the error of a step's answer other than 0.

        Raises:
            DivergedError: The state is not finite any more.
            InputError: A command is not.
        """
        if answer < 0:
            self.refuse_command(-answer - 1, commands)
        if answer <= len(self._own_q):
            self.refuse_state(answer - 1, self._own_q, self._own_qd)
        self.check_muscles()

    def energies(self) -> tuple[float, float]:
        """Kinetic and potential energy; see `Mechanism.energies`."""
        self.core.update_energies(self._handle, self.qd.tobytes())
        kinetic, weight, springs = self._energies.tolist()
        return kinetic, weight + self._fixed_energy + springs

    def momentum(self) -> Momentum:
        """Linear and angular momentum in the world."""
        self.core.update_energies(self._handle, self.qd.tobytes())
        linear, angular = self._momenta.copy()
        return Momentum(linear, angular)


class CoreSteps:
    """An integrator of the C core: everything of a step in one call.

    Args:
        mechanism: What to move.
        rule: `euler`, semi-implicit; or `rk4`, the classical rule of fourth order.
        step: h, in [s].
        substeps: Steps of the rule in one; everything but commands and loads is evaluated again.
        balance: Energy balance to add the work to; None for none.
    """

    def __init__(
        self,
        mechanism: CoreMechanism,
        rule: Literal["euler", "rk4"],
        step: float,
        substeps: int,
        balance: EnergyBalance | None,
    ) -> None:
        core = mechanism.core
        self._mechanism, self._balance = mechanism, balance
        self._advance = core.step if rule == "euler" else core.runge_kutta
        self._handle, self._step, self._substeps = core.handle, step / substeps, substeps
        self._work = core.array("work", 4)

    def step(self, commands: FloatArray, external: ExternalForces | None) -> None:
        """See `integrators.Integrator.step`."""
        mechanism = self._mechanism
        torques = mechanism.set_external(external)
        answer = self._advance(
            self._handle, commands.tobytes(), torques, self._step, self._substeps
        )
        if answer:
            mechanism.refuse_step(answer, commands)
        if self._balance is not None:
            self._balance.work += self._work
        mechanism.read_state()
