"""Mechanism in DART."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.tasks import point_rows
from sim_dart.dart.skeleton import build_skeleton
from sim_dart.dart.skeleton_group import build_skeletons

from .mechanism import DivergedError, ExternalForces, Mechanism


class DartMechanism(Mechanism):
    """State of a robot in DART.

    Args:
        robot: A valid robot.
        separate_trees: Use one skeleton per kinematic tree, which makes contacts faster.
        wrenched: Names of the links on which external wrenches act.

    Attributes:
        skeleton: The skeleton, or group of skeletons, of the robot.
        muscle_torques: -L'f of the last evaluation, shape (n,), in [N·m] or [N], as a view.
        outer_torques: A tau + J_p'w of the last evaluation, shape (n,), as a view.
    """

    def __init__(
        self, robot: Robot, *, separate_trees: bool = False, wrenched: Sequence[str] = ()
    ) -> None:
        super().__init__(robot, wrenched)
        n, k = len(robot.coordinates), len(robot.task_frames)
        self.skeleton = build_skeletons(robot) if separate_trees else build_skeleton(robot)
        self._wrenched = [self.skeleton.bodies[link] for link in wrenched]
        self.muscle_torques = self.core.array("torques", n)
        self.outer_torques = np.zeros(n)
        self._pull = self.core.pull
        self._work = self.core.array("work", 4)
        self._point_rows = point_rows(robot)
        self._task_jacobian = self.core.array("task_jacobian", 3 * k, n)

    def forces(self, commands: FloatArray, external: ExternalForces | None) -> FloatArray:
        """Return -L'f + A tau + J_p'w at the current state, shape (n,), possibly as a view.

        Args:
            commands: Muscle commands, shape (m,).
            external: External forces, or None.

        Raises:
            InputError: A command is not finite.
            DivergedError: A generalised force is not finite.
        """
        if self.laws is None:
            bad = self._pull(self._handle, commands.tobytes())
        else:
            qd = self.qd.tobytes()
            inner = self.laws.inner_commands(commands, qd)
            bad = self.core.drive(self._handle, qd, inner.tobytes())
        if bad:
            self.raise_command_error(bad - 1, commands)
        if external is None:
            return self.muscle_torques
        outer = external.torques
        with np.errstate(over="ignore", invalid="ignore"):
            if external.loads is not None:
                self.core.update_task_jacobian(self._handle)
                outer = outer + self._task_jacobian[self._point_rows].T @ external.loads
            if external.wrenches is not None:
                outer = outer + self._wrench_torques(external.wrenches)
            self.outer_torques = outer
            total: FloatArray = self.muscle_torques + outer
        if not np.isfinite(total).all():  # DART does not check this
            worst = int(np.flatnonzero(~np.isfinite(total))[0])
            name = self.robot.coordinates[worst].name
            raise DivergedError(f"the force or torque on {name} is {total[worst]}")
        return total

    def _wrench_torques(self, wrenches: FloatArray) -> FloatArray:
        """Return the generalised forces of forces and torques on links, shape (n,)."""
        for body, wrench in zip(self._wrenched, wrenches.reshape(-1, 6), strict=True):
            body.addExtForce(wrench[:3])
            body.addExtTorque(wrench[3:])
        torques = self.skeleton.get_external_forces()
        for dart in self.skeleton.darts:
            dart.clearExternalForces()
        return torques

    def set_state(self, q: FloatArray, qd: FloatArray) -> None:
        """Set the state; see `Mechanism.set_state`."""
        self.update(q, qd)
        self.skeleton.dart.resetAccelerations()
        self.skeleton.set_positions(q)
        self.skeleton.set_velocities(qd)

    def advance_muscles(self, commands: FloatArray, qd: FloatArray, h: float) -> float:
        """Integrate the states of the muscles over h with the path velocities at qd.

        Returns:
            The work of cable friction, in [J].

        Raises:
            DivergedError: A state is no longer finite.
        """
        self.core.update_rates(self._handle, qd.tobytes())
        self._work[:] = 0.0
        self.core.advance(self._handle, commands.tobytes(), h)
        self.check_muscles()
        return float(self._work[3])
