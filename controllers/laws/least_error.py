"""The smallest task error within the bounds, or none, as a QP over the forces alone.

    min  1/2 (J qdd - c)'W (J qdd - c) + 1/2 (qdd - qdd_p)'H_q (qdd - qdd_p) + 1/2 f'H_f f + g_f'f
    s.t. qdd = -M^-1 (h + L'f),   J_0 qdd = c_0,   qdd_min <= qdd <= qdd_max,   f_min <= f <= f_max

With qdd eliminated, the motion equation holds whatever the forces are: an answer that is not quite
the best one is still one that the robot can do. A solver that works on multipliers of the motion
equation has none of that: where tasks are far from what the forces allow, W outweighs H_f by more
than a float's digits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from controllers.arrays import FloatArray
from controllers.qp import solver as qp

_FLAT = 1e-10  # the least curvature, relative to the largest: DAQP needs a definite Hessian
_KEPT = 1e-6  # a row that is missed by less than this, relative to its size, is kept
_NOTHING = float(np.finfo(float).tiny)
_BEFORE = 1e6  # how much more the tasks J_0 weigh than J, where they cannot be met exactly


class LeastError(NamedTuple):
    """The program.

    Attributes:
        M: Mass matrix, shape (n, n).
        h: Other terms of the motion equation, shape (n,), in [N·m] or [N].
        L: Muscle Jacobian, shape (m, n), in [m/rad] or [m/m].
        J, c: Tasks that may give way, and the desired J qdd, shapes (k, n) and (k,).
        W: Diagonal weights of their errors, shape (k,).
        J_0, c_0: Tasks that may not.
        H_q, qdd_p: Diagonal weights of accelerations, and the ones preferred, shape (n,).
        H_f, g_f: Diagonal and linear cost of forces, shape (m,).
        f_min, f_max: Shape (m,), in [N].
        limits: Bounds on qdd, shape (n,) each; None for none.
    """

    M: FloatArray
    h: FloatArray
    L: FloatArray
    J: FloatArray
    c: FloatArray
    W: FloatArray
    J_0: FloatArray
    c_0: FloatArray
    H_q: FloatArray
    qdd_p: FloatArray
    H_f: FloatArray
    g_f: FloatArray
    f_min: FloatArray
    f_max: FloatArray
    limits: tuple[FloatArray, FloatArray] | None


def solve(problem: LeastError) -> FloatArray | None:
    """[qdd, f], shape (n + m,), or None if no answer keeps all that must be kept.

    Where there are tasks that may give way, those that may not do so last; else they never do.

    Args:
        problem: The program.
    """
    right = np.column_stack([problem.h, problem.L.T])
    made: FloatArray = -np.asarray(np.linalg.solve(problem.M, right), dtype=np.float64)
    a, B = made[:, 0], made[:, 1:]  # qdd = a + B f
    rows, room = _limit_rows(problem, a, B)
    before, after = len(problem.c_0) > 0, len(problem.c) > 0
    for exactly in (True, False) if before and after else (before,):
        f = _forces(problem, a, B, rows, room, exactly)
        if f is None:
            continue
        qdd = a + B @ f
        kept = _excess(rows @ f - room, room, rows, f) <= _KEPT
        rest = problem.c_0 - problem.J_0 @ a
        missed = _excess(np.abs(problem.J_0 @ B @ f - rest), rest, problem.J_0 @ B, f)
        if kept and (not exactly or missed <= _KEPT):
            return np.concatenate([qdd, f])
    return None


def _excess(beyond: FloatArray, side: FloatArray, rows: FloatArray, f: FloatArray) -> float:
    """The largest of some numbers above 0, relative to the terms side and rows @ f."""
    terms = np.abs(side) + np.abs(rows) @ np.abs(f) + _NOTHING
    return float((beyond / terms).max(initial=0.0))


def _forces(
    problem: LeastError,
    a: FloatArray,
    B: FloatArray,
    rows: FloatArray,
    room: FloatArray,
    exactly: bool,
) -> FloatArray | None:
    """The forces by DAQP; the tasks that may not give way as equalities, or very heavy."""
    J, c, W = problem.J, problem.c, problem.W
    if not exactly:
        J, c = np.vstack([problem.J_0, J]), np.concatenate([problem.c_0, c])
        W = np.concatenate([np.full(len(problem.c_0), _BEFORE * W.max(initial=1.0)), W])
    tasks, missing = J @ B, c - J @ a
    P = tasks.T @ (W[:, None] * tasks) + B.T @ (problem.H_q[:, None] * B) + np.diag(problem.H_f)
    P += _FLAT * np.diag(P).max() * np.eye(len(P))
    linear = problem.g_f - tasks.T @ (W * missing) - B.T @ (problem.H_q * (problem.qdd_p - a))
    unit = np.diag(P).max()
    before, rest = problem.J_0 @ B, problem.c_0 - problem.J_0 @ a
    import qpsolvers  # late, as in controllers.qp.solver

    program = qpsolvers.Problem(
        P / unit,
        linear / unit,
        rows if len(rows) else None,
        room if len(rows) else None,
        before if exactly else None,
        rest if exactly else None,
        problem.f_min,
        problem.f_max,
    )
    f = qp.solve(program, qp.FALLBACKS[0])
    return None if f is None else np.clip(f, problem.f_min, problem.f_max)


def _limit_rows(problem: LeastError, a: FloatArray, B: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The finite limits on qdd as rows @ f <= room."""
    if problem.limits is None:
        return np.empty((0, B.shape[1])), np.empty(0)
    low, high = problem.limits
    rows, room = np.vstack([B, -B]), np.concatenate([high - a, a - low])
    kept = np.isfinite(room)
    return rows[kept], room[kept]
