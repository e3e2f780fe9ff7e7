"""Task as cost: operational-space control whose QP always has a solution.

min  1/2 alpha |J qdd + J' qd - ydd_c|² + 1/2 (qdd - qdd_p)'H_q (qdd - qdd_p) + 1/2 f'H_f f
s.t. M qdd + C + G + D qd + w_e = -L'f,   f_min <= f <= f_max,   bounds on qdd

Eq. (4) with a finite weight on every task: the motion equation alone must hold. As CASPR's
`ReactiveQPController` of 2019. A task is met less exactly than as a constraint, the more so the
smaller alpha is beside H_q.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from controllers.dynamics import TaskDynamics

from .operational_space import OperationalSpaceController

TASK_WEIGHT = 1e4
"""Default of alpha, beside H_q = 1."""


class ReactiveQPController(OperationalSpaceController):
    """Control of task coordinates that gives way before it fails.

    Arguments as of `OperationalSpaceController`; `task_weights` is alpha and must be finite for the
    QP to have a solution always.
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
