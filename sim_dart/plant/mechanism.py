"""What integrators move: a robot at a state, its muscles in the C core, its bodies in an engine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.model.tension_laws import law_of
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core
from sim_dart.core.tasks import point_rows

if TYPE_CHECKING:
    from sim_dart.muscles.laws import MuscleLaws


class DivergedError(Exception):
    """The state of a robot is no state: caught by the plant, which knows the time.

    Args:
        what: What of the robot is what.
    """


class Held(NamedTuple):
    """What acts from outside, held over a step.

    Attributes:
        torques: A tau, shape (n,), in [N·m] or [N].
        loads: w, forces on the task frames that are points, shape (3 p,), in [N]; None for none.
        wrenches: On the links that take them, shape (6 k,), in [N] and [N·m]; None for none.
    """

    torques: FloatArray
    loads: FloatArray | None
    wrenches: FloatArray | None = None


class Momentum(NamedTuple):
    """Momentum of a robot in the world.

    Attributes:
        linear: Shape (3,), in [N·s].
        angular: About the world's origin, shape (3,), in [N·m·s].
    """

    linear: FloatArray
    angular: FloatArray


class Mechanism(ABC):
    """A robot at a state.

    Args:
        robot: A valid robot.

    Attributes:
        robot: The robot.
        core: Its muscle paths.
        laws: How its muscles' tensions follow from their commands; None if all are ideal cables,
            whose commands are their tensions.
        q, qd: Where it is, shape (n,).
        lengths, jacobian: l and L there; views.
        points: Number of rows of the loads: three a task frame that is a point.
    """

    q: FloatArray
    qd: FloatArray

    def __init__(self, robot: Robot) -> None:
        n, m = len(robot.coordinates), len(robot.muscles)
        self.robot = robot
        self.core = Core(compile_blob(robot))
        self.lengths = self.core.array("lengths", m)
        self.jacobian = self.core.array("jacobian", m, n)
        self.laws = _laws(robot, self.core)
        self.q, self.qd = np.zeros(n), np.zeros(n)
        self.points = len(point_rows(robot))
        self._handle = self.core.handle
        self._move = self.core.move_checked

    @property
    @abstractmethod
    def wrench_size(self) -> int:
        """Number of values in the wrenches: six a link that takes one."""

    @abstractmethod
    def place(self, q: FloatArray, qd: FloatArray) -> None:
        """Go to a state, whatever was before; the arrays become the mechanism's own.

        Raises:
            DivergedError: It is not finite, or beyond all bounds; nothing has moved then.
        """

    @property
    @abstractmethod
    def kinetic_energy(self) -> float:
        """1/2 qd'M qd, in [J]."""

    @property
    @abstractmethod
    def potential_energy(self) -> float:
        """Of the weight, zero at the world's origin, and of the joints' springs, in [J]."""

    @property
    @abstractmethod
    def momentum(self) -> Momentum:
        """Linear and angular momentum in the world."""

    @property
    def muscle_states(self) -> FloatArray:
        """The muscles' states, shape (s,); a view."""
        return np.empty(0) if self.laws is None else self.laws.states

    def arrive(self, q: FloatArray, qd: FloatArray) -> None:
        """Move muscles and tasks to a state; the arrays become the mechanism's own.

        Raises:
            DivergedError: It is not finite, or beyond all bounds; nothing has moved then.
        """
        bad = self._move(self._handle, q.tobytes(), qd.tobytes())
        if bad:
            self.refuse_state(bad - 1, q, qd)
        self.q, self.qd = q, qd

    def refuse_state(self, k: int, q: FloatArray, qd: FloatArray) -> None:
        """Raise DivergedError for coordinate k of a state."""
        name = self.robot.coordinates[k].name
        raise DivergedError(f"{name} is {q[k]} with velocity {qd[k]}")

    def refuse_command(self, k: int, commands: FloatArray) -> None:
        """Raise InputError for the command of muscle k."""
        what = "force" if self.laws is None else "command"
        name = self.robot.muscles[k].name
        raise InputError(f"{what} {commands[k]} of muscle {name!r} is not finite")

    def check_muscles(self) -> None:
        """Refuse states of muscles that are not finite.

        Raises:
            DivergedError: One is not.
        """
        laws = self.laws
        if laws is None or np.isfinite(laws.states).all():
            return
        worst = int(np.flatnonzero(~np.isfinite(laws.states))[0])
        raise DivergedError(f"{laws.state_names[worst]} is {laws.states[worst]}")


def _laws(robot: Robot, core: Core) -> MuscleLaws | None:
    if all(law_of(muscle.model).kind == "ideal" for muscle in robot.muscles):
        return None
    from sim_dart.muscles.laws import MuscleLaws

    return MuscleLaws(robot, core)
