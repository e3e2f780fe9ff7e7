"""The plant: a robot in a DART world, pulled by its muscles.

M(q) qdd + C + G + D qd = -L(q)^T f + A tau + J_p(q)^T w, stepped by DART's semi-implicit Euler
rule; L and J_p are evaluated anew at every step. Joint damping D is integrated implicitly: DART's
rule, stable for any step. Joint limits are inelastic stops.
"""

from __future__ import annotations

from typing import Any

import dartpy
import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import InputError, Robot, SimulationError
from addin_sdfusion.robot.check import require_valid

from .blob import compile_blob
from .core import Core
from .muscle_paths import finite, vector
from .skeleton import build_skeleton
from .tasks import point_rows, task_rows

FloatArray = NDArray[np.float64]


class Plant:
    """A simulated robot.

    Args:
        robot: The robot; its active cable set counts.
        step: Length of a step, in [s].

    Raises:
        RobotError: The robot is not valid.
        InputError: The step is not a positive, finite time.

    Attributes:
        robot: The robot.
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
    """

    q: FloatArray
    qd: FloatArray

    def __init__(self, robot: Robot, step: float = 1e-3) -> None:
        require_valid(robot)
        if not (np.isfinite(step) and step > 0):
            raise InputError(f"the plant's step must be a positive time in s, not {step}")
        self.robot = robot
        self._step = float(step)
        n, m, k = len(robot.coordinates), len(robot.muscles), len(robot.task_frames)
        self._n, self._m = n, m
        self._actuated = [k for k, c in enumerate(robot.coordinates) if c.actuated]
        self._core = Core(compile_blob(robot))
        self._handle = self._core.handle
        self._pull = self._core.pull
        self._move = self._core.move_checked
        self._lengths = self._core.array("lengths", m)
        self._jacobian = self._core.array("jacobian", m, n)
        self._torques = self._core.array("torques", n)
        self._task_rows = task_rows(robot)
        self._task_values = self._core.array("task_values", 3 * k)
        self._point_rows = point_rows(robot)
        self._task_jacobian = self._core.array("task_jacobian", 3 * k, n)
        self._skeleton = build_skeleton(robot)
        self._world = _world(robot, self._skeleton.dart, step)
        self._set_forces = self._skeleton.set_forces
        self._world_step = self._world.step
        self._get_positions = self._skeleton.get_positions
        self._get_velocities = self._skeleton.get_velocities
        self.reset()

    @property
    def step_size(self) -> float:
        """Length of a step, in [s]."""
        return self._step

    @property
    def time(self) -> float:
        """Time since the reset, in [s]."""
        return self._ticks * self._step

    @property
    def muscle_lengths(self) -> FloatArray:
        """Path lengths l at the present q, shape (m,), in [m]."""
        return self._lengths.copy()

    @property
    def lengths_view(self) -> FloatArray:
        """As `muscle_lengths`, but a view that the next step changes."""
        return self._lengths

    @property
    def muscle_jacobian(self) -> FloatArray:
        """L = dl/dq at the present q, shape (m, n), in [m/rad] or [m/m]."""
        return self._jacobian.copy()

    @property
    def task_position(self) -> FloatArray:
        """Task coordinates y at the present q, shape (k,), in [m] or [rad]."""
        return self._task_values[self._task_rows]

    def reset(self, q: ArrayLike | None = None, qd: ArrayLike | None = None) -> None:
        """Go to time 0 and a state.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m]; the robot's initial ones when None.
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s]; zero when None.

        Raises:
            InputError: A value is not finite, or the shape is wrong.
        """
        initial = [c.initial for c in self.robot.coordinates]
        positions = vector("q", initial if q is None else q, self._n)
        velocities = vector("qd", np.zeros(self._n) if qd is None else qd, self._n)
        self._go(0, positions, velocities)

    def step(
        self,
        forces: ArrayLike,
        torques: ArrayLike | None = None,
        loads: ArrayLike | None = None,
    ) -> None:
        """Advance by one step with constant muscle forces.

        Args:
            forces: Tension of every muscle, shape (m,), in [N]. A cable cannot push: a negative
                value acts as zero. The bounds f_min and f_max are the controller's business.
            torques: tau, one for every actuated coordinate, in [N·m] or [N]; zero when None.
            loads: w, forces from outside on the task frames that are points, x, y, z of each in
                world axes, shape (3 p,), in [N]; zero when None.

        Raises:
            InputError: A force is not finite, or the shape is wrong.
            SimulationError: The state has diverged; the message names time and coordinate.
        """
        f = vector("forces", forces, self._m)
        bad = self._pull(self._handle, f.tobytes())
        if bad:
            muscle = self.robot.muscles[bad - 1].name
            raise InputError(f"force {f[bad - 1]} of muscle {muscle!r} is not finite")
        if torques is None and loads is None:
            self._set_forces(self._torques)
        else:
            self._set_forces(self._torques + self._motors(torques) + self._pushed(loads))
        self._world_step()
        q = self._get_positions()
        qd = self._get_velocities()
        self._ticks += 1
        bad = self._move(self._handle, q.tobytes(), qd.tobytes())
        if bad:
            self._diverged(bad - 1, q, qd)
        self.q = q
        self.qd = qd

    def _motors(self, torques: ArrayLike | None) -> FloatArray:
        """A tau, shape (n,)."""
        made = np.zeros(self._n)
        if torques is not None:
            made[self._actuated] = finite(
                "torques", vector("torques", torques, len(self._actuated))
            )
        return made

    def _pushed(self, loads: ArrayLike | None) -> FloatArray:
        """J_p^T w, shape (n,)."""
        if loads is None:
            return np.zeros(self._n)
        w = finite("loads", vector("loads", loads, len(self._point_rows)))
        self._core.update_task_jacobian(self._handle)
        pushed: FloatArray = self._task_jacobian[self._point_rows].T @ w
        return pushed

    def get_state(self) -> FloatArray:
        """The whole state, shape (1 + 2 n,): number of steps since the reset, q, qd."""
        return np.concatenate([[self._ticks], self.q, self.qd])

    def set_state(self, state: ArrayLike) -> None:
        """Go back to a state from `get_state`.

        Args:
            state: Shape (1 + 2 n,).

        Raises:
            InputError: A value is not finite, or the shape is wrong.
        """
        values = vector("state", state, 1 + 2 * self._n)
        if not (np.isfinite(values[0]) and values[0] >= 0):
            raise InputError(f"state: {values[0]} is no number of steps")
        self._go(int(values[0]), values[1 : 1 + self._n], values[1 + self._n :])

    def _go(self, ticks: int, q: FloatArray, qd: FloatArray) -> None:
        bad = self._move(self._handle, q.tobytes(), qd.tobytes())
        if bad:
            name = self.robot.coordinates[bad - 1].name
            raise InputError(f"position or velocity of {name!r} is not finite, or beyond 1e9")
        self._skeleton.dart.resetAccelerations()
        self._skeleton.set_positions(q)
        self._skeleton.set_velocities(qd)
        self._ticks = ticks
        self.q = q.copy()
        self.qd = qd.copy()

    def _diverged(self, index: int, q: FloatArray, qd: FloatArray) -> None:
        name = self.robot.coordinates[index].name
        raise SimulationError(
            f"robot {self.robot.name!r} diverged at t = {self.time:.6g} s: "
            f"{name} is {q[index]} with velocity {qd[index]}; use a smaller step or softer gains"
        )


def _world(robot: Robot, skeleton: Any, step: float) -> Any:
    """A DART world with the robot in it; resting bodies are never put to sleep."""
    world = dartpy.simulation.World()
    options = world.getDeactivationOptions()
    options.mEnabled = False
    world.setDeactivationOptions(options)
    world.setTimeStep(step)
    world.setGravity(np.array(robot.gravity))
    world.addSkeleton(skeleton)
    return world
