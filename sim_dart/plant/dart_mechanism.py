"""Mechanism in DART.

DART uses semi-implicit Euler: qd+ = qd + h M^-1 (-L'f + ... - C - G - D qd - ...), then
q+ = q + h qd+. The error is of first order in h. Contacts and joint limits are satisfied at the end
of a step. Joint damping and joint springs are implicit and therefore stable for any step.

DART stops the joints that would exceed their limits if no joint were stopped. If the stop of one
joint drives another joint beyond its limit, this joint exceeds the limit for one step. The step of
the core enforces all limits simultaneously.

Coulomb friction of a joint is an impulse of at most h times the friction force or torque. The joint
sticks at the end of the step if this impulse suffices.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.tasks import point_rows
from sim_dart.dart.skeleton import build_skeleton
from sim_dart.dart.skeleton_group import build_skeletons
from sim_dart.dart.world import World
from sim_dart.scene import Scene

from .mechanism import DivergedError, ExternalForces, Mechanism


class DartMechanism(Mechanism):
    """State of a robot in DART.

    Args:
        scene: The scene around the robot, or None. For other arguments see `Mechanism`.

    Attributes:
        skeleton: The skeleton of the robot; with a scene, one skeleton per kinematic tree, which
            makes contacts faster.
    """

    def __init__(
        self,
        robot: Robot,
        step: float,
        substeps: int,
        scene: Scene | None,
        wrenched: Sequence[str],
        *,
        energy: bool,
    ) -> None:
        super().__init__(robot, step, substeps, wrenched, energy=energy)
        n, k = len(robot.coordinates), len(robot.task_frames)
        self.skeleton = build_skeleton(robot) if scene is None else build_skeletons(robot)
        self.world: World = World(self.skeleton, robot, self._substep, scene)
        self._wrenched = [self.skeleton.bodies[link] for link in wrenched]
        self._damping = np.array([c.damping for c in robot.coordinates])
        self._muscle_torques = self.core.array("torques", n)
        self._outer_torques = np.zeros(n)
        self._has_states = self.muscle_states.size > 0
        self._pull = self.core.pull
        self._point_rows = point_rows(robot)
        self._task_jacobian = self.core.array("task_jacobian", 3 * k, n)

    def step(self, commands: FloatArray, external: ExternalForces | None) -> None:
        """Advance the robot by one step of semi-implicit Euler, with contacts and joint limits."""
        skeleton = self.skeleton
        for _ in range(self._substeps):
            skeleton.set_forces(self._forces(commands, external))
            self.world.step()
            q, qd = skeleton.get_positions(), skeleton.get_velocities()
            if self.work is not None:
                self.work[:3] += self._works(qd, is_loaded=external is not None)
            if self._has_states:
                self._advance_muscles(commands, qd)
            self.update(q, qd)

    def _works(self, qd: FloatArray, *, is_loaded: bool) -> FloatArray:
        """Return the work of muscles, external forces and damping over a substep, in [J].

        It is computed from the forces at the beginning of the substep and the mean of both
        velocities. With a constant mass matrix it equals the change of the kinetic energy.

        Args:
            qd: Velocities at the end of the substep, shape (n,).
            is_loaded: Whether external forces act.
        """
        mean = 0.5 * (self.qd + qd)
        outer = self._outer_torques @ mean if is_loaded else 0.0
        powers = (self._muscle_torques @ mean, outer, -(self._damping * qd) @ mean)
        return self._substep * np.array(powers)

    def _forces(self, commands: FloatArray, external: ExternalForces | None) -> FloatArray:
        """Return -L'f + A tau + J_p'w at the current state, shape (n,), possibly as a view."""
        if self.laws is None:
            bad = self._pull(self._handle, commands.tobytes())
        else:
            qd = self.qd.tobytes()
            inner = self.laws.inner_commands(commands, qd)
            bad = self.core.drive(self._handle, qd, inner.tobytes())
        if bad:
            self.raise_command_error(bad - 1, commands)
        if external is None:
            return self._muscle_torques
        outer = external.torques
        with np.errstate(over="ignore", invalid="ignore"):
            if external.loads is not None:
                self.core.update_task_jacobian(self._handle)
                outer = outer + self._task_jacobian[self._point_rows].T @ external.loads
            if external.wrenches is not None:
                outer = outer + self._wrench_torques(external.wrenches)
            self._outer_torques = outer
            total: FloatArray = self._muscle_torques + outer
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

    def _advance_muscles(self, commands: FloatArray, qd: FloatArray) -> None:
        """Integrate the states of the muscles over a substep with the path velocities at qd."""
        self.core.update_rates(self._handle, qd.tobytes())
        self._work_of_step[:] = 0.0
        self.core.advance(self._handle, commands.tobytes(), self._substep)
        self.check_muscles()
        if self.work is not None:
            lost = self._work_of_step[3]
            self.work += (-lost, 0.0, 0.0, lost)
