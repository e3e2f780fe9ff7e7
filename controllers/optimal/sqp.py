"""Sequential quadratic programming with a filter line search."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import chain
from typing import NamedTuple

import numpy as np

from controllers.arrays import FloatArray

from .convexity import Program
from .lagrangian import DynamicsHessian
from .problem import Iterate, OptimalProblem
from .qp import QpSolution, QpSolver
from .transcription import Linearisation, Transcription

OPTIMAL, NEARLY_OPTIMAL, INFEASIBLE, NOT_CONVERGED, INTERRUPTED = STATUSES = (
    "optimal",
    "nearly optimal",
    "infeasible",
    "not converged",
    "interrupted",
)

_SETTLED, _STRICTER = 1e-6, 0.15  # changes of globals, and factor of the tolerance above them
_SHARES = 0.5 ** np.arange(9)
_FEASIBILITY = 1e-7  # largest accepted violation of a constraint, scaled
_MARGIN = 1e-5  # required decrease, relative to the violation
_ARMIJO = 1e-4
_ROUNDING = 1e-9  # of the cost
_PROGRESS = 0.99  # of the violation, for an iteration with relaxed constraints
_MIN_DAMPING, _MAX_DAMPING, _MORE_DAMPING = 1e-10, 1e4, 1e-5
_LARGE_DAMPING = 1.0  # largest damping with which a small predicted decrease means optimality
_DAMPING, _DAMPING_FREE_TIME = 1e-8, 1e-2  # first damping; a duration has no Hessian of its own
_LESS_POSITIVE, _MIN_POSITIVE = 0.5, 1e-3  # factor after a good step, and smallest value
_CORRECTION = 1e3  # damping of a step that reduces the violation at almost the same motion
_LAST_DAMPING, _LAST_STEPS = 1e6, 4  # damping and number of such steps after the last iteration
_GOOD = 0.3  # factor of the violation, for much less damping
_FREE_STEPS = 3  # first steps, which may increase cost and violation
_MAX_VIOLATION = 1e3  # of these steps, relative to the violation of the guess plus 1
_MAX_LATER_VIOLATION = 10.0  # likewise, of attempts without such steps
_NEAR = 1e-3  # violation below which a rejected step may be followed
ROUGH = 0.1  # violation up to which a motion can be corrected after the last iteration
_FIRST_ITERATIONS = 60  # of an attempt that is not the last, while it violates constraints
_FLAT, _FLAT_ITERATIONS = 1e-3, 20  # relative fall of the cost with which the iterations end
_LARGE = 5000  # variables of problems with a larger fall in fewer iterations
_FLAT_OF_LARGE, _ITERATIONS_OF_LARGE, _ITERATIONS_OF_NEAR = 1e-2, 10, 2
MANY_STATES = 100  # with which the first steps from a guess are not free
_STALLED = 3  # iterations with relaxed constraints and without progress


@dataclass(frozen=True, slots=True)
class Progress:
    """State of the optimisation after an iteration.

    Attributes:
        iteration: Number of the iteration, from 0 for the start.
        cost: The cost.
        violation: Largest violation of a constraint, scaled.
        share: Share of the step that was used.
        seconds: Time since the start, in [s].
    """

    iteration: int
    cost: float
    violation: float
    share: float
    seconds: float


@dataclass(frozen=True, slots=True)
class Solution:
    """Result of an optimisation.

    Attributes:
        iterate: The best motion.
        linearisation: Terms at this motion.
        status: One of `STATUSES`.
        is_feasible: Whether the motion satisfies all constraints.
        violation: Largest violation of a constraint, scaled.
        history: Progress, one entry per iteration.
        hessian: Contribution of the dynamics to the Hessian.
    """

    iterate: Iterate
    linearisation: Linearisation
    status: str
    is_feasible: bool
    violation: float
    history: tuple[Progress, ...]
    hessian: DynamicsHessian

    @property
    def cost(self) -> float:
        """The cost."""
        return self.linearisation.cost


@dataclass
class _State:
    """Iterate with its terms, and the memory of the globalisation.

    Attributes:
        at: The iterate.
        linearised: Its terms.
        damping: Number on the diagonal of the Hessian.
        filter: Pairs of violation and cost that later iterates must improve; first, the largest
            accepted violation.
        idle: Number of iterations without progress.
        hessian: Contribution of the dynamics to the Hessian.
        free: Number of steps that may increase both cost and violation.
        positive: See `Transcription.program`.
        is_full: Whether the last step was a full one.
        reduced: Factor of the violation in the last step.
        best: Last iterate that satisfies the constraints, with its terms.
    """

    at: Iterate
    linearised: Linearisation
    damping: float
    hessian: DynamicsHessian
    filter: list[tuple[float, float]] = field(default_factory=list)
    idle: int = 0
    free: int = _FREE_STEPS
    positive: float = 0.0
    is_full: bool = False
    reduced: float = 0.0
    best: tuple[Iterate, Linearisation] | None = None


class _Step(NamedTuple):
    """Step from an iterate.

    Attributes:
        program: Its quadratic program.
        solution: Solution of this program.
        is_relaxed: Whether constraints had to be relaxed.
    """

    program: Program
    solution: QpSolution
    is_relaxed: bool


def _rank(solution: Solution) -> tuple[bool, bool, float]:
    """Return the order of attempts: feasible ones, then those that name a constraint."""
    worth = solution.cost if solution.is_feasible else solution.violation
    return not solution.is_feasible, solution.status == NOT_CONVERGED, worth


class Optimiser:
    """Solver of optimal-control problems.

    Args:
        problem: The problem.
        tolerance: Decrease that a step must promise, relative to the cost; otherwise the motion is
            optimal. While a duration or parameters change, it is smaller: the cost is flat in them.
        max_iterations: Number of iterations.
        refine: Function of an iterate and the ends of its intervals that makes the dynamics more
            accurate if the iterate requires it, and returns whether they changed.
    """

    def __init__(
        self,
        problem: OptimalProblem,
        tolerance: float = 3e-7,
        max_iterations: int = 100,
        refine: Callable[[Iterate, FloatArray], bool] = lambda _, ends: False,
    ) -> None:
        self.problem = problem
        self.transcription = Transcription(problem)
        self._solver = QpSolver(all(each.in_stages for each in problem.linear))
        self._tolerance, self._max_iterations, self._refine = tolerance, max_iterations, refine

    def solve(
        self,
        guess: Iterate,
        progress: Callable[[Progress], None] = lambda _: None,
        others: Iterable[Iterate] | None = (),
        hessian: DynamicsHessian | None = None,
    ) -> Solution | None:
        """Return the optimal motion near a guess; None if the guess diverges.

        An interruption (KeyboardInterrupt) returns the last motion, after few iterations that
        satisfy the constraints if it nearly does, or the last one that satisfies them.

        Args:
            guess: First iterate.
            progress: Function that is called after every iteration.
            others: Guesses that are tried if no motion is found from the first one; None if this
                one is near the optimal motion.
            hessian: Of the solution of a similar problem near the guess (default: none).
        """
        began, history = time.perf_counter(), list[Progress]()

        def report(state: _State, share: float) -> None:
            seconds, violation = time.perf_counter() - began, self._worst(state)
            history.append(Progress(len(history), state.linearised.cost, violation, share, seconds))
            progress(history[-1])

        limit = self._max_iterations
        attempts: Iterable[tuple[Iterate, int, int]] = [(guess, 0, limit)]
        if others is not None:
            first = min(limit, _FIRST_ITERATIONS)
            more = ((each, 0, max(first, limit // 2)) for each in others)
            free = _FREE_STEPS if self.problem.x_low.shape[1] <= MANY_STATES else 0
            attempts = chain([(guess, free, first)], more, attempts)
        best = None
        for start, free, most in attempts:
            solution = self._attempt(start, free, most, report, history, hessian)
            if solution is not None and (best is None or _rank(solution) < _rank(best)):
                best = solution
            if solution is not None and (solution.is_feasible or solution.status == INTERRUPTED):
                break
        return best

    def _attempt(
        self,
        guess: Iterate,
        free: int,
        limit: int,
        report: Callable[[_State, float], None],
        history: list[Progress],
        hessian: DynamicsHessian | None,
    ) -> Solution | None:
        """Return the motion after iterations from a guess; see `_State.free`."""
        at = self.problem.clip(guess)
        linearised = self.transcription.linearise(at)
        if linearised is None:
            return None
        damping = _DAMPING_FREE_TIME if self.problem.is_free_time else _DAMPING
        is_near = hessian is not None
        positive = float(is_near)
        hessian = hessian or DynamicsHessian(*self.transcription.stages(at).shape)
        state, status = _State(at, linearised, damping, hessian, free=free, positive=positive), ""
        costs = list[float]()
        try:
            report(state, 0.0)
            factor = _MAX_VIOLATION if free else _MAX_LATER_VIOLATION
            largest = factor * (1.0 + self.transcription.violation(at, linearised))
            state.filter.append((largest, -np.inf))
            for k in range(self._max_iterations):
                if k >= limit and self._worst(state) > _NEAR:
                    break
                status, share = self._iterate(state)
                if share:
                    report(state, share)
                costs.append(state.linearised.cost)
                if self._is_flat(costs, is_near) and self._worst(state) < ROUGH:
                    status = status if status == OPTIMAL else NEARLY_OPTIMAL
                if status:
                    break
            if status != OPTIMAL:
                self._correct(state, report)
        except KeyboardInterrupt:
            status = INTERRUPTED
            if state.best is not None and self._worst(state) > _FEASIBILITY:
                state.at, state.linearised = state.best
            with suppress(KeyboardInterrupt):
                self._correct(state, report)
        worst = self._worst(state)
        feasible = worst <= _FEASIBILITY
        if status not in (OPTIMAL, INTERRUPTED) and not (status == NEARLY_OPTIMAL and feasible):
            status = INFEASIBLE if self._is_dynamic(state) else NOT_CONVERGED
        return Solution(
            state.at, state.linearised, status, feasible, worst, tuple(history), hessian
        )

    def _is_flat(self, costs: list[float], is_near: bool) -> bool:
        """Return whether the last costs after iterations hardly fall."""
        least, count, most = _FIRST_ITERATIONS, _FLAT_ITERATIONS, _FLAT
        if self.transcription.size > _LARGE:
            count = _ITERATIONS_OF_NEAR if is_near else _ITERATIONS_OF_LARGE
            least, most = 0, _FLAT_OF_LARGE
        last = costs[-count - 1 :]
        return len(costs) > max(least, count) and max(last) - min(last) <= most * abs(last[-1])

    def _correct(self, state: _State, report: Callable[[_State, float], None]) -> None:
        """Satisfy the constraints near an iterate that nearly does."""
        for _ in range(_LAST_STEPS):
            if not _FEASIBILITY < self._worst(state) < ROUGH:
                break
            state.damping, state.filter = _LAST_DAMPING, state.filter[:1]
            report(state, self._iterate(state)[1])

    def _is_dynamic(self, state: _State) -> bool:
        """Return whether bounds and goals are violated more than the dynamics."""
        gaps, *others = self._violations(state)
        worst = max(float(v.max(initial=0.0)) for v in others)
        return worst > max(float(gaps.max()), _FEASIBILITY)

    def _iterate(self, state: _State) -> tuple[str, float]:
        """Improve the iterate. Return the status if this is the end, and the share of the step."""
        best = self._step(state)
        if not best.solution.is_solved:
            return self._increase_damping(state), 0.0
        chosen, is_end = best, False
        if not best.is_relaxed and self._is_small(state, best):
            worst = self._worst(state)
            if worst <= _FEASIBILITY:
                return OPTIMAL if state.damping <= _LARGE_DAMPING else "stalled", 0.0
            if state.reduced * worst > _FEASIBILITY:
                chosen, is_end = self._correction(state, best)
        program, solution, is_relaxed = chosen
        step = solution.d
        moved, share, linearised = self._search(state, step, is_relaxed)
        if moved is None and not is_relaxed and self._worst(state) < _NEAR:
            # the filter rejects steps of second order near the optimum: follow one, and start anew
            moved, share = self.transcription.move(state.at, step, 1.0), 1.0
            state.filter = state.filter[:1]
            state.damping = max(10.0 * state.damping, _MORE_DAMPING)
        linearised = linearised or (None if moved is None else self.transcription.linearise(moved))
        state.is_full = share == 1.0
        if moved is None or linearised is None:
            state.idle += is_relaxed
            return self._increase_damping(state), 0.0
        violation = self.transcription.violation
        before, after = violation(state.at, state.linearised), violation(moved, linearised)
        stays = is_relaxed and after >= _PROGRESS * before
        if not is_relaxed:
            multipliers = self.transcription.multipliers(state.linearised, program, solution)
            self._learn(state, moved, linearised, multipliers)
        reduced = after / max(before, _FEASIBILITY)
        if state.free <= 0 and self._refine(moved, linearised.ends):
            linearised = self.transcription.linearise(moved) or linearised
            state.filter, state.best = state.filter[:1], None
        state.at, state.linearised = moved, linearised
        if self._worst(state) <= _FEASIBILITY:
            state.best = moved, linearised
        state.idle = state.idle + 1 if stays else 0
        self._adapt_damping(state, share, reduced)
        if is_end and self._worst(state) <= _FEASIBILITY:
            return OPTIMAL, share
        return "stalled" if state.idle >= _STALLED else "", share

    def _learn(
        self, state: _State, moved: Iterate, linearised: Linearisation, multipliers: FloatArray
    ) -> None:
        """Update the Hessian of the Lagrangian with the change of the gradients along a step."""
        gradients, stages = self.transcription.stage_gradients, self.transcription.stages
        before, after = (gradients(each, multipliers) for each in (state.linearised, linearised))
        state.hessian.update(stages(moved) - stages(state.at), after - before)

    def _adapt_damping(self, state: _State, share: float, reduced: float) -> None:
        """Change the damping after a step that multiplied the violation by `reduced`.

        A bad step also adds the positive part of the Hessian of the dynamics.
        """
        is_good, state.reduced = share == 1.0 and reduced <= 1.0, reduced
        positive = _LESS_POSITIVE * state.positive if is_good else 1.0
        state.positive = positive if positive > _MIN_POSITIVE else 0.0
        if share < 1.0:
            damping = max(state.damping / share, _MORE_DAMPING)
        elif reduced > 1.0 and state.free <= 0:
            damping = max(4.0 * state.damping, _MORE_DAMPING)
        else:
            damping = max((0.5 if reduced >= _GOOD else 0.2) * state.damping, _MIN_DAMPING)
        state.damping = min(damping, _LARGE_DAMPING)

    def _increase_damping(self, state: _State) -> str:
        state.damping = max(10.0 * state.damping, _MORE_DAMPING)
        is_end = state.idle >= _STALLED or state.damping > _MAX_DAMPING
        return "stalled" if is_end else ""

    def _worst(self, state: _State) -> float:
        """Return the largest scaled violation of a constraint."""
        return max(float(v.max(initial=0.0)) for v in self._violations(state))

    def _violations(self, state: _State) -> list[FloatArray]:
        terms = state.linearised
        return self.transcription.violations(state.at, terms.gaps, terms.values)

    def _step(self, state: _State, damping: float | None = None) -> _Step:
        """Return the step from an iterate."""
        damping = state.damping if damping is None else damping
        arguments = state.at, state.linearised, damping, state.hessian.blocks, state.positive
        program = self.transcription.program(*arguments)
        solution = self._solver.solve(program.qp)
        if solution.is_solved:
            return _Step(program, solution, False)
        return _Step(program, self.transcription.solve_relaxed(program.qp), True)

    def _correction(self, state: _State, best: _Step) -> tuple[_Step, bool]:
        """Return a step to the nearest motion without violation, and whether that is optimal."""
        step, qp = self._step(state, max(_CORRECTION, state.damping)), best.program.qp
        loss = self._relative(state, qp.value(step.solution.d) - qp.value(best.solution.d))
        is_optimal = loss < self._tolerance and state.damping <= _LARGE_DAMPING
        return step, is_optimal and not step.is_relaxed

    def _is_small(self, state: _State, step: _Step) -> bool:
        """Return whether a step promises a small decrease of the Lagrangian."""
        qp, solution = step.program.qp, step.solution
        change = self._relative(state, qp.value(solution.d) + float(solution.y @ qp.b))
        is_settled = abs(self.transcription.globals_of(solution.d)).max(initial=0.0) < _SETTLED
        return change < self._tolerance * (1.0 if is_settled else _STRICTER)

    def _relative(self, state: _State, change: float) -> float:
        """Return the size of a change of the objective of a program, relative to the cost."""
        terms, cost = state.linearised.terms, abs(state.linearised.cost)
        return abs(change) * self.transcription.cost_scale(terms) / max(cost, 1e-12)

    def _search(
        self, state: _State, step: FloatArray, is_relaxed: bool
    ) -> tuple[Iterate | None, float, Linearisation | None]:
        """Return the first iterate along a step that the filter accepts, its share, and its terms.

        A relaxed step must reduce the violation. After a full step, the next one is linearised at
        once: it is probably accepted, too.
        """
        transcription, current = self.transcription, state.linearised
        theta = transcription.violation(state.at, current)
        slope = float(transcription.gradient(state.at, current.terms) @ step)
        less = current.cost - _MARGIN * theta * abs(current.cost)
        for share in _SHARES.tolist():
            moved = transcription.move(state.at, step, share)
            linearised = None
            if share == 1.0 and state.is_full:
                linearised = transcription.linearise(moved)
                tried = linearised and (transcription.violation(moved, linearised), linearised.cost)
            else:
                tried = transcription.evaluate(moved)
            if tried is None:
                continue
            new_theta, cost = tried
            if state.free > 0 and new_theta < state.filter[0][0]:
                state.free -= 1
                return moved, share, linearised
            descends = slope < 0.0 and -share * slope > 10.0 * theta * abs(current.cost)
            if descends and new_theta <= max(theta, 0.1 * _FEASIBILITY):
                rounding = _ROUNDING * max(abs(current.cost), 1e-12)
                accepted = cost <= current.cost + _ARMIJO * share * slope + rounding
            else:
                accepted = new_theta <= (1.0 - _MARGIN) * theta
                accepted |= cost < less and not is_relaxed
            if any(new_theta >= worst and cost >= best for worst, best in state.filter):
                continue
            if accepted:
                if not descends:
                    state.filter.append(((1.0 - _MARGIN) * theta, less))
                return moved, share, linearised
        return None, 0.0, None
