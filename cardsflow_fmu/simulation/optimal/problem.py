"""Optimal-control problem of an experiment with [motion]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.settings import MotionTable
from cardsflow_fmu.utils.arrays import FloatArray, IntArray
from controllers.dynamics import actuator_names
from controllers.optimal.linear import LinearConstraint, limited_rates, periodic
from controllers.optimal.problem import Iterate, OptimalProblem
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.muscles.friction import has_cable_friction, without_friction
from sim_dart.optimal.shooting import Shooting

from .costs import motion_costs
from .goals import fix_goals, fix_start, state_bounds
from .loops import advances, closing, constant_speed, require_independent
from .muscles import MotionControls, actuators, control_bounds
from .obstacles.constraints import obstacle_constraints
from .parameters import FreeParameters, free_parameters
from .tasks import task_bounds

_MAX_REFINED = 8  # substeps up to which they are doubled automatically
_MAX_STIFF = 64  # the same for final motions with a rough error, such as with stiff springs
_MIN_GAIN = 5.0  # of the error by twice the substeps; 16 for smooth motions, 8 with elastic tendons
_UNSTABLE = 1.0  # error of an interval whose substeps are too long, in rad, m, and their rates
_REFINED_TOO = 0.03  # errors of intervals that early iterations refine too, relative to tolerance
ROUGH_INTEGRATION = 1e-2  # error of an interval during the iterations, in rad, m, and their rates


class MotionProblem(NamedTuple):
    """Optimal-control problem of an experiment.

    Attributes:
        problem: The problem.
        guess: Rest at the start, with forces that hold the robot.
        controls: Controls that move the robot along poses.
        dynamics: The robot's dynamics, without friction.
        shooting: Its motion over intervals.
        free: Free parameters of the robot, or None.
        notes: Properties of the robot that the motion neglects, one line each.
    """

    problem: OptimalProblem
    guess: Iterate
    controls: MotionControls
    dynamics: CoreDynamics
    shooting: Shooting
    free: FreeParameters | None
    notes: tuple[str, ...]

    def refine(
        self,
        at: Iterate,
        tolerance: float,
        *,
        is_final: bool = False,
        ends: FloatArray | None = None,
    ) -> float:
        """Double the substeps of inaccurate intervals until all intervals are accurate.

        More than 8 substeps are only used for rough errors, and not for the wild motions of early
        iterations, in which they are doubled once. If they hardly reduce the error of the worst
        intervals, since the forces jump, they are not doubled; rough errors may also fall with
        twice as many again.

        Args:
            at: The motion.
            tolerance: Largest error of an interval, in [rad], [m], and their rates.
            is_final: Whether the motion satisfies all constraints.
            ends: Ends of its intervals, if they are known.

        Returns:
            The largest error.
        """
        first = steps = np.broadcast_to(self.shooting.steps, len(at.u))
        every = np.arange(len(at.u))
        ends = self._ends(at, steps, every) if ends is None else ends
        fine = self._ends(at, 2 * steps, every)
        errors, share = _errors(ends, fine), 1.0 if is_final else _REFINED_TOO
        while errors.max() > tolerance:
            most = np.where(errors > ROUGH_INTEGRATION, _MAX_STIFF, _MAX_REFINED)
            can_double = steps < (most if is_final else np.minimum(2 * first, _MAX_REFINED))
            bad = np.flatnonzero(can_double & (errors > share * tolerance))
            finer = self._ends(at, 4 * steps, bad)
            before, after = errors[bad], _errors(fine[bad], finer)
            is_worst = before >= max(tolerance, min(errors.max(), ROUGH_INTEGRATION))
            is_better = (after <= before / _MIN_GAIN) | (before > _UNSTABLE)
            if not (is_worst & is_better).any():
                worst = bad[is_worst]
                if not is_final or errors[worst].max(initial=0.0) <= ROUGH_INTEGRATION:
                    break
                later = _errors(finer[is_worst], self._ends(at, 8 * steps, worst))
                if not (later <= errors[worst] / _MIN_GAIN**2).any():
                    break
            fine[bad], errors[bad] = finer, after
            steps = np.where(np.isin(every, bad), 2 * steps, steps)
        self.shooting.steps = steps
        return float(errors.max())

    def _ends(self, at: Iterate, steps: IntArray, nodes: IntArray) -> FloatArray:
        """Return the ends of intervals with numbers of substeps; infinite if one diverges."""
        with self.shooting.using(steps):
            intervals = self.problem.run_inside(at, nodes, np.ones(len(nodes)), derivatives=False)
        return np.full_like(at.x[nodes], np.inf) if intervals is None else intervals.ends


def _errors(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the largest difference of the ends of each interval."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.nan_to_num(abs(one - other), nan=np.inf).max(axis=1))


def motion_problem(experiment: Experiment) -> MotionProblem:
    """Return the problem of an experiment.

    Raises:
        InputError: The experiment has no [motion], its robot is not supported, or a goal is beyond
            the bounds; the message names the key.
    """
    motion = experiment.motion
    if motion is None:
        missing = 'missing; for example: duration = 1.0, goals = [{ y = { "hand.x" = 0.4 } }]'
        raise InputError(missing, file=experiment.file, key="motion")
    robot, notes = _frictionless(experiment.robot)
    with_laws = motion.muscles == "laws"
    dynamics = CoreDynamics(robot)
    free = free_parameters(experiment, robot)
    family = None if free is None else free.family
    shooting = Shooting(robot, motion.substeps, with_laws=with_laws, family=family)
    if free is not None:
        free.require_effect(shooting)
    if not shooting.nu:
        raise InputError("requires muscles or motors", file=experiment.file, key="motion")
    bounds = control_bounds(experiment, motion, dynamics, shooting)
    closing_dynamics = closing(experiment, robot) or dynamics
    require_independent(experiment, motion, dynamics.coordinate_names)
    q = np.array(experiment.start.q)
    controls = MotionControls(closing_dynamics, shooting, bounds)
    resting, states = controls.at_rest(q, motion.start_command)
    start = np.array([*q, *experiment.start.qd, *states])
    x_low, x_high = state_bounds(experiment, motion, dynamics, shooting)
    constraints = fix_start(experiment, motion, dynamics, start, x_low, x_high)
    goals = fix_goals(experiment, motion, dynamics, x_low, x_high)
    names, N = actuator_names(dynamics), motion.intervals
    first = int((x_low[0] == x_high[0])[: shooting.n].all())  # a fixed pose is not constrained
    context = experiment, motion, dynamics, np.arange(first, N + 1), shooting.nx
    constraints += goals.constraints + task_bounds(*context)
    obstacles, more = obstacle_constraints(*context)
    constraints += obstacles
    state_names = (
        *(f"{letter}.{c.name}" for letter in ("q", "qd") for c in robot.coordinates),
        *shooting.laws.state_names,
    )
    drives = actuators(dynamics, shooting)
    control_names = tuple(names[k] for k in drives)
    problem = OptimalProblem(
        shooting,
        x_low,
        x_high,
        np.tile(bounds[0], (N, 1)),
        np.tile(bounds[1], (N, 1)),
        motion.duration,
        motion_costs(experiment, motion, shooting, dynamics, goals.costs),
        constraints,
        state_names,
        control_names,
        linear=_linear_constraints(
            experiment, motion, shooting, drives, state_names, control_names
        ),
    )
    duration = float(np.sqrt(motion.duration[0] * motion.duration[1]))
    x = np.tile(start, (N + 1, 1))
    if motion.periodic:
        advance = np.nan_to_num(advances(experiment, motion))
        x[:, : 2 * shooting.n] = constant_speed(advance, N, closing_dynamics, q, duration)
    guess = Iterate(x, np.tile(resting, (N, 1)), duration)
    if free is not None:
        problem = replace(problem, parameters=free.parameters)
        guess = guess._replace(parameters=free.parameters.nominal)
    return MotionProblem(problem, guess, controls, dynamics, shooting, free, (*notes, *more))


def _linear_constraints(
    experiment: Experiment,
    motion: MotionTable,
    shooting: Shooting,
    drives: Sequence[int],
    state_names: tuple[str, ...],
    control_names: tuple[str, ...],
) -> list[LinearConstraint]:
    """Return the limits of force rates, and the conditions of a periodic motion."""
    constraints, n, nx, N = list[LinearConstraint](), shooting.n, shooting.nx, motion.intervals
    if motion.bounds.f_rate_max:
        limits = np.nan_to_num(np.array(motion.bounds.f_rate_max), nan=np.inf)
        driven = limits[drives]
        if np.isfinite(driven).any():
            constraints.append(limited_rates(driven, control_names, N, nx))
    if motion.periodic:
        advance = advances(experiment, motion)
        change = np.concatenate([advance, 0.0 * advance, np.zeros(nx - 2 * n)])
        chosen = np.flatnonzero(~np.isnan(change))
        constraints.append(periodic(chosen, change[chosen], state_names, (N + 1, nx), shooting.nu))
    return constraints


def _frictionless(robot: Robot) -> tuple[Robot, tuple[str, ...]]:
    """Return the robot without friction, which is not differentiable, and notes about it."""
    neglected = {
        "cable friction": has_cable_friction(robot),
        "Coulomb friction of joints": any(c.friction for c in robot.coordinates),
    }
    notes = tuple(f"the motion neglects {name}" for name, is_there in neglected.items() if is_there)
    return without_friction(robot) if notes else robot, notes
