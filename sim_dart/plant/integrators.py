"""Integrators of a plant: what they have in common, and semi-implicit Euler on DART.

Semi-implicit Euler, DART's own rule: qd+ = qd + h M^-1 (-L'f + ... - C - G - D qd - ...), then
q+ = q + h qd+. Contacts and joint limits hold as of the step's end; damping and springs of joints
are implicit, so that they are stable with any step; the error is of first order in h. DART stops
those joints that would pass their limits without any stop; one that only the stop of another
drives into its own is beyond it for a step. The core's step (`core_mechanism`) holds all at once.
Coulomb friction of joints is an impulse of at most h times its force or torque, which brings the
velocity at the step's end to zero if it can.

The core has the Runge-Kutta rule of fourth order, too: see `csrc/integrators/runge_kutta.c`.
"""

from __future__ import annotations

from typing import Protocol

from sim_dart.core.arrays import FloatArray
from sim_dart.dart.world import World

from .dart_mechanism import DartMechanism
from .energy import EnergyBalance
from .mechanism import ExternalForces


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
        substeps: Steps of the world in one; muscles are evaluated again at each.
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
