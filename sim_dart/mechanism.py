"""What integrators move: a robot's skeleton in DART, its muscles in the C core, and its state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.tension_laws import law_of

from .blob import compile_blob
from .core import Core
from .link_wrenches import LinkWrenches
from .skeleton import build_skeleton
from .skeleton_group import build_skeletons
from .tasks import point_rows

if TYPE_CHECKING:
    from .muscle_laws import MuscleLaws

FloatArray = NDArray[np.float64]


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


class Mechanism:
    """A robot at a state.

    Args:
        robot: A valid robot.
        apart: Whether each of its trees is a skeleton of its own: contacts cost less then.
        wrenched: Names of the links that take wrenches.

    Attributes:
        robot: The robot.
        core: Its muscle paths.
        skeleton: Its bodies.
        laws: How its muscles' tensions follow from their commands; None if all are ideal cables,
            whose commands are their tensions.
        q, qd: Where it is, shape (n,).
        muscle_torques: -L'f at the last evaluation, shape (n,), in [N·m] or [N]; a view.
        outer_torques: A tau + J_p'w, likewise.
        link_wrenches: What makes torques of wrenches on links.
    """

    def __init__(self, robot: Robot, *, apart: bool = False, wrenched: Sequence[str] = ()) -> None:
        n, m, k = len(robot.coordinates), len(robot.muscles), len(robot.task_frames)
        self.robot = robot
        self.core = Core(compile_blob(robot))
        self.skeleton = build_skeletons(robot) if apart else build_skeleton(robot)
        self.link_wrenches = LinkWrenches(self.skeleton, wrenched)
        self.lengths = self.core.array("lengths", m)
        self.jacobian = self.core.array("jacobian", m, n)
        self.muscle_torques = self.core.array("torques", n)
        self.outer_torques = np.zeros(n)
        self.laws = _laws(robot, self.core)
        self.q, self.qd = np.zeros(n), np.zeros(n)
        self._handle, self._pull = self.core.handle, self.core.pull
        self._move = self.core.move_checked
        self._point_rows = point_rows(robot)
        self._task_jacobian = self.core.array("task_jacobian", 3 * k, n)

    @property
    def points(self) -> int:
        """Number of rows of the loads: three a task frame that is a point."""
        return len(self._point_rows)

    @property
    def muscle_states(self) -> FloatArray:
        """The muscles' states, shape (s,); a view."""
        return np.empty(0) if self.laws is None else self.laws.states

    def forces(self, commands: FloatArray, held: Held | None) -> FloatArray:
        """-L'f + A tau + J_p'w at the present state, shape (n,); may be a view.

        Args:
            commands: Of every muscle, shape (m,).
            held: What acts from outside; None for nothing.

        Raises:
            InputError: A command is not finite.
        """
        if self.laws is None:
            bad = self._pull(self._handle, commands.tobytes())
        else:
            bad = self.core.drive(self._handle, self.qd.tobytes(), commands.tobytes())
        if bad:
            what = "force" if self.laws is None else "command"
            name = self.robot.muscles[bad - 1].name
            raise InputError(f"{what} {commands[bad - 1]} of muscle {name!r} is not finite")
        if held is None:
            return self.muscle_torques
        self.outer_torques = held.torques
        if held.loads is not None:
            self.core.update_task_jacobian(self._handle)
            pushed = self._task_jacobian[self._point_rows].T @ held.loads
            self.outer_torques = held.torques + pushed
        if held.wrenches is not None:
            self.outer_torques = self.outer_torques + self.link_wrenches.torques(held.wrenches)
        return self.muscle_torques + self.outer_torques

    def arrive(self, q: FloatArray, qd: FloatArray) -> None:
        """Go to a state; the arrays become the mechanism's own.

        Raises:
            DivergedError: It is not finite, or beyond all bounds; nothing has moved then.
        """
        bad = self._move(self._handle, q.tobytes(), qd.tobytes())
        if bad:
            name = self.robot.coordinates[bad - 1].name
            raise DivergedError(f"{name} is {q[bad - 1]} with velocity {qd[bad - 1]}")
        self.q, self.qd = q, qd

    def advance_muscles(self, commands: FloatArray, qd: FloatArray, h: float) -> None:
        """Move the muscles' states on, their paths lengthening as they do at qd.

        Raises:
            DivergedError: A state is not finite any more.
        """
        self.core.update_rates(self._handle, qd.tobytes())
        self.core.advance(self._handle, commands.tobytes(), h)
        self.check_muscles()

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
    from .muscle_laws import MuscleLaws

    return MuscleLaws(robot, core)
