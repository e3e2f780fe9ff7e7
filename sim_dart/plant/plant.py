"""The plant: a robot pulled by its muscles, in the C core or in a DART world.

M(q) qdd + C + G + D qd = -L(q)^T f + A tau + J_p(q)^T w, with the tensions f as the muscles' laws
make them of commands, lengths, speeds and states of their own; by semi-implicit Euler steps, or, in
the core, of fourth order: see `integrators`. L, J_p and f are evaluated again at
every step. Joint limits are inelastic stops. Joints that close loops hold exactly, in the core.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot, SimulationError
from addin_sdfusion.robot.checks.check import require_valid
from sim_dart.core.arrays import FloatArray, finite, vector
from sim_dart.core.tasks import task_rows
from sim_dart.dart.empty_world import EmptyWorld
from sim_dart.dart.world import World
from sim_dart.scene import Scene

from .core_mechanism import CoreMechanism, CoreSteps
from .dart_mechanism import DartMechanism
from .energy import Energy, EnergyBalance
from .integrators import Integrator, SemiImplicitEuler
from .mechanism import DivergedError, ExternalForces, Mechanism, Momentum
from .settings import Engine, Rule, check_step, chosen_engine, refuse_loops_in_dart, refuse_rk4


class Plant:
    """A simulated robot.

    Args:
        robot: The robot; its active cable set counts.
        step: Length of a step, in [s].
        integrator: `euler`, semi-implicit; or `rk4`, of fourth order, with the engine `core`.
        substeps: Steps of the integrator in a step of the plant, with commands held; a million at
            most.
        energy: Whether the work done on the robot is summed up, for `energy`.
        scene: The scene around the robot, for contacts; None for none.
        wrenched: Names of the links that take external wrenches.
        engine: `core`, the C core, for robots without contacts; `dart`; or `auto` for the core
            if it can. Both give the same motion, but for rounding, and where a stop drives
            another joint into its own: see `integrators`. The core is faster.

    Raises:
        RobotError: The robot is not valid.
        InputError: A setting is wrong, or integrator or engine do not fit the robot.

    Attributes:
        robot: The robot.
        engine: What computes it: `core` or `dart`.
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        world: Its world: objects and contacts.
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
        self.robot = robot
        self._step = float(step)
        self._n, self._m = len(robot.coordinates), len(robot.muscles)
        self._actuated = [k for k, c in enumerate(robot.coordinates) if c.actuated]
        self._balance = EnergyBalance(robot) if energy else None
        self.engine = chosen_engine(engine, scene, robot)
        if integrator == "rk4":
            refuse_rk4(self.engine, scene, robot)
        self._mechanism: Mechanism
        self._integrator: Integrator
        self.world: World | EmptyWorld
        if self.engine == "core":
            mechanism = CoreMechanism(robot, wrenched=wrenched)
            self._mechanism, self.world = mechanism, EmptyWorld()
            self._integrator = CoreSteps(mechanism, integrator, step, substeps, self._balance)
        else:
            refuse_loops_in_dart(robot, scene)
            self._build_in_dart(substeps, scene, wrenched)
        self._laws = self._mechanism.laws
        self._task_rows = task_rows(robot)
        self._task_values = self._mechanism.core.array("task_values", 3 * len(robot.task_frames))
        self._advance = self._integrator.step
        self.reset()

    def _build_in_dart(self, substeps: int, scene: Scene | None, wrenched: Sequence[str]) -> None:
        """Make mechanism, world and integrator in DART."""
        mechanism = DartMechanism(self.robot, apart=scene is not None, wrenched=wrenched)
        world = World(mechanism.skeleton, self.robot, self._step / substeps, scene)
        self._mechanism, self.world = mechanism, world
        parts = mechanism, world, self._step, substeps, self._balance
        self._integrator = SemiImplicitEuler(*parts)

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
        return self._mechanism.lengths.copy()

    @property
    def lengths_view(self) -> FloatArray:
        """As `muscle_lengths`, but a view that the next step changes."""
        return self._mechanism.lengths

    @property
    def muscle_jacobian(self) -> FloatArray:
        """L = dl/dq at the present q, shape (m, n), in [m/rad] or [m/m]."""
        return self._mechanism.jacobian.copy()

    @property
    def task_position(self) -> FloatArray:
        """Task coordinates y at the present q, shape (k,), in [m] or [rad]."""
        return self._task_values[self._task_rows]

    @property
    def commands(self) -> FloatArray:
        """The commands last held, shape (m,), each in the unit of its muscle's law."""
        return self._commands.copy()

    @property
    def tensions(self) -> FloatArray:
        """Tensions f at the present state with the commands last held, shape (m,), in [N]."""
        if self._laws is None:
            return np.maximum(self._commands, 0.0)
        self._laws.drive(self.qd, self._commands)
        return self._laws.tensions.copy()

    @property
    def far_tensions(self) -> FloatArray:
        """What friction makes of `tensions` at the last via points, shape (m,), in [N]."""
        tensions = self.tensions
        return tensions if self._laws is None else self._laws.far_tensions.copy()

    @property
    def muscle_states(self) -> FloatArray:
        """The muscles' own states, shape (s,), in the order of `muscle_state_names`."""
        return self._mechanism.muscle_states.copy()

    @property
    def muscle_state_names(self) -> tuple[str, ...]:
        """Such as `activation.biceps`; none if all muscles are ideal cables."""
        return () if self._laws is None else self._laws.state_names

    @property
    def energy(self) -> Energy:
        """Energies and the work done since the reset, in [J].

        Raises:
            InputError: The plant does not record its energy.
        """
        if self._balance is None:
            raise InputError("this plant records no energy; create it with energy=True")
        return Energy(*self._mechanism.energies(), *self._balance.work.tolist())

    @property
    def momentum(self) -> Momentum:
        """Linear and angular momentum of the robot in the world."""
        return self._mechanism.momentum()

    @property
    def command_range(self) -> tuple[FloatArray, FloatArray]:
        """The smallest and the largest commands that act, each of shape (m,); see `step`."""
        if self._laws is None:
            return np.zeros(self._m), np.full(self._m, np.inf)
        return self._laws.command_low, self._laws.command_high

    def reset(
        self,
        q: ArrayLike | None = None,
        qd: ArrayLike | None = None,
        commands: ArrayLike | None = None,
    ) -> None:
        """Go to time 0 and a state, or to the one nearest to it in which all loops are closed.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m]; the robot's initial ones when None.
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s]; zero when None.
            commands: What every muscle has been at rest with for long, shape (m,), each in the unit
                of its law; those that make f_min when None.

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
        if self._balance is not None:
            self._balance.work[:] = 0.0
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
            commands: Of every muscle, shape (m,): of an ideal cable its tension, in [N]; of other
                laws the command of the law, in its unit. A cable cannot push: a negative tension
                acts as zero; any other command beyond its law's range as the nearest one in it, and
                that of a passive muscle as nothing. f_min and f_max are bounds of the controller
                alone.
            torques: tau, one for every actuated coordinate, in [N·m] or [N]; zero when None.
            loads: w, external forces on the task frames that are points, x, y, z of each in
                world axes, shape (3 p,), in [N]; zero when None.
            wrenches: For every link that takes one a force and a torque at its frame's origin,
                world axes, shape (6 k,), in [N] and [N·m]; zero when None.

        Raises:
            InputError: A command is not finite, or the shape is wrong.
            SimulationError: The state has diverged; the message names robot, time and coordinate.
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
        """The whole state: steps since the reset, q, qd, states of muscles, work, objects."""
        work = () if self._balance is None else (self._balance.work,)
        x = self._mechanism.muscle_states
        return np.concatenate([[self._ticks], self.q, self.qd, x, *work, self.world.get_state()])

    def set_state(self, state: ArrayLike) -> None:
        """Go back to a state from `get_state`.

        Args:
            state: As from there.

        Raises:
            InputError: A value is not finite, or the shape is wrong.
        """
        n, x = self._n, self._mechanism.muscle_states
        works = 0 if self._balance is None else self._balance.work.size
        ends = np.cumsum([1, n, n, x.size, works])
        values = vector("state", state, int(ends[-1]) + self.world.get_state().size)
        ticks, q, qd, states, work, objects = np.split(values, ends)
        if not (np.isfinite(ticks[0]) and ticks[0] >= 0):
            raise InputError(f"state: {ticks[0]} is not a number of steps")
        finite("the muscles' states", states, x.size)
        finite("work", work, works)
        finite("state of objects", objects, objects.size)
        self._set_state(int(ticks[0]), q, qd)
        self.world.set_state(objects)
        x[:] = states
        if self._balance is not None:
            self._balance.work[:] = work

    def hold(self, commands: ArrayLike) -> None:
        """Set the commands that `tensions` and `commands` refer to, without a step.

        Args:
            commands: As for `step`.

        Raises:
            InputError: One is not finite, or the shape is wrong.
        """
        self._commands = finite("commands", commands, self._m)

    def _set_state(self, ticks: int, q: FloatArray, qd: FloatArray) -> None:
        q, qd = q.copy(), qd.copy()
        try:
            self._mechanism.set_state(q, qd)
        except DivergedError as error:
            raise InputError(f"a state is not finite, or beyond 1e9: {error}") from None
        self._ticks = ticks
        self.world.time = self.time
        self.q, self.qd = q, qd
