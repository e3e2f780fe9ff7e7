"""Splines that a robot can track within joint limits, speeds and force limits."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import CardsflowError, Robot
from cardsflow_fmu.results.analysis.first_motion import assumed_force, robot_size
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.inverse_dynamics import Motion, MotionTerms, motion_terms
from sim_dart import control_dynamics
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.estimation.estimated_robot import passive_muscles

from .spline import GRID, KNOTS, ORDER, PER_SPAN, basis

_MARGIN = 0.05
"""Margin to upper force limits and joint limits, as fraction of the range."""

_AT_BOUND = 0.7
"""Fraction of proposals, and of their coordinates, at limits, where the information is largest."""

_SCALE = 0.8
_ROW_STRIDE = 4

_SLIDE = 0.3
"""Ratio of sliding and rotational speed, as fraction of the robot size."""

_UNLIMITED_RANGE = 1.5
"""Maximum distance from the start, in [rad], or as fraction of the robot size."""


class Motions:
    """Motions that a robot can perform.

    Args:
        start: Pose at the begin and end, at rest.
        spans: Number of spans between knots.
        speed: Maximum speed, in [rad/s].
    """

    def __init__(self, robot: Robot, start: FloatArray, spans: int, speed: float) -> None:
        self.robot, self.start, self.spans = robot, start, spans
        self.dynamics: CoreDynamics = control_dynamics(robot)
        turns = np.array([c.unit == "rad" for c in robot.coordinates])
        size = robot_size(robot)
        self._step = KNOTS * speed * np.where(turns, 1.0, _SLIDE * size)
        default = _UNLIMITED_RANGE * np.where(turns, 1.0, size)
        low, high = np.array([(c.lower, c.upper) for c in robot.coordinates]).reshape(-1, 2).T
        joint_range = np.where(np.isfinite(high - low), high - low, 0.0)
        self._low = np.maximum(low + _MARGIN * joint_range, start - default)
        self._high = np.minimum(high - _MARGIN * joint_range, start + default)
        self._low, self._high = np.minimum(self._low, start), np.maximum(self._high, start)
        high_force = np.minimum(self.dynamics.f_max, assumed_force(robot))
        low_force = np.maximum(self.dynamics.f_min, -assumed_force(robot))
        self._bounds = low_force, high_force - _MARGIN * (high_force - low_force)
        self._basis = [basis(order) for order in range(3)]
        self.passive = passive_muscles(robot)
        self.motors = [k for k, c in enumerate(robot.coordinates) if c.actuated]

    @property
    def free(self) -> range:
        """Indices of the control points that are optimised."""
        return range(ORDER, self.spans)

    def at_rest(self) -> FloatArray:
        """Return control points of a robot at rest, shape (spans + 5, n)."""
        return np.tile(self.start, (self.spans + ORDER, 1))

    def propose(self, points: FloatArray, k: int, rng: np.random.Generator) -> FloatArray:
        """Draw a control point k within limits and speeds, often at a bound, shape (n,)."""
        near = points[[k - 1, k + 1]]
        low = np.maximum(self._low, near.max(axis=0) - self._step)
        high = np.minimum(self._high, near.min(axis=0) + self._step)
        low, share = np.minimum(low, high), rng.uniform(size=len(low))
        at_bound = rng.uniform(size=len(low)) < _AT_BOUND * (rng.uniform() < _AT_BOUND)
        return np.asarray(low + (high - low) * np.where(at_bound, np.round(share), share))

    def random_motion(self, rng: np.random.Generator) -> FloatArray:
        """Return control points of a random feasible motion."""
        points = self.at_rest()
        for k in self.free:
            points[k] = self.propose(points, k, rng)
        for k in reversed(self.free):  # limits the speed of the return to the start
            points[k] = np.clip(points[k], points[k + 1] - self._step, points[k + 1] + self._step)
        return self.make_feasible(points)

    def make_feasible(self, points: FloatArray) -> FloatArray:
        """Shrink a motion towards the start until it is feasible.

        Raises:
            CardsflowError: The muscles cannot hold the start with force margins.
        """
        for _ in range(40):
            if np.isfinite(self.whole(points)[1]).all():
                return points
            points = self.scale_down(points)
        raise CardsflowError(
            f"robot {self.robot.name!r}: the muscles hold the start pose with less than "
            f"{100 * _MARGIN:g} % force margin; no motion is possible"
        )

    def scale_down(self, points: FloatArray) -> FloatArray:
        """Return the motion scaled towards the start."""
        return np.asarray(self.start + _SCALE * (points - self.start))

    def rows(self, points: FloatArray, span: int, first: int, count: int) -> Motion:
        """Return rows of the motion on the grid.

        Args:
            first: First row, counted from the begin of the span.
        """
        at = first + np.arange(count)
        which = np.minimum(span + at // PER_SPAN, self.spans - 1)
        inside = at - (which - span) * PER_SPAN
        around = points[which[:, None] + np.arange(ORDER + 1)]
        q, qd, qdd = (np.einsum("tk,tkn->tn", B[inside], around) for B in self._basis)
        return Motion(np.asarray(span * KNOTS + GRID * at, np.float64), q, qd, qdd)

    def terms(self, points: FloatArray, spans: range) -> MotionTerms:
        """Return torques and Jacobians in spans, at selected rows of the grid."""
        m = self.rows(points, spans[0], 0, PER_SPAN * len(spans) + 1)
        some = slice(None, None, _ROW_STRIDE)
        return motion_terms(
            self.dynamics, Motion(m.times[some], m.q[some], m.qd[some], m.qdd[some])
        )

    def forces(self, terms: MotionTerms) -> FloatArray:
        """Return minimum forces within the limits, shape (T, m); NaN if infeasible."""
        return terms.with_bounds(*self._bounds).distribute().forces

    def whole(self, points: FloatArray) -> tuple[Motion, FloatArray]:
        """Return the motion on the grid, and its forces."""
        motion = self.rows(points, 0, 0, self.spans * PER_SPAN + 1)
        return motion, self.forces(motion_terms(self.dynamics, motion))
