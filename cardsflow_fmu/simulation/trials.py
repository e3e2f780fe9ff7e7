"""The search for a first experiment of a robot: beginnings are tried, and judged by a run."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, Robot, SimulationError
from addin_sdfusion.robot.checks.not_simulated import not_simulated
from addin_sdfusion.robot.files import is_folder
from addin_sdfusion.robot.model.trajectory import Trajectory, TrajectoryPoint
from cardsflow_fmu.cosim.signals.muscles import modelled_muscles
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.reader import EXPERIMENT_TOML, experiment_settings
from cardsflow_fmu.experiment.template import Beginning, experiment_text
from cardsflow_fmu.models.native_loop import NativeLoop
from cardsflow_fmu.results.analysis.first_motion import (
    DURATION,
    UNDRIVEN,
    FirstMotion,
    first_motion,
)
from cardsflow_fmu.results.analysis.motion_check import new_meetings
from cardsflow_fmu.results.summary import Speed, summarize
from controllers.analysis.stiffness import stiffness
from controllers.force_distribution.one_way import one_way
from controllers.force_distribution.quadratic import least_squares
from sim_dart import control_dynamics, dependent_coordinates
from sim_dart.muscles.friction import rubs

_GAINS = (400.0, 40.0)  # kp in [1/s²], kd in [1/s]: critically damped at 20 rad/s
_SLOW_GAINS = (150.0, 25.0)  # for muscles that take their time
_STIFF_GAINS, _OBSERVER = (2000.0, 90.0), 0.2
"""Against the friction of joints: gains, and the bandwidth of the observer times the period."""
_OBSERVER_OF_CABLES = 0.5
"""The same against what is not known of the friction of cables: 100 rad/s at a period of 5 ms."""
_PERIODS = ((0.005, 0.001), (0.002, 0.001), (0.001, 0.001), (0.0005, 0.0005), (0.0002, 0.0002))
"""Of the controller and of the simulation, in [s], the longest first."""
_OWN_RATE = 20.0  # in [rad/s], of what springs hold; half of critical damping
_STABLE = 0.5  # most that a displacement may grow by within a period: the period times this rate
_GOOD_ERROR = 5e-4  # in [rad] or [m]: a motion that is followed this well is good
_SLOW_ERROR = 2e-3  # the same with muscles that take their time
_MAX_WORK, _ALL_WORK = 1e6, 6e6  # of a trial but the first, and of all
_SCALES = (1.0, 0.5, 0.2)
_MAX_LOCKED = 6  # coordinates that are locked as trials have failed
_POSTURES = 33  # of a motion, at which muscles are looked at
_MAX_LINES, _SOME_LINES = 8, 5  # on what is locked: at most, and of more
_STRONGER = 3.0  # f_max over the largest force of the motion


@dataclass(frozen=True)
class Trial:
    """What a run of an experiment gave.

    Attributes:
        error: Largest error of a position, in [rad] or [m].
        peak: Largest force, in [N].
        infeasible: Ticks without forces that fit.
        complete: Whether it reached its end.
        worst: The coordinate that lacks most, or follows least.
        good_error: Up to which error the motion is followed well, in [rad] or [m].
    """

    error: float
    peak: float
    infeasible: int
    complete: bool
    worst: str
    good_error: float = _GOOD_ERROR

    @property
    def is_good(self) -> bool:
        """Whether the motion is followed, with forces that fit all along."""
        return self.complete and not self.infeasible and self.error <= self.good_error

    @property
    def rank(self) -> tuple[bool, int, float]:
        """The better, the smaller."""
        return not self.complete, self.infeasible, self.error


@dataclass(frozen=True)
class Search:
    """The search for an experiment that tracks.

    Attributes:
        robot: The robot.
        robot_path: Where its files are.
        cable_set: The cable set that is asked for.
    """

    robot: Robot
    robot_path: Path
    cable_set: str | None

    def best(self) -> tuple[Beginning, Trial | None]:
        """What an experiment is to do, and how a run of it goes."""
        held: dict[str, str] = {}
        tried: list[tuple[Beginning, Trial, FirstMotion]] = []
        work = 0.0
        for _ in range(_MAX_LOCKED + 1):
            first, crossing = len(tried), []
            for scale in _SCALES:
                motion = first_motion(self.robot, scale, held)
                if not motion.start:
                    break
                for beginning in self._beginnings(motion):
                    due = self._work(beginning)
                    if tried and due and (due > _MAX_WORK or work + due > _ALL_WORK):
                        break
                    if due and any(beginning.period > one[0].period for one in tried):
                        continue  # of many muscles, as short ones fail too
                    work += due
                    trial = self.tried(beginning)
                    if trial is None:
                        return self._described(beginning, motion, None), None
                    tried.append((beginning, trial, motion))
                    if not trial.is_good:
                        continue
                    if not self._meetings(motion):
                        return self._bounded(beginning, trial, motion)
                    crossing.append((beginning, trial, motion))  # muscles meet: a shorter one
                    break
            if crossing:
                return self._bounded(*crossing[0])
            if len(tried) == first:  # nothing is left
                break
            worst = min(tried[first:], key=lambda one: one[1].rank)[1].worst
            held[worst] = "it did not follow in a trial"
        if not tried:
            raise self._cannot_be_held(motion)
        beginning, trial, motion = min(tried, key=lambda one: one[1].rank)
        return self._described(beginning, motion, trial), trial

    def _work(self, beginning: Beginning) -> float:
        """The steps and ticks of a trial, by muscles that have a model; 0 where none has."""
        ticks = DURATION / beginning.step + DURATION / beginning.period
        return len(modelled_muscles(self.robot)) * ticks

    def _beginnings(self, motion: FirstMotion) -> Iterator[Beginning]:
        """Experiments with ever shorter periods, from the longest that is stable."""
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
        observed, slow = bool(_rubbing(motion.robot)), bool(modelled_muscles(self.robot))
        bandwidth = max(
            _OBSERVER if observed else 0.0,
            _OBSERVER_OF_CABLES if rubs(motion.robot) else 0.0,
        )
        kp, kd = _SLOW_GAINS if slow else _STIFF_GAINS if observed else _GAINS
        rate = _growth(motion)
        for period, step in _PERIODS:
            if rate * period > _STABLE and period > _PERIODS[-1][0]:
                continue
            reference = Trajectory("reference", "quintic", tuple(points), step)
            yield Beginning(
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

    def _bounded(
        self, beginning: Beginning, trial: Trial, motion: FirstMotion
    ) -> tuple[Beginning, Trial]:
        """With force bounds where the robot has none, as far as it follows as well with them."""
        modelled = modelled_muscles(self.robot)
        unlimited = [
            muscle.name
            for k, muscle in enumerate(self.robot.muscles)
            if not math.isfinite(muscle.f_max) and k not in modelled
        ]
        for stronger in (_STRONGER, 3.0 * _STRONGER) if unlimited else ():
            f_max = _round_up(max([stronger * trial.peak, *(m.f_min for m in self.robot.muscles)]))
            reason = (
                f"The robot's files have no f_max; this is some {stronger:g} times the "
                f"{trial.peak:.3g} N that the motion needs:"
            )
            with_bounds = replace(
                beginning, f_max=dict.fromkeys(unlimited, f_max), f_max_reason=reason
            )
            again = self.tried(with_bounds)
            if again is not None and again.is_good:
                return self._described(with_bounds, motion, again), again
        return self._described(beginning, motion, trial), trial

    def _described(
        self, beginning: Beginning, motion: FirstMotion, trial: Trial | None
    ) -> Beginning:
        remarks = _locked(motion)
        outside = [c.name for c in self.robot.coordinates if not c.lower <= c.initial <= c.upper]
        if outside:
            names = ", ".join([*outside[:_SOME_LINES], *(["..."] if outside[_SOME_LINES:] else [])])
            remarks.append(f"the initial pose is outside the limits of {names}; the start is not")
        elif motion.moved:
            remarks.append("the start is not the robot's initial pose, which muscles cannot hold")
        still = [
            c.name
            for c, a, b in zip(motion.robot.coordinates, motion.start, motion.end, strict=True)
            if a == b
        ]
        if beginning.observer:
            cables = ["cables"] if rubs(motion.robot) else []
            names = ", ".join([*_rubbing(motion.robot)[:_SOME_LINES], *cables])
            remarks.append(
                f"against the friction of {names}: kp {beginning.kp:g}, kd {beginning.kd:g}, and a "
                f"disturbance observer of {beginning.observer:g} rad/s"
            )
        if still:
            remarks.append(f"muscles hold {', '.join(still)}, with no room for a motion")
        meetings = self._meetings(motion) if trial is not None and trial.is_good else []
        remarks += [f"along the motion {line}" for line in meetings[:_SOME_LINES]]
        remarks += not_simulated(self.robot)
        if beginning.f_max:
            value = next(iter(beginning.f_max.values()))
            remarks.append(f"the robot's files have no f_max; it is set to {value:g} N")
        if trial is None:
            remarks.append("not tried: it has something that the native models lack")
        elif not trial.is_good:
            remarks.append(
                f"in a trial it does not track: errors up to {trial.error:.3g}, "
                f"{trial.infeasible} infeasible ticks, {trial.worst} worst"
            )
        return replace(beginning, remarks=tuple(remarks))

    def tried(self, beginning: Beginning) -> Trial | None:
        """A run in C; None where the native models lack something."""
        path = self.robot_path.resolve()
        text = experiment_text(self.robot, str(path), beginning, self.cable_set)
        file = path.parent / EXPERIMENT_TOML  # which is not written, nor read
        try:
            experiment = Experiment(**experiment_settings(tomllib.loads(text), file))
        except InputError as error:
            if error.file == file:
                error.file, error.key = self.robot_path, None
            raise
        try:
            loop = NativeLoop(experiment)
        except InputError:
            return None
        except SimulationError:
            return Trial(math.inf, math.inf, 0, False, experiment.robot.coordinates[-1].name)
        with loop:
            recording = loop.run()
        summary = summarize(experiment, recording, Speed(0.0, 0.0))
        good = _SLOW_ERROR if modelled_muscles(self.robot) else _GOOD_ERROR
        return _judged(experiment.robot, summary, good)

    def _springs(self, motion: FirstMotion) -> dict[str, tuple[float, float, float]]:
        """Stiffness, rest and damping of springs that would hold what nothing drives there."""
        start = iter(motion.start)
        names = [c.name for c in self.robot.coordinates]
        q = [motion.locked[name] if name in motion.locked else next(start) for name in names]
        dynamics = control_dynamics(self.robot, may_be_singular=True)
        M, G = dynamics.mass_matrix(q), dynamics.gravity(q)
        springs = {}
        for k, name in enumerate(names):
            if motion.reasons.get(name) == UNDRIVEN:
                stiffness = float(f"{_OWN_RATE**2 * M[k, k]:.3g}")
                rest = q[k] + float(G[k]) / stiffness
                springs[name] = stiffness, rest, float(f"{_OWN_RATE * M[k, k]:.3g}")
        return springs

    def _meetings(self, motion: FirstMotion) -> list[str]:
        """Muscles that meet one another or links along a motion, a line each."""
        start, way = np.array(motion.start), np.subtract(motion.end, motion.start)
        postures = start + way * np.linspace(0.0, 1.0, _POSTURES)[:, None]
        folder = self.robot_path if is_folder(self.robot_path) else self.robot_path.parent
        return new_meetings(motion.robot, folder.resolve(), postures)

    def _cannot_be_held(self, motion: FirstMotion) -> InputError:
        words = "; ".join(f"{name}: {why}" for name, why in list(motion.reasons.items())[:8])
        return InputError(
            f"robot {self.robot.name!r} cannot be held by its muscles in any pose: {words}",
            file=self.robot_path,
        )


def _locked(motion: FirstMotion) -> list[str]:
    """What is locked and why, a line each; of many the first, as the file has a line for each."""
    lines = [
        f"{name} is locked at {q:.4g}: {motion.reasons[name]}" for name, q in motion.locked.items()
    ]
    if len(lines) <= _MAX_LINES:
        return lines
    more = len(lines) - _SOME_LINES
    return [*lines[:_SOME_LINES], f"{more} others are locked, too: the file has a line for each"]


def _rubbing(robot: Robot) -> list[str]:
    """The coordinates with Coulomb friction."""
    return [c.name for c in robot.coordinates if c.friction > 0.0]


def _judged(robot: Robot, summary: Mapping[str, Any], good_error: float) -> Trial:
    infeasible = summary["infeasible_ticks"] + summary["not_converged_ticks"]
    rows = summary["slack" if infeasible else "tracking"]["per_signal"].values()
    sizes = [float(row["max"]) for row in rows]
    error, peak = summary["tracking"]["max"], summary["forces"]["max"]
    return Trial(
        math.inf if error is None else error,
        math.inf if peak is None else peak,
        infeasible,
        summary["status"] == "complete",
        robot.coordinates[int(np.argmax(sizes)) if sizes else -1].name,
        good_error,
    )


def _growth(motion: FirstMotion) -> float:
    """The fastest that a displacement grows, or swings, at held forces, in [1/s]."""
    dynamics, q = control_dynamics(motion.robot), np.array(motion.start)
    motors = len(dynamics.motor_names)
    L, low, high = one_way(dynamics.actuator_jacobian(q), dynamics.f_min, dynamics.f_max, motors)
    try:
        forces = least_squares(L, dynamics.gravity(q), low, high).forces
        rates = stiffness(dynamics, q, forces[: dynamics.m]).rates(dynamics.mass_matrix(q))
    except CardsflowError:
        return 0.0
    return float(np.sqrt(np.abs(rates).max()))


def _round_up(value: float) -> float:
    """The next of 1, 2, 3, 5 or 8 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value)) if value > 0.0 else 1.0
    return float(f"{next(x * power for x in (1, 2, 3, 5, 8, 10) if x * power >= value):.3g}")
