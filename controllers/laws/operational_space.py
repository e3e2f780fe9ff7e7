"""Computed torque in operational space, eq. (4) of the CARDSFlow paper.

min  1/2 (qdd - qdd_p)'H_q (qdd - qdd_p) + 1/2 (f - f_p)'H_f (f - f_p)
     + 1/2 (f - f_last)'H_r (f - f_last) + 1/2 s'W s                         over qdd, f, s
s.t. M qdd + C + G + D qd + w_e = -L'f,
     J qdd + J' qd + s = ydd_d + Kd (yd_d - J qd) + Kp (y_d - y),
     f_min <= f <= f_max,   -2 w qd - w² (q - q_min) <= qdd <= -2 w qd + w² (q_max - q).

The paper uses qdd_p = 0, f_p = 0, H_r = 0, s = 0 and no bounds on qdd. This form does not damp the
self-motion of the robot, so that a redundant arm drifts. The posture acceleration
qdd_p = kp (q0 - q) - kd qd prevents the drift. A task with a finite weight in W can be violated;
a task with an infinite weight has s = 0. Tasks of a lower priority do not affect tasks of a higher
priority.

The file csrc/laws/operational_space.c implements the computation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, SimulationError
from controllers.arrays import FloatArray
from controllers.dynamics import TaskDynamics, actuator_names, bias_torque, task_error
from controllers.force_distribution.solution import STATUSES, ForceSolution
from controllers.qp import law_in_c
from controllers.qp.solver import DEFAULT_SOLVER, require_solver
from controllers.validation import (
    MAX_PRETENSION,
    check_sizes,
    finite_vector,
    float_array,
    force_bounds,
    named_vector,
    require_positive,
)

if TYPE_CHECKING:
    import qpsolvers

FORCE_WEIGHT = 1e-6
"""Default of H_f, in [1/N²]. Larger values relative to H_q reduce forces by more self-motion."""

TASK_WEIGHT = 1e4
"""Default of W of `reactive_qp`, whose tasks are in the cost, as in `ReactiveQPController` of CASPR
(2019). Tasks are tracked less accurately if W is smaller relative to H_q."""

LIMIT_BANDWIDTH = 20.0
"""Default of w, in [rad/s]. Larger values brake later and harder before a joint limit."""


@dataclass(frozen=True)
class Posture:
    """Desired motion in the null space of the tasks: qdd_p = kp (q0 - q) - kd qd.

    Attributes:
        kd: Damping, a number or shape (n,), in [1/s].
        kp: Stiffness, a number or shape (n,), in [1/s²].
        q0: Preferred posture, shape (n,), in [rad] or [m]; required if kp is not 0.
    """

    kd: ArrayLike = 10.0
    kp: ArrayLike = 0.0
    q0: ArrayLike | None = None


DAMPED = Posture()
"""Default posture: damping of self-motion, without a preferred configuration."""


@dataclass(frozen=True)
class OperationalSpaceSolution(ForceSolution):
    """Muscle forces and accelerations. The slack is a task acceleration.

    Attributes:
        slack: Missing task acceleration, shape (k,), in [m/s²] or [rad/s²].
        coordinate_names: Names of the k task coordinates.
        qdd: Joint acceleration predicted by the robot model, shape (n,), in [rad/s²] or [m/s²].
        limits_dropped: Whether the bounds on qdd from joint limits were infeasible and removed.
    """

    qdd: FloatArray
    limits_dropped: bool


class OperationalSpaceController:
    """Computed-torque control of task coordinates through muscle forces.

    Args:
        dynamics: Robot model of the controller, with an operational space.
        kp: Position gain Kp, a number or shape (k,), in [1/s²].
        kd: Velocity gain Kd, a number or shape (k,), in [1/s].
        posture: Desired motion in the null space of the tasks. None selects the form of the paper,
            which is not stable for redundant robots.
        task_weights: W, a number or shape (k,), in [s⁴/m²] or [s⁴/rad²]; infinite for a hard
            constraint. With finite weights the QP is always feasible.
        priorities: Priority of every task coordinate, shape (k,), 1 is the highest (default: equal
            priorities).
        acceleration_weights: Diagonal of H_q, a number or shape (n,).
        force_weights: Diagonal of H_f, a number or shape (a,), in [1/N²] for muscles and
            [1/(N·m)²] for motors.
        force_rate_weights: Diagonal of H_r, a number or shape (a,), in the units of H_f.
        pretension: f_p, a number or shape (a,), in [N] and [N·m] (default: 0).
        limit_bandwidth: w, in [rad/s]; None disables the bounds on qdd.
        solver: Name of a QP back end.

    Raises:
        InputError: A gain, weight, limit or size is invalid; the message names it.
        UnknownNameError: The back end is not installed.

    Attributes:
        kp, kd: The gains, shape (k,).
        f_min, f_max: Limits of muscle forces and motor torques, shape (a,), in [N] and [N·m].
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
        self.dynamics, self.solver = dynamics, require_solver(solver)
        joints, actuators = dynamics.coordinate_names, actuator_names(dynamics)
        tasks = dynamics.task_names
        if not tasks:
            raise InputError("the robot has no operational space; define task frames")
        self._law = law_in_c.LawInC(len(joints), len(actuators), len(tasks))
        self.set_gains(kp, kd)
        self.set_bounds(dynamics.f_min, dynamics.f_max)
        self._set_posture(posture)
        if limit_bandwidth is not None:
            require_positive(limit_bandwidth=limit_bandwidth)
        f_p = 0.0 if pretension is None else pretension
        self._law.write(
            W=named_vector("task_weights", task_weights, tasks, above=0.0, infinite=True),
            priority=self._check_priorities(priorities),
            H_q=named_vector("acceleration_weights", acceleration_weights, joints, above=0.0),
            H_f=named_vector("force_weights", force_weights, actuators, above=0.0),
            H_r=named_vector("force_rate_weights", force_rate_weights, actuators),
            f_p=named_vector("pretension", f_p, actuators, upper=MAX_PRETENSION),
            limit_bandwidth=limit_bandwidth,
        )
        self.reset()

    def set_gains(self, kp: ArrayLike, kd: ArrayLike) -> None:
        """Change the gains.

        Args:
            kp: Position gain, a number or shape (k,), in [1/s²].
            kd: Velocity gain, a number or shape (k,), in [1/s].

        Raises:
            InputError: kp is not positive, kd is negative, or the number of gains is wrong.
        """
        self.kp = named_vector("kp", kp, self.dynamics.task_names, above=0.0)
        self.kd = named_vector("kd", kd, self.dynamics.task_names)
        self._law.write(kp=self.kp, kd=self.kd)

    def set_bounds(self, f_min: ArrayLike, f_max: ArrayLike) -> None:
        """Change the force limits.

        Args:
            f_min: Lower limits, shape (a,), in [N] for muscles and [N·m] for motors.
            f_max: Upper limits, shape (a,), in [N] for muscles and [N·m] for motors; may be
                infinite.

        Raises:
            InputError: A limit is invalid; the message names the muscle or motor.
        """
        names, motors = actuator_names(self.dynamics), len(self.dynamics.motor_names)
        self.f_min, self.f_max = force_bounds(names, f_min, f_max, motors)
        self._law.write(f_min=self.f_min, f_max=self.f_max)

    def reset(self) -> None:
        """Discard the last forces and the warm starts of the solvers."""
        self._law.reset()

    def get_state(self) -> FloatArray:
        """Return the state of the controller: the last forces and the solver warm starts."""
        return self._law["memory"].copy()

    def set_state(self, state: FloatArray) -> None:
        """Restore a state from `get_state`, so that the following solutions repeat bit for bit.

        Raises:
            InputError: The state has another length or is not finite.
        """
        self._law.restore("memory", state, "controller")

    def error(self, q: FloatArray, y_d: FloatArray) -> FloatArray:
        """Return y_d - y, with angles wrapped to [-pi, pi), shape (k,), in [m] or [rad]."""
        return task_error(self.dynamics, q, y_d)

    def build_problem(
        self,
        q: FloatArray,
        qd: FloatArray,
        y_d: FloatArray,
        yd_d: FloatArray,
        ydd_d: FloatArray,
        w_e: FloatArray | None = None,
    ) -> qpsolvers.Problem:
        """Return the QP of eq. (4) for the tasks of the highest priority, over [qdd, f, s].

        s are the errors of tasks with finite weights. See `solve` for the arguments.
        """
        self._write(w_e, None, q, qd, y_d, yd_d, ydd_d)
        return self._law.build()

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
        """Compute and check the forces of eq. (4).

        If the tasks are infeasible, they are violated, starting with the lowest priority. The
        equation of motion is never violated.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            y_d: Desired task coordinates, shape (k,), in [m] or [rad].
            yd_d: Desired task velocities, shape (k,).
            ydd_d: Desired task accelerations, shape (k,), in [m/s²] or [rad/s²].
            w_e: Generalised external load on the left of the equation of motion, shape (n,), in
                [N·m] or [N], or None.
            correction: Vector to add to the commanded task acceleration, shape (k,), in [m/s²] or
                [rad/s²], or None.

        Raises:
            InputError: The length of a vector is wrong.
            SimulationError: The state or the reference is not finite.
        """
        robot = self.dynamics
        check_sizes(robot.coordinate_names, q=q, qd=qd, w_e=w_e)
        check_sizes(robot.task_names, y_d=y_d, yd_d=yd_d, ydd_d=ydd_d, correction=correction)
        self._write(w_e, correction, q, qd, y_d, yd_d, ydd_d)
        status = self._law.solve(self.solver)
        if status == law_in_c.WRONG:
            raise SimulationError("the state or the reference of the controller is not finite")
        if status == law_in_c.FAILED:
            raise SimulationError(
                "no forces within the limits produce the required motion: the QP failed"
            )
        law = self._law
        return OperationalSpaceSolution(
            law["forces"].copy(),
            STATUSES[status],
            law["slack"].copy(),
            self.f_min.copy(),
            self.f_max.copy(),
            robot.task_names,
            actuator_names(robot),
            law["qdd"].copy(),
            bool(law["limits_dropped"][0]),
        )

    def _write(
        self, w_e: FloatArray | None, correction: FloatArray | None, *state: FloatArray
    ) -> None:
        q, qd, y_d, yd_d, ydd_d = state
        robot = self.dynamics
        J = robot.task_jacobian(q)
        self._law.write(
            M=robot.mass_matrix(q),
            h=bias_torque(robot, q, qd),
            L=robot.actuator_jacobian(q),
            J=J,
            bias=robot.task_bias(q, qd),
            error=self.error(q, y_d),
            rate_error=yd_d - J @ qd,
            acceleration=ydd_d,
            q=q,
            qd=qd,
            load=w_e,
            correction=correction,
            q_min=robot.q_min,
            q_max=robot.q_max,
        )

    def _set_posture(self, posture: Posture | None) -> None:
        names = self.dynamics.coordinate_names
        chosen = Posture(kd=0.0) if posture is None else posture
        kp, kd = named_vector("posture kp", chosen.kp, names), chosen.kd
        if chosen.q0 is None and kp.any():
            raise InputError("a posture with a positive kp requires q0")
        q0 = np.zeros(len(names)) if chosen.q0 is None else chosen.q0
        q0 = finite_vector("posture q0", q0, len(names))
        self._law.write(posture_kp=kp, posture_kd=named_vector("posture kd", kd, names), q0=q0)

    def _check_priorities(self, priorities: ArrayLike | None) -> FloatArray:
        tasks = self.dynamics.task_names
        k = len(tasks)
        values = np.ones(k) if priorities is None else float_array("priorities", priorities)
        if values.shape != (k,) or not (np.isfinite(values).all() and (values >= 1).all()):
            raise InputError(
                f"priorities must be {k} finite numbers of at least 1, for {', '.join(tasks)}"
            )
        return values
