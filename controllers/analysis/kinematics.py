"""Forward kinematics from muscle lengths and inverse kinematics from a task position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.dynamics import PathDynamics, TaskDynamics, close_loops, task_error
from controllers.validation import finite_vector, is_finite

_RELATIVE_TOLERANCE = 1e-15  # relative change at which least squares stops
_MAX_STEP = 0.3  # step length of one iteration, in [rad] or [m]
_NEAR_LIMIT = 1e-6  # distance from a limit at which a coordinate is at it, in [rad] or [m]
_POSTURE_WEIGHT = 1e-5  # weight of the posture relative to the task, after the task is reached
_ROUNDING = 1e-13  # task error caused by rounding, in [m] or [rad]
_MIN_STEP = 1e-6  # step length at which the search stops, in [rad] or [m]
_ITERATIONS = 200


@dataclass(frozen=True, eq=False)
class ForwardKinematics:
    """A configuration found from muscle lengths.

    Attributes:
        q: Joint positions, shape (n,), in [rad] or [m].
        residual: l(q) - l, shape (m,), in [m]; near 0 if the lengths are consistent.
        determined: Whether L(q) has full column rank, so that the lengths determine all of q.
    """

    q: FloatArray
    residual: FloatArray
    determined: bool

    @property
    def error(self) -> float:
        """Largest length error, in [m]."""
        return float(np.abs(self.residual).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class InverseKinematics:
    """A configuration found for a task position.

    Attributes:
        q: Joint positions within the joint limits, shape (n,), in [rad] or [m].
        error: y_d - y(q), shape (k,), in [m] or [rad].
        at_limits: Names of the coordinates at a joint limit.
    """

    q: FloatArray
    error: FloatArray
    at_limits: tuple[str, ...]


def forward_kinematics(
    robot: PathDynamics,
    lengths: ArrayLike,
    q_start: ArrayLike,
    *,
    starts: int = 1,
    seed: int = 0,
) -> ForwardKinematics:
    """Compute a configuration from muscle lengths: min |l(q) - l|² within the joint limits.

    The method corresponds to `FKLeastSquares` of CASPR. If several configurations have the given
    lengths, the start selects one of them. With several starts, the function returns the
    configuration with the smallest residual.

    Args:
        lengths: l, shape (m,), in [m].
        q_start: Start, shape (n,), in [rad] or [m], such as the previous q of a motion.
        starts: Number of starts: `q_start` and random ones. Random starts are within the limits,
            or within pi of `q_start`, in [rad] or [m], for a coordinate without limits.
        seed: Seed of the random starts.

    Raises:
        InputError: A size is wrong or a number is not finite.
    """
    n, m = len(robot.coordinate_names), len(robot.muscle_names)
    desired, first = finite_vector("lengths", lengths, m), finite_vector("q_start", q_start, n)

    def error(q: FloatArray) -> FloatArray:
        return robot.muscle_lengths(q) - desired

    from scipy.optimize import least_squares  # late, since the import takes 0.5 s

    best: ForwardKinematics | None = None
    for start in _starts(first, robot.q_min, robot.q_max, starts, seed):
        answer = least_squares(
            error,
            start,
            robot.muscle_jacobian,
            bounds=_widen_limits(robot.q_min, robot.q_max),
            ftol=_RELATIVE_TOLERANCE,
            xtol=_RELATIVE_TOLERANCE,
            gtol=_RELATIVE_TOLERANCE,
            x_scale="jac",
            max_nfev=_ITERATIONS,
        )
        q = np.clip(answer.x, robot.q_min, robot.q_max)
        residual = robot.muscle_lengths(q) - desired
        if best is None or np.linalg.norm(residual) < np.linalg.norm(best.residual):
            full = bool(np.linalg.matrix_rank(robot.muscle_jacobian(q)) == n)
            best = ForwardKinematics(q, residual, full)
    assert best is not None
    return best


@np.errstate(over="ignore", invalid="ignore")  # a position out of reach is rejected
def inverse_kinematics(
    robot: TaskDynamics,
    y: ArrayLike,
    q_start: ArrayLike,
    *,
    posture: ArrayLike | None = None,
    tolerance: float = 1e-8,
    starts: int = 8,
    seed: int = 0,
) -> InverseKinematics:
    """Compute the configuration nearest to a posture that reaches a task position.

    The method is damped least squares. Every step minimises |J dq - e|² + mu² |dq|² within the
    joint limits and a maximum step length; mu decreases with the error e. After the task is
    reached, the term |dq - (q_p - q)|² moves the configuration along the solutions of the task
    towards the posture q_p. Nakamura, Hanafusa, "Inverse kinematic solutions with singularity
    robustness for robot manipulator control", J. Dynamic Systems, Measurement, and Control 108
    (1986).

    Args:
        robot: The robot, with an operational space.
        y: Task position, shape (k,), in [m] or [rad].
        q_start: Start, shape (n,), in [rad] or [m].
        posture: q_p, shape (n,) (default: `q_start`).
        tolerance: Largest error of a task coordinate, in [m] or [rad].
        starts: Number of starts: `q_start`, then random ones.
        seed: Seed of the random starts.

    Raises:
        InputError: A size is wrong, a number is not finite, or the position is out of reach. The
            message then states the nearest position in reach, the remaining error and the active
            joint limits.
    """
    n = len(robot.coordinate_names)
    desired, first = (
        finite_vector("y", y, len(robot.task_names)),
        finite_vector("q_start", q_start, n),
    )
    preferred = first if posture is None else finite_vector("posture", posture, n)
    if not (is_finite(tolerance) and tolerance > 0):
        raise InputError(f"tolerance must be finite and positive: {tolerance}")
    best: InverseKinematics | None = None
    for start in _starts(first, robot.q_min, robot.q_max, starts, seed):
        solution = _descend(robot, desired, start, preferred, tolerance)
        if best is None or np.linalg.norm(solution.error) < np.linalg.norm(best.error):
            best = solution
        if np.abs(best.error).max(initial=0.0) <= tolerance:
            return best
    assert best is not None
    raise InputError(_out_of_reach(robot, desired, best))


def _descend(
    robot: TaskDynamics, y: FloatArray, start: FloatArray, posture: FloatArray, tolerance: float
) -> InverseKinematics:
    """Reach the task from one start by damped least squares, then approach the posture."""
    q = np.clip(start, robot.q_min, robot.q_max)
    q = _reach_task(robot, y, _close_loops(robot, q, q))
    longest = _MAX_STEP
    for _ in range(_ITERATIONS):
        error = task_error(robot, q, y)
        if np.abs(error).max(initial=0.0) > tolerance or longest < _MIN_STEP:
            break
        dq = _step(robot, q, error, posture - q, _POSTURE_WEIGHT, longest)
        if np.abs(dq).max(initial=0.0) < _MIN_STEP:
            break
        ahead = _reach_task(robot, y, _close_loops(robot, q + dq, q))
        reached = np.abs(task_error(robot, ahead, y)).max(initial=0.0) <= tolerance
        gain = np.linalg.norm(q - posture) - np.linalg.norm(ahead - posture)
        if reached and gain > 0:
            q, longest = ahead, min(2.0 * longest, _MAX_STEP)
        if not reached or gain <= _MIN_STEP * longest:
            longest *= 0.25  # the step exceeds the linear range, or the search has almost converged
    limits = np.minimum(q - robot.q_min, robot.q_max - q) <= _NEAR_LIMIT
    names = [name for name, at in zip(robot.coordinate_names, limits, strict=True) if at]
    return InverseKinematics(q, task_error(robot, q, y), tuple(names))


def _close_loops(robot: TaskDynamics, q: FloatArray, fallback: FloatArray) -> FloatArray:
    """Return q with closed kinematic loops, or the fallback if they cannot be closed."""
    try:
        return close_loops(robot, q)
    except InputError:
        return fallback


def _reach_task(robot: TaskDynamics, y: FloatArray, q: FloatArray) -> FloatArray:
    """Minimise the task error, starting from q, and return the configuration, shape (n,)."""
    error, longest = task_error(robot, q, y), _MAX_STEP
    for _ in range(_ITERATIONS):
        size = float(np.linalg.norm(error))
        if size < _ROUNDING or longest < _MIN_STEP**2:
            break
        step = _step(robot, q, error, np.zeros_like(q), 0.1 * min(size, 1.0), longest)
        ahead = _close_loops(robot, q + step, q)
        new = task_error(robot, ahead, y)
        if np.linalg.norm(new) < size:
            q, error, longest = ahead, new, min(2.0 * longest, _MAX_STEP)
        else:
            longest *= 0.25
    return q


def _step(
    robot: TaskDynamics,
    q: FloatArray,
    error: FloatArray,
    to_posture: FloatArray,
    mu: float,
    longest: float,
) -> FloatArray:
    """Return the damped step within the limits, shape (n,)."""
    J = robot.task_jacobian(q)
    low = np.maximum(robot.q_min - q, -longest)
    high = np.minimum(robot.q_max - q, longest)
    locked = high - low <= 1e-14  # coordinates that cannot move within their limits
    dq: FloatArray = np.zeros_like(q)
    if locked.all():
        return dq
    rows = np.vstack([J, mu * np.eye(len(q))])[:, ~locked]
    goal = np.concatenate([error, mu * to_posture])
    free = np.linalg.lstsq(rows, goal, rcond=None)[0]
    if (free < low[~locked]).any() or (free > high[~locked]).any():
        from scipy.optimize import (
            lsq_linear,
        )  # late, since the import takes 0.5 s and is rarely needed

        bounds = low[~locked], high[~locked]
        free = lsq_linear(rows, goal, bounds=bounds, method="bvls", tol=1e-15).x
    dq[~locked] = free
    return np.clip(dq, low, high)


def _out_of_reach(robot: TaskDynamics, y: FloatArray, best: InverseKinematics) -> str:
    """Return the error message for a position that no configuration reaches."""
    goal, nearest = (
        ", ".join(f"{n} {v:.6g}" for n, v in zip(robot.task_names, values, strict=True))
        for values in (y, robot.task_position(best.q))
    )
    parts = []
    for angles, quantity, unit in ((False, "distance", "m"), (True, "angle", "rad")):
        error = best.error[robot.task_angles == angles]
        if len(error):
            parts.append(f"{quantity} {np.linalg.norm(error):.4g} {unit}")
    limits = f"at the limits of {', '.join(best.at_limits)}" if best.at_limits else "at no limit"
    remaining = f"the remaining error is {', '.join(parts)}, {limits}"
    return f"no configuration reaches {goal}: the nearest in reach is {nearest}; {remaining}"


def _starts(
    first: FloatArray, q_min: FloatArray, q_max: FloatArray, count: int, seed: int
) -> list[FloatArray]:
    """Return the given start and random starts, within the joint limits."""
    if count < 1:
        raise InputError(f"starts must be at least 1: {count}")
    first = np.clip(first, q_min, q_max)
    low = np.where(np.isfinite(q_min), q_min, first - np.pi)
    high = np.where(np.isfinite(q_max), q_max, first + np.pi)
    rng = np.random.default_rng(seed)
    return [first, *(rng.uniform(low, high) for _ in range(count - 1))]


def _widen_limits(q_min: FloatArray, q_max: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return slightly wider limits, since scipy requires a start strictly between them."""
    slack = 1e-12 * np.maximum(1.0, np.abs(np.where(np.isfinite(q_min), q_min, 0.0)))
    return q_min - slack, np.maximum(q_max, q_min) + slack
