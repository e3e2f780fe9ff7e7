"""Operational-space control with tasks in the cost, so that the QP always has a solution.

min  1/2 alpha |J qdd + J' qd - ydd_c|² + 1/2 (qdd - qdd_p)'H_q (qdd - qdd_p) + 1/2 f'H_f f
s.t. M qdd + C + G + D qd + w_e = -L'f,   f_min <= f <= f_max,   bounds on qdd

This is eq. (4) with a finite weight on every task. Only the equation of motion is a constraint.
The law corresponds to `ReactiveQPController` of CASPR (2019). Tasks are tracked less accurately
than constraints. The error increases as alpha decreases relative to H_q.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from controllers.dynamics import TaskDynamics

from .operational_space import OperationalSpaceController

TASK_WEIGHT = 1e4
"""Default of alpha, for H_q = 1."""


class ReactiveQPController(OperationalSpaceController):
    """Controller of task coordinates that violates tasks instead of failing.

    The arguments are those of `OperationalSpaceController`. `task_weights` is alpha. The QP is
    always feasible if all weights are finite.
    """

    def __init__(
        self,
        dynamics: TaskDynamics,
        kp: ArrayLike,
        kd: ArrayLike,
        *,
        task_weights: ArrayLike = TASK_WEIGHT,
        **settings: Any,
    ) -> None:
        super().__init__(dynamics, kp, kd, task_weights=task_weights, **settings)
