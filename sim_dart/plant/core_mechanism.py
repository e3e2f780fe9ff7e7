"""A robot whose bodies are in the C core, and how it steps there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import standing_energy
from sim_dart.core.mass_check import require_inertia
from sim_dart.core.tasks import point_rows
from sim_dart.core.wrench_points import pushed_points

from .energy import Ledger
from .mechanism import Held, Mechanism, Momentum


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
        super().__init__(robot)
        n = len(robot.coordinates)
        self._wrenched = len(wrenched)
        self._standing = standing_energy(robot)
        self._energies = self.core.array("energies", 3)
        self._momenta = self.core.array("momenta", 2, 3)
        self._M = self.core.array("mass_matrix", n, n)
        self._own_q, self._own_qd = self.core.array("q", n), self.core.array("qd", n)
        self._pushes = _Pushes(robot, wrenched, self)
        initial = np.array([coordinate.initial for coordinate in robot.coordinates])
        self.core.move(self._handle, initial.tobytes())
        self.core.update_mass_matrix(self._handle)
        require_inertia(robot, self._M)

    @property
    def wrench_size(self) -> int:
        """Number of values in the wrenches: six a link that takes one."""
        return 6 * self._wrenched

    def place(self, q: FloatArray, qd: FloatArray) -> None:
        """Go to a state; see `Mechanism.place`."""
        self.arrive(q, qd)
        self._own_q[:], self._own_qd[:] = q, qd

    def act(self, held: Held | None) -> bytes | None:
        """Have this act from outside from now on; the generalised forces for the core's step."""
        self._pushes.set(held)
        return None if held is None else held.torques.tobytes()

    def settle(self) -> None:
        """Take over where the core's step has come to; the arrays are new ones."""
        self.q, self.qd = self._own_q.copy(), self._own_qd.copy()

    def refuse_step(self, answer: int, commands: FloatArray) -> None:
        """Raise what a step's answer other than 0 stands for.

        Raises:
            DivergedError: The state is not finite any more.
            InputError: A command is not.
        """
        if answer < 0:
            self.refuse_command(-answer - 1, commands)
        if answer <= len(self._own_q):
            self.refuse_state(answer - 1, self._own_q, self._own_qd)
        self.check_muscles()

    @property
    def kinetic_energy(self) -> float:
        """1/2 qd'M qd, in [J]."""
        self._update()
        return float(self._energies[0])

    @property
    def potential_energy(self) -> float:
        """Of the weight, zero at the world's origin, and of the joints' springs, in [J]."""
        self._update()
        _, weight, springs = self._energies.tolist()
        return float(weight + self._standing + springs)

    @property
    def momentum(self) -> Momentum:
        """Linear and angular momentum in the world."""
        self._update()
        linear, angular = self._momenta.copy()
        return Momentum(linear, angular)

    def _update(self) -> None:
        """Energies and momenta of now."""
        self.core.update_energies(self._handle, self.qd.tobytes())


class _Pushes:
    """Loads on task points and wrenches on links, as the core's step takes them."""

    def __init__(self, robot: Robot, wrenched: Sequence[str], mechanism: Mechanism) -> None:
        points = len(point_rows(robot)) // 3
        self._all = mechanism.core.push(*pushed_points(robot, wrenched))
        self._loads, self._wrenches = self._all[:points, :3], self._all[points:]
        self._is_pushing = False

    def set(self, held: Held | None) -> None:
        """Push with these, or with nothing."""
        if self._is_pushing:
            self._all[:] = 0.0
            self._is_pushing = False
        if held is None:
            return
        if held.loads is not None:
            self._loads[:] = held.loads.reshape(-1, 3)
            self._is_pushing = True
        if held.wrenches is not None:
            self._wrenches[:] = held.wrenches.reshape(-1, 6)
            self._is_pushing = True


class CoreSteps:
    """An integrator of the C core: everything of a step in one call.

    Args:
        mechanism: What to move.
        rule: `euler` or `rk4`, as in `integrators`.
        step: h, in [s].
        substeps: Steps of the rule in one; everything but commands and loads is evaluated anew.
        ledger: Where work is booked; None for nowhere.
    """

    def __init__(
        self,
        mechanism: CoreMechanism,
        rule: Literal["euler", "rk4"],
        step: float,
        substeps: int,
        ledger: Ledger | None,
    ) -> None:
        core = mechanism.core
        self._mechanism, self._ledger = mechanism, ledger
        self._advance = core.step if rule == "euler" else core.runge_kutta
        self._handle, self._step, self._substeps = core.handle, step / substeps, substeps
        self._work = core.array("work", 3)

    def step(self, commands: FloatArray, held: Held | None) -> None:
        """See `integrators.Integrator.step`."""
        mechanism = self._mechanism
        extra = mechanism.act(held)
        told = commands.tobytes()
        answer = self._advance(self._handle, told, extra, self._step, self._substeps)
        if answer:
            mechanism.refuse_step(answer, commands)
        if self._ledger is not None:
            self._ledger.add(self._work)
        mechanism.settle()
