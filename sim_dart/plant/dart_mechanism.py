"""A robot whose bodies are in DART."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.tasks import point_rows
from sim_dart.dart.link_wrenches import LinkWrenches
from sim_dart.dart.skeleton import build_skeleton
from sim_dart.dart.skeleton_group import build_skeletons

from .mechanism import DivergedError, Held, Mechanism, Momentum


class DartMechanism(Mechanism):
    """A robot at a state, in DART.

    Args:
        robot: A valid robot.
        apart: Whether each of its trees is a skeleton of its own: contacts cost less then.
        wrenched: Names of the links that take wrenches.

    Attributes:
        skeleton: Its bodies.
        muscle_torques: -L'f at the last evaluation, shape (n,), in [N·m] or [N]; a view.
        outer_torques: A tau + J_p'w, likewise.
    """

    def __init__(self, robot: Robot, *, apart: bool = False, wrenched: Sequence[str] = ()) -> None:
        super().__init__(robot)
        n, k = len(robot.coordinates), len(robot.task_frames)
        self.skeleton = build_skeletons(robot) if apart else build_skeleton(robot)
        self._link_wrenches = LinkWrenches(self.skeleton, wrenched)
        self.muscle_torques = self.core.array("torques", n)
        self.outer_torques = np.zeros(n)
        self._stiffness = np.array([c.stiffness for c in robot.coordinates])
        self._rest = np.array([c.rest for c in robot.coordinates])
        self._pull = self.core.pull
        self._point_rows = point_rows(robot)
        self._task_jacobian = self.core.array("task_jacobian", 3 * k, n)

    @property
    def wrench_size(self) -> int:
        """Number of values in the wrenches: six a link that takes one."""
        return self._link_wrenches.size

    def forces(self, commands: FloatArray, held: Held | None) -> FloatArray:
        """-L'f + A tau + J_p'w at the present state, shape (n,); may be a view.

        Args:
            commands: Of every muscle, shape (m,).
            held: What acts from outside; None for nothing.

        Raises:
            InputError: A command is not finite.
            DivergedError: What acts from outside is beyond all numbers.
        """
        if self.laws is None:
            bad = self._pull(self._handle, commands.tobytes())
        else:
            bad = self.core.drive(self._handle, self.qd.tobytes(), commands.tobytes())
        if bad:
            self.refuse_command(bad - 1, commands)
        if held is None:
            return self.muscle_torques
        self.outer_torques = held.torques
        with np.errstate(over="ignore", invalid="ignore"):
            if held.loads is not None:
                self.core.update_task_jacobian(self._handle)
                pushed = self._task_jacobian[self._point_rows].T @ held.loads
                self.outer_torques = held.torques + pushed
            if held.wrenches is not None:
                self.outer_torques = self.outer_torques + self._link_wrenches.torques(held.wrenches)
            total: FloatArray = self.muscle_torques + self.outer_torques
        self._check_forces(total)
        return total

    def _check_forces(self, forces: FloatArray) -> None:
        """DART takes accelerations that are no numbers for none at all.

        Raises:
            DivergedError: A generalised force is not finite.
        """
        if not np.isfinite(forces).all():
            worst = int(np.flatnonzero(~np.isfinite(forces))[0])
            name = self.robot.coordinates[worst].name
            raise DivergedError(f"the force or torque on {name} is {forces[worst]}")

    def place(self, q: FloatArray, qd: FloatArray) -> None:
        """Go to a state; see `Mechanism.place`."""
        self.arrive(q, qd)
        self.skeleton.dart.resetAccelerations()
        self.skeleton.set_positions(q)
        self.skeleton.set_velocities(qd)

    def advance_muscles(self, commands: FloatArray, qd: FloatArray, h: float) -> None:
        """Move the muscles' states on, their paths lengthening as they do at qd.

        Raises:
            DivergedError: A state is not finite any more.
        """
        self.core.update_rates(self._handle, qd.tobytes())
        self.core.advance(self._handle, commands.tobytes(), h)
        self.check_muscles()

    @property
    def kinetic_energy(self) -> float:
        """1/2 qd'M qd, in [J]."""
        return float(self.skeleton.dart.computeKineticEnergy())

    @property
    def potential_energy(self) -> float:
        """Of the weight, zero at the world's origin, and of the joints' springs, in [J]."""
        dart = self.skeleton.dart
        weight = -dart.getMass() * (np.array(self.robot.gravity) @ dart.getCOM())
        bent = self.q - self._rest
        return float(weight + 0.5 * self._stiffness @ bent**2)

    @property
    def momentum(self) -> Momentum:
        """Linear and angular momentum in the world."""
        linear, angular = np.zeros(3), np.zeros(3)
        skeleton = self.skeleton.dart
        for k in range(skeleton.getNumBodyNodes()):
            body = skeleton.getBodyNode(k)
            p = body.getMass() * body.getCOMLinearVelocity()
            R = body.getWorldTransform().rotation()
            inertia = R @ body.getInertia().getMoment() @ R.T
            linear += p
            angular += np.cross(body.getCOM(), p) + inertia @ body.getAngularVelocity()
        return Momentum(linear, angular)
