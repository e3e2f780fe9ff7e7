"""Multiple shooting: the quadratic program of a step, with a fixed sparsity pattern."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, diags, vstack

from controllers.arrays import BoolArray, FloatArray, IntArray

from .costs import CostTerms
from .linear import LinearConstraint
from .problem import IntervalResult, Iterate, NodeConstraint, OptimalProblem
from .qp import QuadraticProgram
from .sparse_pattern import SparsePattern

_MIN_DURATION_CHANGE = 1e-9  # for a secant, relative
_MAX_DURATION_CHANGE = 0.5  # per iteration, relative


class Linearisation(NamedTuple):
    """Terms of a problem at an iterate.

    Attributes:
        intervals: Intervals with derivatives.
        gaps: Ends of the intervals minus states at the next nodes, shape (N, nx).
        values: Values of each node constraint, shape (k, r), then of each linear one, shape (r,).
        jacobians: Derivatives of the node constraints, shape (k, r, nx).
        terms: Gradient and Hessian of the cost.
        cost: The cost.
    """

    intervals: IntervalResult
    gaps: FloatArray
    values: list[FloatArray]
    jacobians: list[FloatArray]
    terms: CostTerms
    cost: float


class Transcription:
    """Quadratic programs of a problem. Variables: x0, u0, x1, u1, ..., xN, and the globals g.

    Globals are the free parameters and, if it is free, the duration. All variables are divided by
    a scale: states, parameters and durations by 1 or their range, controls by half of their range.

    Args:
        problem: The problem.
    """

    def __init__(self, problem: OptimalProblem) -> None:
        self.problem = problem
        N, nu = problem.u_low.shape
        nx = problem.x_low.shape[1]
        self._N, self._nx, self._nu, self._width = N, nx, nu, nx + nu
        self._has_time = problem.is_free_time
        self._np = len(problem.parameters)
        stages = N * self._width + nx
        self.size = stages + self._np + int(self._has_time)
        self._g: IntArray = np.arange(stages, self.size)
        node = np.arange(N + 1)[:, None] * self._width
        self._x: IntArray = node + np.arange(nx)
        self._u: IntArray = node[:-1] + nx + np.arange(nu)
        self._scales()
        self._fixed: BoolArray = problem.x_low == problem.x_high
        self._A, self._P = self._equality_pattern(), self._hessian_pattern()
        self._C = [self._constraint_pattern(own) for own in problem.constraints]
        equal = [own.low == own.high for own in problem.constraints]
        self._is_equal = [np.tile(row, len(c.nodes)) for row, c in zip(equal, problem.constraints)]  # noqa: B905
        self._is_equal += [own.low == own.high for own in problem.linear]
        self._linear = [self._linear_rows(own) for own in problem.linear]

    def _scales(self) -> None:
        problem = self.problem
        half = 0.5 * (problem.u_high - problem.u_low).max(axis=0)
        self.u_scale: FloatArray = np.where(np.isfinite(half) & (half > 0.0), half, 1.0)
        reach = np.maximum(abs(problem.x_low), abs(problem.x_high))
        reach = np.where(np.isfinite(reach), reach, 0.0).max(axis=0)
        self.x_scale: FloatArray = np.clip(reach, 1.0, 10.0)
        self.t_scale = problem.duration[1]
        self.scale = np.ones(self.size)
        self.scale[self._x], self.scale[self._u] = self.x_scale, self.u_scale
        self.scale[self._g[: self._np]] = problem.parameters.scale
        if self._has_time:
            self.scale[-1] = self.t_scale

    def _equality_pattern(self) -> SparsePattern:
        N, nx, nu = self._N, self._nx, self._nu
        gap, ng = np.arange(N * nx).reshape(N, nx), len(self._g)
        rows = [
            np.broadcast_to(gap[:, :, None], (N, nx, nx)),
            np.broadcast_to(gap[:, :, None], (N, nx, nu)),
            gap,
            np.broadcast_to(gap[:, :, None], (N, nx, ng)),
        ]
        columns = [
            np.broadcast_to(self._x[:-1, None, :], (N, nx, nx)),
            np.broadcast_to(self._u[:, None, :], (N, nx, nu)),
            self._x[1:],
            np.broadcast_to(self._g, (N, nx, ng)),
        ]
        fixed = self._x[self._fixed]
        rows.append(N * nx + np.arange(len(fixed)))
        columns.append(fixed)
        return SparsePattern(rows, columns, (N * nx + len(fixed), self.size))

    def _hessian_pattern(self) -> SparsePattern:
        own = np.concatenate([self._x.ravel(), self._u.ravel()])
        before, after = self._u[:-1].ravel(), self._u[1:].ravel()
        rows, columns = [own, before, after, self._g], [own, after, before, self._g]
        costs, nx = self.problem.costs, self._nx
        self._has_state_rates, self._has_dense = bool(costs.state_rates.any()), bool(costs.nodes)
        if self._has_state_rates:
            rows += [self._x[:-1].ravel(), self._x[1:].ravel()]
            columns += [self._x[1:].ravel(), self._x[:-1].ravel()]
        if self._has_dense:
            i, j = np.nonzero(~np.eye(nx, dtype=bool))
            rows.append(self._x[:, i].ravel())
            columns.append(self._x[:, j].ravel())
        if self._has_time:
            final = np.full(len(own), self.size - 1)
            rows += [own, final]
            columns += [final, own]
        return SparsePattern(rows, columns, (self.size, self.size))

    def _constraint_pattern(self, own: NodeConstraint) -> SparsePattern:
        count, r = len(own.nodes), len(own.low)
        row = np.arange(count * r).reshape(count, r, 1)
        shape = (count, r, self._nx)
        rows = np.broadcast_to(row, shape)
        columns = np.broadcast_to(self._x[own.nodes][:, None, :], shape)
        return SparsePattern([rows], [columns], (count * r, self.size))

    def _linear_rows(self, own: LinearConstraint) -> csr_matrix:
        """Return the rows of a linear constraint for the scaled variables."""
        parts = [(own.states, self._x.ravel()), (own.controls, self._u.ravel())]
        if self._has_time:
            parts.append((csr_matrix(own.duration[:, None]), self._g[-1:]))
        rows = csc_matrix((len(own.low), self.size))
        for part, columns in parts:
            ones, shape = np.ones(len(columns)), (len(columns), self.size)
            rows = rows + part @ csr_matrix((ones, (np.arange(len(columns)), columns)), shape)
        return csr_matrix(rows @ diags(self.scale))

    def _values(self, at: Iterate, found: list[FloatArray]) -> list[FloatArray]:
        """Return the values of node constraints, followed by those of linear constraints."""
        return found + [own.value(at.x, at.u, at.duration) for own in self.problem.linear]

    def linearise(self, at: Iterate) -> Linearisation | None:
        """Return all terms at an iterate; None if a state diverged."""
        problem = self.problem
        intervals = problem.run(at)
        if intervals is None:
            return None
        found = [own.evaluate(at.x[own.nodes]) for own in problem.constraints]
        return Linearisation(
            intervals,
            intervals.ends - at.x[1:],
            self._values(at, [values for values, _ in found]),
            [jacobian for _, jacobian in found],
            problem.costs.terms(at.x, at.u, at.duration),
            problem.cost(at),
        )

    def program(
        self, at: Iterate, own: Linearisation, damping: float, curvature: float = 0.0
    ) -> QuadraticProgram:
        """Return the quadratic program of a step from an iterate, in scaled variables.

        Args:
            at: The iterate.
            own: Terms at the iterate.
            damping: Number that is added to the diagonal of the Hessian, relative to `cost_scale`.
            curvature: From `duration_curvature`.
        """
        per_cost = 1.0 / self.cost_scale(own.terms)
        terms = own.terms._replace(tt=own.terms.tt + curvature)
        P = self._hessian(terms, damping / per_cost) * per_cost
        g = self.gradient(at, own.terms) * per_cost
        A, b = self._equalities(at, own)
        C, low, high = self._inequalities(own)
        equal = np.concatenate([*self._is_equal, np.empty(0, dtype=bool)])
        A = vstack([A, C[equal]], format="csc")
        b = np.concatenate([b, low[equal]])
        lb, ub = self._bounds(at)
        return QuadraticProgram(P, g, A, b, C[~equal], low[~equal], high[~equal], lb, ub)

    def _hessian(self, t: CostTerms, damping: float) -> csc_matrix:
        s = self.scale
        own = np.concatenate([self._x.ravel(), self._u.ravel()])
        entries = [np.concatenate([t.xx.ravel(), t.uu.ravel()]) * s[own] ** 2 + damping]
        coupled = t.uv * self.u_scale**2
        of_globals = 2.0 * self.problem.parameters.weights
        if self._has_time:
            of_globals = np.append(of_globals, t.tt)
        entries += [coupled, coupled, of_globals * s[self._g] ** 2 + damping]
        if self._has_state_rates:
            coupled = t.xv * self.x_scale**2
            entries += [coupled, coupled]
        if self._has_dense:
            i, j = np.nonzero(~np.eye(self._nx, dtype=bool))
            entries.append(t.dense[:, i, j] * self.x_scale[i] * self.x_scale[j])
        if self._has_time:
            across = np.concatenate([t.xt.ravel(), t.ut.ravel()]) * s[own] * s[-1]
            entries += [across, across]
        return self._P.fill(*entries)

    def _equalities(self, at: Iterate, own: Linearisation) -> tuple[csc_matrix, FloatArray]:
        N, intervals, per_row = self._N, own.intervals, 1.0 / self.x_scale[:, None]
        parts = [
            intervals.A * per_row * self.x_scale,
            intervals.B * per_row * self.u_scale,
            -np.ones((N, self._nx)),
            self._by_globals(intervals) * per_row * self.scale[self._g],
        ]
        count = int(self._fixed.sum())
        A = self._A.fill(*parts, np.ones(count))
        rest = (self.problem.x_low - at.x) / self.x_scale
        return A, np.concatenate([(-own.gaps / self.x_scale).ravel(), rest[self._fixed]])

    def _by_globals(self, intervals: IntervalResult) -> FloatArray:
        """Return the derivatives of the ends by the globals, shape (N, nx, ng)."""
        by_time = intervals.c[:, :, None] / self._N
        parts = ([intervals.D] if self._np else []) + ([by_time] if self._has_time else [])
        return np.concatenate([*parts, np.empty((self._N, self._nx, 0))], axis=2)

    def _inequalities(self, own: Linearisation) -> tuple[csc_matrix, FloatArray, FloatArray]:
        """Return the rows of all constraints with their bounds."""
        rows: list[csc_matrix | csr_matrix] = []
        low, high = [np.empty(0)], [np.empty(0)]
        triples = zip(self.problem.constraints, self._C, own.values, own.jacobians)  # noqa: B905
        for constraint, pattern, values, jacobian in triples:
            rows.append(pattern.fill(jacobian * self.x_scale))
            low.append((constraint.low - values).ravel())
            high.append((constraint.high - values).ravel())
        rest = zip(self.problem.linear, self._linear, own.values[len(rows) :], strict=True)
        for linear, part, value in rest:
            rows.append(part)
            low.append(linear.low - value)
            high.append(linear.high - value)
        if not rows:
            empty = csc_matrix((0, self.size))
            return empty, low[0], high[0]
        return vstack(rows, format="csr"), np.concatenate(low), np.concatenate(high)

    def _bounds(self, at: Iterate) -> tuple[FloatArray, FloatArray]:
        problem = self.problem
        lb, ub = np.empty(self.size), np.empty(self.size)
        lb[self._x], ub[self._x] = problem.x_low - at.x, problem.x_high - at.x
        lb[self._x[self._fixed]], ub[self._x[self._fixed]] = -np.inf, np.inf
        lb[self._u], ub[self._u] = problem.u_low - at.u, problem.u_high - at.u
        own, p = problem.parameters, self._g[: self._np]
        lb[p], ub[p] = own.low - at.parameters, own.high - at.parameters
        if self._has_time:
            lb[-1], ub[-1] = np.array(problem.duration) - at.duration
            reach = _MAX_DURATION_CHANGE * at.duration
            lb[-1], ub[-1] = max(lb[-1], -reach), min(ub[-1], reach)
        return lb / self.scale, ub / self.scale

    @property
    def state_indices(self) -> IntArray:
        """Indices of the states among the variables, shape (N + 1, nx)."""
        return self._x

    @property
    def hard_rows(self) -> int:
        """Number of equalities of the dynamics and of the start, which come first."""
        return int(self._N * self._nx + self._fixed[0].sum())

    def cost_scale(self, terms: CostTerms) -> float:
        """Return the size of the Hessian, or of the gradient by the duration, per interval."""
        uu = float((terms.uu * self.u_scale**2).mean())
        time = abs(terms.gt) * self.t_scale / self._N if self._has_time else 0.0
        return max(uu, time) or 1.0

    def duration_curvature(
        self, before: Iterate, old: Linearisation, after: Iterate, new: Linearisation, y: FloatArray
    ) -> float:
        """Return the curvature by the duration that the Hessian of the cost lacks, at least 0.

        It is the secant of the Lagrangian along a step, since the dynamics depend on products of
        the duration with states and controls.

        Args:
            before: Iterate before the step.
            old: Its terms.
            after: Iterate after the step.
            new: Its terms.
            y: Multipliers of the equalities of the step.
        """
        change, t = after.duration - before.duration, old.terms
        if abs(change) < _MIN_DURATION_CHANGE * before.duration:
            return 0.0
        force = y[: old.gaps.size].reshape(old.gaps.shape) * self.cost_scale(t) / self.x_scale
        slope = new.terms.gt - t.gt + (force * (new.intervals.c - old.intervals.c)).sum() / self._N
        modelled = (t.xt * (after.x - before.x)).sum() + (t.ut * (after.u - before.u)).sum()
        return max(float((slope - modelled) / change) - t.tt, 0.0)

    def gradient(self, at: Iterate, terms: CostTerms) -> FloatArray:
        """Return the gradient of the cost by the scaled variables."""
        g = np.zeros(self.size)
        g[self._x], g[self._u] = terms.gx, terms.gu
        g[self._g[: self._np]] = self.problem.parameters.gradient(at.parameters)
        if self._has_time:
            g[-1] = terms.gt
        return g * self.scale

    def evaluate(self, at: Iterate) -> tuple[float, float] | None:
        """Return the sum of violations and the cost of an iterate; None if a state diverged."""
        problem = self.problem
        intervals = problem.run(at, derivatives=False)
        if intervals is None:
            return None
        values = [own.evaluate(at.x[own.nodes])[0] for own in problem.constraints]
        values, gaps = self._values(at, values), intervals.ends - at.x[1:]
        return self._total(self.violations(at, gaps, values)), problem.cost(at)

    def move(self, at: Iterate, d: FloatArray, share: float) -> Iterate:
        """Return the iterate after a share of a step d, which is in scaled variables."""
        step = share * d * self.scale
        time = at.duration + (step[-1] if self._has_time else 0.0)
        p = at.parameters + step[self._g[: self._np]]
        return self.problem.clip(Iterate(at.x + step[self._x], at.u + step[self._u], time, p))

    def violation(self, at: Iterate, own: Linearisation) -> float:
        """Return the sum of all scaled violations of the constraints."""
        return self._total(self.violations(at, own.gaps, own.values))

    def _total(self, violations: list[FloatArray]) -> float:
        return float(sum(float(part.sum()) for part in violations))

    def violations(
        self, at: Iterate, gaps: FloatArray, values: list[FloatArray]
    ) -> list[FloatArray]:
        """Return by how much each constraint is violated, scaled.

        Returns:
            Of the dynamics, shape (N, nx); of the bounds of states, shape (N + 1, nx); of each node
            constraint, shape (k, r), and of each linear one, shape (r,).
        """
        problem = self.problem
        beyond = excess(at.x, problem.x_low, problem.x_high) / self.x_scale
        bounds = [(each.low, each.high) for each in problem.constraints]
        bounds += [(each.low, each.high) for each in problem.linear]
        own = [excess(value, *bound) for bound, value in zip(bounds, values, strict=True)]
        return [abs(gaps) / self.x_scale, beyond, *own]


def excess(values: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the distance of values from a range, 0 inside."""
    return np.maximum(np.maximum(low - values, values - high), 0.0)
