"""A controller in Python, where its law, its dynamics or its muscles are not in C."""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np

import controllers
from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.signals.muscles import modelled_muscles
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.multiples import MOST_STEPS, whole_steps
from controllers import (
    ControlLoop,
    ForceSolution,
    OperationalSpaceSolution,
    Posture,
)
from controllers.validation import resting
from sim_dart import CoreDynamics, DartDynamics, IndependentDynamics
from sim_dart.muscles.cable_slip import CableSlip

from ..start_commands import start
from .command_ramp import CommandRamp
from .muscle_control import MuscleControl
from .own_law import Law, own_law

CONTROL_DYNAMICS: dict[str, type[CoreDynamics] | type[DartDynamics]] = {
    "auto": CoreDynamics,
    "core": CoreDynamics,
    "dart": DartDynamics,
}
"""What computes the dynamics that a controller knows, by its engine."""


class PythonController:
    """A control law and what a sampled loop needs around it: one tick a step.

    Args:
        experiment: What to simulate.
        views: The values of each group of variables.
        parameters: Those of all parameters.
    """

    def __init__(
        self, experiment: Experiment, views: Mapping[str, FloatArray], parameters: FloatArray
    ) -> None:
        self.parameters = parameters
        robot, settings = experiment.robot, experiment.controller
        self._dynamics = (
            IndependentDynamics(robot, settings.dependent)
            if robot.loops
            else CONTROL_DYNAMICS[settings.engine](robot)
        )
        self._law = control_law(experiment, self._dynamics)
        names = (
            self._dynamics.coordinate_names
            if settings.space == "joint"
            else self._dynamics.task_names
        )
        self._loop = ControlLoop(
            self._law,
            names,
            settings.period,
            ki=settings.ki,
            observer=settings.observer,
            delay=settings.delay,
            predict=settings.predict,
        )
        self._slip = self._dynamics.cable_slip
        modelled = bool(modelled_muscles(robot))
        self._muscles = MuscleControl(robot, settings.muscle_horizon) if modelled else None
        self._begin, self._start_q = start(robot, experiment.start.q), experiment.start.q
        self._q, self._qd, self._loads, self._states = (
            views[name] for name in ("q", "qd", "loads", "states")
        )
        self._reference = views["reference"].reshape(3, -1)
        self._forces, self._commands, self._slack, self._report = (
            views[name] for name in ("forces", "commands", "slack", "report")
        )
        self._kp, self._kd, self._f_min, self._f_max, self._period = (
            views[name] for name in ("kp", "kd", "f_min", "f_max", "period")
        )
        self._estimated_loads, self._valid = views["estimated_loads"], views["valid"]
        self._feeding = experiment.feeding
        self._ramp: CommandRamp | None = None
        self._applied = np.empty(0)
        self._m = len(robot.muscles)

    def initialize(self, t: float = 0.0) -> None:
        """Take over gains and bounds.

        Until the first tick, every ideal cable holds its f_min, and motors give no torque; muscles
        with laws hold the robot.
        """
        self._apply_parameters()
        self._loop.set_period(float(self._period[0]))
        self._law.reset()
        if self._slip is not None:
            self._slip.reset()
        forces = resting(self._f_min, self._f_max)
        if self._muscles is not None:
            forces[: self._m] = self._begin.forces
            self._muscles.reset(self._begin.commands)
            self._commands[:] = self._muscles.commands
        self._loop.reset(forces)
        if self._feeding is not None:
            ramps = self._feeding.ramp_down, self._feeding.ramp_in
            self._ramp = CommandRamp(*ramps, forces, np.array(self._start_q))
        self._forces[:] = forces
        self._slack[:] = 0.0
        self._report[:] = 0.0

    def step(self, t: float, h: float) -> None:
        """A tick with the inputs at t; a step of several periods is a tick of a longer one."""
        period = float(self._period[0])
        periods = whole_steps(h, period, "the controller's period", most=MOST_STEPS)
        self._loop.set_period(periods * period)
        if not np.array_equal(self._applied, self.parameters):
            self._apply_parameters()
        if self._ramp is not None and not self._valid[0]:
            self._fall(self._ramp)
            return
        begin = time.perf_counter()
        solution = self._tick(self._known_load())
        self._forces[:] = self._loop.acting
        self._slack[:] = solution.slack
        self._report[:] = _report(solution, time.perf_counter() - begin)

    def _tick(self, load: FloatArray | None) -> ForceSolution:
        """The loop's tick, among the forces that the muscles can come to."""
        q, qd, muscles = self._q, self._qd, self._muscles
        if self._slip is not None:
            self._slip.follow(q)
        if muscles is None:
            solution = self._loop.tick(q, qd, self._reference, load)
            self._rise()
            return solution
        m, period = self._m, self._loop.period
        applied = muscles.observe(q, qd, self._states, self._slip)
        if applied is not None:
            applied = np.concatenate([applied, self._loop.acting[m:]])
        f_min, f_max, pushed = muscles.bounds(self._f_min[:m], self._f_max[:m], period)
        if pushed.any():
            known = self._dynamics.muscle_jacobian(q).T @ pushed
            load = known if load is None else load + known
        self._law.set_bounds(
            np.concatenate([f_min, self._f_min[m:]]), np.concatenate([f_max, self._f_max[m:]])
        )
        solution = self._loop.tick(q, qd, self._reference, load, applied=applied)
        self._rise()
        muscles.update(self._loop.acting[:m], period)
        self._commands[:] = muscles.commands
        return solution

    def _rise(self) -> None:
        """What acts is less while a lost state has not been back for long."""
        if self._ramp is not None:
            loop, rest = self._loop, resting(self._f_min, self._f_max)
            loop.acting = self._ramp.rising(loop.period, rest, loop.acting, self._q)

    def _fall(self, ramp: CommandRamp) -> None:
        """A tick without a state: commands go down, and the loop forgets what it knew."""
        period = self._loop.period
        forces = ramp.falling(period, resting(self._f_min, self._f_max))
        self._law.reset()
        self._loop.reset(forces)
        if self._slip is not None:
            self._slip.lose()
        if self._muscles is not None:
            self._muscles.observe(ramp.q, np.zeros_like(ramp.q), self._states, self._slip)
            self._muscles.update(forces[: self._m], period)
            self._commands[:] = self._muscles.commands
        self._forces[:] = forces
        self._slack[:] = 0.0
        self._report[:] = 0.0

    def get_state(self) -> bytes:
        """The memory of the loop, of the law, of the muscles and of the ramp."""
        return np.concatenate([part.get_state() for part in self._remembering]).tobytes()

    def set_state(self, state: bytes) -> None:
        """Go back to a state from `get_state`."""
        parts = self._remembering
        sizes = [part.get_state().size for part in parts]
        if len(state) != 8 * sum(sizes):
            raise InputError(f"a state of this controller does not have {len(state)} bytes")
        numbers = np.split(np.frombuffer(state), np.cumsum(sizes)[:-1])
        for part, own in zip(parts, numbers, strict=True):
            part.set_state(own)

    @property
    def _remembering(self) -> list[ControlLoop | Law | MuscleControl | CommandRamp | CableSlip]:
        """What has a memory."""
        parts = [self._loop, self._law, self._muscles, self._ramp, self._slip]
        return [part for part in parts if part is not None]

    def _known_load(self) -> FloatArray | None:
        """w_e = -J'F + w of forces on task points and of estimated loads w, shape (n,)."""
        estimated = self._estimated_loads.copy() if self._estimated_loads.any() else None
        if estimated is not None and isinstance(self._dynamics, IndependentDynamics):
            estimated = self._dynamics.load(self._q, estimated)
        if not self._loads.any():
            return estimated
        w_e: FloatArray = -self._dynamics.point_jacobian(self._q).T @ self._loads
        return w_e if estimated is None else w_e + estimated

    def _apply_parameters(self) -> None:
        self._law.set_gains(self._kp, self._kd)
        self._law.set_bounds(self._f_min, self._f_max)
        self._applied = self.parameters.copy()


def control_law(experiment: Experiment, dynamics: CoreDynamics | DartDynamics) -> Law:
    """The law that an experiment asks for."""
    settings = experiment.controller
    tasks, own = settings.tasks, settings.own_law
    law = getattr(controllers, settings.law.law) if own is None else own_law(own, settings.space)
    made: Law
    if tasks is None:
        made = law(
            dynamics,
            settings.kp,
            settings.kd,
            weights=settings.actuator_weights,
            solver=settings.solver,
            **({"norm": settings.norm} if settings.norm != 2.0 else {}),
            **({"pretension": settings.pretensions} if any(settings.pretension) else {}),
            **({"passive": settings.unfollowing} if any(settings.unfollowing) else {}),
        )
        return made
    posture = tasks.posture
    made = law(
        dynamics,
        settings.kp,
        settings.kd,
        posture=None if posture is None else Posture(posture.kd, posture.kp, posture.q0),
        task_weights=tasks.task_weights,
        priorities=tasks.priorities,
        acceleration_weights=tasks.acceleration_weights,
        force_weights=settings.actuator_weights,
        force_rate_weights=settings.with_motors(tasks.force_rate_weights),
        pretension=settings.pretensions,
        limit_bandwidth=tasks.limit_bandwidth,
        solver=settings.solver,
    )
    return made


def _report(solution: ForceSolution, seconds: float) -> tuple[float, ...]:
    """Number of actuators at a bound, time, status; whether joint limits had to be dropped."""
    status = solution.status
    report = solution.count_at_bounds, seconds, status == "soft", status == "not converged"
    if isinstance(solution, OperationalSpaceSolution):
        return *report, solution.limits_dropped
    return report
