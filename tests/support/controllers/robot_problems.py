"""Force QPs of random robots with 6 to 20 coordinates, close to the limit of feasibility.

The robots are in random states. Forces within their bounds determine a feasible acceleration. From
there, tasks or torques change in a random direction. Bisection by the solver's results finds the
distance at which the problem becomes infeasible, so problems approach this limit.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog

from controllers.arrays import FloatArray
from sim_dart import CoreDynamics

from ..robots.random_robots import random_robot
from .box_solver import BoxProblem

COUNT = int(os.environ.get("CARDSFLOW_QP_PROBLEMS", "2000"))
"""Number of problems per test."""

EXACT = 1e-13
"""Maximum error of most rows of solved problems, relative to their terms."""

AT_THE_EDGE = 1e-7
"""Maximum error of a row close to the limit of feasibility."""

FAR = 1e7
"""Bound of unbounded variables (accelerations) for certificates, in [rad/s²]."""

INSIDE = 1e-3
"""Minimum distance of a point from its bounds, relative to their difference."""

STATES = 4
KINDS = ("tasks", "limited", "torque")
HALVINGS = (4, 6, 12, 24)


class _State(NamedTuple):
    M: FloatArray
    h: FloatArray
    L: FloatArray
    J: FloatArray
    g: FloatArray
    limits: tuple[FloatArray, FloatArray]
    f_min: FloatArray
    f_max: FloatArray
    H_f: float


class _Robot:
    """Random robot with one to three muscles per coordinate, and random tasks."""

    def __init__(self, seed: int) -> None:
        self.rng = rng = np.random.default_rng([19, seed])
        n = int(rng.integers(6, 21))
        m = int(n * rng.uniform(1.0, 3.0)) + 1
        self.dynamics = CoreDynamics(random_robot(seed, joints=n, muscles=m))
        k = len(self.dynamics.task_names)
        self.tasks = np.sort(rng.permutation(k)[: rng.integers(1, k + 1)])

    def state(self) -> _State:
        rng, robot = self.rng, self.dynamics
        n, m = robot.n, robot.m
        q, qd = rng.uniform(-1.0, 1.0, (2, n))
        brake, room = -40.0 * qd, 400.0 * rng.uniform(0.0, 2.0, (2, n))
        return _State(
            robot.mass_matrix(q).copy(),
            robot.coriolis(q, qd) + robot.gravity(q),
            robot.muscle_jacobian(q).copy(),
            robot.task_jacobian(q)[self.tasks].copy(),
            rng.choice([0.0, 10.0]) * qd,
            (brake - room[0], brake + room[1]),
            rng.uniform(0.0, 10.0, m),
            rng.uniform(150.0, 700.0, m),
            float(rng.choice([1e-6, 1e-6, 1e-4])),
        )


def _problem(kind: str, now: _State, b: FloatArray) -> BoxProblem:
    """Return eq. (3) for a torque or eq. (4) for task accelerations, with or without limits."""
    n, m = len(now.h), len(now.f_min)
    if kind == "torque":
        return BoxProblem(np.ones(m), np.zeros(m), -now.L.T, b, now.f_min, now.f_max)
    A = np.zeros((n + len(b), n + m))
    A[:n, :n], A[:n, n:], A[n:, :n] = now.M, now.L.T, now.J
    low, high = now.limits if kind == "limited" else np.full((2, n), [[-np.inf], [np.inf]])
    return BoxProblem(
        np.concatenate([np.ones(n), np.full(m, now.H_f)]),
        np.concatenate([now.g, np.zeros(m)]),
        A,
        np.concatenate([-now.h, b]),
        np.concatenate([low, now.f_min]),
        np.concatenate([high, now.f_max]),
    )


def _of_robot(seed: int, judge: Callable[[BoxProblem], bool]) -> Iterator[BoxProblem]:
    robot = _Robot(seed)
    rng = robot.rng
    for _ in range(STATES):
        now = robot.state()
        f = rng.uniform(now.f_min, now.f_max)
        f = np.where(rng.random(len(f)) < 0.3, now.f_min, f)
        torque = -now.L.T @ f
        for kind in KINDS:
            made = torque if kind == "torque" else now.J @ np.linalg.solve(now.M, torque - now.h)
            way = rng.normal(size=len(made)) * (np.abs(made).max() + 1.0)
            low, high = 0.0, 10.0 ** rng.uniform(-2.0, 1.0)
            for _ in range(rng.choice(HALVINGS)):
                middle = 0.5 * (low + high)
                problem = _problem(kind, now, made + middle * way)
                yield problem
                low, high = (middle, high) if judge(problem) else (low, middle)


def robot_problems(judge: Callable[[BoxProblem], bool], count: int = COUNT) -> Iterator[BoxProblem]:
    """Yield problems of several robots.

    Args:
        judge: Returns whether the solver found the last problem feasible.
        count: Number of problems.
    """
    found, seed = 0, 0
    while found < count:
        for problem in _of_robot(seed, judge):
            yield problem
            found += 1
        seed += 1


def row_error(problem: BoxProblem, x: FloatArray) -> float:
    """Return the largest row error relative to its terms; infinite if x is out of bounds."""
    if not ((x >= problem.lb) & (x <= problem.ub)).all():
        return np.inf
    long = np.longdouble
    rest = problem.A.astype(long) @ x - problem.b
    terms = np.abs(problem.b) + np.abs(problem.A) @ np.abs(x)
    return float((np.abs(rest) / np.maximum(terms, np.finfo(float).tiny)).max())


def is_certificate(problem: BoxProblem, y: FloatArray) -> bool:
    """Return whether y'b > y'Ax for all x within the bounds, beyond rounding (Farkas' lemma)."""
    long = np.longdouble
    pull = problem.A.T.astype(long) @ y.astype(long)
    bound = np.where(pull > 0, problem.ub, problem.lb)
    free = np.isinf(bound)
    terms = np.abs(y) @ np.abs(problem.b)
    terms += (np.abs(problem.A.T) @ np.abs(y))[~free] @ np.abs(bound[~free])
    gap = problem.b.astype(long) @ y - pull[~free] @ bound[~free]
    return bool(gap - FAR * np.abs(pull[free]).sum() > 1e-13 * terms)


def is_feasible(problem: BoxProblem) -> bool:
    """Return whether HiGHS finds a point inside all bounds that fulfils the rows.

    For feasible problems the minimum error is exactly zero.
    """
    return _least_error(problem, INSIDE) < 1e-12


def is_infeasible(problem: BoxProblem) -> bool:
    """Return whether HiGHS finds no solution within its tolerance."""
    return _least_error(problem, 0.0) > 1e-6


def _least_error(problem: BoxProblem, inside: float) -> float:
    """Return the minimum sum of row errors, relative to the largest row."""
    m_eq, n = problem.A.shape
    unit = np.where(np.isinf(problem.lb), 1.0, 1e-2)  # accelerations in addition to forces
    A = problem.A / unit
    size = np.where(A.any(axis=1), np.abs(A).max(axis=1), 1.0)
    A, b = A / size[:, None], problem.b / size
    scale = np.abs(b).max() + 1.0
    between = np.where(np.isinf(problem.ub), 0.0, problem.ub - np.maximum(problem.lb, -1e300))
    low, high = problem.lb + inside * between, problem.ub - inside * between
    bounds = np.column_stack([low * unit, high * unit]) / scale
    answer = linprog(
        np.concatenate([np.zeros(n), np.ones(2 * m_eq)]),
        A_eq=np.hstack([A, np.eye(m_eq), -np.eye(m_eq)]),
        b_eq=b / scale,
        bounds=np.vstack([bounds, np.tile([0.0, np.inf], (2 * m_eq, 1))]),
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    assert answer.status == 0, answer.message
    return float(answer.fun)
