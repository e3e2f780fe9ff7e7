"""Batch: many instances of a robot that the C core steps together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import (
    InputError,
    Robot,
    SimulationError,
    UnknownNameError,
)
from sim_dart.core.arrays import BoolArray, FloatArray
from sim_dart.core.tasks import task_rows
from sim_dart.plant.settings import Rule, check_step, require_rk4_support

from .arguments import chosen_instances, indices, integer, rows
from .binding import BIAS, MASS_MATRIX, TASK_JACOBIAN, TENSIONS, batch_library
from .instances import Instances
from .threads import Threads

_COLUMNS = ("q", "qd", "states", "task_position")

_MIN_SHARED = 256  # instances times substeps; fewer are stepped by one thread


class Derivatives(NamedTuple):
    """Derivatives of the states x = (q, qd, states of muscles) at the end of a step.

    Attributes:
        A: Derivatives by the states at its start, shape (n, nx, nx).
        B: Derivatives by the commands of all muscles, then by the torques of motors at joints,
            shape (n, nx, nu).
    """

    A: FloatArray
    B: FloatArray


class Batch:
    """Instances of a robot, each with its own state, that are stepped together in C.

    An instance moves exactly, bit by bit, as a `Plant` with the engine `core`, for any number of
    threads. A step allocates no arrays and releases Python's global interpreter lock. Batches do
    not support contacts, custom muscle laws in Python and external loads. Batches can be copied and
    pickled with their states.

    Args:
        n: Number of instances.
        step: Length of a step, in [s].
        integrator: `euler` or `rk4`; see `Plant`.
        substeps: Number of integrator steps per step, with constant commands.
        variants: Robots that instances can have (default: only `robot`). They differ only in
            numbers: masses, points, parameters of muscles, friction, limits. Instance i begins with
            variant i modulo the number of variants.
        threads: Number of threads (default: number of processors, at most 8).

    Raises:
        RobotError: A robot is not valid.
        InputError: A setting is invalid, or a robot is not supported.

    Attributes:
        n: Number of instances.
        step_size: Length of a step, in [s].
        q: Joint positions, shape (n, dofs), in [rad] or [m]. This and the following arrays are
            views, which the next step overwrites; use `reset` or `set_state` to change the state.
        qd: Joint velocities, shape (n, dofs), in [rad/s] or [m/s].
        states: States of the muscles, shape (n, s), in the order of `state_names`.
        lengths: Path lengths l, shape (n, m), in [m].
        jacobian: L = dl/dq, shape (n, m, dofs), in [m/rad] or [m/m].
        commands: The last commands, shape (n, m).
        ticks: Number of steps of every instance since its reset, shape (n,).
        diverged: Flags of instances whose state diverged, shape (n,). They do not move until they
            are reset.
        variant: Index of the variant of every instance, shape (n,).
        state_names: Names of the states of muscles, such as `activation.biceps`.
        command_names: Quantity of each command, such as `excitation`; empty for a passive muscle.
        command_low: Smallest effective commands, shape (m,).
        command_high: Largest effective commands, shape (m,); infinite for ideal cables.
    """

    def __init__(
        self,
        robot: Robot,
        n: int,
        step: float = 1e-3,
        *,
        integrator: Rule = "euler",
        substeps: int = 1,
        variants: Sequence[Robot] = (),
        threads: int = 0,
    ) -> None:
        check_step(step, integrator, substeps)
        self._options = {"integrator": integrator, "substeps": substeps, "threads": threads}
        self._robots = tuple(variants) or (robot,)
        self.robot, self.n = robot, integer("n", n, 1)
        self._threads = Threads(integer("threads", threads, 0))
        self._instances = Instances(self._robots, self.n)
        if integrator == "rk4":
            for one in self._robots:
                require_rk4_support("core", None, one)
        self.step_size, self._substeps = float(step), int(substeps)
        dofs, m = len(robot.coordinates), len(robot.muscles)
        self._actuated = [k for k, c in enumerate(robot.coordinates) if c.actuated]
        laws = self._instances.laws[0]
        self.state_names, self.command_names = laws.state_names, laws.command_names
        self.command_low, self.command_high = laws.command_low, laws.command_high
        view = self._instances.view
        self.q, self.qd = view("q", dofs), view("qd", dofs)
        self.states = view("law_states", len(laws.state_names))
        self.lengths, self.jacobian = view("lengths", m), view("jacobian", m, dofs)
        self.variant, self.ticks = self._instances.variant, np.zeros(self.n, dtype=np.int64)
        self.commands, self._torques = np.zeros((self.n, m)), np.zeros((self.n, dofs))
        self._has_torques = False
        self._task_values = view("task_values", 3 * len(robot.task_frames))
        self._task_rows = task_rows(robot)
        self._answers = np.zeros(self.n, dtype=np.int32)
        self._scratch: list[FloatArray] = []
        self._groups = self._instances.group_memory(self._threads.count)
        self.reset()

    @property
    def diverged(self) -> BoolArray:
        """Flags of instances whose state diverged, shape (n,)."""
        flags: BoolArray = self._answers != 0
        return flags

    @property
    def task_position(self) -> FloatArray:
        """Task coordinates y, shape (n, k), in [m] or [rad]."""
        return self._task_values[:, self._task_rows]

    def step(
        self,
        commands: ArrayLike,
        torques: ArrayLike | None = None,
        chosen: ArrayLike | None = None,
    ) -> None:
        """Advance instances by one step with constant commands.

        Args:
            commands: Muscle commands, shape (n, m) or (m,), as for `Plant.step`.
            torques: Motor torques of the actuated coordinates, shape (n, k) or (k,), in [N·m] or
                [N] (default: 0).
            chosen: Flags of the instances that move, shape (n,) (default: all).

        Raises:
            InputError: A value is not finite or the shape is wrong; no instance moves.
            SimulationError: Instances diverged; see `diverged`. The others have moved.
        """
        mask = None if chosen is None else chosen_instances(chosen, self.n)
        self._set_inputs(commands, torques, mask)
        before, rule = np.count_nonzero(self._answers), self._rule()

        def run(part: slice, group: int | None) -> None:
            place, answers = self._instances.place(part), self._answers[part].ctypes.data
            moving = None if mask is None else mask[part].ctypes.data
            inputs = moving, *self._inputs(part)
            batch_library().core_batch_step(*place, *inputs, *rule, group, answers)

        self._share_step(run)
        moved = self._answers == 0
        self.ticks += moved if mask is None else moved & mask
        if np.count_nonzero(self._answers) > before:
            raise SimulationError(self._divergence())

    def reset(
        self,
        chosen: ArrayLike | None = None,
        q: ArrayLike | None = None,
        qd: ArrayLike | None = None,
        commands: ArrayLike | None = None,
        variant: ArrayLike | None = None,
    ) -> None:
        """Set the state of instances, or the nearest state with closed loops.

        Args:
            chosen: Flags of the instances, shape (n,) (default: all).
            q: Joint positions, shape (n, dofs) or (dofs,) (default: initial positions).
            qd: Joint velocities, shape (n, dofs) or (dofs,) (default: 0).
            commands: Commands with which the muscles are in equilibrium at rest, shape (n, m) or
                (m,) (default: commands for the tensions f_min; the search takes about 0.5 ms
                for each pose).
            variant: Indices of the variants, shape (n,) (default: unchanged).

        Raises:
            InputError: A value is not finite, the shape is wrong, or loops cannot be closed.
        """
        mask = chosen_instances(chosen, self.n)
        if variant is not None:
            self._open_variants(mask, variant)
        at = self._initial() if q is None else rows("q", q, self.q.shape)
        rates = np.zeros(self.qd.shape) if qd is None else rows("qd", qd, self.qd.shape)
        if commands is not None:
            values = rows("commands", commands, self.commands.shape)
            np.copyto(self.commands, values, where=mask[:, None])
        u = None if commands is None else self.commands
        self._set_start(mask, at, rates, u)
        if commands is None and self.commands.size:
            self._set_resting_commands(mask)
            self._set_start(mask, self.q.copy(), self.qd.copy(), self.commands)
        self.ticks[mask] = 0

    def set_state(self, x: ArrayLike) -> None:
        """Set the states of all instances.

        Args:
            x: States, shape (n, nx), as from `get_state`.
        """
        dofs, shape = self.q.shape[1], (self.n, 2 * self.q.shape[1] + self.states.shape[1])
        values = rows("x", x, shape)
        every = np.ones(self.n, dtype=np.bool_)
        self._set_start(every, values[:, :dofs], values[:, dofs : 2 * dofs], None)
        self.states[:] = values[:, 2 * dofs :]

    def get_state(self) -> FloatArray:
        """Return the states x = (q, qd, states of muscles), shape (n, nx)."""
        return np.hstack([self.q, self.qd, self.states])

    def mass_matrix(self) -> FloatArray:
        """Compute and return M(q), shape (n, dofs, dofs), as a view."""
        dofs = self.q.shape[1]
        return self._term(MASS_MATRIX, "mass_matrix", dofs, dofs)

    def bias(self) -> FloatArray:
        """Compute and return C(q, qd) + G(q), shape (n, dofs), in [N·m] or [N], as a view."""
        return self._term(BIAS, "coriolis", self.q.shape[1])

    def task_jacobian(self) -> FloatArray:
        """Compute and return J = dy/dq, shape (n, k, dofs)."""
        count = 3 * len(self.robot.task_frames)
        return self._term(TASK_JACOBIAN, "task_jacobian", count, self.q.shape[1])[
            :, self._task_rows
        ]

    def tensions(self) -> FloatArray:
        """Compute and return the tensions with the last commands, shape (n, m), as a view."""
        return self._term(TENSIONS, "tensions", self.commands.shape[1])

    def columns(self, name: str) -> list[int]:
        """Return the columns of `q`, `qd`, `states` or `task_position` for features.

        Raises:
            UnknownNameError: The name is another one.
        """
        if name not in _COLUMNS:
            raise UnknownNameError("state", name, _COLUMNS)
        if name == "task_position":
            columns = self._instances.columns("task_values")
            return [columns[k] for k in self._task_rows]
        return [*self._instances.columns("law_states" if name == "states" else name)]

    def derivatives(self, commands: ArrayLike, torques: ArrayLike | None = None) -> Derivatives:
        """Return the exact derivatives of the next step, without a step.

        Args:
            commands: Muscle commands, as for `step`.
            torques: Motor torques, as for `step`.

        Raises:
            SimulationError: Instances diverge in this step.
        """
        self._set_inputs(commands, torques)
        nx = 2 * self.q.shape[1] + self.states.shape[1]
        m = self.commands.shape[1]
        motors = [nx + m + k for k in self._actuated]
        inputs = np.array([*range(nx + m), *motors], dtype=np.int32)
        derivatives = np.empty((self.n, nx, len(inputs)))
        answers = self._answers.copy()
        scratch = self._derivative_memory()

        def run(thread: int, part: slice) -> None:
            place, memory = self._instances.place(part), scratch[thread].ctypes.data
            rest = len(inputs), inputs.ctypes.data, derivatives[part].ctypes.data
            arguments = *self._inputs(part), *self._rule(), *rest, answers[part].ctypes.data
            batch_library().core_batch_derivatives(*place, memory, *arguments)

        self._threads.share(run, self.n, is_small=self.n < 2)
        if answers.any():
            bad = np.flatnonzero(answers)
            raise SimulationError(f"derivatives: {len(bad)} of {self.n} instances diverge: {bad}")
        return Derivatives(derivatives[:, :, :nx], derivatives[:, :, nx:])

    def __reduce__(self) -> tuple[Any, ...]:
        """Describe a copy by arguments and state, since pointers to C cannot be copied."""
        arguments = self.robot, self.n, self.step_size, self._robots, self._options
        state = self.get_state(), self.commands, self.variant, self.ticks, self._answers
        return _restored_batch, (type(self), *arguments, state)

    def _initial(self) -> FloatArray:
        initial = [[c.initial for c in robot.coordinates] for robot in self._robots]
        q: FloatArray = np.take(initial, self.variant, axis=0)
        return q

    def _rule(self) -> tuple[float, int, int]:
        is_runge_kutta = int(self._options["integrator"] == "rk4")
        return self.step_size / self._substeps, self._substeps, is_runge_kutta

    def _share_step(self, run: Callable[[slice, int | None], None]) -> None:
        """Call `run` for the parts of the threads, with the addresses of memory for lanes."""

        def run_part(thread: int, part: slice) -> None:
            run(part, self._groups[thread].ctypes.data if self._groups else None)

        self._threads.share(run_part, self.n, is_small=self.n * self._substeps < _MIN_SHARED)

    def _inputs(self, part: slice) -> tuple[int, int | None]:
        """Return the addresses of the commands and of the torques of a part."""
        torques = self._torques[part].ctypes.data if self._has_torques else None
        return self.commands[part].ctypes.data, torques

    def _set_inputs(
        self, commands: ArrayLike, torques: ArrayLike | None, chosen: BoolArray | None = None
    ) -> None:
        u = rows("commands", commands, self.commands.shape)
        tau = None
        if torques is not None:
            tau = rows("torques", torques, (self.n, len(self._actuated)))
        np.copyto(self.commands, u, where=True if chosen is None else chosen[:, None])
        self._has_torques = tau is not None
        if tau is not None:
            self._torques[:, self._actuated] = tau

    def _set_start(
        self, mask: BoolArray, q: FloatArray, qd: FloatArray, commands: FloatArray | None
    ) -> None:
        place, u = self._instances.place(slice(0, self.n)), None
        if commands is not None:
            u = commands.ctypes.data
        at, rates = np.ascontiguousarray(q), np.ascontiguousarray(qd)
        arrays = mask.ctypes.data, at.ctypes.data, rates.ctypes.data, u
        batch_library().core_batch_reset(*place, *arrays, self._answers.ctypes.data)
        self._require_started(mask)

    def _require_started(self, mask: BoolArray) -> None:
        """Report instances whose states could not be set."""
        if not self._answers.any():
            return
        bad = np.flatnonzero(mask & (self._answers != 0))
        if not len(bad):
            return
        i, answer = int(bad[0]), int(self._answers[bad[0]])
        if answer < 0:
            raise InputError(f"instance {i}: a loop of the robot cannot be closed; change q")
        name = self.robot.coordinates[answer - 1].name
        raise InputError(f"instance {i}: coordinate {name!r} is not finite, or beyond 1e9")

    def _set_resting_commands(self, mask: BoolArray) -> None:
        """Set the commands that hold f_min at the current poses, once for equal poses."""
        resting: dict[tuple[int, bytes], FloatArray] = {}
        for i in np.flatnonzero(mask).tolist():
            variant = int(self.variant[i])
            key = variant, self.q[i].tobytes()
            if key not in resting:
                f_min = np.array([muscle.f_min for muscle in self._robots[variant].muscles])
                resting[key] = self._instances.resting_commands(variant, self.q[i], f_min)
            self.commands[i] = resting[key]

    def _open_variants(self, mask: BoolArray, variant: ArrayLike) -> None:
        new = indices("variant", variant, self.n, len(self._robots))
        for i in np.flatnonzero(mask & (new != self.variant)).tolist():
            self._instances.open(i, int(new[i]))

    def _term(self, which: int, name: str, *shape: int) -> FloatArray:
        def run(thread: int, part: slice) -> None:
            u = self.commands[part].ctypes.data
            batch_library().core_batch_terms(*self._instances.place(part), which, u)

        self._threads.share(run, self.n, is_small=self.n < _MIN_SHARED)
        return self._instances.view(name, *shape)

    def _derivative_memory(self) -> list[FloatArray]:
        if not self._scratch:
            size = batch_library().core_batch_derivatives_size(self._instances.address(0))
            self._scratch = [np.empty(-(-size // 8)) for _ in range(self._threads.count)]
        return self._scratch

    def _divergence(self) -> str:
        bad = np.flatnonzero(self._answers)
        i, dofs = int(bad[0]), self.q.shape[1]
        answer = int(self._answers[i])
        name = self.robot.coordinates[answer - 1].name if answer <= dofs else "a muscle"
        return (
            f"robot {self.robot.name!r}: {len(bad)} of {self.n} instances have diverged, first "
            f"instance {i} in {name!r}; use a smaller step or softer gains, and reset them"
        )


def _restored_batch(
    cls: type[Batch],
    robot: Robot,
    n: int,
    step: float,
    variants: Sequence[Robot],
    options: Mapping[str, Any],
    state: Sequence[Any],
) -> Batch:
    batch = cls(robot, n, step, variants=variants, **options)
    x, commands, variant, ticks, answers = state
    batch.reset(answers == 0, commands=commands, variant=variant)
    batch.set_state(np.where(answers[:, None] == 0, x, 0.0))
    batch.ticks[:] = ticks
    batch._answers[:] = answers
    return batch
