"""Optimal-control problem of an experiment with [motion]."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.settings import (
    GoalSettings,
    MotionTable,
)
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.dynamics import actuator_names
from controllers.optimal.problem import Iterate, NodeConstraint, OptimalProblem
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.muscles.friction import has_cable_friction
from sim_dart.optimal.shooting import Shooting

from .muscles import (
    actuators,
    control_bounds,
    motion_costs,
    override,
    require_order,
    resting_controls,
    state_ranges,
)
from .tasks import TaskRows, obstacle_constraints

_WHOLE = 1e-6  # deviation of a time from a node, relative to an interval


class MotionProblem(NamedTuple):
    """Optimal-control problem of an experiment.

    Attributes:
        problem: The problem.
        guess: Rest at the start, with forces that hold the robot.
        dynamics: The robot's dynamics, without friction.
        shooting: Its motion over intervals.
        notes: Properties of the robot that the motion neglects, one line each.
    """

    problem: OptimalProblem
    guess: Iterate
    dynamics: CoreDynamics
    shooting: Shooting
    notes: tuple[str, ...]

    def integration_error(self, at: Iterate) -> float:
        """Return the largest error of the ends of the intervals, in rad, m, and their rates."""
        steps, ends = self.shooting.steps, []
        for self.shooting.steps in (steps, 2 * steps):
            found = self.problem.run(at, derivatives=False)
            ends.append(np.full_like(at.x[1:], np.inf) if found is None else found.ends)
        self.shooting.steps = steps
        return float(np.nan_to_num(abs(ends[1] - ends[0]), nan=np.inf).max())


def motion_problem(experiment: Experiment) -> MotionProblem:
    """Return the problem of an experiment.

    Raises:
        InputError: The experiment has no [motion], its robot is not supported, or a goal is beyond
            the bounds; the message names the key.
    """
    motion = experiment.motion
    if motion is None:
        what = 'missing; for example: duration = 1.0, goals = [{ y = { "hand.x" = 0.4 } }]'
        raise InputError(what, file=experiment.file, key="motion")
    robot, notes = _frictionless(experiment.robot)
    if robot.loops:
        what = "does not support closed kinematic loops"
        raise InputError(what, file=experiment.file, key="motion")
    with_laws = motion.muscles == "laws"
    dynamics = CoreDynamics(robot)
    shooting = Shooting(robot, motion.substeps, with_laws=with_laws)
    if not shooting.nu:
        raise InputError("requires muscles or motors", file=experiment.file, key="motion")
    bounds = control_bounds(experiment, motion, dynamics, shooting)
    q = np.array(experiment.start.q)
    controls, states = resting_controls(motion, dynamics, shooting, q, bounds)
    x_low, x_high = _state_bounds(experiment, motion, dynamics, shooting, states)
    constraints = _fix_goals(experiment, motion, dynamics, x_low, x_high)
    constraints += obstacle_constraints(experiment, motion, dynamics, shooting.nx)
    names, N = actuator_names(dynamics), motion.intervals
    problem = OptimalProblem(
        shooting,
        x_low,
        x_high,
        np.tile(bounds[0], (N, 1)),
        np.tile(bounds[1], (N, 1)),
        motion.duration,
        motion_costs(motion, shooting, dynamics),
        constraints,
        (
            *(f"{letter}.{c.name}" for letter in ("q", "qd") for c in robot.coordinates),
            *shooting.laws.state_names,
        ),
        tuple(names[k] for k in actuators(dynamics, shooting)),
    )
    duration = float(np.sqrt(motion.duration[0] * motion.duration[1]))
    guess = Iterate(np.tile(x_low[0], (N + 1, 1)), np.tile(controls, (N, 1)), duration)
    return MotionProblem(problem, guess, dynamics, shooting, notes)


def _frictionless(robot: Robot) -> tuple[Robot, tuple[str, ...]]:
    """Return the robot without friction, which is not differentiable, and notes about it."""
    notes = []
    if has_cable_friction(robot):
        robot = robot.with_muscles([muscle.with_friction_scaled(0.0) for muscle in robot.muscles])
        notes.append("the motion neglects cable friction")
    if any(c.friction for c in robot.coordinates):
        joints = tuple(
            replace(joint, coordinates=tuple(replace(c, friction=0.0) for c in joint.coordinates))
            for joint in robot.joints
        )
        robot = replace(robot, joints=joints)
        notes.append("the motion neglects Coulomb friction of joints")
    return robot, tuple(notes)


def _state_bounds(
    experiment: Experiment,
    motion: MotionTable,
    dynamics: CoreDynamics,
    shooting: Shooting,
    states: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the bounds of the states at the nodes, with the fixed start."""
    own, n = motion.bounds, shooting.n
    low, high = override(dynamics.q_min, own.q_min), override(dynamics.q_max, own.q_max)
    speed = override(np.full(n, np.inf), own.qd_max)
    names, q, qd = dynamics.coordinate_names, experiment.start.q, experiment.start.qd
    for k, name in enumerate(names):
        require_order(experiment, f"q_max.{name}", low[k], high[k])
        for letter, value, least, most in (
            ("q", q[k], low[k], high[k]),
            ("qd", qd[k], -speed[k], speed[k]),
        ):
            if not least <= value <= most:
                what = f"must be within the bounds {least:.6g} to {most:.6g} of the motion"
                raise InputError(
                    f"{what}, not {value!r}", file=experiment.file, key=f"start.{letter}.{name}"
                )
    weakest, strongest = state_ranges(shooting, dynamics)
    x_low = np.tile([*low, *-speed, *weakest], (motion.intervals + 1, 1))
    x_high = np.tile([*high, *speed, *strongest], (motion.intervals + 1, 1))
    x_low[0] = x_high[0] = [*q, *qd, *states]
    return x_low, x_high


def _fix_goals(
    experiment: Experiment,
    motion: MotionTable,
    dynamics: CoreDynamics,
    x_low: FloatArray,
    x_high: FloatArray,
) -> list[NodeConstraint]:
    """Fix the states of the goals in the bounds; return the constraints of task coordinates."""
    constraints, n = [], dynamics.n
    for k, goal in enumerate(motion.goals):
        key = f"motion.goals[{k}]"
        node = _node(experiment, motion, goal, f"{key}.time")
        if goal.rest is True or (goal.rest is None and node == motion.intervals):
            x_low[node, n : 2 * n] = x_high[node, n : 2 * n] = 0.0
        for j, value in enumerate(goal.q):
            if np.isnan(value):
                continue
            if not x_low[node, j] <= value <= x_high[node, j]:
                name = dynamics.coordinate_names[j]
                low, high = x_low[node, j], x_high[node, j]
                what = f"must be within the bounds {low:.6g} to {high:.6g}, not {value!r}"
                raise InputError(what, file=experiment.file, key=f"{key}.q.{name}")
            x_low[node, j] = x_high[node, j] = value
        rows = np.flatnonzero(~np.isnan(goal.y)) if goal.y else np.empty(0, dtype=int)
        if len(rows):
            target = np.array(goal.y)[rows]
            names = tuple(dynamics.task_names[row] for row in rows)
            evaluate = TaskRows(dynamics, rows, x_low.shape[1])
            constraints.append(
                NodeConstraint(f"goals[{k}].y", names, np.array([node]), evaluate, target, target)
            )
    return constraints


def _node(experiment: Experiment, motion: MotionTable, goal: GoalSettings, key: str) -> int:
    if goal.time is None:
        return motion.intervals
    at = goal.time / motion.duration[1] * motion.intervals
    node = round(at)
    if abs(at - node) > _WHOLE or not node:
        h = motion.duration[1] / motion.intervals
        what = f"must be a multiple of an interval, {h:.6g} s, above 0, not {goal.time!r} s"
        raise InputError(f"{what}; change motion.intervals", file=experiment.file, key=key)
    return node
