"""Multiple shooting: the quadratic program of a step, with a fixed sparsity pattern."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, diags, vstack

from controllers.arrays import BoolArray, FloatArray, IntArray

from .convexity import ConvexStages, Program, convexify_with_share, positive_part
from .costs import CostTerms
from .linear import LinearConstraint
from .problem import IntervalResult, Iterate, NodeConstraint, OptimalProblem, excess
from .qp import QpSolution, QuadraticProgram
from .relaxation import solve_relaxed
from .sparse_pattern import SparsePattern
from .stages import StageHessian

_MAX_DURATION_CHANGE = 0.5  # per iteration, relative
_PENALTY = 10.0  # of a relaxed constraint, relative to the largest gradient
_UNLIMITED = 100.0  # scale of controls without a range, such as forces in [N]
_FIXED = 1e3  # curvature of fixed values, which does not change the solution


class Linearisation(NamedTuple):
    """Terms of a problem at an iterate.

    Attributes:
        ends: States at the ends of the intervals, shape (N, nx).
        by_stages: Scaled derivatives of the ends by states, controls and globals, (N, nx, nz).
        gaps: Ends of the intervals minus states at the next nodes, shape (N, nx).
        values: Values of each node constraint, shape (k, r), then of each linear one, shape (r,).
        jacobians: Derivatives of the node constraints by the states, shape (k, r, nx); inside
            intervals, by states, controls and globals, shape (k, r, nz).
        terms: Gradient and Hessian of the cost.
        cost: The cost.
    """

    ends: FloatArray
    by_stages: FloatArray
    gaps: FloatArray
    values: list[FloatArray]
    jacobians: list[FloatArray]
    terms: CostTerms
    cost: float


class Transcription:
    """Quadratic programs of a problem. Variables: x0, u0, x1, u1, ..., xN, and the globals g.

    Globals are the free parameters and, if it is free, the duration. All variables are divided by
    a scale: states, parameters and durations by 1 or their range, controls by half of their range
    or 100.

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
        self._z: IntArray = np.concatenate([self._x[:-1], self._u], axis=1)
        self._scales()
        self._fixed: BoolArray = problem.x_low == problem.x_high
        self._A = self._equality_pattern()
        self._hessian = StageHessian(problem, self._x, self._u, self._g, self._z_scale)
        self._C = [self._constraint_pattern(c) for c in problem.constraints]
        equal = [c.low == c.high for c in problem.constraints]
        self._is_equal = [np.tile(row, len(c.nodes)) for row, c in zip(equal, problem.constraints)]  # noqa: B905
        self._is_equal += [c.low == c.high for c in problem.linear]
        self._linear = [self._linear_rows(c) for c in problem.linear]

    def _scales(self) -> None:
        problem = self.problem
        half = 0.5 * (problem.u_high - problem.u_low).max(axis=0)
        self.u_scale: FloatArray = np.where(np.isfinite(half) & (half > 0.0), half, _UNLIMITED)
        reach = np.maximum(abs(problem.x_low), abs(problem.x_high))
        reach = np.where(np.isfinite(reach), reach, 0.0).max(axis=0)
        self.x_scale: FloatArray = np.clip(reach, 1.0, 10.0)
        self.t_scale = problem.duration[1]
        self.scale = np.ones(self.size)
        self.scale[self._x], self.scale[self._u] = self.x_scale, self.u_scale
        self.scale[self._g[: self._np]] = problem.parameters.scale
        if self._has_time:
            self.scale[-1] = self.t_scale
        self._z_scale = np.concatenate([self.x_scale, self.u_scale, self.scale[self._g]])

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

    def _constraint_pattern(self, constraint: NodeConstraint) -> SparsePattern:
        count, r = len(constraint.nodes), len(constraint.low)
        row, columns = np.arange(count * r).reshape(count, r, 1), self._x[constraint.nodes]
        if constraint.shares is not None:
            g = np.tile(self._g, (count, 1))
            columns = np.concatenate([self._z[constraint.nodes], g], axis=1)
        shape = (count, r, columns.shape[1])
        rows, columns = np.broadcast_to(row, shape), np.broadcast_to(columns[:, None, :], shape)
        return SparsePattern([rows], [columns], (count * r, self.size))

    def _linear_rows(self, constraint: LinearConstraint) -> csr_matrix:
        """Return the rows of a linear constraint for the scaled variables."""
        parts = [(constraint.states, self._x.ravel()), (constraint.controls, self._u.ravel())]
        if self._has_time:
            parts.append((csr_matrix(constraint.duration[:, None]), self._g[-1:]))
        rows = csc_matrix((len(constraint.low), self.size))
        for matrix, columns in parts:
            ones, shape = np.ones(len(columns)), (len(columns), self.size)
            rows = rows + matrix @ csr_matrix((ones, (np.arange(len(columns)), columns)), shape)
        return csr_matrix(rows @ diags(self.scale))

    def _values(self, at: Iterate, of_nodes: list[FloatArray]) -> list[FloatArray]:
        """Return the values of node constraints, followed by those of linear constraints."""
        return of_nodes + [c.value(at.x, at.u, at.duration) for c in self.problem.linear]

    def linearise(self, at: Iterate) -> Linearisation | None:
        """Return all terms at an iterate; None if a state diverged."""
        problem = self.problem
        intervals = problem.run(at)
        if intervals is None:
            return None
        pairs = []
        for constraint in problem.constraints:
            pair = self._constraint(constraint, at)
            if pair is None:
                return None
            pairs.append(pair)
        return Linearisation(
            intervals.ends,
            self._by_stages(intervals) / self.x_scale[:, None] * self._z_scale,
            intervals.ends - at.x[1:],
            self._values(at, [values for values, _ in pairs]),
            [jacobian for _, jacobian in pairs],
            problem.costs.terms(at.x, at.u, at.duration),
            problem.cost(at),
        )

    def _constraint(
        self, constraint: NodeConstraint, at: Iterate, derivatives: bool = True
    ) -> tuple[FloatArray, FloatArray] | None:
        """Return the values and derivatives of a constraint; None if a state diverged."""
        if constraint.shares is None:
            return constraint.evaluate(at.x[constraint.nodes])
        parts = self.problem.run_inside(at, constraint.nodes, constraint.shares, derivatives)
        if parts is None:
            return None
        values, jacobian = constraint.evaluate(parts.ends)
        if derivatives:
            jacobian = jacobian @ self._by_stages(parts, constraint.shares[:, None])
        return values, jacobian

    def program(
        self,
        at: Iterate,
        linearised: Linearisation,
        damping: float,
        of_dynamics: FloatArray,
        positive: float,
    ) -> Program:
        """Return the quadratic program of a step from an iterate, in scaled variables.

        The Hessian is that of the Lagrangian with the largest share of the dynamics with which the
        program is convex.

        Args:
            at: The iterate.
            linearised: Terms at the iterate.
            damping: Number that is added to the diagonal of the Hessian, relative to `cost_scale`.
            of_dynamics: Hessians of the multiplied ends of the intervals by their scaled states,
                controls and globals, shape (N, nz, nz).
            positive: Share of the positive part of `of_dynamics` that is used if the program is
                convex with none of their shares.
        """
        per_cost = 1.0 / self.cost_scale(linearised.terms)
        g = self.gradient(at, linearised.terms) * per_cost
        blocks, moved = self._hessian.blocks(linearised.terms) * per_cost, None
        convex = self._with_dynamics(linearised, blocks, of_dynamics * per_cost)
        if convex is not None:
            blocks, moved = convex.blocks, convex.moved
            g[self._z] += convex.gradients[:, : self._width]
            g[self._g] += convex.gradients[:, self._width :].sum(axis=0)
        elif positive:
            blocks[:-1] += positive * per_cost * positive_part(of_dynamics)
        P = self._hessian.matrix(blocks, linearised.terms, per_cost, damping)
        A, b = self._equalities(at, linearised)
        C, low, high = self._inequalities(linearised)
        equal = np.concatenate([*self._is_equal, np.empty(0, dtype=bool)])
        if equal.any():
            A, b = vstack([A, C[equal]], format="csc"), np.concatenate([b, low[equal]])
            C, low, high = C[~equal], low[~equal], high[~equal]
        qp = QuadraticProgram(P, g, A, b, C, low, high, *self._bounds(at))
        return Program(qp, moved)

    def _with_dynamics(
        self, linearised: Linearisation, blocks: FloatArray, of_dynamics: FloatArray
    ) -> ConvexStages | None:
        """Return convex stages with a share of the dynamics; None if there are none."""
        if not of_dynamics.any():
            return None
        blocks, nx = blocks.copy(), self._nx
        np.einsum("kii->ki", blocks)[:, :nx] += _FIXED * self._fixed
        for constraint, jacobian in zip(
            self.problem.constraints, linearised.jacobians, strict=True
        ):
            J = (jacobian[..., :nx] * self.x_scale)[:, constraint.low == constraint.high]
            blocks[constraint.nodes, :nx, :nx] += _FIXED * np.einsum("kri,krj->kij", J, J)
        ends, gaps = linearised.by_stages, linearised.gaps / self.x_scale
        free = np.concatenate([np.flatnonzero(~self._fixed[0]), nx + np.arange(len(self._g))])
        return convexify_with_share(blocks, of_dynamics, ends, gaps, self._nu, free)

    def _equalities(self, at: Iterate, linearised: Linearisation) -> tuple[csc_matrix, FloatArray]:
        nx, nz, ends = self._nx, self._width, linearised.by_stages
        parts = ends[:, :, :nx], ends[:, :, nx:nz], -np.ones((self._N, nx)), ends[:, :, nz:]
        count = int(self._fixed.sum())
        A = self._A.fill(*parts, np.ones(count))
        rest = (self.problem.x_low - at.x) / self.x_scale
        return A, np.concatenate([(-linearised.gaps / self.x_scale).ravel(), rest[self._fixed]])

    def _by_stages(self, intervals: IntervalResult, shares: FloatArray | float = 1.0) -> FloatArray:
        """Return the derivatives of k ends by states, controls and globals, shape (k, nx, nz)."""
        parts = [intervals.A, intervals.B] + ([intervals.D] if self._np else [])
        if self._has_time:
            parts.append((shares * intervals.c)[:, :, None] / self._N)
        return np.concatenate(parts, axis=2)

    def _inequalities(self, linearised: Linearisation) -> tuple[csc_matrix, FloatArray, FloatArray]:
        """Return the rows of all constraints with their bounds."""
        rows: list[csc_matrix | csr_matrix] = []
        low, high = [np.empty(0)], [np.empty(0)]
        triples = zip(self.problem.constraints, self._C, linearised.values, linearised.jacobians)  # noqa: B905
        for constraint, pattern, values, jacobian in triples:
            rows.append(pattern.fill(jacobian * self._z_scale[: jacobian.shape[2]]))
            low.append((constraint.low - values).ravel())
            high.append((constraint.high - values).ravel())
        rest = zip(self.problem.linear, self._linear, linearised.values[len(rows) :], strict=True)
        for linear, matrix, value in rest:
            rows.append(matrix)
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
        parameters, p = problem.parameters, self._g[: self._np]
        lb[p], ub[p] = parameters.low - at.parameters, parameters.high - at.parameters
        if self._has_time:
            lb[-1], ub[-1] = np.array(problem.duration) - at.duration
            reach = _MAX_DURATION_CHANGE * at.duration
            lb[-1], ub[-1] = max(lb[-1], -reach), min(ub[-1], reach)
        return lb / self.scale, ub / self.scale

    def globals_of(self, d: FloatArray) -> FloatArray:
        """Return the scaled free parameters and duration among variables, shape (ng,)."""
        return d[self._g]

    def solve_relaxed(self, qp: QuadraticProgram) -> QpSolution:
        """Solve a program in which all but dynamics, start and controls may be violated."""
        soft = np.zeros(self.size, dtype=bool)
        soft[self._x] = True
        hard_rows = int(self._N * self._nx + self._fixed[0].sum())
        weight = _PENALTY * max(float(abs(qp.g).max()), 1.0)
        return solve_relaxed(qp, hard_rows, soft, weight)

    def cost_scale(self, terms: CostTerms) -> float:
        """Return the size of the Hessian, or of the gradient by the duration, per interval."""
        uu = float((terms.uu * self.u_scale**2).mean())
        time = abs(terms.gt) * self.t_scale / self._N if self._has_time else 0.0
        return max(uu, time) or 1.0

    def stages(self, at: Iterate) -> FloatArray:
        """Return the scaled states, controls and globals of each interval, shape (N, nz)."""
        g = np.append(at.parameters, at.duration) if self._has_time else at.parameters
        parts = at.x[:-1], at.u, np.tile(g, (self._N, 1))
        return np.asarray(np.concatenate(parts, axis=1) / self._z_scale)

    def multipliers(
        self, linearised: Linearisation, program: Program, step: QpSolution
    ) -> FloatArray:
        """Return the multipliers of the scaled dynamics from those of a program, shape (N, nx)."""
        y = step.y[: linearised.gaps.size].reshape(linearised.gaps.shape)
        if program.moved is not None:
            x, g = step.d[self._x], np.tile(step.d[self._g], (self._N + 1, 1))
            s = np.concatenate([x, g], axis=1)
            y = y + np.einsum("kij,kj->ki", program.moved, s)[1:, : self._nx]
        return np.asarray(y * self.cost_scale(linearised.terms))

    def stage_gradients(self, linearised: Linearisation, multipliers: FloatArray) -> FloatArray:
        """Return the gradients of the multiplied ends by the scaled stages, shape (N, nz)."""
        return np.asarray(np.einsum("ki,kij->kj", multipliers, linearised.by_stages))

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
        pairs = [self._constraint(c, at, derivatives=False) for c in problem.constraints]
        if any(pair is None for pair in pairs):
            return None
        values = self._values(at, [pair[0] for pair in pairs if pair is not None])
        gaps = intervals.ends - at.x[1:]
        violation = sum(float(v.sum()) for v in self.violations(at, gaps, values))
        return violation, problem.cost(at)

    def move(self, at: Iterate, d: FloatArray, share: float) -> Iterate:
        """Return the iterate after a share of a step d, which is in scaled variables."""
        step = share * d * self.scale
        time = at.duration + (step[-1] if self._has_time else 0.0)
        p = at.parameters + step[self._g[: self._np]]
        return self.problem.clip(Iterate(at.x + step[self._x], at.u + step[self._u], time, p))

    def violation(self, at: Iterate, linearised: Linearisation) -> float:
        """Return the sum of all scaled violations of the constraints."""
        return sum(float(v.sum()) for v in self.violations(at, linearised.gaps, linearised.values))

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
        others = [excess(value, *bound) for bound, value in zip(bounds, values, strict=True)]
        return [abs(gaps) / self.x_scale, beyond, *others]
