"""Interior-point method for activations and tensions of muscles over a whole given motion.

The activations a at the frames, and the tensions of elastic tendons between frames, minimise the
integral over time of

    sum of e^p + sum of (r / R)^2

with the excitations e that change the activations, and reserve torques r with weights R. At each
frame, fibres are in equilibrium with their tendons, and the tensions f satisfy tau = -L'f + r.
Derivatives in time are central differences, whose error decreases with the square of the time step.
At both ends of the motion the activations are constant. First derivatives are exact; the linear
equations are those of `MuscleChains`.

De Groote, Kinney, Rao & Fregly 2016, Ann. Biomed. Eng. 44, introduced the tendon force as state.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from controllers.arrays import FloatArray

from .chains import ChainEquations, ChainSolution, MuscleChains
from .interior import BoundedVariables
from .problem import MuscleProblem, MuscleTrajectory
from .terms import MuscleTerms, Terms, convex

_BARRIER, _LESS_BARRIER = 0.01, 0.2
_GAP = 1e-4  # complementarity at the end, relative to the cost
_TOLERANCE = 1e-3  # of the optimality conditions
_TORQUE, _DUAL = 1e-2, 0.1  # scales of errors of torques and gradients
_FEASIBLE = 1.0  # errors of stalled iterations that allow a smaller barrier, over the barrier
_PROGRESS, _IDLE, _MIN_DAMPING = 0.7, 5, 0.1
_MAX_ITERATIONS = 250
_MIN_TENSION, _MAX_TENSION = 1e-3, 3.0  # bounds of tendon forces over F0
_MIN_FORCE = 5e-3  # of the start, over F0
_MIN_SLOPE = 1e-6  # of fibre forces over F0, by activation


class _Gradients(NamedTuple):
    """Gradients of the cost, without barrier.

    Attributes:
        a: By the activations at both ends, 0 between them, shape (m, N).
        e: By the excitations, shape (m, N - 1).
        aa, ee: Second derivatives, of the same shapes.
    """

    a: FloatArray
    e: FloatArray
    aa: FloatArray
    ee: FloatArray


class _Progress:
    """Decrease of the error with one barrier.

    Args:
        damping: Factor of the steps.

    Attributes:
        damping: The factor; halved after several iterations without a smaller error.
        is_stalled: Whether it was halved twice.
    """

    def __init__(self, damping: float = 1.0) -> None:
        self.damping = min(2.0 * damping, 1.0)
        self._best, self._idle, self._halvings = np.inf, 0, 0

    @property
    def is_stalled(self) -> bool:
        return self._halvings >= 2

    def update(self, error: float) -> None:
        """Record the error of an iteration."""
        if error < _PROGRESS * self._best:
            self._best, self._idle = error, 0
            return
        self._idle += 1
        if self._idle >= _IDLE:
            self.damping = max(0.5 * self.damping, _MIN_DAMPING)
            self._idle, self._halvings = 0, self._halvings + 1


class MuscleTrajectorySolver:
    """Solver of one problem.

    Args:
        activations: First activations, shape (N, m).
    """

    def __init__(self, problem: MuscleProblem, activations: FloatArray) -> None:
        self._problem = problem
        self._N, m, _ = problem.L.shape
        self._terms, self._chains = MuscleTerms(problem), MuscleChains(problem.L)
        self._D = np.tile(problem.reserve**2 / 2.0, (self._N, 1))
        self._barrier = _BARRIER
        low = np.tile(problem.low[:, None], self._N)
        self._a = BoundedVariables(activations.T, low, np.ones_like(low), _BARRIER)
        a = self._a.value
        between = (a[:, 1:] + a[:, :-1]) / 2.0
        self._e = BoundedVariables(between, low[:, 1:], np.ones_like(between), _BARRIER)
        x, high = self._terms.start(a, _MIN_FORCE), self._terms.max_tensions()
        high = np.clip(high, 2.0 * _MIN_TENSION, _MAX_TENSION)
        self._x = BoundedVariables(x, np.full_like(x, _MIN_TENSION), high, _BARRIER)
        self._mu, self._nu = np.zeros((m, self._N)), np.zeros((m, self._N - 1))
        self._y = np.zeros((self._N, problem.L.shape[2]))

    def solve(self) -> MuscleTrajectory:
        """Return the muscles over the motion."""
        progress, count = _Progress(), 0
        for count in range(_MAX_ITERATIONS):
            terms = self._terms.evaluate(self._a.value, self._x.value)
            cost = self._cost(terms)
            primal, dual = self._primal_error(terms), self._dual_error(terms)
            progress.update(self._error(primal, dual, self._barrier))
            if self._gap() < _GAP * cost:
                if primal < _TOLERANCE and (dual < _TOLERANCE or progress.is_stalled):
                    return self._result(terms, count, True)
            else:
                while self._may_reduce(primal, dual, progress) and self._gap() >= _GAP * cost:
                    self._barrier = min(_LESS_BARRIER * self._barrier, self._barrier**1.5)
                    progress = _Progress(progress.damping)
            if not self._advance(terms, progress.damping):
                break
        terms = self._terms.evaluate(self._a.value, self._x.value)
        return self._result(terms, count + 1, False)

    def _may_reduce(self, primal: float, dual: float, progress: _Progress) -> bool:
        """Return whether the problem with this barrier is solved.

        Kinks of curves, such as the force-velocity curve of Thelen 2003 at rest, may prevent the
        gradients from vanishing. Then feasible variables are sufficient.
        """
        if progress.is_stalled:
            return primal < max(_FEASIBLE * self._barrier, _TOLERANCE)
        return self._error(primal, dual, self._barrier) < 10.0 * self._barrier

    @property
    def _all(self) -> tuple[BoundedVariables, ...]:
        return self._a, self._e, self._x

    def _variables(self) -> tuple[BoundedVariables, ...]:
        return self._all if self._problem.elastic.any() else self._all[:2]

    def _gap(self) -> float:
        """Return the complementarity of all bounds."""
        return 2.0 * self._barrier * sum(variable.value.size for variable in self._variables())

    def _cost(self, terms: Terms) -> float:
        """Return the cost, divided by the time step."""
        p, a, e = self._problem.power, self._a.value, self._e.value
        ends = 0.5 * (a[:, 0] ** p + a[:, -1] ** p).sum()
        reserves = ((terms.torque / self._problem.reserve) ** 2).sum()
        return float((e**p).sum() + ends + reserves)

    def _gradients(self) -> _Gradients:
        p, a, e = self._problem.power, self._a.value, self._e.value
        ends = np.zeros(self._N)
        ends[[0, -1]] = 0.5
        return _Gradients(
            p * ends * a ** (p - 1.0),
            p * e ** (p - 1.0),
            p * (p - 1.0) * ends * a ** (p - 2.0),
            p * (p - 1.0) * e ** (p - 2.0),
        )

    def _primal_error(self, terms: Terms) -> float:
        """Return the largest error of balances, excitations and torques, scaled."""
        torque = _TORQUE * (terms.torque - self._D * self._y)
        residuals = terms.balance, self._excess(terms), torque
        return max(float(abs(residual).max(initial=0.0)) for residual in residuals)

    def _dual_error(self, terms: Terms) -> float:
        """Return the largest gradient of the Lagrange function, scaled."""
        gradients = self._gradients()
        pull = np.einsum("kmn,kn->mk", self._problem.L, self._y)
        rows = self._mu[:, :, None] * terms.by_balance + pull[:, :, None] * terms.by_tension
        of_a = gradients.a + self._a.dual + rows[:, :, 1]
        of_a[:, :-1] += self._nu * terms.by_excitation[:, :, 0]
        of_a[:, 1:] += self._nu * terms.by_excitation[:, :, 1]
        of_x = self._x.dual
        of_x[:, :-1] += rows[:, :, 0]
        of_x[:, 1:] += rows[:, :, 2]
        residuals = of_a, of_x[self._problem.elastic], gradients.e - self._nu + self._e.dual
        return _DUAL * max(float(abs(residual).max(initial=0.0)) for residual in residuals)

    def _error(self, primal: float, dual: float, barrier: float) -> float:
        return max(primal, dual, *(variable.error(barrier) for variable in self._variables()))

    def _excess(self, terms: Terms) -> FloatArray:
        return terms.excitations - self._e.value

    def _advance(self, terms: Terms, damping: float) -> bool:
        """Move along a step; return whether there is one."""
        gradients, J, elastic = self._gradients(), terms.by_excitation, self._problem.elastic
        ee = gradients.ee + self._e.curvature
        ge = gradients.e + self._e.slope(self._barrier)
        ga, excess = gradients.a + self._a.slope(self._barrier), self._excess(terms)
        of_edges = ge + ee * excess
        ga[:, :-1] += J[:, :, 0] * of_edges
        ga[:, 1:] += J[:, :, 1] * of_edges
        gx = np.where(elastic[:, None], self._x.slope(self._barrier), 0.0)
        pivot = terms.by_balance[:, :, 1]
        pivot = np.where(elastic[:, None], np.maximum(pivot, _MIN_SLOPE), 1.0)
        T = -terms.by_balance[:, :, ::2] / pivot[:, :, None]
        T[~elastic, :, 1] = 1.0  # the activation is the unknown
        edges = J[:, :, :, None] * J[:, :, None, :] * ee[:, :, None, None]
        t = -terms.balance / pivot
        frames = self._frame_blocks(terms)
        frames[:, :, 1, 1] += gradients.aa
        solution = self._chains.solve(
            ChainEquations(frames, edges, T, t, terms.by_tension, self._D, gx, ga, terms.torque)
        )
        if solution is None:
            return False
        self._move(terms, solution, pivot, (ee, ge, excess), damping)
        return True

    def _frame_blocks(self, terms: Terms) -> FloatArray:
        """Return the blocks of (x before, a, x after), without the cost, shape (m, N, 3, 3)."""
        elastic = self._problem.elastic
        added = np.zeros_like(terms.by_balance)
        added[:, :, 1] = self._a.curvature
        bound = self._x.curvature
        bound[~elastic] = 1.0
        bound[:, 1:-1] *= 0.5  # each x is next to two frames
        added[:, :, 0], added[:, :, 2] = bound[:, :-1], bound[:, 1:]
        added[~elastic, :, ::2] = 0.0
        added[~elastic, 0, 0] = 1.0  # an unused unknown
        H = self._terms.hessian(terms, self._mu, self._x.value)
        H[elastic] = convex(H[elastic], added[elastic], terms.by_balance[elastic])
        return H + added[..., None] * np.eye(3)

    def _move(
        self,
        terms: Terms,
        solution: ChainSolution,
        pivot: FloatArray,
        of_edges: tuple[FloatArray, FloatArray, FloatArray],
        damping: float,
    ) -> None:
        """Move all variables and multipliers."""
        ee, ge, excess = of_edges
        J, elastic = terms.by_excitation, self._problem.elastic[:, None]
        dx = np.where(elastic, solution.x, 0.0)
        de = J[:, :, 0] * solution.a[:, :-1] + J[:, :, 1] * solution.a[:, 1:] + excess
        pull = np.einsum("kmn,kn->mk", self._problem.L, solution.y)
        mu = -(solution.a_residual + terms.by_tension[:, :, 1] * pull) / pivot
        steps = {self._a: solution.a, self._e: de, self._x: dx}
        nu = ee * de + ge
        share = damping * min(v.max_step(step) for v, step in steps.items())
        duals = {v: v.dual_steps(step, self._barrier) for v, step in steps.items()}
        dual_share = damping * min(v.max_dual_step(both) for v, both in duals.items())
        for v, step in steps.items():
            v.move(step, share, duals[v], dual_share, self._barrier)
        self._mu += share * (np.where(elastic, mu, 0.0) - self._mu)
        self._nu += share * (nu - self._nu)
        self._y += share * (solution.y - self._y)

    def _result(self, terms: Terms, count: int, is_solved: bool) -> MuscleTrajectory:
        a, e = self._a.value, terms.excitations
        edges = np.concatenate([a[:, :1], e, a[:, -1:]], axis=1)
        return MuscleTrajectory(
            a.T,
            (edges[:, 1:] + edges[:, :-1]).T / 2.0,
            terms.tensions.T,
            terms.points[:, :, 1],
            terms.points[:, :, 2],
            terms.torque,
            self._problem.step * self._cost(terms),
            count,
            is_solved,
        )
