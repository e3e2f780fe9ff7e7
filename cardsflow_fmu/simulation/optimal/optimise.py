"""Optimal motion of an experiment: solution, file of the motion, figure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.cosim.signals.muscles import modelled_muscles
from cardsflow_fmu.cosim.signals.ports import motor_signals, muscle_signals, task_signals
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.feedback import MotionFeedback
from cardsflow_fmu.utils.arrays import FloatArray, IntArray
from controllers.optimal.problem import Iterate, NodeConstraint
from controllers.optimal.sqp import (
    INFEASIBLE,
    INTERRUPTED,
    MANY_STATES,
    NEARLY_OPTIMAL,
    OPTIMAL,
    Optimiser,
    Progress,
    Solution,
)
from sim_dart.dynamics.core import CoreDynamics

from .diagnosis import infeasibility, require_reachable
from .feedback import motion_feedback
from .guess import PARAMETER, last_motion, motion_from_start, smooth_guess
from .muscles import below_reach
from .obstacles.constraints import against_jumps, between_nodes, is_blocked, passages
from .obstacles.detours import ROUGH, detours, rough_motion, without_obstacles
from .problem import ROUGH_INTEGRATION, MotionProblem, motion_problem

_INTEGRATION_ERROR = 1e-5  # of an interval, in rad, m, and their rates
_OF_GAPS = 0.1  # error of the integration during iterations, relative to gaps between intervals
_MAX_ROUNDS = 20  # of constraints between the nodes
_MAX_PAUSE = 8  # iterations between two checks of the integration
_LAST_ROWS = 11  # of the progress, in the note about a nearly optimal motion
MARK_COLUMN = "cardsflow.interval"


class NoMotionError(CardsflowError):
    """No motion satisfies the constraints."""


@dataclass(frozen=True)
class OptimisedMotion:
    """Optimal motion of an experiment.

    Attributes:
        solution: Result of the optimisation.
        problem: The problem.
        times: Times of the samples, shape (k,), in [s].
        columns: Samples of q, qd, qdd, forces and torques by name of the column.
        feedback: Feed-forward and feedback gains.
        notes: Lines about neglected properties.
        warnings: Lines about a motion that is not optimal, large integration errors, and
            constraints that are violated between the nodes.
        iterations: Number of iterations, with all numbers of substeps.
        seconds: Time of the iterations, in [s].
        history: Progress and number of substeps after each iteration.
    """

    solution: Solution
    problem: MotionProblem
    times: FloatArray
    columns: Mapping[str, FloatArray]
    feedback: MotionFeedback
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    iterations: int
    seconds: float
    history: tuple[tuple[Progress, int], ...]

    @property
    def duration(self) -> float:
        """Duration, in [s]."""
        return self.solution.iterate.duration

    @property
    def parameters(self) -> dict[str, float | list[float]]:
        """Found numbers and vectors of the robot by path; empty without free parameters."""
        free = self.problem.free
        return {} if free is None else free.settings(self.solution.iterate.parameters)

    def parameter_lines(self) -> list[str]:
        """Return a line about each free parameter: value before and after, and active bounds."""
        free, values = self.problem.free, self.solution.iterate.parameters
        return [] if free is None else free.lines(values)


class _Refinement:
    """Refinement of the integration during iterations; after checks without effect it pauses."""

    def __init__(self, setup: MotionProblem) -> None:
        self._setup, self._pause, self._left = setup, 1, 1

    def __call__(self, at: Iterate, ends: FloatArray) -> bool:
        self._left -= 1
        if self._left > 0:
            return False
        tolerance = max(ROUGH_INTEGRATION, _OF_GAPS * float(abs(ends - at.x[1:]).max()))
        steps = self._setup.shooting.steps
        self._setup.refine(at, tolerance, ends=ends)
        is_finer = bool(np.any(self._setup.shooting.steps > steps))
        self._pause = self._pause if is_finer else min(2 * self._pause, _MAX_PAUSE)
        self._left = self._pause
        return is_finer


def _keep_substeps(_at: Iterate, _ends: FloatArray) -> bool:
    """Keep the substeps near a motion whose integration has been refined."""
    return False


def load_for_motion(path: Path, settings: Mapping[str, Any] | None = None) -> Experiment:
    """Load an experiment whose reference does not exist yet; the reference is a rest."""
    return Experiment.load(path, {**(settings or {}), "reference": {"type": "rest"}})


def optimise(
    experiment: Experiment,
    progress: Callable[[Progress, int], None] = lambda row, substeps: None,
    *,
    resume: Path | None = None,
) -> OptimisedMotion:
    """Compute the optimal motion of an experiment with [motion].

    An interruption returns the best motion so far; its `solution.status` is `interrupted`.
    Without a motion that nearly satisfies the constraints, it raises KeyboardInterrupt.

    Args:
        experiment: From `load_for_motion`.
        progress: Function of the progress and the number of substeps, called after every iteration.
        resume: File of an earlier motion, which is the first guess (default: a rest).

    Raises:
        InputError: The file of the earlier motion belongs to another robot.
        NoMotionError: No motion satisfies the constraints; the message names one of them.
    """
    search = _Search(experiment, motion_problem(experiment), progress, resume)
    solution, error = search.run()
    setup, at, motion = search.setup, solution.iterate, experiment.motion
    assert motion is not None
    notes, warnings = _remarks(solution, error)
    if motion.muscles == "forces" and modelled_muscles(experiment.robot):
        tensions = np.full((len(at.u), setup.dynamics.m), np.nan)
        tensions[:, setup.shooting.driven] = at.u[:, : len(setup.shooting.driven)]
        notes += below_reach(experiment, at.x[:-1, : setup.dynamics.n], tensions)
    times, columns = _samples(setup, solution, experiment.run.step)
    x = np.zeros((len(times), setup.shooting.nx))
    x[:, : setup.dynamics.n] = np.transpose(list(columns.values())[: setup.dynamics.n])
    warnings += passages(setup.problem.constraints, times, x)
    feedback, more = motion_feedback(experiment, setup, at)
    return OptimisedMotion(
        *(solution, setup, times, columns, feedback, (*setup.notes, *notes, *more), warnings),
        *(search.iterations, search.seconds, tuple(search.history)),
    )


class _Search:
    """Optimisations until the integration is accurate and the constraints hold between the nodes.

    See `optimise` for the arguments, and `OptimisedMotion` for the attributes.
    """

    def __init__(
        self,
        experiment: Experiment,
        setup: MotionProblem,
        progress: Callable[[Progress, int], None],
        resume: Path | None,
    ) -> None:
        assert experiment.motion is not None
        self._experiment, self._motion, self._progress = experiment, experiment.motion, progress
        self.iterations, self.seconds, self.history = 0, 0.0, list[tuple[Progress, int]]()
        self._previous: Solution | None = None
        self._coarse: tuple[Solution, IntArray | int] | None = None  # before refinement
        self._rounds, self._is_blocked = 0, False
        last = None if resume is None else last_motion(resume, setup)
        first = _first_guess(setup) if last is None else last
        self.setup = _with_constraints(setup, against_jumps(setup.problem, first))
        self._begin(first)
        self._is_near = self._is_resumed = last is not None
        if last is not None:
            self.setup.refine(setup.problem.clip(last), _INTEGRATION_ERROR, is_final=True)

    def _begin(self, first: Iterate) -> None:
        """Set the first guess."""
        self._guess, self._others, self._is_near = first, _other_guesses(self.setup, first), False

    def run(self) -> tuple[Solution, float]:
        """Return the motion, and the largest error of an interval."""
        while True:
            solution = self._solve()
            is_end = solution is not None and solution.status == INTERRUPTED
            is_feasible = solution is not None and solution.is_feasible
            if not is_end and self._has_other_guess(solution if is_feasible else None):
                continue
            if not is_feasible and self._coarse is not None:
                solution, self.setup.shooting.steps = self._coarse
                return solution, self.setup.refine(solution.iterate, np.inf, is_final=True)
            if not is_feasible:
                require_reachable(self._experiment, self.setup)
            _require_motion(self.setup, solution)
            assert solution is not None
            at, steps = solution.iterate, self.setup.shooting.steps
            tolerance, ends = np.inf if is_end else _INTEGRATION_ERROR, solution.linearisation.ends
            error = self.setup.refine(at, tolerance, is_final=True, ends=ends)
            is_accurate = not np.any(self.setup.shooting.steps != steps)
            if is_end or (is_accurate and not self._constrain(at)):
                return solution, error
            self._coarse = None if is_accurate else (solution, steps)
            self._previous, self._guess, self._is_near = solution, at, True

    def _solve(self) -> Solution | None:
        """Return the motion from the guess; None if it diverges."""
        setup, previous = self.setup, self._previous
        limit = self._motion.max_iterations
        refine = _Refinement(setup) if previous is None else _keep_substeps
        solver = Optimiser(setup.problem, max_iterations=limit, refine=refine)
        others = None if self._is_near else self._others
        is_near = previous is not None and previous.status in (OPTIMAL, NEARLY_OPTIMAL)
        hessian = previous.hessian if previous is not None and is_near else None
        solution = solver.solve(self._guess, self._report, others, hessian)
        if solution is None:
            return None
        self.iterations += solution.history[-1].iteration
        self.seconds += solution.history[-1].seconds
        if solution.status == INTERRUPTED and previous is not None and not solution.is_feasible:
            return replace(previous, status=INTERRUPTED, history=solution.history)
        return solution

    def _report(self, done: Progress) -> None:
        substeps = int(np.max(self.setup.shooting.steps))
        self.history.append((done, substeps))
        self._progress(done, substeps)

    def _has_other_guess(self, solution: Solution | None) -> bool:
        """Return whether there is another guess, after one without a motion or past obstacles."""
        if self._is_resumed and solution is None:  # the goals or bounds have changed
            self._is_resumed = False
            self._begin(_first_guess(self.setup))
            self.setup.shooting.steps = self._motion.substeps
            return True
        self._is_resumed = False
        if solution is not None:
            self._is_blocked = is_blocked(self.setup.problem, solution.iterate)
        another = next(self._others, None) if self._is_blocked else None
        if another is not None:
            self._guess, self._is_near = another, True
        return another is not None

    def _constrain(self, at: Iterate) -> bool:
        """Add violated constraints between the nodes; return whether there are any."""
        inner = between_nodes(self.setup.problem, at, self._experiment.run.step)
        if not inner or self._rounds == _MAX_ROUNDS:
            return False
        self._rounds, self._is_blocked = self._rounds + 1, True
        self.setup = _with_constraints(self.setup, inner)
        return True


def _remarks(solution: Solution, error: float) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return notes and warnings about the end of the iterations and the error of an interval."""
    notes, warnings = tuple[str, ...](), tuple[str, ...]()
    if solution.status == NEARLY_OPTIMAL:
        costs = [row.cost for row in solution.history[-_LAST_ROWS:]]
        change = (max(costs) - min(costs)) / max(abs(costs[-1]), np.finfo(float).tiny)
        text = f"nearly optimal: in the last {len(costs) - 1} iterations the cost changed by"
        notes += (f"{text} {change:.2%}; --resume continues",)
    elif solution.status != OPTIMAL:
        text = "the motion satisfies the constraints, but is not optimal"
        if not solution.is_feasible:
            text = f"the motion violates constraints by {solution.violation:.2g} (scaled)"
        warnings += (f"{solution.status}: {text}; continue with --resume",)
    text = f"the integration error of an interval is up to {error:.2g}"
    text += "; increase motion.substeps or motion.intervals"
    if error > ROUGH_INTEGRATION:
        warnings += (text,)
    elif error > _INTEGRATION_ERROR:
        notes += (text,)
    return notes, warnings


def _with_constraints(setup: MotionProblem, inner: Sequence[NodeConstraint]) -> MotionProblem:
    """Return a problem with more constraints."""
    constraints = [*setup.problem.constraints, *inner]
    return setup._replace(problem=replace(setup.problem, constraints=constraints))


def _first_guess(setup: MotionProblem) -> Iterate:
    """Return a guess of the motion without obstacles, or the optimal one."""
    free, guess = without_obstacles(setup.problem), next(_guesses(setup))
    if len(free.constraints) == len(setup.problem.constraints):
        return guess
    return rough_motion(free, guess) or guess


def _other_guesses(setup: MotionProblem, first: Iterate) -> Iterator[Iterate]:
    """Yield guesses for a first one from which no motion is found."""
    if len(without_obstacles(setup.problem).constraints) < len(setup.problem.constraints):
        yield from detours(setup.problem, first, setup.shooting.n)
    yield from islice(_guesses(setup), 1, None)


def _guesses(setup: MotionProblem) -> Iterator[Iterate]:
    """Yield guesses that ignore obstacles, in the order in which they are tried.

    A smooth motion is the first one, but with some muscle states, a free duration or a free robot,
    fewer iterations are needed from a rest. With rigid tendons, the motion with the commands of the
    start may lead to a lower cost, for example if the robot swings back first.
    """
    problem, names = setup.problem, setup.shooting.laws.state_names
    is_free = problem.is_free_time or setup.free is not None
    if not is_free and (not names or setup.shooting.nx > MANY_STATES):
        yield smooth_guess(setup)
        yield setup.guess
        return
    if not is_free and not any(name.startswith("fibre_length") for name in names):
        moving = motion_from_start(setup)
        if moving is not setup.guess:
            yield moving
    yield setup.guess
    yield smooth_guess(setup)


def _require_motion(setup: MotionProblem, solution: Solution | None) -> None:
    """Check that a motion satisfies the constraints."""
    if solution is None:
        raise NoMotionError("the simulation of the start diverges; use more substeps")
    if solution.status == INTERRUPTED:
        if solution.violation > ROUGH:
            raise KeyboardInterrupt
    elif solution.status == INFEASIBLE or not solution.is_feasible:
        raise NoMotionError(infeasibility(setup.problem, solution))


def _samples(
    setup: MotionProblem, solution: Solution, step: float
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return the motion at multiples of a step."""
    at, dynamics, n = solution.iterate, setup.dynamics, setup.dynamics.n
    count = int(np.ceil(at.duration / step - 1e-9))
    times = np.minimum(np.arange(count + 1) * step, at.duration)
    h = at.duration / len(at.u)
    interval = np.minimum((times / h + 1e-9).astype(int), len(at.u) - 1)
    x, u = _states(setup, at, times), at.u[interval]
    torques = u[:, len(setup.shooting.driven) :]
    rates, tensions = setup.shooting.rates(x, u)
    forces, qdd = np.concatenate([tensions, torques], axis=1), rates[:, n : 2 * n]
    robot = dynamics.robot
    names = [
        *(f"{letter}.{c.name}" for letter in ("q", "qd", "qdd") for c in robot.coordinates),
        *muscle_signals("f", robot),
        *motor_signals("tau", robot),
    ]
    table = np.concatenate([x[:, :n], x[:, n : 2 * n], qdd, forces], axis=1)
    columns = dict(zip(names, table.T, strict=True))
    columns |= _law_columns(setup, x, u)
    columns |= _task_columns(dynamics, x[:, :n], x[:, n : 2 * n], qdd)
    for k, p in enumerate(at.parameters.tolist()):
        columns[f"{PARAMETER}{k + 1}"] = np.full(len(times), p)
    return times, {**columns, MARK_COLUMN: interval.astype(float)}


def _states(setup: MotionProblem, at: Iterate, times: FloatArray) -> FloatArray:
    """Return the states at some times, by one step from the Runge-Kutta step before each."""
    shooting, N = setup.shooting, len(at.u)
    steps = np.broadcast_to(shooting.steps, N)
    h = at.duration / N / steps
    x, p = [at.x[:-1]], at.parameters
    with shooting.using(1):
        for k in range(1, int(steps.max())):
            more = np.flatnonzero(k < steps)
            substep = shooting.run(x[-1][more], at.u[more], h[more], False, p)
            assert substep is not None
            x.append(x[-1].copy())
            x[-1][more] = substep.ends
        node = np.minimum((times * (N / at.duration) + 1e-9).astype(int), N - 1)
        since = times - node * (at.duration / N)
        step = np.minimum((since / h[node] + 1e-9).astype(int), steps[node] - 1)
        intervals = shooting.run(
            np.stack(x)[step, node], at.u[node], since - step * h[node], False, p
        )
    assert intervals is not None
    return intervals.ends


def _law_columns(setup: MotionProblem, x: FloatArray, u: FloatArray) -> dict[str, FloatArray]:
    """Return the samples of the commands and states of muscle laws by name of the column."""
    laws, driven = setup.shooting.laws, setup.shooting.driven
    names = muscle_signals("u", setup.dynamics.robot)
    columns = {names[k]: u[:, j] for j, k in enumerate(driven) if laws.modelled[k]}
    states = x[:, 2 * setup.shooting.n :].T
    return columns | dict(zip(laws.state_names, states, strict=True))


def _task_columns(
    dynamics: CoreDynamics, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> dict[str, FloatArray]:
    """Return the samples of y, yd and ydd by name of the column."""
    names = [name for letter in ("y", "yd", "ydd") for name in task_signals(letter, dynamics.robot)]
    if not names:
        return {}
    rows = []
    for at, rates, accelerations in zip(q, qd, qdd, strict=True):
        y, J = dynamics.task_position(at), dynamics.task_jacobian(at)
        ydd = J @ accelerations + dynamics.task_bias(at, rates)
        rows.append(np.concatenate([y, J @ rates, ydd]))
    return dict(zip(names, np.array(rows).T, strict=True))
