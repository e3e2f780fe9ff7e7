"""Plant: simulation of a robot with muscles, in the C core or in a DART world.

The plant integrates M(q) qdd + C + G + D qd = -L(q)'f + A tau + J_p(q)'w. The muscle laws compute
the tensions f from commands, path lengths, path velocities and muscle states. The integrator is
semi-implicit Euler, or Runge-Kutta of fourth order in the core. L, J_p and f are evaluated in every
step. Joint limits are inelastic stops. The core satisfies the constraints of loop joints exactly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot, SimulationError
from addin_sdfusion.robot.checks.check import require_valid
from sim_dart.core.arrays import FloatArray, finite, vector
from sim_dart.core.tasks import task_rows
from sim_dart.scene import Scene

from .core_mechanism import CoreMechanism
from .dart_mechanism import DartMechanism
from .energy import Energy
from .mechanism import DivergedError, ExternalForces, Mechanism, Momentum
from .settings import (
    Engine,
    Rule,
    check_step,
    reject_loops_in_dart,
    require_rk4_support,
    select_engine,
)


class Plant:
    """Simulated robot. Plants can be copied and pickled with their state.

    Args:
        robot: The robot. Its active cable set is used.
        step: Length of a step, in [s].
        integrator: `euler` (semi-implicit Euler) or `rk4` (Runge-Kutta of fourth order, only with
            the engine `core`).
        substeps: Number of integrator steps per plant step, with constant commands, at most one
            million.
        energy: Whether to sum up the work done on the robot for `energy`.
        scene: The scene around the robot, for contacts, or None.
        wrenched: Names of the links on which external wrenches act.
        engine: `core` for the C core, which does not support contacts; `dart` for DART; `auto` for
            the core if possible, otherwise DART. Both engines compute the same motion up to
            rounding, except if the stop of one joint drives another joint to its limit; see
            `dart_mechanism`. The core is faster.

    Raises:
        RobotError: The robot is not valid.
        InputError: A setting is invalid, or the integrator or engine does not support the robot.

    Attributes:
        engine: The selected engine, `core` or `dart`.
        step_size: Length of a step, in [s].
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        world: The world with objects and contacts.
    """

    q: FloatArray
    qd: FloatArray

    def __init__(
        self,
        robot: Robot,
        step: float = 1e-3,
        *,
        integrator: Rule = "euler",
        substeps: int = 1,
        energy: bool = False,
        scene: Scene | None = None,
        wrenched: Sequence[str] = (),
        engine: Engine = "auto",
    ) -> None:
        require_valid(robot)
        check_step(step, integrator, substeps)
        substeps = int(substeps)
        self._options = {
            "integrator": integrator,
            "substeps": substeps,
            "energy": energy,
            "scene": scene,
            "wrenched": tuple(wrenched),
            "engine": engine,
        }
        self.robot = robot
        self.step_size = float(step)
        self._n, self._m = len(robot.coordinates), len(robot.muscles)
        self._actuated = [k for k, c in enumerate(robot.coordinates) if c.actuated]
        self.engine = select_engine(engine, scene, robot)
        if integrator == "rk4":
            require_rk4_support(self.engine, scene, robot)
        self._mechanism: Mechanism
        if self.engine == "core":
            self._mechanism = CoreMechanism(
                robot, step, substeps, integrator, wrenched, energy=energy
            )
        else:
            reject_loops_in_dart(robot, scene)
            self._mechanism = DartMechanism(robot, step, substeps, scene, wrenched, energy=energy)
        self.world = self._mechanism.world
        self._laws = self._mechanism.laws
        self._task_rows = task_rows(robot)
        self._task_values = self._mechanism.core.array("task_values", 3 * len(robot.task_frames))
        self._advance = self._mechanism.step
        self.reset()

    @property
    def time(self) -> float:
        """Time since the reset, in [s]."""
        return self._ticks * self.step_size

    @property
    def muscle_lengths(self) -> FloatArray:
        """Path lengths l at the current q, shape (m,), in [m]."""
        return self._mechanism.lengths.copy()

    @property
    def lengths_view(self) -> FloatArray:
        """Path lengths l as a view that the next step overwrites, shape (m,), in [m]."""
        return self._mechanism.lengths

    @property
    def muscle_jacobian(self) -> FloatArray:
        """L = dl/dq at the current q, shape (m, n), in [m/rad] or [m/m]."""
        return self._mechanism.jacobian.copy()

    @property
    def task_position(self) -> FloatArray:
        """Task coordinates y at the current q, shape (k,), in [m] or [rad]."""
        return self._task_values[self._task_rows]

    @property
    def commands(self) -> FloatArray:
        """The last commands, shape (m,), each in the unit of its muscle law."""
        return self._commands.copy()

    @property
    def tensions(self) -> FloatArray:
        """Tensions f at the current state with the last commands, shape (m,), in [N]."""
        if self._laws is None:
            return np.maximum(self._commands, 0.0)
        self._laws.drive(self.qd, self._commands)
        return self._laws.tensions.copy()

    @property
    def far_tensions(self) -> FloatArray:
        """Tensions at the last via points, after cable friction, shape (m,), in [N]."""
        tensions = self.tensions
        return tensions if self._laws is None else self._laws.far_tensions.copy()

    @property
    def muscle_states(self) -> FloatArray:
        """States of the muscles, shape (s,), in the order of `muscle_state_names`."""
        return self._mechanism.muscle_states.copy()

    @property
    def muscle_state_names(self) -> tuple[str, ...]:
        """Names such as `activation.biceps`; empty if all muscles are ideal cables."""
        return () if self._laws is None else self._laws.state_names

    @property
    def energy(self) -> Energy:
        """Energies and the work done since the reset, in [J].

        Raises:
            InputError: The plant was created without `energy=True`.
        """
        if self._mechanism.work is None:
            raise InputError("this plant does not record its energy; create it with energy=True")
        return Energy(*self._mechanism.energies(), *self._mechanism.work.tolist())

    @property
    def momentum(self) -> Momentum:
        """Linear and angular momentum of the robot in the world frame."""
        return self._mechanism.momentum()

    @property
    def command_range(self) -> tuple[FloatArray, FloatArray]:
        """Smallest and largest effective commands, each of shape (m,); see `step`."""
        if self._laws is None:
            return np.zeros(self._m), np.full(self._m, np.inf)
        return self._laws.command_low, self._laws.command_high

    def reset(
        self,
        q: ArrayLike | None = None,
        qd: ArrayLike | None = None,
        commands: ArrayLike | None = None,
    ) -> None:
        """Set the time to 0 and set the state, or the nearest state with closed loops.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m] (default: initial positions).
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s] (default: 0).
            commands: Commands with which the muscles are in equilibrium at rest, shape (m,), each
                in the unit of its law (default: commands for the tensions f_min).

        Raises:
            InputError: A value is not finite, the shape is wrong, or loops cannot be closed.
        """
        initial = [c.initial for c in self.robot.coordinates]
        positions = vector("q", initial if q is None else q, self._n)
        velocities = vector("qd", np.zeros(self._n) if qd is None else qd, self._n)
        self._set_state(0, positions, velocities)
        if isinstance(self._mechanism, CoreMechanism) and self.robot.loops:
            self._set_state(0, *self._mechanism.closed(positions, velocities))
        self.world.reset()
        if self._mechanism.work is not None:
            self._mechanism.work[:] = 0.0
        self._commands = self._start_commands(commands)
        if self._laws is not None:
            self._laws.start(self._commands)

    def _start_commands(self, commands: ArrayLike | None) -> FloatArray:
        if commands is not None:
            return finite("commands", commands, self._m)
        f_min = np.array([muscle.f_min for muscle in self.robot.muscles])
        return f_min if self._laws is None else self._laws.resting_commands(f_min)

    def step(
        self,
        commands: ArrayLike,
        torques: ArrayLike | None = None,
        loads: ArrayLike | None = None,
        wrenches: ArrayLike | None = None,
    ) -> None:
        """Advance by one step with constant commands.

        Args:
            commands: Muscle commands, shape (m,). The command of an ideal cable is its tension, in
                [N]. Other commands have the unit of their muscle law. Commands are clipped to the
                range of their law, for example negative tensions to 0. Commands of passive muscles
                are ignored. The plant does not apply f_min and f_max; these are limits of the
                controller.
            torques: Motor torque tau of every actuated coordinate, in [N·m] or [N] (default: 0).
            loads: External forces w on the position task frames, world axes, shape (3 p,), in [N]
                (default: 0).
            wrenches: External force and torque at the origin of the frame of every link in
                `wrenched`, world axes, shape (6 k,), in [N] and [N·m] (default: 0).

        Raises:
            InputError: A command is not finite or the shape is wrong.
            SimulationError: The state diverged. The message contains robot, time and coordinate.
        """
        u = vector("commands", commands, self._m)
        external = self._external(torques, loads, wrenches)
        mechanism = self._mechanism
        try:
            self._advance(u, external)
        except DivergedError as error:
            self._ticks += 1
            raise SimulationError(
                f"robot {self.robot.name!r} diverged at t = {self.time:.6g} s: {error}; "
                "use a smaller step or softer gains"
            ) from None
        self._ticks += 1
        self._commands = u
        self.q = mechanism.q
        self.qd = mechanism.qd

    def _external(
        self, torques: ArrayLike | None, loads: ArrayLike | None, wrenches: ArrayLike | None
    ) -> ExternalForces | None:
        if torques is None and loads is None and wrenches is None:
            return None
        tau, mechanism = np.zeros(self._n), self._mechanism
        if torques is not None:
            tau[self._actuated] = finite("torques", torques, len(self._actuated))
        if loads is not None:
            loads = finite("loads", loads, mechanism.load_size)
        if wrenches is not None:
            wrenches = finite("wrenches", wrenches, mechanism.wrench_size)
        return ExternalForces(tau, loads, wrenches)

    def get_state(self) -> FloatArray:
        """Return the complete state: steps since the reset, q, qd, muscles, work and objects."""
        work = () if self._mechanism.work is None else self._mechanism.work
        x = self._mechanism.muscle_states
        return np.concatenate([[self._ticks], self.q, self.qd, x, work, self.world.get_state()])

    def set_state(self, state: ArrayLike) -> None:
        """Restore a state from `get_state`.

        Raises:
            InputError: A value is not finite or the shape is wrong.
        """
        n, x = self._n, self._mechanism.muscle_states
        works = 0 if self._mechanism.work is None else self._mechanism.work.size
        ends = np.cumsum([1, n, n, x.size, works])
        values = vector("state", state, int(ends[-1]) + self.world.get_state().size)
        ticks, q, qd, states, work, objects = np.split(values, ends)
        if not (np.isfinite(ticks[0]) and ticks[0] >= 0):
            raise InputError(f"state: number of steps must be a whole number, not {ticks[0]}")
        finite("the muscles' states", states, x.size)
        finite("work", work, works)
        finite("state of objects", objects, objects.size)
        self._set_state(int(ticks[0]), q, qd)
        self.world.set_state(objects)
        x[:] = states
        if self._mechanism.work is not None:
            self._mechanism.work[:] = work

    def __reduce__(self) -> tuple[Any, ...]:
        """Describe a copy by arguments and state, since pointers to C cannot be copied."""
        state = self.get_state(), self._commands
        return _restored_plant, (type(self), self.robot, self.step_size, self._options, *state)

    def hold(self, commands: ArrayLike) -> None:
        """Set the commands without a step, which updates `tensions` and `commands`.

        Args:
            commands: As for `step`.

        Raises:
            InputError: A command is not finite or the shape is wrong.
        """
        self._commands = finite("commands", commands, self._m)

    def _set_state(self, ticks: int, q: FloatArray, qd: FloatArray) -> None:
        q, qd = q.copy(), qd.copy()
        try:
            self._mechanism.set_state(q, qd)
        except DivergedError as error:
            raise InputError(f"the state is not finite, or beyond 1e9: {error}") from None
        self._ticks = ticks
        self.world.time = self.time
        self.q, self.qd = q, qd


def _restored_plant(
    cls: type[Plant],
    robot: Robot,
    step: float,
    options: Mapping[str, Any],
    state: FloatArray,
    commands: FloatArray,
) -> Plant:
    plant = cls(robot, step, **options)
    plant.set_state(state)
    plant.hold(commands)
    return plant
