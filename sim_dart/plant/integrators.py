"""Integrators of a plant: semi-implicit Euler, and the Runge-Kutta rule of fourth order.

Semi-implicit Euler, DART's own rule: qd+ = qd + h M^-1 (-L'f + ... - C - G - D qd - ...), then
q+ = q + h qd+. Contacts and joint limits hold as of the step's end; damping and springs of joints
are implicit, so that they are stable with any step; the error is of first order in h. DART stops
those joints that would pass their limits without any stop; one that only the stop of another
drives into its own is beyond it for a step. The core's step (`core_mechanism`) holds all at once.
Coulomb friction of joints is an impulse of at most h times its force or torque, which brings the
velocity at the step's end to zero where it can.

Runge-Kutta 4 for plants without contacts: M qdd = -L'f + A tau + J_p'w - C - G - D qd - K (q - r)
and x' of the muscles, with everything evaluated at all four stages. Its error is of fourth order
where these are smooth; a cable that goes slack, a path that touches a surface and a joint that
meets its limit are kinks, and cost orders where they happen.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.dart.world import World

from .dart_mechanism import DartMechanism
from .energy import EnergyBalance
from .mechanism import ExternalForces

if TYPE_CHECKING:
    import dartpy


class Integrator(Protocol):
    """Moves a mechanism."""

    def step(self, commands: FloatArray, external: ExternalForces | None) -> None:
        """Move on by the plant's step.

        Args:
            commands: Of every muscle, shape (m,), held.
            external: External forces, held; None for none.

        Raises:
            InputError: A command is not finite.
            DivergedError: The state is not finite any more.
        """


class SemiImplicitEuler:
    """DART's rule, with contacts and limits.

    Args:
        mechanism: What to move.
        world: Its world, with a step of h over substeps.
        step: h, in [s].
        substeps: Steps of the world in one; muscles are evaluated anew at each.
        balance: Energy balance to add the work to; None for none.
    """

    def __init__(
        self,
        mechanism: DartMechanism,
        world: World,
        step: float,
        substeps: int,
        balance: EnergyBalance | None,
    ) -> None:
        self._mechanism, self._balance = mechanism, balance
        self._step, self._substeps = step / substeps, substeps
        self._world_step = world.step
        skeleton = mechanism.skeleton
        self._set_forces = skeleton.set_forces
        self._get_positions = skeleton.get_positions
        self._get_velocities = skeleton.get_velocities
        self._forces, self._update = mechanism.forces, mechanism.update
        self._remembers = mechanism.muscle_states.size > 0
        self._is_plain = substeps == 1 and balance is None and not self._remembers

    def step(self, commands: FloatArray, external: ExternalForces | None) -> None:
        """See `Integrator.step`."""
        if self._is_plain:  # the fast path of most plants
            self._set_forces(self._forces(commands, external))
            self._world_step()
            self._update(self._get_positions(), self._get_velocities())
            return
        for _ in range(self._substeps):
            self._set_forces(self._forces(commands, external))
            self._world_step()
            q, qd = self._get_positions(), self._get_velocities()
            if self._balance is not None:
                self._balance.add_step(self._step, self._mechanism, external is not None, qd)
            if self._remembers:
                lost = self._mechanism.advance_muscles(commands, qd, self._step)
                if self._balance is not None:
                    self._balance.work += (-lost, 0.0, 0.0, lost)
            self._update(q, qd)


class RungeKutta4:
    """The classical rule of order 4 on DART's forward dynamics, without contacts.

    A joint that passes its limit within a step is put back to it at the end, and stopped by an
    impulse, as it acts on all joints.

    Args:
        mechanism: What to move.
        step: h, in [s].
        substeps: Steps of the rule in one.
        balance: Energy balance to add the work to; None for none.
    """

    def __init__(
        self, mechanism: DartMechanism, step: float, substeps: int, balance: EnergyBalance | None
    ) -> None:
        self._mechanism, self._balance = mechanism, balance
        self._step, self._substeps = step / substeps, substeps
        robot = mechanism.robot
        self._skeleton = mechanism.skeleton
        self._damping = np.array([c.damping for c in robot.coordinates])
        self._stiffness = np.array([c.stiffness for c in robot.coordinates])
        self._rest = np.array([c.rest for c in robot.coordinates])
        self._lower = np.array([c.lower for c in robot.coordinates])
        self._upper = np.array([c.upper for c in robot.coordinates])
        _remove_resistance(self._skeleton.dart)
        n = len(robot.coordinates)
        self._ends = [n, 2 * n, 2 * n + mechanism.muscle_states.size]

    def step(self, commands: FloatArray, external: ExternalForces | None) -> None:
        """See `Integrator.step`."""
        for _ in range(self._substeps):
            self._one_step(commands, external)

    def _one_step(self, commands: FloatArray, external: ExternalForces | None) -> None:
        mechanism, h = self._mechanism, self._step
        y = np.concatenate([mechanism.q, mechanism.qd, mechanism.muscle_states, np.zeros(3)])

        def rates(at: FloatArray) -> FloatArray:
            self._update(at)
            return self._rates(commands, external)

        k1 = rates(y)
        k2 = rates(y + 0.5 * h * k1)
        k3 = rates(y + 0.5 * h * k2)
        k4 = rates(y + h * k3)
        y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        self._update(y)
        if self._balance is not None:
            self._balance.work[:3] += y[self._ends[-1] :]
        self._stop_at_limits()
        self._skeleton.set_positions(mechanism.q)
        self._skeleton.set_velocities(mechanism.qd)

    def _update(self, y: FloatArray) -> None:
        mechanism = self._mechanism
        n, end, last = self._ends
        if last > end:
            mechanism.muscle_states[:] = y[end:last]
            mechanism.check_muscles()
        mechanism.update(y[:n], y[n:end])

    def _rates(self, commands: FloatArray, external: ExternalForces | None) -> FloatArray:
        """(qd, qdd, x', powers of muscles, of external forces, and of damping)."""
        mechanism, skeleton = self._mechanism, self._skeleton
        q, qd = mechanism.q, mechanism.qd
        skeleton.set_positions(q)
        skeleton.set_velocities(qd)
        damping = -self._damping * qd
        forces = mechanism.forces(commands, external) + damping - self._stiffness * (q - self._rest)
        skeleton.set_forces(forces)
        skeleton.dart.computeForwardDynamics()
        qdd = skeleton.vector(skeleton.dart.getAccelerations())
        laws = mechanism.laws
        x_rates = np.empty(0) if laws is None else laws.update_state_rates(commands)
        outer = 0.0 if external is None else mechanism.outer_torques @ qd
        powers = (mechanism.muscle_torques @ qd, outer, damping @ qd)
        return np.concatenate([qd, qdd, x_rates, powers])

    def _stop_at_limits(self) -> None:
        mechanism = self._mechanism
        low, high = mechanism.q < self._lower, mechanism.q > self._upper
        if not (low.any() or high.any()):
            return
        q = np.clip(mechanism.q, self._lower, self._upper)
        self._skeleton.set_positions(q)
        M = self._skeleton.matrix(self._skeleton.dart.getMassMatrix())
        # DART's own inverse is wrong where a fixed joint has moving ones behind it
        inverse_M = np.asarray(np.linalg.inv(M), dtype=np.float64)
        normals = np.concatenate([np.eye(q.size)[low], -np.eye(q.size)[high]])
        mechanism.update(q, stopped(mechanism.qd, inverse_M, normals))


def stopped(qd: FloatArray, inverse_M: FloatArray, normals: FloatArray) -> FloatArray:
    """The velocities behind an inelastic stop: N qd+ >= 0 by the smallest impulses p >= 0.

    qd+ = qd + M^-1 N'p, with p'(N qd+) = 0: what minimises 1/2 p'Ap + p'N qd, A = N M^-1 N'.

    Args:
        qd: The velocities before, shape (n,).
        inverse_M: M^-1, shape (n, n).
        normals: N, a row a stop: which way its joint may go, shape (k, n).
    """
    from scipy.optimize import nnls  # takes half a second

    A = normals @ inverse_M @ normals.T
    root = np.linalg.cholesky(A).T
    impulses, _ = nnls(root, -np.linalg.solve(root.T, normals @ qd))
    after: FloatArray = qd + inverse_M @ normals.T @ impulses
    return after


def _remove_resistance(skeleton: dartpy.dynamics.Skeleton) -> None:
    """No damping and springs in DART: its forward dynamics would scale them by its time step."""
    for k in range(skeleton.getNumDofs()):
        dof = skeleton.getDof(k)
        dof.setDampingCoefficient(0.0)
        dof.setSpringStiffness(0.0)


def refuse_friction(robot: Robot) -> None:
    """Refuse robots that no explicit rule can hold at rest.

    Raises:
        InputError: A joint has Coulomb friction, which jumps with the sign of the velocity, or a
            cable has friction, which turns round within a fraction of a millimetre.
    """
    cables = [muscle.name for muscle in robot.muscles if muscle.bend_friction]
    if cables:
        raise InputError(
            "rk4 does not support friction of cables, which is too fast for an explicit rule: "
            f"{', '.join(cables)} has some; use the euler integrator"
        )
    rough = [c.name for c in robot.coordinates if c.friction]
    if rough:
        raise InputError(
            "rk4 does not support Coulomb friction, which jumps where a joint turns: "
            f"{', '.join(rough)} has some; use the euler integrator"
        )
