"""Computed torque in operational space, eq. (4) of the CARDSFlow paper.

min  1/2 (qdd - qdd_p)'H_q (qdd - qdd_p) + 1/2 (f - f_p)'H_f (f - f_p)
     + 1/2 (f - f_last)'H_r (f - f_last) + 1/2 s'W s                         over qdd, f, s
s.t. M qdd + C + G + D qd + w_e = -L'f,
     J qdd + J' qd + s = ydd_d + Kd (yd_d - J qd) + Kp (y_d - y),
     f_min <= f <= f_max,   -2 w qd - w² (q - q_min) <= qdd <= -2 w qd + w² (q_max - q).

The paper's own form has qdd_p = 0, f_p = 0, H_r = 0, s = 0 and no bounds on qdd. Taken literally it
leaves the robot's self-motion undamped, and a redundant arm drifts away; the posture acceleration
qdd_p = kp (q0 - q) - kd qd keeps it. Of a task with a finite weight in W the constraint may give
way; of one with an infinite weight s = 0. Tasks of a later priority never disturb those before.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, SimulationError
from controllers.arrays import FloatArray
from controllers.dynamics import TaskDynamics, actuator_names, bias_torque
from controllers.force_distribution.solution import Status
from controllers.qp.problem import BoxProblem, row_softness
from controllers.qp.solver import DEFAULT_SOLVER
from controllers.validation import (
    LARGEST_PRETENSION,
    check_sizes,
    finite_vector,
    float_array,
    force_bounds,
    named_vector,
    positive_or_none,
    resting,
)

from . import least_error
from .operational_solution import DAMPED, OperationalSpaceSolution, Posture
from .priority_level import PriorityLevel

FORCE_WEIGHT = 1e-6
"""Default of H_f, in [1/N²], beside H_q in [s⁴/rad²]: larger ones buy self-motion with forces."""

LIMIT_BANDWIDTH = 20.0
"""Default of w, in [rad/s]: how late and how hard joint limits are kept."""


_WORSE: tuple[Status, ...] = ("solved", "soft", "not converged")


class _Terms(NamedTuple):
    """The robot at (q, qd): M qdd + h = -L'f, the desired J qdd, qdd_p, and bounds on qdd."""

    M: FloatArray
    h: FloatArray
    L: FloatArray
    J: FloatArray
    desired: FloatArray
    qdd_p: FloatArray
    limits: tuple[FloatArray, FloatArray] | None


class OperationalSpaceController:
    """Computed-torque control of task coordinates through muscle forces.

    Args:
        dynamics: The robot as the controller knows it, with an operational space.
        kp: Position gain Kp, a number or shape (k,), in [1/s²].
        kd: Velocity gain Kd, a number or shape (k,), in [1/s].
        posture: What to do with the freedom that the tasks leave; None for the paper's literal
            form, which is not stable on redundant robots.
        task_weights: W, a number or shape (k,), in [s⁴/m²] or [s⁴/rad²]; infinite for a task that
            is to be met exactly.
        priorities: Rank of every task coordinate, shape (k,), 1 first; all equal when None.
        acceleration_weights: Diagonal of H_q, a number or shape (n,).
        force_weights: Diagonal of H_f, a number or shape (a,), in [1/N²], of motors [1/(N·m)²].
        force_rate_weights: Diagonal of H_r, a number or shape (a,), likewise.
        pretension: f_p, a number or shape (a,), in [N] and [N·m]; 0 when None.
        limit_bandwidth: w, in [rad/s]; None to leave joint limits to the robot.
        solver: Name of a QP back end.

    Raises:
        InputError: A gain, weight, bound or size is wrong; the message names it.
        UnknownNameError: The back end is not installed.

    Attributes:
        kp, kd: The gains, shape (k,).
        f_min, f_max: Bounds of forces and of motors' torques, shape (a,), in [N] and [N·m].
    """

    def __init__(
        self,
        dynamics: TaskDynamics,
        kp: ArrayLike,
        kd: ArrayLike,
        *,
        posture: Posture | None = DAMPED,
        task_weights: ArrayLike = np.inf,
        priorities: ArrayLike | None = None,
        acceleration_weights: ArrayLike = 1.0,
        force_weights: ArrayLike = FORCE_WEIGHT,
        force_rate_weights: ArrayLike = 0.0,
        pretension: ArrayLike | None = None,
        limit_bandwidth: float | None = LIMIT_BANDWIDTH,
        solver: str = DEFAULT_SOLVER,
    ) -> None:
        self.dynamics = dynamics
        actuators = actuator_names(dynamics)
        self._n, self._m = len(dynamics.coordinate_names), len(actuators)
        self._k = len(dynamics.task_names)
        if not self._k:
            raise InputError("the robot has no operational space to control; give it task frames")
        joints = dynamics.coordinate_names
        self.set_gains(kp, kd)
        self.set_bounds(dynamics.f_min, dynamics.f_max)
        self._set_posture(posture)
        self._W = named_vector(
            "task_weights", task_weights, dynamics.task_names, above=0.0, infinite=True
        )
        self._H_q = named_vector("acceleration_weights", acceleration_weights, joints, above=0.0)
        self._H_f = named_vector("force_weights", force_weights, actuators, above=0.0)
        self._H_r = named_vector("force_rate_weights", force_rate_weights, actuators)
        f_p = 0.0 if pretension is None else pretension
        self._f_p = named_vector("pretension", f_p, actuators, most=LARGEST_PRETENSION)
        self._w = positive_or_none("limit_bandwidth", limit_bandwidth, "rad/s")
        self._make_levels(priorities, solver)
        self.reset()

    def set_gains(self, kp: ArrayLike, kd: ArrayLike) -> None:
        """Change the gains.

        Args:
            kp: Position gain, a number or shape (k,), in [1/s²].
            kd: Velocity gain, a number or shape (k,), in [1/s].

        Raises:
            InputError: kp is not above 0, kd negative, or there are too many or too few.
        """
        self.kp = named_vector("kp", kp, self.dynamics.task_names, above=0.0)
        self.kd = named_vector("kd", kd, self.dynamics.task_names)

    def set_bounds(self, f_min: ArrayLike, f_max: ArrayLike) -> None:
        """Change the force bounds.

        Args:
            f_min: Lower bounds, shape (a,), in [N] and, of motors, [N·m].
            f_max: Upper bounds, shape (a,); may be infinite.

        Raises:
            InputError: A bound is wrong; the message names the muscle or motor.
        """
        names, motors = actuator_names(self.dynamics), len(self.dynamics.motor_names)
        self.f_min, self.f_max = force_bounds(names, f_min, f_max, motors)

    def reset(self) -> None:
        """Forget the last forces and the solvers' warm starts."""
        self._f_last = resting(self.f_min, self.f_max)
        for level in self._levels:
            level.solver.reset()

    def get_state(self) -> FloatArray:
        """All that the controller remembers: the last forces and the solvers' warm starts."""
        return np.concatenate([self._f_last, *(level.solver.get_state() for level in self._levels)])

    def set_state(self, state: FloatArray) -> None:
        """Go back to a state from `get_state`; the following solutions repeat bit for bit.

        Raises:
            InputError: The state has another length or is not finite.
        """
        ends = np.cumsum([self._m, *(level.rows for level in self._levels)])
        if np.shape(state) != (ends[-1],) or not np.isfinite(state).all():
            raise InputError(f"the controller's state is {ends[-1]} finite numbers")
        self._f_last[:] = state[: self._m]
        for level, part in zip(self._levels, np.split(state, ends[:-1])[1:], strict=True):
            level.solver.set_state(part)

    def error(self, q: FloatArray, y_d: FloatArray) -> FloatArray:
        """y_d - y, angles the shorter way round, shape (k,), in [m] or [rad]."""
        e: FloatArray = y_d - self.dynamics.task_position(q)
        angles = self.dynamics.task_angles
        e[angles] = np.remainder(e[angles] + np.pi, 2.0 * np.pi) - np.pi
        return e

    def build_problem(
        self,
        q: FloatArray,
        qd: FloatArray,
        y_d: FloatArray,
        yd_d: FloatArray,
        ydd_d: FloatArray,
        w_e: FloatArray | None = None,
    ) -> BoxProblem:
        """Eq. (4) with all tasks at once as a QP over [qdd, f, s], apart from its solution.

        Arguments as in `solve`.
        """
        terms = self._terms(q, qd, y_d, yd_d, ydd_d, w_e, None)
        return self._problem(self._levels[-1], terms, terms.desired)

    def solve(
        self,
        q: FloatArray,
        qd: FloatArray,
        y_d: FloatArray,
        yd_d: FloatArray,
        ydd_d: FloatArray,
        *,
        w_e: FloatArray | None = None,
        correction: FloatArray | None = None,
    ) -> OperationalSpaceSolution:
        """The forces of eq. (4), checked.

        Where no forces within the bounds meet the tasks, these give way, the last priority first;
        the motion equation never does.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            y_d: Desired task coordinates, shape (k,), in [m] or [rad].
            yd_d: Desired task velocities, shape (k,).
            ydd_d: Desired task accelerations, shape (k,), in [m/s²] or [rad/s²].
            w_e: Generalised external load on the left of the motion equation, shape (n,), in
                [N·m] or [N]; none when None.
            correction: Added to the commanded task acceleration, shape (k,); none when None.

        Raises:
            InputError: A vector has the wrong length.
            SimulationError: The state or the reference is not finite.
        """
        robot = self.dynamics
        check_sizes(robot.coordinate_names, q=q, qd=qd, w_e=w_e)
        check_sizes(robot.task_names, y_d=y_d, yd_d=yd_d, ydd_d=ydd_d, correction=correction)
        terms = self._terms(q, qd, y_d, yd_d, ydd_d, w_e, correction)
        target, statuses = terms.desired.copy(), set[Status]()
        for level in self._levels:
            x, status, terms = self._solve_level(level, terms, target)
            statuses.add(status)
            target[level.tasks] = terms.J[level.tasks] @ x[: self._n]
        return self._solution(x, terms, max(statuses, key=_WORSE.index))

    def _terms(
        self,
        q: FloatArray,
        qd: FloatArray,
        y_d: FloatArray,
        yd_d: FloatArray,
        ydd_d: FloatArray,
        w_e: FloatArray | None,
        correction: FloatArray | None,
    ) -> _Terms:
        robot = self.dynamics
        h = bias_torque(robot, q, qd)
        if w_e is not None:
            h = h + w_e
        J = robot.task_jacobian(q)
        ydd = ydd_d + self.kd * (yd_d - J @ qd) + self.kp * self.error(q, y_d)
        if correction is not None:
            ydd = ydd + correction
        desired = ydd - robot.task_bias(q, qd)
        if not (np.isfinite(desired).all() and np.isfinite(h).all()):
            raise SimulationError("the state or the reference of the controller is not finite")
        qdd_p: FloatArray = self._posture_kp * (self._q0 - q) - self._posture_kd * qd
        M, L = robot.mass_matrix(q), robot.actuator_jacobian(q)
        return _Terms(M, h, L, J, desired, qdd_p, self._limits(q, qd))

    def _limits(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray] | None:
        """Bounds on qdd that let every joint come to rest at its limit, critically damped."""
        if self._w is None:
            return None
        w, robot = self._w, self.dynamics
        brake = -2.0 * w * qd
        return brake - w * w * (q - robot.q_min), brake + w * w * (robot.q_max - q)

    def _solve_level(
        self, level: PriorityLevel, terms: _Terms, target: FloatArray
    ) -> tuple[FloatArray, Status, _Terms]:
        """[qdd, f, ...], its status, and the terms with the limits it keeps.

        What gives way does so softly only where every programme before is proven infeasible.
        """
        proven: Status = "soft"
        without = () if terms.limits is None else (terms._replace(limits=None),)
        for kept in (terms, *without):
            for row_weights in (None, level.soft_rows):
                problem = self._problem(level, kept, target, row_weights)
                solution = level.solver.solve(problem)
                gave_way = row_weights is not None
                status: Status = proven if gave_way or kept is not terms else "solved"
                if solution.status == "solved":
                    return solution.x, status, kept
                if gave_way or level.is_weighted or solution.status == "not converged":
                    x = self._least_error(level, problem, kept, target)
                    if x is not None:
                        return x, status, kept
                if solution.status == "not converged":
                    proven = "not converged"
        raise SimulationError("no forces within the bounds move the robot as it must: QP failed")

    def _least_error(
        self, level: PriorityLevel, problem: BoxProblem, terms: _Terms, target: FloatArray
    ) -> FloatArray | None:
        """[qdd, f] of a problem that the dual solver has failed on; None for none."""
        n, m = self._n, self._m
        weights = self._W[level.tasks]
        if problem.row_weights is not None:
            weights = np.minimum(weights, 1.0 / row_softness(problem)[-len(level.tasks) :])
        giving = np.isfinite(weights)
        kept = np.concatenate([level.before, level.tasks[~giving]])
        tasks = level.tasks[giving]
        return least_error.solve(
            least_error.LeastError(
                terms.M,
                terms.h,
                terms.L,
                terms.J[tasks],
                target[tasks],
                weights[giving],
                terms.J[kept],
                target[kept],
                self._H_q,
                terms.qdd_p,
                level.H[n : n + m],
                problem.g[n : n + m],
                self.f_min,
                self.f_max,
                terms.limits,
            )
        )

    def _problem(
        self,
        level: PriorityLevel,
        terms: _Terms,
        target: FloatArray,
        row_weights: FloatArray | None = None,
    ) -> BoxProblem:
        """The QP of a priority level over [qdd, f, s]."""
        n, p = self._n, self._n + self._m
        A, b, lb, ub, g = level.A, level.b, level.lb, level.ub, level.g
        A[:n, :n], A[:n, n:p] = terms.M, terms.L.T
        A[n:, :n] = terms.J[level.known]
        b[:n], b[n:] = -terms.h, target[level.known]
        lb[:n], ub[:n] = terms.limits or (-np.inf, np.inf)
        lb[n:p], ub[n:p] = self.f_min, self.f_max
        g[:n] = -self._H_q * terms.qdd_p
        g[n:p] = -self._H_f * self._f_p - self._H_r * self._f_last
        return BoxProblem(level.H, g, A, b, lb, ub, row_weights)

    def _solution(self, x: FloatArray, terms: _Terms, status: Status) -> OperationalSpaceSolution:
        n, m = self._n, self._m
        dropped = terms.limits is None and self._w is not None
        forces, qdd = x[n : n + m].copy(), x[:n].copy()
        self._f_last[:] = forces
        return OperationalSpaceSolution(
            forces,
            status,
            terms.desired - terms.J @ qdd,
            self.f_min.copy(),
            self.f_max.copy(),
            self.dynamics.task_names,
            actuator_names(self.dynamics),
            qdd,
            dropped,
        )

    def _set_posture(self, posture: Posture | None) -> None:
        names = self.dynamics.coordinate_names
        chosen = Posture(kd=0.0) if posture is None else posture
        self._posture_kp = named_vector("posture kp", chosen.kp, names)
        self._posture_kd = named_vector("posture kd", chosen.kd, names)
        if chosen.q0 is None and self._posture_kp.any():
            raise InputError("a posture with a stiffness kp needs its q0")
        q0 = np.zeros(self._n) if chosen.q0 is None else chosen.q0
        self._q0 = finite_vector("posture q0", q0, self._n)

    def _make_levels(self, priorities: ArrayLike | None, solver: str) -> None:
        ranks = np.ones(self._k) if priorities is None else float_array("priorities", priorities)
        if ranks.shape != (self._k,) or not (np.isfinite(ranks).all() and (ranks >= 1).all()):
            names = ", ".join(self.dynamics.task_names)
            raise InputError(f"priorities must be {self._k} numbers from 1 on, for {names}")
        H = np.concatenate([self._H_q, self._H_f + self._H_r])
        self._levels = [
            PriorityLevel(rank, ranks, self._W, H, self._n, solver) for rank in np.unique(ranks)
        ]
