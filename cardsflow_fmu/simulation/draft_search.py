"""Search for a first experiment of a robot by test runs of drafts, with decreasing motions."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, Robot, SimulationError
from addin_sdfusion.robot.checks.not_simulated import not_simulated
from addin_sdfusion.robot.files import is_folder
from addin_sdfusion.robot.formats.read import Reading, read
from addin_sdfusion.robot.model.trajectory import Trajectory, TrajectoryPoint
from cardsflow_fmu.cosim.recording import Watch
from cardsflow_fmu.cosim.signals.muscles import modelled_muscles
from cardsflow_fmu.cosim.signals.tracked_signals import tracked_signals
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.reader import EXPERIMENT_TOML, experiment_settings
from cardsflow_fmu.experiment.template import ExperimentDraft, experiment_text
from cardsflow_fmu.models.native_loop import missing_in_loop, native_loop
from cardsflow_fmu.results.analysis.first_motion import (
    DURATION,
    UNDRIVEN,
    FirstMotion,
    first_motion,
)
from cardsflow_fmu.results.analysis.motion_check import new_collisions
from cardsflow_fmu.results.summary import Speed, summarize
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.stiffness import stiffness
from controllers.force_distribution.motor_columns import split_motors
from controllers.force_distribution.quadratic import least_squares
from sim_dart import control_dynamics, dependent_coordinates
from sim_dart.muscles.friction import has_cable_friction

_GAINS = (400.0, 40.0)  # kp in [1/s²], kd in [1/s]: critically damped at 20 rad/s
_SLOW_GAINS = (150.0, 25.0)  # for muscles with slow laws
_STIFF_GAINS, _OBSERVER = (2000.0, 90.0), 0.2
"""For joints with friction: gains, and the product of observer bandwidth and period."""
_CABLE_OBSERVER = 0.5
"""The same product for cable friction: 100 rad/s at a period of 5 ms."""
_PERIODS = ((0.005, 0.001), (0.002, 0.001), (0.001, 0.001), (0.0005, 0.0005), (0.0002, 0.0002))
"""Controller period and simulation step, in [s], in the order of the test runs."""
_SPRING_RATE = 20.0  # natural frequency of suggested springs, in [rad/s]; damping ratio 0.5
_MAX_GROWTH = 0.5  # maximum of growth rate times controller period
_GOOD_ERROR = 5e-4  # maximum tracking error of a good test run, in [rad] or [m]
_SLOW_ERROR = 2e-3  # the same for muscles with slow laws
_MAX_WORK, _MAX_TOTAL_WORK = 1e6, 6e6  # of a single test run, and of all
_SCALES = (1.0, 0.5, 0.2)
_MAX_LOCKED = 6  # coordinates that are locked because test runs failed
_POSTURES = 33  # of a motion, for the collision check
_MAX_LINES, _SHORT_LINES = 8, 5  # lines on locked coordinates: at most, and of a longer list
_FORCE_FACTOR = 3.0  # ratio of f_max and the largest force of the motion


@dataclass(frozen=True)
class TestRun:
    """Result of a test run.

    Attributes:
        error: Maximum tracking error, in [rad] or [m].
        peak: Maximum force, in [N].
        infeasible: Number of infeasible ticks.
        complete: Whether the run reached its end.
        worst: The coordinate with the largest torque shortfall or tracking error.
        unit: Unit of the tracking error; `rad and m` if coordinates differ.
        good_error: Maximum tracking error of a good test run, in [rad] or [m].
        is_stopped: Whether it was stopped because the error was larger.
    """

    error: float
    peak: float
    infeasible: int
    complete: bool
    worst: str
    unit: str
    good_error: float = _GOOD_ERROR
    is_stopped: bool = False

    @property
    def is_good(self) -> bool:
        """Whether the robot tracks the motion, and every tick is feasible."""
        return self.complete and not self.infeasible and self.error <= self.good_error

    @property
    def rank(self) -> tuple[bool, int, float]:
        """Sort key; better test runs are smaller."""
        return not self.complete, self.infeasible, self.error


@dataclass(frozen=True)
class DraftSearch:
    """Search for an experiment whose test run tracks the reference.

    Attributes:
        cable_set: Name of the cable set; None for the default.
    """

    robot: Robot
    robot_path: Path
    cable_set: str | None

    @cached_property
    def _reading(self) -> Reading:
        return read(self.robot_path.resolve(), self.cable_set)

    def find_best(self) -> tuple[ExperimentDraft, TestRun | None]:
        """Return the best draft and its test run; None if the native models do not support it."""
        undriven: dict[str, str] = {}
        test_runs: list[tuple[ExperimentDraft, TestRun, FirstMotion]] = []
        work = 0.0
        for _ in range(_MAX_LOCKED + 1):
            first = len(test_runs)
            colliding: list[tuple[ExperimentDraft, TestRun, FirstMotion]] = []
            for scale in _SCALES:
                motion = first_motion(self.robot, scale, undriven)
                if not motion.start:
                    break
                if colliding and self._collisions(motion):
                    continue  # no better than the first
                for draft in self._drafts(motion):
                    work_of_draft = self._work(draft)
                    if (
                        test_runs
                        and work_of_draft
                        and (work_of_draft > _MAX_WORK or work + work_of_draft > _MAX_TOTAL_WORK)
                    ):
                        break
                    if work_of_draft and any(draft.period > run[0].period for run in test_runs):
                        continue  # drafts with many muscles and a shorter period failed before
                    work += work_of_draft
                    test_run = self.run_test(draft, may_stop=not work_of_draft)
                    if test_run is None:
                        return self._with_notes(draft, motion, None), None
                    test_runs.append((draft, test_run, motion))
                    if not test_run.is_good:
                        continue
                    if not self._collisions(motion):
                        return self._with_force_limits(draft, test_run, motion)
                    # muscles collide: try a shorter motion
                    colliding.append((draft, test_run, motion))
                    break
            if colliding:
                return self._with_force_limits(*colliding[0])
            if len(test_runs) == first:
                break
            test_runs[first:] = [self._complete(*run) for run in test_runs[first:]]
            worst = min(test_runs[first:], key=lambda run: run[1].rank)[1].worst
            undriven[worst] = "it did not track the reference in a test run"
        if not test_runs:
            raise self._no_pose_error(motion)
        draft, test_run, motion = min(test_runs, key=lambda run: run[1].rank)
        return self._with_notes(draft, motion, test_run), test_run

    def _complete(
        self, draft: ExperimentDraft, test_run: TestRun, motion: FirstMotion
    ) -> tuple[ExperimentDraft, TestRun, FirstMotion]:
        """Repeat a test run that was stopped, to compare it with others."""
        again = self.run_test(draft) if test_run.is_stopped else None
        return draft, again or test_run, motion

    def _work(self, draft: ExperimentDraft) -> float:
        """Return the number of steps and ticks times the number of muscles with a muscle law."""
        ticks = DURATION / draft.step + DURATION / draft.period
        return len(modelled_muscles(self.robot)) * ticks

    def _drafts(self, motion: FirstMotion) -> Iterator[ExperimentDraft]:
        """Yield drafts with decreasing periods, from the longest stable period."""
        rest = (0.0,) * len(motion.start)
        points = [
            TrajectoryPoint(time, q, rest, rest)
            for time, q in ((0.0, motion.start), (0.5 * DURATION, motion.end))
        ]
        points.append(replace(points[0], time=DURATION))
        locked = {name: (q, motion.reasons[name]) for name, q in motion.locked.items()}
        springs = self._springs(motion)
        chosen = dependent_coordinates(motion.robot)
        dependent = tuple(
            c.name for c, d in zip(motion.robot.coordinates, chosen, strict=True) if d
        )
        observed, slow = (
            bool(_joints_with_friction(motion.robot)),
            bool(modelled_muscles(self.robot)),
        )
        bandwidth = max(
            _OBSERVER if observed else 0.0,
            _CABLE_OBSERVER if has_cable_friction(motion.robot) else 0.0,
        )
        kp, kd = _SLOW_GAINS if slow else _STIFF_GAINS if observed else _GAINS
        rate = _growth(motion)
        for period, step in _PERIODS:
            if rate * period > _MAX_GROWTH and period > _PERIODS[-1][0]:
                continue
            reference = Trajectory("reference", "quintic", tuple(points), step)
            yield ExperimentDraft(
                reference,
                locked,
                springs,
                dependent,
                kp=kp,
                kd=kd,
                observer=0.0 if slow else float(f"{bandwidth / period:.3g}"),
                period=period,
                step=step,
            )

    def _with_force_limits(
        self, draft: ExperimentDraft, test_run: TestRun, motion: FirstMotion
    ) -> tuple[ExperimentDraft, TestRun]:
        """Add missing force limits if the test run with them is good as well."""
        modelled = modelled_muscles(self.robot)
        unlimited = [
            muscle.name
            for k, muscle in enumerate(self.robot.muscles)
            if not math.isfinite(muscle.f_max) and k not in modelled
        ]
        for factor in (_FORCE_FACTOR, 3.0 * _FORCE_FACTOR) if unlimited else ():
            f_max = _round_up(max([factor * test_run.peak, *(m.f_min for m in self.robot.muscles)]))
            reason = (
                f"The robot files have no f_max. This value is about {factor:g} times the "
                f"{test_run.peak:.3g} N that the motion requires:"
            )
            with_bounds = replace(draft, f_max=dict.fromkeys(unlimited, f_max), f_max_reason=reason)
            again = self.run_test(with_bounds)
            if again is not None and again.is_good:
                return self._with_notes(with_bounds, motion, again), again
        return self._with_notes(draft, motion, test_run), test_run

    def _with_notes(
        self, draft: ExperimentDraft, motion: FirstMotion, test_run: TestRun | None
    ) -> ExperimentDraft:
        """Add notes on locked coordinates, start pose, friction, and the test run."""
        notes = _locked(motion)
        outside = [c.name for c in self.robot.coordinates if not c.lower <= c.initial <= c.upper]
        if outside:
            names = ", ".join(
                [*outside[:_SHORT_LINES], *(["..."] if outside[_SHORT_LINES:] else [])]
            )
            notes.append(
                f"the initial pose violates the limits of {names}; the start pose does not"
            )
        elif motion.moved:
            notes.append(
                "the start pose differs from the initial pose, which the muscles cannot hold"
            )
        still = [
            c.name
            for c, a, b in zip(motion.robot.coordinates, motion.start, motion.end, strict=True)
            if a == b
        ]
        if draft.observer:
            cables = ["cables"] if has_cable_friction(motion.robot) else []
            names = ", ".join([*_joints_with_friction(motion.robot)[:_SHORT_LINES], *cables])
            notes.append(
                f"kp {draft.kp:g}, kd {draft.kd:g} and a disturbance observer of "
                f"{draft.observer:g} rad/s compensate for the friction of {names}"
            )
        if still:
            notes.append(f"muscles hold {', '.join(still)}, but are too weak for a motion")
        collisions = self._collisions(motion) if test_run is not None and test_run.is_good else []
        notes += [f"during the motion, {line}" for line in collisions[:_SHORT_LINES]]
        notes += not_simulated(self.robot)
        if draft.f_max:
            value = next(iter(draft.f_max.values()))
            notes.append(f"the robot files have no f_max; it is set to {value:g} N")
        if test_run is None:
            notes.append("no test run: the native models do not support this robot")
        elif not test_run.is_good:
            notes.append(
                f"test run failed: tracking error up to {test_run.error:.3g} {test_run.unit}, "
                f"{test_run.infeasible} infeasible ticks, worst coordinate {test_run.worst}"
            )
        return replace(draft, notes=tuple(notes))

    def run_test(self, draft: ExperimentDraft, *, may_stop: bool = False) -> TestRun | None:
        """Run a draft in C; None if the native models do not support it.

        Args:
            may_stop: Whether the run ends as soon as its tracking error is too large.
        """
        path = self.robot_path.resolve()
        text = experiment_text(self.robot, str(path), draft, self.cable_set)
        file = path.parent / EXPERIMENT_TOML  # for messages; the file does not exist
        try:
            data = tomllib.loads(text)
            experiment = Experiment(**experiment_settings(data, file, reading=self._reading))
        except InputError as error:
            if error.file == file:
                error.file = self.robot_path
                error.key = error.key and f"first experiment: {error.key}"
            raise
        if missing_in_loop(experiment) is not None:
            return None
        try:
            loop = native_loop(experiment)
        except (InputError, SimulationError):
            last = experiment.robot.coordinates[-1]
            return TestRun(math.inf, math.inf, 0, False, last.name, last.unit)
        good = _SLOW_ERROR if modelled_muscles(self.robot) else _GOOD_ERROR
        recording = loop.run(watch=_stop_above(good, experiment) if may_stop else None)
        summary = summarize(experiment, recording, Speed(0.0, 0.0))
        test_run = _test_run(experiment.robot, summary, good)
        return replace(test_run, is_stopped=isinstance(recording.failure, _PoorTrackingError))

    def _springs(self, motion: FirstMotion) -> dict[str, tuple[float, float, float]]:
        """Return stiffness, rest position and damping of springs for coordinates without drive."""
        start = iter(motion.start)
        names = [c.name for c in self.robot.coordinates]
        q = [motion.locked[name] if name in motion.locked else next(start) for name in names]
        dynamics = control_dynamics(self.robot, may_be_singular=True)
        M, G = dynamics.mass_matrix(q), dynamics.gravity(q)
        springs = {}
        for k, name in enumerate(names):
            if motion.reasons.get(name) == UNDRIVEN:
                stiffness = float(f"{_SPRING_RATE**2 * M[k, k]:.3g}")
                rest = q[k] + float(G[k]) / stiffness
                springs[name] = stiffness, rest, float(f"{_SPRING_RATE * M[k, k]:.3g}")
        return springs

    def _collisions(self, motion: FirstMotion) -> list[str]:
        """Describe collisions of muscles with muscles or links during a motion, one line each."""
        start, change = np.array(motion.start), np.subtract(motion.end, motion.start)
        postures = start + change * np.linspace(0.0, 1.0, _POSTURES)[:, None]
        folder = self.robot_path if is_folder(self.robot_path) else self.robot_path.parent
        return new_collisions(motion.robot, folder.resolve(), postures)

    def _no_pose_error(self, motion: FirstMotion) -> InputError:
        problems = "; ".join(f"{name}: {why}" for name, why in list(motion.reasons.items())[:8])
        return InputError(
            f"robot {self.robot.name!r}: the muscles cannot hold the robot in any pose: {problems}",
            file=self.robot_path,
        )


class _PoorTrackingError(SimulationError):
    """The tracking error of a test run is too large."""


def _stop_above(good_error: float, experiment: Experiment) -> Watch:
    """Return a callback that stops a run whose tracking error exceeds a limit."""
    signals = tracked_signals(
        experiment.robot, experiment.reference.space, experiment.controller.uncontrolled
    )

    def watch(names: tuple[str, ...], rows: FloatArray) -> None:
        for signal in signals:
            actual, desired = (rows[:, names.index(n)] for n in (signal.actual, signal.desired))
            if np.abs(signal.error(actual, desired)).max(initial=0.0) > good_error:
                raise _PoorTrackingError("the tracking error is too large")

    return watch


def _locked(motion: FirstMotion) -> list[str]:
    """Describe the locked coordinates, one line each; a long list is cut."""
    lines = [
        f"{name} is locked at {q + 0.0:.4g}: {motion.reasons[name]}"
        for name, q in motion.locked.items()
    ]
    if len(lines) <= _MAX_LINES:
        return lines
    more = len(lines) - _SHORT_LINES
    return [*lines[:_SHORT_LINES], f"{more} other coordinates are locked; see experiment.toml"]


def _joints_with_friction(robot: Robot) -> list[str]:
    """Return the coordinates with Coulomb friction."""
    return [c.name for c in robot.coordinates if c.friction > 0.0]


def _test_run(robot: Robot, summary: Mapping[str, Any], good_error: float) -> TestRun:
    infeasible = summary["infeasible_ticks"] + summary["not_converged_ticks"]
    rows = summary["slack" if infeasible else "tracking"]["per_signal"].values()
    sizes = [float(row["max"]) for row in rows]
    error, peak = summary["tracking"]["max"], summary["forces"]["max"]
    return TestRun(
        math.inf if error is None else error,
        math.inf if peak is None else peak,
        infeasible,
        summary["status"] != "incomplete",
        robot.coordinates[int(np.argmax(sizes)) if sizes else -1].name,
        summary["tracking"]["unit"],
        good_error,
    )


def _growth(motion: FirstMotion) -> float:
    """Return the largest growth or oscillation rate at constant forces, in [1/s]."""
    dynamics, q = control_dynamics(motion.robot), np.array(motion.start)
    motors = len(dynamics.motor_names)
    L, low, high = split_motors(
        dynamics.actuator_jacobian(q), dynamics.f_min, dynamics.f_max, motors
    )
    try:
        forces = least_squares(L, dynamics.gravity(q), low, high).forces
        rates = stiffness(dynamics, q, forces[: dynamics.m]).rates(dynamics.mass_matrix(q))
    except CardsflowError:
        return 0.0
    return float(np.sqrt(np.abs(rates).max()))


def _round_up(value: float) -> float:
    """Round up to 1, 2, 3, 5 or 8 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value)) if value > 0.0 else 1.0
    return float(f"{next(x * power for x in (1, 2, 3, 5, 8, 10) if x * power >= value):.3g}")
