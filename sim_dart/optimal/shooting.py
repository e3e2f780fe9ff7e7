"""Intervals of a robot's motion with exact derivatives, computed by the C core in threads."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import CardsflowError, Robot, SimulationError
from sim_dart.batch.threads import Threads
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library
from sim_dart.estimation.estimated_robot import estimated_robot, without_limits
from sim_dart.muscles.friction import has_cable_friction
from sim_dart.muscles.laws import MuscleLaws

from .parameters import RobotFamily, RobotNumbers

Integers = NDArray[np.intp]
_NO_PARAMETERS: FloatArray = np.zeros(0)
_MIN_SHARED = 16  # intervals; fewer are simulated in one thread


class Intervals(NamedTuple):
    """Ends of k intervals and their derivatives; see `controllers.optimal.problem.IntervalResult`.

    The derivatives by the lengths are in [1/s].
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
        *(pointer, count, pointer, pointer, pointer, pointer, count, pointer, pointer, pointer)
    ]
    core.core_shooting_rates.argtypes = [pointer, count, pointer, pointer, pointer, pointer]
    core.core_shooting_along.argtypes = [
        *(pointer, count, pointer, pointer, pointer, pointer, pointer, pointer)
    ]
    return core


class Shooting:
    """Motion of a robot over intervals with constant forces, and its exact derivatives.

    The state x is (q, qd, states of muscles). The control u is the commands of all driven muscles,
    then the torques of motors at joints. Joints have no limits, since limits are constraints of
    the optimal motion.

    Args:
        steps: Runge-Kutta steps in an interval.
        with_laws: Whether muscles have their laws; otherwise driven muscles are ideal cables, whose
            commands are tensions.
        threads: Number of threads (default: number of processors, at most 8).
        family: Robots with other values of free parameters (default: none). Their nominal robot
            replaces `robot`.

    Attributes:
        n: Number of coordinates.
        nx: Number of states.
        laws: Laws of the muscles, for the names and ranges of states and commands.
        driven: Indices of the driven muscles.
        nu: Number of controls.
        steps: Runge-Kutta steps in an interval: of all, or of each, shape (N,).

    Raises:
        CardsflowError: The robot has cable friction.
    """

    def __init__(
        self,
        robot: Robot,
        steps: int = 1,
        threads: int = 0,
        with_laws: bool = False,
        family: RobotFamily | None = None,
    ) -> None:
        if has_cable_friction(robot):
            raise CardsflowError("optimal motions do not support cable friction; remove it")
        prepare = without_limits if with_laws else estimated_robot
        self._robot = prepare(robot)
        self._threads = Threads(threads, is_balanced=True)
        self.steps: int | Integers = steps
        self.n, self._m = len(robot.coordinates), len(robot.muscles)
        self._numbers = None if family is None else RobotNumbers(family, prepare)
        self._parameters = _NO_PARAMETERS if family is None else family.nominal.copy()
        self._open()
        self.nx = 2 * self.n + len(self.laws.state_names)
        self.driven = np.flatnonzero(~self.laws.passive).tolist()
        motors = [k for k, c in enumerate(robot.coordinates) if c.actuated]
        self._controls = np.array([*self.driven, *(self._m + k for k in motors)], dtype=np.int32)
        self.nu = len(self._controls)
        last = self.nx + self._m + self.n
        inputs = [*range(self.nx), *(self.nx + self._controls).tolist(), last]
        self._inputs = np.array(inputs, dtype=np.int32)

    def _open(self) -> None:
        """Create the handles of the core for the current parameters."""
        numbers = self._numbers
        blob = compile_blob(self._robot) if numbers is None else numbers.blob(self._parameters)
        self._cores = [Core(blob) for _ in range(self._threads.count)]
        self._core = self._cores[0]
        numbers = -(-_bound().core_shooting_size(self._core.handle) // 8)
        self._memory = np.empty((len(self._cores), numbers))
        pairs = zip(self._cores, self._memory, strict=True)
        opened = [_bound().core_shooting_open(c.handle, row.ctypes.data) for c, row in pairs]
        self._handles = [ctypes.c_void_p(handle) for handle in opened]
        self.laws = MuscleLaws(self._robot, self._core)

    def use(self, parameters: FloatArray) -> None:
        """Set the values of the free parameters for all methods, shape (np,)."""
        if np.array_equal(parameters, self._parameters):
            return
        self._parameters = parameters.copy()
        self._open()

    @contextmanager
    def using(self, steps: int | Integers) -> Iterator[None]:
        """Use other numbers of Runge-Kutta steps."""
        previous, self.steps = self.steps, steps
        try:
            yield
        finally:
            self.steps = previous

    def run(
        self,
        x: FloatArray,
        u: FloatArray,
        h: FloatArray,
        derivatives: bool = True,
        parameters: FloatArray = _NO_PARAMETERS,
        nodes: Integers | None = None,
    ) -> Intervals | None:
        """Simulate k intervals.

        Args:
            x: States at the starts, shape (k, nx).
            u: Controls, shape (k, nu).
            h: Lengths of the intervals, shape (k,), in [s].
            derivatives: Whether to compute derivatives; otherwise A, B, c and D are empty.
            parameters: Values of the free parameters, shape (np,), for `use` (default: unchanged).
            nodes: Indices of the intervals, for their numbers of steps, shape (k,) (default: all).

        Returns:
            The intervals; None if a state diverged.
        """
        if len(parameters):
            self.use(parameters)
        steps = self._steps_of(len(h), nodes)
        inputs = self._inputs if derivatives else self._inputs[:0]
        result = self._simulate(x, u, h, steps, inputs)
        by_p = result is not None and derivatives
        D = self._along_parameters(x, u, h, steps) if by_p else np.empty((len(h), 0, 0))
        if result is None or D is None:
            return None
        ends, rows = result
        A, B = rows[:, :, : self.nx], rows[:, :, self.nx : -1]
        c = rows[:, :, -1] if derivatives else rows[:, :, 0:0]
        return Intervals(ends, A, B, c, D)

    def changed_fields(self) -> list[list[str]]:
        """Return the names of the core's fields that each parameter changes."""
        numbers = self._numbers
        return [] if numbers is None else numbers.changed_fields(self._parameters)

    def start(self, q: FloatArray, commands: FloatArray) -> FloatArray:
        """Return the states of muscles at rest.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            commands: Commands of all muscles, shape (m,).
        """
        self._core.move(self._core.handle, q.tobytes())
        self.laws.start(commands)
        return self.laws.states.copy()

    def rates(self, x: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the time derivatives of states, shape (k, nx), and tensions, shape (k, m), in [N].

        States and controls are as for `run`.

        Raises:
            SimulationError: A state is not finite.
        """
        count = len(x)
        _, states, controls = self._arguments(x, u, np.zeros(count))
        rates, tensions = np.empty((count, self.nx)), np.empty((count, self._m))
        arrays = states, controls, rates, tensions
        if not self._compute(_bound().core_shooting_rates, count, *arrays):
            raise SimulationError("the rates of a state of the motion are not finite")
        return rates, tensions

    def _steps_of(self, count: int, nodes: Integers | None) -> IntArray:
        """Return the number of steps of each interval, shape (count,)."""
        steps = np.asarray(self.steps, dtype=np.int32)
        chosen = steps if nodes is None or not steps.ndim else steps[nodes]
        return np.array(np.broadcast_to(chosen, count))

    def _simulate(
        self, x: FloatArray, u: FloatArray, h: FloatArray, steps: IntArray, inputs: IntArray
    ) -> tuple[FloatArray, FloatArray] | None:
        """Return the ends of intervals, and their derivatives by some inputs."""
        count = len(h)
        ends, rows = np.empty((count, self.nx)), np.empty((count, self.nx, len(inputs)))
        arguments = *self._arguments(x, u, h / steps), len(inputs), inputs.ctypes.data, ends, rows
        is_sound = self._compute(_bound().core_shooting_run, count, steps, *arguments)
        if not is_sound or not np.isfinite(ends).all():
            return None
        if len(inputs):
            rows[:, :, -1] /= steps[:, None]  # by the length of the interval
        return ends, rows

    def _along_parameters(
        self, x: FloatArray, u: FloatArray, h: FloatArray, steps: IntArray
    ) -> FloatArray | None:
        """Return the derivatives of the ends by the parameters, shape (k, nx, np)."""
        count = len(h)
        slopes = () if self._numbers is None else self._numbers.slopes(self._parameters)
        by_p = np.empty((len(slopes), count, self.nx))
        arguments = steps, *self._arguments(x, u, h / steps)
        for slope, rows in zip(slopes, by_p, strict=True):
            along = *arguments, slope.ctypes.data, rows
            if not self._compute(_bound().core_shooting_along, count, *along):
                return None
        return by_p.transpose(1, 2, 0) if np.isfinite(by_p).all() else None

    def _compute(self, function: Any, count: int, *arguments: FloatArray | IntArray | int) -> bool:
        """Call a function of the core in threads; return whether it succeeds.

        Args:
            function: The function; its first arguments are the handle, and the number of items.
            arguments: Its other arguments: numbers, addresses, and arrays with one row per item.
        """
        failures = []

        def run(worker: int, part: slice) -> None:
            data = [a[part].ctypes.data if isinstance(a, np.ndarray) else a for a in arguments]
            failures.append(function(self._handles[worker], part.stop - part.start, *data))

        self._threads.share(run, count, is_small=count < _MIN_SHARED)
        return not any(failures)

    def _arguments(
        self, x: FloatArray, u: FloatArray, h: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return lengths of steps h, states and controls as the core needs them."""
        controls = np.zeros((len(h), self._m + self.n))
        controls[:, self._controls] = u
        return np.ascontiguousarray(h), np.ascontiguousarray(x), controls
