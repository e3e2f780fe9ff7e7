"""Intervals of a robot's motion with exact derivatives, computed by the C core in threads."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from addin_sdfusion.robot import CardsflowError, Robot
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library
from sim_dart.estimation.estimated_robot import estimated_robot, without_limits
from sim_dart.muscles.friction import has_cable_friction
from sim_dart.muscles.laws import MuscleLaws

_MAX_THREADS = 8
_NO_PARAMETERS: FloatArray = np.zeros(0)
_MIN_SHARED = 16  # intervals; fewer are simulated in one thread


class Intervals(NamedTuple):
    """Ends of k intervals and their derivatives.

    Attributes:
        ends: States at the ends, shape (k, nx).
        A: Derivatives by the states at the starts, shape (k, nx, nx).
        B: Derivatives by the controls, shape (k, nx, nu).
        c: Derivatives by the lengths of the intervals, shape (k, nx), in [1/s].
        D: Derivatives by the parameters, shape (k, nx, np).
    """

    ends: FloatArray
    A: FloatArray
    B: FloatArray
    c: FloatArray
    D: FloatArray


@cache
def _bound() -> Any:
    core = ctypes.CDLL(library()._name)  # releases the GIL
    pointer, count = ctypes.c_void_p, ctypes.c_int32
    core.core_shooting_size.argtypes = [pointer]
    core.core_shooting_size.restype = ctypes.c_size_t
    core.core_shooting_open.argtypes = [pointer, pointer]
    core.core_shooting_open.restype = pointer
    core.core_shooting_run.argtypes = [
        *(pointer, count, count, pointer, pointer, pointer, count, pointer, pointer, pointer)
    ]
    return core


class _Worker:
    """Handles of the core for one thread."""

    def __init__(self, robot: Robot) -> None:
        if has_cable_friction(robot):
            raise CardsflowError("optimal motions do not support cable friction; remove it")
        self._core = Core(compile_blob(robot))
        size = _bound().core_shooting_size(self._core.handle)
        if not size:
            raise CardsflowError(
                "this C core does not support derivatives, which optimal motions require"
            )
        self._memory = np.empty(-(-size // 8))
        self._handle = ctypes.c_void_p(
            _bound().core_shooting_open(self._core.handle, self._memory.ctypes.data)
        )

    def run(
        self,
        steps: int,
        h: FloatArray,
        starts: FloatArray,
        controls: FloatArray,
        inputs: Any,
        ends: FloatArray,
        derivatives: FloatArray,
    ) -> int:
        data = [array.ctypes.data for array in (h, starts, controls, inputs, ends, derivatives)]
        bad: int = _bound().core_shooting_run(
            self._handle, len(h), steps, *data[:3], len(inputs), *data[3:]
        )
        return bad


class Shooting:
    """Motion of a robot over intervals with constant forces, and its exact derivatives.

    The state x is (q, qd, states of muscles). The control u is the commands of all driven muscles,
    then the torques of motors at joints. Joints have no limits, since limits are constraints of
    the optimal motion.

    Args:
        robot: The robot.
        steps: Runge-Kutta steps in each interval.
        with_laws: Whether muscles have their laws; otherwise driven muscles are ideal cables, whose
            commands are tensions.
        threads: Number of threads (default: number of processors, at most 8).

    Attributes:
        n: Number of coordinates.
        nx: Number of states.
        laws: Laws of the muscles, for the names and ranges of states and commands.
        driven: Indices of the driven muscles.
        nu: Number of controls.
        steps: Runge-Kutta steps in each interval.

    Raises:
        CardsflowError: This core does not support derivatives, or the robot has cable friction.
    """

    def __init__(
        self, robot: Robot, steps: int = 1, threads: int = 0, with_laws: bool = False
    ) -> None:
        own = without_limits(robot) if with_laws else estimated_robot(robot)
        count = threads or min(os.cpu_count() or 1, _MAX_THREADS)
        self._workers = [_Worker(own) for _ in range(count)]
        self._pool = ThreadPoolExecutor(count) if count > 1 else None
        self.steps = steps
        self.n, self._m = len(robot.coordinates), len(robot.muscles)
        self._core = Core(compile_blob(own))
        self.laws = MuscleLaws(own, self._core)
        self.nx = 2 * self.n + len(self.laws.state_names)
        self.driven = np.flatnonzero(~self.laws.passive).tolist()
        motors = [k for k, c in enumerate(robot.coordinates) if c.actuated]
        self._controls = np.array([*self.driven, *(self._m + k for k in motors)], dtype=np.int32)
        self.nu = len(self._controls)
        last = self.nx + self._m + self.n
        inputs = [*range(self.nx), *(self.nx + self._controls).tolist(), last]
        self._inputs = np.array(inputs, dtype=np.int32)

    def run(
        self,
        x: FloatArray,
        u: FloatArray,
        h: FloatArray,
        derivatives: bool = True,
        parameters: FloatArray = _NO_PARAMETERS,
    ) -> Intervals | None:
        """Simulate k intervals.

        Args:
            x: States at the starts, shape (k, nx).
            u: Controls, shape (k, nu).
            h: Lengths of the intervals, shape (k,), in [s].
            derivatives: Whether to compute derivatives; otherwise A, B, c and D are empty.
            parameters: Values of the free parameters, shape (0,), since there are none.

        Returns:
            The intervals; None if a state diverged.
        """
        found = self._simulate(x, u, h, self._inputs if derivatives else self._inputs[:0])
        if found is None:
            return None
        ends, rows = found
        A, B = rows[:, :, : self.nx], rows[:, :, self.nx : -1]
        c = rows[:, :, -1] if derivatives else rows[:, :, 0:0]
        return Intervals(ends, A, B, c, np.empty((len(h), self.nx, len(parameters))))

    def start(self, q: FloatArray, commands: FloatArray) -> FloatArray:
        """Return the states of muscles at rest.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            commands: Commands of all muscles, shape (m,).
        """
        self._core.move(self._core.handle, q.tobytes())
        self.laws.start(commands)
        return self.laws.states.copy()

    def tensions(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return the tensions of all muscles, shape (k, m), in [N], as for `run`."""
        commands = np.zeros((len(x), self._m))
        commands[:, self.driven] = u[:, : len(self.driven)]
        found = np.empty((len(x), self._m))
        for k, row in enumerate(x):
            self._core.move(self._core.handle, row[: self.n].tobytes())
            self.laws.states[:] = row[2 * self.n :]
            found[k] = self.laws.drive(row[self.n : 2 * self.n], commands[k])
        return found

    def rates(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Return the time derivatives of states, shape (k, nx), as for `run`."""
        found = self._simulate(x, u, np.zeros(len(x)), self._inputs[-1:])
        assert found is not None
        return found[1][:, :, 0]

    def _simulate(
        self, x: FloatArray, u: FloatArray, h: FloatArray, inputs: IntArray
    ) -> tuple[FloatArray, FloatArray] | None:
        """Return the ends of intervals, and their derivatives by some inputs."""
        count = len(h)
        controls = np.zeros((count, self._m + self.n))
        controls[:, self._controls] = u
        lengths = np.ascontiguousarray(h / self.steps)
        starts, ends = np.ascontiguousarray(x), np.empty((count, self.nx))
        rows = np.empty((count, self.nx, len(inputs)))

        def run(worker: _Worker, part: slice) -> int:
            arrays = lengths[part], starts[part], controls[part], inputs, ends[part], rows[part]
            return worker.run(self.steps, *arrays)

        if self._pool is None or count < _MIN_SHARED:
            bad = run(self._workers[0], slice(0, count))
        else:
            bad = any(list(self._pool.map(run, self._workers, self._parts(count))))
        if bad or not np.isfinite(ends).all():
            return None
        if len(inputs):
            rows[:, :, -1] /= self.steps  # by the length of the interval
        return ends, rows

    def _parts(self, count: int) -> Sequence[slice]:
        ends = np.linspace(0, count, len(self._workers) + 1).astype(int)
        return [slice(a, b) for a, b in pairwise(ends.tolist())]
