"""Kinematics by least squares: q from muscle lengths, and q from a task position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.dynamics import PathDynamics, TaskDynamics, closed
from controllers.validation import finite_vector, is_finite

_EXACT = 1e-15  # relative changes at which an iteration has nothing to gain any more
_MAX_STEP = 0.3  # of one iteration, in [rad] or [m]
_NEAR_LIMIT = 1e-6  # a coordinate this close to a limit is at it, in [rad] or [m]
_DAMPING = 1e-5  # of the posture next to the task, once the task is met
_MET = 1e-13  # a task error that is nothing but rounding, in [m] or [rad]
_SETTLED = (
    1e-6  # a distance that is not worth a further step, in [rad] or [m], or relative to a step
)
_ITERATIONS = 200


@dataclass(frozen=True, eq=False)
class ForwardKinematics:
    """A configuration found from muscle lengths.

    Attributes:
        q: Joint positions, shape (n,), in [rad] or [m].
        residual: l(q) - l, shape (m,), in [m]: near 0 if the lengths belong together.
        determined: Whether the lengths determine all of q: L(q) has full column rank there.
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
        q: Joint positions, shape (n,), in [rad] or [m]; within the limits.
        error: y_d - y(q), shape (k,), in [m] or [rad].
        at_limits: Names of the coordinates at a limit.
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
    """Configuration from muscle lengths: min |l(q) - l|² within the limits, with L as Jacobian.

    CASPR's `FKLeastSquares`. Lengths may belong to several q: it is the one that the start leads
    to; of several starts, the one of least residual.

    Args:
        robot: The robot.
        lengths: l, shape (m,), in [m].
        q_start: Where to begin, shape (n,), in [rad] or [m], such as the last q of a motion.
        starts: How many beginnings: the given one, and random ones within the limits, or
            within pi, in [rad] or [m], of the given one if there is no limit.
        seed: Of the random ones.

    Raises:
        InputError: A size or a number is wrong.
    """
    n, m = len(robot.coordinate_names), len(robot.muscle_names)
    desired, first = finite_vector("lengths", lengths, m), finite_vector("q_start", q_start, n)

    def error(q: FloatArray) -> FloatArray:
        return robot.muscle_lengths(q) - desired

    from scipy.optimize import least_squares  # takes half a second

    best: ForwardKinematics | None = None
    for start in _starts(first, robot.q_min, robot.q_max, starts, seed):
        answer = least_squares(
            error,
            start,
            robot.muscle_jacobian,
            bounds=_open(robot.q_min, robot.q_max),
            ftol=_EXACT,
            xtol=_EXACT,
            gtol=_EXACT,
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


@np.errstate(over="ignore", invalid="ignore")  # what is out of reach is rejected
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
    """Configuration for a task position, within the joint limits and otherwise near a posture.

    Damped least squares: every step minimises |J dq - e|² + mu² |dq|² within the limits and a
    longest step, with mu falling with the error e. Once the task is met, |dq - (q_p - q)|² leads
    along the configurations that meet it to the one nearest to the posture q_p. Nakamura,
    Hanafusa, "Inverse kinematic solutions with singularity robustness for robot manipulator
    control", J. Dynamic Systems, Measurement, and Control 108 (1986).

    Args:
        robot: The robot, with an operational space.
        y: Task position, shape (k,), in [m] or [rad].
        q_start: Where to begin, shape (n,), in [rad] or [m].
        posture: q_p, shape (n,); the start when None.
        tolerance: Largest error of a task coordinate, in [m] or [rad].
        starts: Number of start poses to try: the given one, then random ones.
        seed: Of the random ones.

    Raises:
        InputError: A size or a number is wrong, or the position is out of reach; the message says
            by how much, and which limits are in the way.
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
        found = _descend(robot, desired, start, preferred, tolerance)
        if best is None or np.linalg.norm(found.error) < np.linalg.norm(best.error):
            best = found
        if np.abs(best.error).max(initial=0.0) <= tolerance:
            return best
    assert best is not None
    raise InputError(_out_of_reach(robot, desired, best))


def _descend(
    robot: TaskDynamics, y: FloatArray, start: FloatArray, posture: FloatArray, tolerance: float
) -> InverseKinematics:
    """Where damped least squares lead from one start: to the task, then along it to the posture."""
    q = np.clip(start, robot.q_min, robot.q_max)
    q = _reach(robot, y, _closed(robot, q, q))
    longest = _MAX_STEP
    for _ in range(_ITERATIONS):
        error = _task_error(robot, y, q)
        if np.abs(error).max(initial=0.0) > tolerance or longest < _SETTLED:
            break
        dq = _step(robot, q, error, posture - q, _DAMPING, longest)
        if np.abs(dq).max(initial=0.0) < _SETTLED:
            break
        ahead = _reach(robot, y, _closed(robot, q + dq, q))
        met = np.abs(_task_error(robot, y, ahead)).max(initial=0.0) <= tolerance
        gain = np.linalg.norm(q - posture) - np.linalg.norm(ahead - posture)
        if met and gain > 0:
            q, longest = ahead, min(2.0 * longest, _MAX_STEP)
        if not met or gain <= _SETTLED * longest:
            longest *= 0.25  # too far for a linear model, or nearly there
    limits = np.minimum(q - robot.q_min, robot.q_max - q) <= _NEAR_LIMIT
    names = [name for name, at in zip(robot.coordinate_names, limits, strict=True) if at]
    return InverseKinematics(q, _task_error(robot, y, q), tuple(names))


def _closed(robot: TaskDynamics, q: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Return the pose with closed loops; another one if they cannot be closed."""
    try:
        return closed(robot, q)
    except InputError:
        return otherwise


def _reach(robot: TaskDynamics, y: FloatArray, q: FloatArray) -> FloatArray:
    """Return the configuration of least task error that q leads to, shape (n,)."""
    error, longest = _task_error(robot, y, q), _MAX_STEP
    for _ in range(_ITERATIONS):
        size = float(np.linalg.norm(error))
        if size < _MET or longest < _SETTLED**2:
            break
        step = _step(robot, q, error, np.zeros_like(q), 0.1 * min(size, 1.0), longest)
        ahead = _closed(robot, q + step, q)
        new = _task_error(robot, y, ahead)
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
    locked = high - low <= 1e-14  # a coordinate that its limits leave no room
    dq: FloatArray = np.zeros_like(q)
    if locked.all():
        return dq
    rows = np.vstack([J, mu * np.eye(len(q))])[:, ~locked]
    goal = np.concatenate([error, mu * to_posture])
    free = np.linalg.lstsq(rows, goal)[0]
    if (free < low[~locked]).any() or (free > high[~locked]).any():
        from scipy.optimize import lsq_linear  # takes half a second, and steps are mostly free

        bounds = low[~locked], high[~locked]
        free = lsq_linear(rows, goal, bounds=bounds, method="bvls", tol=1e-15).x
    dq[~locked] = free
    return np.clip(dq, low, high)


def _task_error(robot: TaskDynamics, y: FloatArray, q: FloatArray) -> FloatArray:
    """Task error y - y(q), angles the short way round, shape (k,)."""
    error = y - robot.task_position(q)
    turns = np.remainder(error + np.pi, 2.0 * np.pi) - np.pi
    return np.asarray(np.where(robot.task_angles, turns, error))


def _out_of_reach(robot: TaskDynamics, y: FloatArray, best: InverseKinematics) -> str:
    """Return the message about a position that no configuration reaches."""
    goal = ", ".join(f"{n} {v:.6g}" for n, v in zip(robot.task_names, y, strict=True))
    parts = []
    for angles, what, unit in ((False, "distance", "m"), (True, "angle", "rad")):
        rest = best.error[robot.task_angles == angles]
        if len(rest):
            parts.append(f"{what} {np.linalg.norm(rest):.4g} {unit}")
    limits = f"at the limits of {', '.join(best.at_limits)}" if best.at_limits else "at no limit"
    return f"no configuration reaches {goal}: the nearest found leaves {', '.join(parts)}, {limits}"


def _starts(
    first: FloatArray, q_min: FloatArray, q_max: FloatArray, count: int, seed: int
) -> list[FloatArray]:
    """Return the given start and random ones, within the limits."""
    if count < 1:
        raise InputError(f"starts must be at least 1: {count}")
    first = np.clip(first, q_min, q_max)
    low = np.where(np.isfinite(q_min), q_min, first - np.pi)
    high = np.where(np.isfinite(q_max), q_max, first + np.pi)
    rng = np.random.default_rng(seed)
    return [first, *(rng.uniform(low, high) for _ in range(count - 1))]


def _open(q_min: FloatArray, q_max: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Limits that scipy accepts: not equal, and the start may lie on them."""
    slack = 1e-12 * np.maximum(1.0, np.abs(np.where(np.isfinite(q_min), q_min, 0.0)))
    return q_min - slack, np.maximum(q_max, q_min) + slack
