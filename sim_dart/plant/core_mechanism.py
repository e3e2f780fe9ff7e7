"""Mechanism in the C core."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.close_loops import closed_pose, closed_rates
from sim_dart.core.mass_check import require_inertia
from sim_dart.dart.empty_world import EmptyWorld

from .mechanism import ExternalForces, Mechanism
from .settings import Rule


class CoreMechanism(Mechanism):
    """State of a robot in the C core.

    Args:
        rule: `euler` (semi-implicit Euler) or `rk4` (Runge-Kutta of fourth order). For other
            arguments see `Mechanism`.

    Raises:
        InputError: The mass matrix of the robot is singular.
    """

    def __init__(
        self,
        robot: Robot,
        step: float,
        substeps: int,
        rule: Rule,
        wrenched: Sequence[str],
        *,
        energy: bool,
    ) -> None:
        super().__init__(robot, step, substeps, wrenched, energy=energy)
        self.world = EmptyWorld()
        self._advance = self.core.step if rule == "euler" else self.core.runge_kutta
        n = len(robot.coordinates)
        self._M = self.core.array("mass_matrix", n, n)
        self._core_q, self._core_qd = self.core.array("q", n), self.core.array("qd", n)
        points = self.load_size // 3
        self._external = self.core.external_wrenches(*self._wrench_points)
        self._is_loaded = False
        self._loads, self._wrenches = self._external[:points, :3], self._external[points:]
        initial = np.array([coordinate.initial for coordinate in robot.coordinates])
        self.core.move(self._handle, initial.tobytes())
        self.core.update_mass_matrix(self._handle)
        require_inertia(robot, self._M)

    def set_state(self, q: FloatArray, qd: FloatArray) -> None:
        """Set the state; see `Mechanism.set_state`."""
        self.update(q, qd)
        self._core_q[:], self._core_qd[:] = q, qd

    def closed(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the nearest state with closed loops and velocities that keep them closed.

        Raises:
            InputError: The loops cannot be closed.
        """
        return closed_pose(self.robot, self.core, q), closed_rates(self.core, qd)

    def step(self, commands: FloatArray, external: ExternalForces | None) -> None:
        """Advance the robot by one step, which the core computes in a single call."""
        torques = self._set_external(external)
        answer = self._advance(
            self._handle, commands.tobytes(), torques, self._substep, self._substeps
        )
        if answer:
            self._raise_step_error(answer, commands)
        if self.work is not None:
            self.work += self._work_of_step
        self.q, self.qd = self._core_q.copy(), self._core_qd.copy()

    def _set_external(self, external: ExternalForces | None) -> bytes | None:
        """Set the loads and wrenches of the next step, and return the torques for the core."""
        if self._is_loaded:
            self._external[:] = 0.0
            self._is_loaded = False
        if external is None:
            return None
        for values, target in ((external.loads, self._loads), (external.wrenches, self._wrenches)):
            if values is not None:
                target[:] = values.reshape(target.shape)
                self._is_loaded = True
        return external.torques.tobytes()

    def _raise_step_error(self, answer: int, commands: FloatArray) -> None:
        """Raise the error for a nonzero return value of a step."""
        if answer < 0:
            self.raise_command_error(-answer - 1, commands)
        if answer <= len(self._core_q):
            self.raise_state_error(answer - 1, self._core_q, self._core_qd)
        self.check_muscles()
