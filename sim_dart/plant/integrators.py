"""Integrators of a plant: their common interface, and semi-implicit Euler in DART.

DART uses semi-implicit Euler: qd+ = qd + h M^-1 (-L'f + ... - C - G - D qd - ...), then
q+ = q + h qd+. The error is of first order in h. Contacts and joint limits are satisfied at the end
of a step. Joint damping and joint springs are implicit and therefore stable for any step.

DART stops the joints that would exceed their limits if no joint were stopped. If the stop of one
joint drives another joint beyond its limit, this joint exceeds the limit for one step. The step of
the core (`core_mechanism`) enforces all limits simultaneously.

Coulomb friction of a joint is an impulse of at most h times the friction force or torque. The joint
sticks at the end of the step if this impulse suffices.

The core also has the Runge-Kutta rule of fourth order; see `csrc/integrators/runge_kutta.c`.
"""

from __future__ import annotations

from typing import Protocol

from sim_dart.core.arrays import FloatArray
from sim_dart.dart.world import World

from .dart_mechanism import DartMechanism
from .energy import EnergyBalance
from .mechanism import ExternalForces


class Integrator(Protocol):
    """Interface of integrators of a mechanism."""

    def step(self, commands: FloatArray, external: ExternalForces | None) -> None:
        """Advance the mechanism by one step of the plant.

        Args:
            commands: Muscle commands, constant over the step, shape (m,).
            external: External forces, constant over the step, or None.

        Raises:
            InputError: A command is not finite.
            DivergedError: The state is no longer finite.
        """


class SemiImplicitEuler:
    """Semi-implicit Euler integrator of DART, with contacts and joint limits.

    Args:
        mechanism: The mechanism to integrate.
        world: Its world, with a step of h / substeps.
        step: Length of a step h, in [s].
        substeps: Number of world steps per step. Muscles are evaluated in each of them.
        balance: Energy balance to which the work is added, or None.
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
        if self._is_plain:  # fast path that most plants use
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
